# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The unknowns of the adjustment between rounds, and what is held against them: labels, weights, the deviation grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.adjustment.problem.deviation_field import DeviationGrid
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array


@dataclass(frozen=True)
class State:
    """nodes T_g_v, tray (n,), landmark (L, 3) in g (NaN: not used), motions T_a_b as batches of one (None where absent),
    navigation (6,), field (size,) on `grid` (None: no field)."""

    nodes: Poses
    tray: Array
    landmark: Array
    T_g_M: Poses | None
    T_s_ct: Poses | None
    T_ct_cb: Poses | None
    T_s_d: Poses
    navigation: Array
    grid: DeviationGrid | None
    field: Array


@dataclass(frozen=True)
class Weights:
    """One sigma of each kind of measurement as used in a round. surface (L,): weight of each landmark's mixture.
    depth: in the sigma that navigation gave it. range_sigma: metres. tray_direction (n,): +1 or -1, the side of its backlash on
    which the tray hangs."""

    pixel: float
    depth: float
    tray: float
    range_sigma: float
    surface: Array
    tray_direction: Array


def pose_vector(pose: Poses | None) -> Array:
    """x y z qx qy qz qw of a batch of one; NaN where there is none."""
    return np.full(7, np.nan) if pose is None else np.r_[pose.translation[0], pose.quaternion[0]]


def pose_from_vector(values: Array) -> Poses:
    """The inverse of `seven`."""
    return Poses(values[None, 3:] / np.linalg.norm(values[3:]), values[None, :3].copy())
