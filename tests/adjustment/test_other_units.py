# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A CAD model read in the wrong unit is named where the survey fits it in another."""

from dataclasses import replace

import numpy as np
from adjustment.scenes import ERROR, TRUTH, cad_model, side, survey

from hullrecon.adjustment.cad_acceptance import add_fitting_unit_and_heading
from hullrecon.adjustment.hull_pose.other_units import find_fitting_unit
from hullrecon.adjustment.hull_pose.registration import register
from hullrecon.adjustment.rounds import Verdict
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.units import METRES_PER_UNIT

HULL = side(1.0)
POINTS = TRUTH.apply(survey(HULL, np.random.default_rng(0)))


def read_as(unit: str, true_unit: str):
    """The CAD model of a file in one unit that was read in another."""
    scale = METRES_PER_UNIT[unit] / METRES_PER_UNIT[true_unit]
    model = cad_model(Mesh(HULL.vertices * scale, HULL.faces), TRUTH, ERROR)
    return replace(model, units=unit)


def test_the_unit_in_which_the_survey_fits_is_named():
    model = read_as("m", "ft")
    fitting = find_fitting_unit(POINTS, model, 0.01)
    assert fitting is not None
    unit, found = fitting
    assert unit == "ft"
    assert found.fitness > 0.95
    refused = Verdict(accepted=False, reason="it fits badly")
    badly = register(POINTS, model, 0.01)
    assert add_fitting_unit_and_heading(refused, badly, POINTS, 0.01).reason == (
        "it fits badly; read in feet it fits 100 % of the points where hull.pose says "
        '(hull.units = "ft")'
    )


def test_another_ship_is_not_called_a_matter_of_units():
    bumps = 0.5 * np.sin(2.0 * HULL.vertices[:, [0]]) * np.array([0.0, 1.0, 0.0])
    model = cad_model(Mesh(HULL.vertices + bumps, HULL.faces), TRUTH, ERROR)
    assert find_fitting_unit(POINTS, model, 0.01) is None
