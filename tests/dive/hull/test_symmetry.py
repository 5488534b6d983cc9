# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A CAD model that lies on its side is told by its symmetry, and nothing else is."""

import re

import numpy as np
import pytest
from dive.hull.shapes import barge, box, spindle

from hullrecon.dive.check.hull_checks import check_afloat, check_upright
from hullrecon.dive.config.schema import Hull
from hullrecon.dive.hull.symmetry import find_lying_side
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import from_mount, up_in

Y_UP = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


def test_a_ship_on_her_side_is_named_and_upright_again_when_turned():
    ship = Mesh(barge().vertices @ Y_UP.T, barge().faces)
    (named,) = check_upright(Hull(mesh="h.stl"), ship)
    assert named.sentence.startswith("the CAD model: it is symmetric about a level plane")
    assert "exported with y up? Then give hull.pose" in named.sentence
    (numbers,) = re.findall(r"hull\.pose = \[(.*)\]", named.sentence)
    upright = Hull(mesh="h.stl", pose=tuple(float(number) for number in numbers.split(",")))
    assert check_upright(upright, ship) == []
    assert up_in(from_mount(upright.pose)) == pytest.approx([0, 1, 0])


def test_a_ship_under_water_is_named_and_afloat_again_when_turned_over():
    ship = Mesh(barge().vertices * [1, -1, -1], barge().faces)
    given = Hull(mesh="h.stl", pose=(1.0, 2.0, 3.5, 180.0, 0.0, -90.0))
    assert check_afloat(given, barge()) == []
    (named,) = check_afloat(given, ship)
    (numbers,) = re.findall(
        r"does its z point down\? Then give hull\.pose = \[(.*?)\]", named.sentence
    )
    afloat = Hull(mesh="h.stl", pose=tuple(float(number) for number in numbers.split(",")))
    assert check_afloat(afloat, ship) == []


@pytest.mark.parametrize(
    "mesh",
    [barge(), box([0, -4, 0], [40, 4, 5]), spindle(), spindle((-np.pi / 2, np.pi / 2))],
    ids=["upright", "a box", "a body of revolution", "half of one"],
)
def test_a_form_that_may_be_upright_is_not_named(mesh):
    assert find_lying_side(mesh, np.eye(3), from_mount(np.zeros(6))) is None
