# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The outer loop of hard EM [Ozog2016 4.2.2], compared with labels decided inside the solve.

Those are [Ozog2016 4.2.4] (docs/adr/0007). E: each landmark takes the likelier label. M: solve with
these labels held. Both steps lower the same cost, constants included, so the loop ends where no
label changes, or after as many turns as it is given.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from hullrecon import native
from hullrecon.adjustment.problem.selection import label_boundary

MOST_TURNS = 30


def solve(
    problem: native.Problem, options: native.Options, most_turns: int = MOST_TURNS
) -> native.Result:
    """Solve with labels held in each solve and refreshed between solves: eqs (4.1) to (4.3).

    The record runs over all turns. A turn's start, which repeats the last turn's end under new
    labels, is left out, and its label changes are in the next row. `max_iterations` bounds each
    turn. `converged` means that the last turn did and that no label changes.
    """
    held, turns, changes = (
        replace(options, labels_in_solve=False),
        list[native.Result](),
        list[int](),
    )
    start = problem.unknowns
    for _ in range(most_turns):
        turns.append(native.solve(problem, held))
        problem = problem.started_from(_calibrated(turns[-1].unknowns, start))
        label = likelier_labels(problem, turns[-1].distance, options)
        changes.append(int((label != turns[-1].label).sum()))
        if not changes[-1]:
            break
    return _join_turns(turns, changes, label)


def _calibrated(unknowns: native.Unknowns, start: native.Unknowns) -> native.Unknowns:
    """Put back the intrinsics of the start.

    Their prior is about those that a solve starts from, and would follow them from turn to turn.
    """
    return replace(
        unknowns, intrinsics_top=start.intrinsics_top, intrinsics_bottom=start.intrinsics_bottom
    )


def likelier_labels(
    problem: native.Problem, distance: NDArray[np.float64], options: native.Options
) -> NDArray[np.int32]:
    """Choose the likelier label (m,) of each landmark's distance to the hull [Ozog2016 eq. 4.4].

    distance: (m,) m, signed, to the CAD model without the field. The field at the solution is taken
    off first.
    """
    offset = distance
    nodes = problem.surface.field
    if len(nodes.index):
        offset = distance - np.einsum(
            "nk,nk->n", nodes.weight, problem.unknowns.deviation[nodes.index]
        )
    return np.asarray(
        np.abs(offset) <= label_boundary(options.sigma_on, options.sigma_off), np.int32
    )


def _join_turns(
    turns: Sequence[native.Result], changes: Sequence[int], label: NDArray[np.int32]
) -> native.Result:
    """Join the results of all turns to one, with the final labels."""
    last = turns[-1]
    parts = last.seconds.keys()
    return replace(
        last,
        label=label,
        iterations=_record([t.iterations for t in turns], changes),
        converged=last.converged and not changes[-1],
        message=f"{len(turns)} turns of EM, {changes[-1]} labels changed after the last; "
        f"{last.message}",
        seconds={part: sum(t.seconds[part] for t in turns) for part in parts},
    )


def _record(
    records: Sequence[native.IterationRecord], changes: Sequence[int]
) -> native.IterationRecord:
    """Join the records of all turns to one.

    The first row of each later turn is dropped, and a turn's label changes are in the next row.
    """
    keep = [slice(None) if k == 0 else slice(1, None) for k in range(len(records))]
    offset = np.cumsum([0.0, *(r.seconds[-1] for r in records)])
    found = {
        name: np.concatenate([getattr(r, name)[s] for r, s in zip(records, keep, strict=True)])
        for name in records[0].__dataclass_fields__
        if name not in ("seconds", "cost_by_factor", "label_changes")
    }
    changed = np.concatenate(
        [np.zeros(len(r.cost[s]), np.int64) for r, s in zip(records, keep, strict=True)]
    )
    ends = np.cumsum([len(r.cost[s]) for r, s in zip(records, keep, strict=True)])
    for end, count in zip(ends, changes, strict=True):
        changed[min(end, len(changed) - 1)] += count
    return native.IterationRecord(
        **found,
        seconds=np.concatenate(
            [r.seconds[s] + o for r, s, o in zip(records, keep, offset, strict=False)]
        ),
        cost_by_factor={
            name: np.concatenate(
                [r.cost_by_factor[name][s] for r, s in zip(records, keep, strict=True)]
            )
            for name in records[0].cost_by_factor
        },
        label_changes=changed,
    )
