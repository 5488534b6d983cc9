# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The solver's record over all rounds: columns of iterations.npz, lines of the log.

As in [Ozog2016 4.4.1]. Costs of two rounds cannot be compared, as each round has its own sigmas and
landmarks. So every row also has the number of its round and the sigmas by which it was whitened.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon import native
from hullrecon.records.iterations import reached_cost
from hullrecon.typing import Array

# Columns of native.IterationRecord that are copied, and sigmas of a round
STEP = ("cost", "cost_change", "step_norm", "gradient_norm", "radius", "accepted")
COUNTS = ("on_surface", "label_changes", "rays_missed")
SIGMAS = ("pixel_sigma_px", "tray_sigma_rad", "range_sigma_m", "depth_sigma_m")


@dataclass(frozen=True, kw_only=True)
class Round:
    """What is recorded of one solve."""

    record: native.IterationRecord  # of each iteration
    # Sigmas by which the residuals were whitened
    pixel_sigma_px: float
    tray_sigma_rad: float
    range_sigma_m: float
    depth_sigma_m: float  # NaN without depths
    landmarks: int  # number of landmarks that entered
    converged: bool
    message: str  # of the solver: why it ended
    began_s: float  # start of the solve, seconds since the start of the adjustment


def columns(rounds: Sequence[Round]) -> dict[str, NDArray[Any]]:
    """Build the columns of iterations.npz, one row per iteration, in the order of the rounds.

    Names and meaning are in docs/formats.md.
    """
    iterations = [len(r.record.cost) for r in rounds]
    found: dict[str, NDArray[Any]] = {
        "round": np.repeat(np.arange(1, len(rounds) + 1), iterations),
        "iteration": np.concatenate([np.arange(n) for n in iterations]),
        "landmarks": np.repeat([r.landmarks for r in rounds], iterations),
        **{
            name: np.repeat([_sigmas(r)[name] for r in rounds], iterations)
            for name in _sigmas(rounds[0])
        },
    }
    for name in (*STEP, *COUNTS):
        found[name] = np.concatenate([getattr(r.record, name) for r in rounds])
    for name in native.FACTORS:
        if name in native.GRAPH_FACTORS:  # the adjustment has none
            continue
        found[f"cost_{name}"] = np.concatenate([r.record.cost_by_factor[name] for r in rounds])
    return found


def seconds(rounds: Sequence[Round]) -> Array:
    """Compute when each row of `columns` was done, (k,) seconds since the adjustment began."""
    return np.concatenate([r.began_s + r.record.seconds for r in rounds])


def summarise_rounds(rounds: Sequence[Round]) -> list[dict[str, Any]]:
    """Summarise each round for adjust.json: what it was given and what it reached."""
    return [
        {
            "iterations": len(r.record.cost) - 1,
            "landmarks": r.landmarks,
            **{name: sigma if np.isfinite(sigma) else None for name, sigma in _sigmas(r).items()},
            "first_cost": float(r.record.cost[0]),
            "last_cost": float(reached_cost(r.record.cost, r.record.accepted)[-1]),
            "on_surface": int(r.record.on_surface[-1]),
            "labels_changed": int(r.record.label_changes.sum()),
            "rays_missed": int(r.record.rays_missed[-1]),
            "converged": r.converged,
            "message": r.message,
        }
        for r in rounds
    ]


def _sigmas(done: Round) -> dict[str, float]:
    return {name: getattr(done, name) for name in SIGMAS}


def lines(number: int, done: Round) -> Iterator[str]:
    """Format a round as a table for the log: heads, one line for each iteration, the end.

    Only factors with any cost have a column.

    number: of the round, from 1.
    """
    record = done.record
    names = [name for name in native.FACTORS if np.any(record.cost_by_factor[name] > 0)]
    yield (
        f"round {number}, {done.landmarks} landmarks, sigmas {done.pixel_sigma_px:.3g} px, tray "
        f"{np.degrees(done.tray_sigma_rad):.2g} deg, ranges {done.range_sigma_m:.3g} m, depths "
        f"{done.depth_sigma_m:.2g} m (costs do not compare with those of other rounds)"
    )
    heads = [
        "iteration",
        "cost",
        *names,
        "step",
        "gradient",
        "on hull",
        "changed",
        "missed",
        "seconds",
    ]
    yield "  ".join(f"{head:>10}" for head in heads)
    for k in range(len(record.cost)):
        cells = [f"{k}" if record.accepted[k] else f"({k})"]
        cells += [
            f"{value:.5g}"
            for value in (record.cost[k], *(record.cost_by_factor[name][k] for name in names))
        ]
        cells += [f"{record.step_norm[k]:.2e}", f"{record.gradient_norm[k]:.2e}"]
        cells += [
            f"{values[k]}"
            for values in (record.on_surface, record.label_changes, record.rays_missed)
        ]
        yield "  ".join(
            f"{cell:>10}" for cell in [*cells, f"{done.began_s + record.seconds[k]:.2f}"]
        )
    yield f"{done.message}; iterations in brackets were not accepted"
