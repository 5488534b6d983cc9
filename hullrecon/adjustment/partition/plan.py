# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Plan the parts of a long dive's adjustment: stripes across the hull, cut by position.

The border between two stripes cuts every leg that runs along the hull, and only poses near a border
are shared by two parts. With parts cut by time, half of all landmarks would be seen from two parts
(docs/adr/0013).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from hullrecon import native
from hullrecon.adjustment.options import MOST_PARTS
from hullrecon.adjustment.problem.state import State
from hullrecon.typing import Array, Ints

Wanted = int | Literal["auto"]
# Memory budget of the solver under "auto". It does not depend on the machine, so that a dive has
# the same parts, and the same bytes, everywhere.
SOLVER_MB = 300.0
# Share of the solver's memory for the whole problem that stays taken by the parts that are not at
# work. From the last solve of five legs of 6.75 m: 207 MB whole, 103 MB in 8 parts, the largest
# with a fifth of the landmarks
AT_REST = 0.36
# Peak memory of a solve, bytes. The solve above, with 57,060 landmarks, 420,967 rows of images and
# 72 columns of lenses, takes 207 MB, predicted are 215. benchmarks.partition, with 100,000
# landmarks and some 700,000 rows, takes 386 MB, predicted are 395. The bytes of a pose are an
# estimate.
BYTES_A_ROW = 160.0  # of stereo and mono, its table and the views
BYTES_A_LANDMARK = 700.0
BYTES_A_LENS_COLUMN = 24.0  # of each landmark, for each unknown of the lenses and intrinsics
BYTES_A_POSE = 40_000.0  # with some 36 neighbours
# Unknowns on which the observations of every landmark depend
SHARED_BY_ALL = ("T_ct_cb", "intrinsics_top", "intrinsics_bottom", "lens_top", "lens_bottom")


@dataclass(frozen=True, kw_only=True)
class Plan:
    """How a problem is divided into parts: which part owns each pose, and why."""

    owner: Ints  # (n,) part of each pose, from 0 on
    cuts_m: Array  # (parts - 1,) positions along `axis` at which the stripes meet
    axis: str  # "along" or "girth" of the chart, "path" without a chart, "" with one part
    predicted_mb: Array  # (parts,) memory of the solver while that part is at work
    reason: str  # why there are so many parts, for log and adjust.json

    @property
    def parts(self) -> int:
        """Count the parts."""
        return len(self.predicted_mb)

    def facts(self) -> dict[str, object]:
        """Collect what adjust.json says of the plan."""
        return {
            "count": self.parts,
            "axis": self.axis,
            "cuts_m": self.cuts_m.tolist(),
            "poses": np.bincount(self.owner, minlength=self.parts).tolist(),
            "predicted_mb": self.predicted_mb.tolist(),
            "reason": self.reason,
        }


def plan_parts(problem: native.Problem, state: State, wanted: Wanted) -> Plan:
    """Plan the parts of a problem.

    Parameters
    ----------
    problem
        The whole problem, whose tables give the memory that each pose takes.
    state
        Positions of the same poses, and the chart on which they are cut, where there is one.
    wanted
        Number of parts, or "auto": one part up to SOLVER_MB, more beyond.
    """
    return plan_along(problem, *_positions_to_cut(state), wanted)


def plan_along(problem: native.Problem, position_m: Array, axis: str, wanted: Wanted) -> Plan:
    """Divide the poses, in the order of their positions, into stripes of about equal memory.

    Parameters
    ----------
    problem
        The whole problem, of whose tables the memory follows.
    position_m
        Positions (n,) m of the poses along the axis that is cut.
    axis
        Name of that axis, for the plan.
    wanted
        Number of parts, or "auto", as for `plan_parts`. A stripe without a pose is dropped, so that
        there may be fewer.
    """
    bytes_of_pose = _bytes_of_poses(problem)
    whole_mb = float(bytes_of_pose.sum()) / 1e6
    if wanted == "auto":
        # The part at work gets what the parts at rest leave of the budget. Where these alone take
        # more than half of it, the part at work gets half of the budget nevertheless.
        for_work_mb = max(SOLVER_MB - AT_REST * whole_mb, SOLVER_MB / 2)
        needed = int(np.ceil((1 - AT_REST) * whole_mb / for_work_mb))
        count = 1 if whole_mb <= SOLVER_MB else min(MOST_PARTS, needed)
        reason = f"the solver takes about {whole_mb:.0f} MB in one part"
    else:
        count, reason = wanted, f"adjust.parts asks for {wanted}"
    order = np.argsort(position_m, kind="stable")
    # Memory of all poses before each one, to its own middle: stripes have equal parts of it
    share = np.cumsum(bytes_of_pose[order]) - 0.5 * bytes_of_pose[order]
    stripe = np.empty(len(order), np.int64)
    stripe[order] = count * share / bytes_of_pose.sum()
    _, owner = np.unique(stripe, return_inverse=True)  # numbers the stripes that have a pose
    mb = AT_REST * whole_mb + (1 - AT_REST) * np.bincount(owner, bytes_of_pose) / 1e6
    begin_m = [float(position_m[owner == k].min()) for k in range(1, len(mb))]
    return Plan(
        owner=owner,
        cuts_m=np.array(begin_m),
        axis=axis,
        predicted_mb=np.asarray(mb, float),
        reason=reason,
    )


def whole(problem: native.Problem, reason: str) -> Plan:
    """Plan a single part, with the reason for it."""
    bytes_of_pose = _bytes_of_poses(problem)
    return Plan(
        owner=np.zeros(len(bytes_of_pose), np.int64),
        cuts_m=np.zeros(0),
        axis="",
        predicted_mb=np.array([bytes_of_pose.sum() / 1e6]),
        reason=reason,
    )


def _positions_to_cut(state: State) -> tuple[Array, str]:
    """Compute the positions (n,) m of the poses along the axis that is cut, and its name.

    It is the longer axis of the survey on the chart ("along" or "girth"), or of the path ("path")
    where there is no chart. Cut across it, stripes have the shortest borders.
    """
    if state.hull is not None:
        at = state.hull.to_chart(state.nodes.translation)
        axis = int(np.argmax(np.ptp(at, axis=0)))
        return at[:, axis], ("along", "girth")[axis]
    centred = state.nodes.translation - state.nodes.translation.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    return centred @ axes[0], "path"


def _bytes_of_poses(problem: native.Problem) -> Array:
    """Predict the solver's memory (n,) bytes for each pose.

    The memory of all landmarks is shared out to the poses by their numbers of observations.
    """
    count = len(problem.unknowns.pose)
    rows = np.bincount(problem.stereo.node, minlength=count) + np.bincount(
        problem.mono.node, minlength=count
    )
    landmarks = len(problem.unknowns.landmark) * rows / max(1, rows.sum())
    columns = sum(_width(problem, name) for name in SHARED_BY_ALL if name not in problem.constant)
    of_landmark = BYTES_A_LANDMARK + columns * BYTES_A_LENS_COLUMN
    return np.asarray(BYTES_A_POSE + BYTES_A_ROW * rows + of_landmark * landmarks)


def _width(problem: native.Problem, name: str) -> int:
    """Count the unknowns of a block. Lenses have none where no displacement is estimated."""
    if name.startswith("lens") and not len(problem.lenses.image_size):
        return 0
    return 6 if name == "T_ct_cb" else len(getattr(problem.unknowns, name))
