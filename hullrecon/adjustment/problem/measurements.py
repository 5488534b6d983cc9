# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the adjustment measures and starts from: records of navigation and vision, the rig with its
priors, the CAD model.
"""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
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
    """The ship's CAD model: mesh and chart in M, the package's guess of T_g_M with sigmas (6,) in
    M's axes (m, rad); contradicted: its sigmas were widened, since the hull lies farther from the
    guess, or leaves the model by more.
    """

    mesh: Mesh
    chart: Chart
    guess: Poses
    guess_sigma: Array
    deviation_sigma: float
    deviation_length: tuple[float, float]
    contradicted: bool = False


@dataclass(frozen=True, kw_only=True)
class Measurements:
    """All that enters the adjustment. tracks None: no camera; CAD model None: no CAD; start None:
    dead reckoning is the path to begin with; planes: what ties passes where there is no CAD model;
    positions: from outside, None where there are none.
    """

    trajectory: Trajectory
    odometry: Odometry
    returns: Returns | None
    attitude: Attitude
    tracks: Tracks | None
    rig: Rig
    cad_model: CadModel | None
    start: VehiclePath | None = None
    planes: TiedPlanes | None = None
    positions: PositionTies | None = None
