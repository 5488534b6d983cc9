# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Test whether a CAD model that does not fit the survey would fit it in another unit of length."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.adjustment.hull_pose.registration import (
    GOOD_FITNESS,
    GUESS_SIGMAS,
    Registration,
    register,
)
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry.charts.chart import chart_for_hull
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.units import LONGEST_M, METRES_PER_UNIT, SHORTEST_M
from hullrecon.typing import Array


def find_fitting_unit(
    points: Array, cad_model: CadModel, range_sigma_m: float
) -> tuple[str, Registration] | None:
    """Register the CAD model to points (n, 3) in g with its file read in each other unit.

    Units in which it would not have the size of a ship are left out. Returns the unit in which it
    fits best, and that registration. None if it fits in no unit near the package's guess of its
    pose.
    """
    length_m = float(np.ptp(cad_model.mesh.vertices, axis=0).max())
    found = []
    for unit, metres in METRES_PER_UNIT.items():
        scale = metres / METRES_PER_UNIT[cad_model.units]
        if unit == cad_model.units or not SHORTEST_M <= scale * length_m <= LONGEST_M:
            continue
        mesh = Mesh(scale * cad_model.mesh.vertices, cad_model.mesh.faces)
        chart = chart_for_hull(mesh, cad_model.chart.ship_axes[2])
        other = replace(cad_model, mesh=mesh, chart=chart, units=unit)
        tried = register(points, other, range_sigma_m)
        if tried.fitness >= GOOD_FITNESS and tried.sigmas_off <= GUESS_SIGMAS:
            found.append((unit, tried))
    return max(found, key=lambda one: one[1].fitness, default=None)
