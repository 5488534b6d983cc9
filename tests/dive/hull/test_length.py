# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A CAD model's scale and unit are held against the length in the ship's papers."""

import re

import pytest
from dive.hull.shapes import box
from scipy.spatial.transform import Rotation

from hullrecon.dive.check.hull_checks import check_length
from hullrecon.dive.config.schema import Hull
from hullrecon.errors import InputError
from hullrecon.geometry.meshes.mesh import Mesh

SHIP = box([0, -4, 0], [40, 4, 5])


def checked(length_m, units="m"):
    return check_length(Hull(mesh="h.stl", units=units, length_overall=length_m), SHIP)


def test_a_model_of_the_stated_length_is_not_named():
    assert checked(39.7) == []
    assert check_length(Hull(mesh="h.stl"), SHIP) == []


def test_a_model_to_another_scale_is_refused_with_the_ratio():
    with pytest.raises(InputError, match=r"40\.0 m long, 0\.909 times the 44 m of hull\.length"):
        checked(44.0)


def test_the_unit_that_gives_the_stated_length_heals():
    with pytest.raises(InputError) as refused:
        checked(40 * 0.3048)
    (unit,) = re.findall(r'set hull\.units = "(\w+)"', str(refused.value))
    in_feet = box([0, -4 * 0.3048, 0], [40 * 0.3048, 4 * 0.3048, 5 * 0.3048])
    assert check_length(Hull(mesh="h.stl", units=unit, length_overall=40 * 0.3048), in_feet) == []


def test_a_model_that_lacks_an_end_is_warned_of():
    (found,) = checked(41.0)
    assert "2.4 % less than hull.length_overall" in found.sentence


@pytest.mark.parametrize("turn_deg", [30.0, -30.0])
def test_a_model_that_lies_turned_is_named_and_turned_back_it_heals(turn_deg):
    def turned(mesh, degrees):
        about = Rotation.from_euler("z", degrees, degrees=True)
        return Mesh(about.apply(mesh.vertices), mesh.faces)

    stated, skew = Hull(mesh="h.stl", units="m", length_overall=40.0), turned(SHIP, turn_deg)
    with pytest.raises(InputError, match=rf"turned by \{turn_deg:+.0f} degrees") as refused:
        check_length(stated, skew)
    (back,) = re.findall(r"export it turned by (\S+) degrees", str(refused.value))
    assert check_length(stated, turned(skew, float(back))) == []
