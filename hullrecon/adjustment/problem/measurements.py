# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Measurements of the adjustment: records of navigation and vision, the rig, the CAD model."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.native import LENS_MODES
from hullrecon.records.planes import TiedPlanes
from hullrecon.records.tracks import Tracks
from hullrecon.records.trajectory import (
    Attitude,
    Odometry,
    PositionTies,
    Returns,
    Trajectory,
    VehiclePath,
)
from hullrecon.rig import Rig
from hullrecon.typing import Array


@dataclass(frozen=True)
class CadModel:
    """The ship's CAD model with the package's prior of its pose and its error."""

    mesh: Mesh  # in M
    chart: Chart  # of the hull, in M
    guess: Poses  # global_from_hull, a batch of one
    # (6,) m and rad in M's axes, of the position of the survey's middle and of the rotation
    guess_sigma: Array
    deviation_sigma: float  # m, of the hull's deviation from the CAD model
    deviation_length: tuple[float, float]  # m, correlation length of that along and in girth
    units: str = "m"  # in which the file was read; a refusal may name another unit that would fit
    has_stated_length: bool = False  # it was held against hull.length_overall before
    # Sigmas were widened, as the hull lies farther from the guess, or deviates more, than stated
    contradicted: bool = False


@dataclass(frozen=True, kw_only=True)
class Measurements:
    """All that enters the adjustment."""

    trajectory: Trajectory
    odometry: Odometry
    returns: Returns | None  # None without a DVL
    attitude: Attitude
    tracks: Tracks | None  # None without a camera
    rig: Rig
    cad_model: CadModel | None  # None without a CAD model
    start: VehiclePath | None = None  # path to begin with; None: dead reckoning
    planes: TiedPlanes | None = None  # patches of hull, which tie passes without a CAD model
    positions: PositionTies | None = None  # position fixes (USBL, GNSS)
    # (k, 2, 2 LENS_MODES) px, displacements of top and bottom lens that k rounds estimated. Pixels
    # are moved by one after the other when they are read.
    lens_steps: Array = field(default_factory=lambda: np.zeros((0, 2, 2 * LENS_MODES)))

    @property
    def lenses(self) -> Array:
        """The displacements (2, 2 LENS_MODES) px of all rounds together."""
        return np.asarray(self.lens_steps.sum(axis=0))
