# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The unknowns of the adjustment between rounds, and what is held against them: labels, weights,
the deviation grid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.adjustment.hull_pose.stretches import Stretches
from hullrecon.adjustment.problem.deviation_field import DeviationGrid
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry.poses import Poses
from hullrecon.records.solution import Mounts
from hullrecon.records.trajectory import VehiclePath
from hullrecon.rig import Rig
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class HullState:
    """The hull as it is estimated: global_from_hull T_g_M (a batch of one), survey_center (3,) in
    M, and the field (size,) m of its deviation from the CAD model on `grid` (None: no field).
    stretches: of the path, known loosely to each other (None: it holds together).
    """

    cad_model: CadModel
    global_from_hull: Poses
    survey_center: Array
    grid: DeviationGrid | None
    field: Array
    stretches: Stretches | None = None

    def to_hull(self, points: Array) -> Array:
        """Return points (n, 3) of g in M."""
        return self.global_from_hull.inverse().apply(points)

    def to_chart(self, points: Array) -> Array:
        """Return along and girth (n, 2) m of points (n, 3) in g."""
        return np.asarray(self.cad_model.chart.to_chart(self.to_hull(points))[:, :2])

    def cad_distance(self, points: Array) -> Array:
        """Return signed distances (n,) m of points (n, 3) in g to the CAD model, positive outside."""
        return self.cad_model.mesh.index.closest(self.to_hull(points)).distance

    def deviation(self, points: Array) -> Array:
        """Return signed distances (n,) m of points (n, 3) in g to the hull as it is: the CAD model
        moved by the field.
        """
        distance = self.cad_distance(points)
        return (
            distance
            if self.grid is None
            else np.asarray(distance - self.grid.value(self.field, self.to_chart(points)))
        )


@dataclass(frozen=True, kw_only=True)
class State:
    """The unknowns of the adjustment."""

    nodes: Poses  # (n,) global_from_vehicle
    tray: Array  # (n,) rad
    landmark: Array  # (L, 3) m in g; NaN: not used
    mounts: Mounts  # of a camera None where it was not carried or saw nothing
    navigation: Array  # (6,) errors, in the order of RigPriors.navigation_sigma
    hull: HullState | None  # None without a CAD model

    @property
    def path(self) -> VehiclePath:
        """Vehicle and tray at the nodes, in g."""
        return VehiclePath(poses=self.nodes, tray=self.tray)

    def mounted(self, rig: Rig) -> Rig:
        """Replace the rig's mounts by those of this state."""
        return rig.with_mounts(self.mounts)


@dataclass(frozen=True, kw_only=True)
class Weights:
    """One sigma of each kind of measurement as used in a round. pixel_ratio (m,): by which the
    sigma of each observation of the tracks differs from `pixel`. surface (L,): weight of each
    landmark's mixture. depth: in the sigma that navigation gave it. range_sigma: metres.
    tray_direction (n,): +1 or -1, the side of its backlash on which the tray hangs.
    """

    pixel: float
    pixel_ratio: Array
    depth: float
    tray: float
    range_sigma: float
    surface: Array
    tray_direction: Array
