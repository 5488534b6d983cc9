# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What `check` says of where the ship lies, its bow, and where stations count from."""

import numpy as np
import pytest

from hullrecon.dive.check.hull_checks import describe_bow, refuse_far_hull
from hullrecon.dive.config.schema import Hull
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences
from hullrecon.geometry.meshes.mesh import Mesh


def box(low, high):
    return Mesh(np.array([low, high], float), np.zeros((0, 3), np.int32))


SHIP = box((0, -4.5, 0), (50, 4.5, 5.5))


def told(*words):
    bow, warnings = describe_bow(*words)
    return bow.sentence, sentences(warnings)


def hull(**more):
    return Hull(mesh="h.stl", **more)


def test_assumed_bow_is_described_with_reason():
    line, warnings = told(hull(), SHIP)
    assert line == (
        "bow: at x = +50.0 m of the CAD model (where x grows, as hull.bow is not given); stations "
        "count from its x = 0, "
        "0.0 m forward of its aft end"
    )
    assert warnings == []


def test_a_bow_at_zero_has_no_minus_sign():
    line, _ = told(hull(bow="-x"), box((0.02, -4.5, 0), (50, 4.5, 5.5)))
    assert line.startswith("bow: at x = +0.0 m")


def test_a_bow_on_the_negative_axis_is_the_other_end():
    line, warnings = told(
        hull(bow="-x", aft_perpendicular=-1.5), box((-50, -4.5, 0), (0, 4.5, 5.5))
    )
    assert line == (
        "bow: at x = -50.0 m of the CAD model (hull.bow); stations count from its x = -1.5 m, 1.5 "
        "m forward of its aft end"
    )
    assert warnings == []


def test_ships_axis_is_the_longest_axis_level_by_pose():
    # y up, a tall rig
    line, _ = told(hull(pose=(0, 0, 0, -90, 0, 0)), box((-4.5, -60, -1), (4.5, 60, 49)))
    assert line.startswith("bow: at z = +49.0 m of the CAD model")
    assert line.endswith("stations count from its z = 0, 1.0 m forward of its aft end")


def test_a_zero_amidships_is_no_aft_perpendicular():
    line, (warning,) = told(hull(), box((-25, -4.5, 0), (25, 4.5, 5.5)))
    assert line.endswith("stations count from its x = 0, 25.0 m forward of its aft end")
    assert warning.endswith(
        "give hull.bow; if its aft perpendicular lies elsewhere, hull.aft_perpendicular"
    )
    assert told(hull(aft_perpendicular=-25), box((-25, -4.5, 0), (25, 4.5, 5.5)))[1] == []
    _, (turned,) = told(hull(bow="-x"), SHIP)
    assert "50.0 m forward of its aft end" in turned


@pytest.mark.parametrize(("bow", "first"), [(None, "573412.0"), ("-x", "573462.0")])
def test_stations_of_a_ship_in_map_coordinates_count_from_its_aft_end(bow, first):
    line, warnings = told(hull(bow=bow), box((573412, 6020150, 0), (573462, 6020159, 5.5)))
    assert line.endswith(f"stations count from its x = {first} m, 0.0 m forward of its aft end")
    assert warnings == []


def test_a_bow_across_the_ship_is_an_error():
    with pytest.raises(InputError, match=r"the bow cannot lie at \+y"):
        told(hull(bow="+y"), SHIP)


def test_pose_that_leaves_the_ship_at_its_berth_is_refused():
    """In map coordinates, with a pose that was given for another origin, or in kilometres."""
    at_berth = box((573412, 6020150, -3.8), (573462, 6020159, 1.7))
    with pytest.raises(InputError, match=r"6047 km from where the dive begins"):
        refuse_far_hull(hull(pose=(8.7, 33.1, 3.5, 180.0, 0.0, 0.0)), at_berth)
    refuse_far_hull(hull(pose=(-573437.0, 6020155.0, 3.5, 180.0, 0.0, 0.0)), at_berth)
    refuse_far_hull(hull(pose=(800.0, -600.0, 3.5, 180.0, 0.0, 0.0)), SHIP)
