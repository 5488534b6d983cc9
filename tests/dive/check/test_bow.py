# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What `check` says of where the ship lies, its bow, and where stations count from."""

import numpy as np
import pytest

from hullrecon.dive.check.hull_checks import check_reach, describe_bow, refuse_far_hull
from hullrecon.dive.config.schema import Hull
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.sensors import DvlPings


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


@pytest.mark.parametrize(
    ("x_m", "sigma_m", "lost", "is_told"),
    [
        (5.0, 1.0, 0, False),  # the dive begins below the ship
        (16.0, 1.0, 0, False),  # 6 m of way, 6 m of range and five sigmas reach it
        (19.0, 1.0, 0, True),
        (19.0, 2.0, 0, False),
        (19.0, 1.0, 15, False),  # as fast as the fastest where the DVL gave no velocity
        (19.0, 1.0, 60, False),  # nothing tells how far it came
    ],
)
def test_a_ship_where_the_dive_never_came_is_told(x_m, sigma_m, lost, is_told):
    velocity = np.tile([0.1, 0.0, 0.0], (61, 1))
    velocity[0, 0] = 0.4
    velocity[1 : 1 + lost] = np.nan
    if lost == 60:
        velocity[:] = np.nan
    dvl = DvlPings(
        t_ns=np.arange(61) * 10**9,
        velocity=velocity,
        velocity_sigma=np.full(61, 0.003),
        ranges=np.full((61, 1), 6.0),
        beams=np.array([[0.0, 0.0, 1.0]]),
    )
    pose = (x_m, 0.0, 3.0, 180.0, 0.0, 0.0)
    placed = hull(pose=pose, pose_sigma=(sigma_m, sigma_m, 0.3, 1.0, 1.0, 5.0))
    found = check_reach(placed, SHIP, dvl)
    assert [one.code for one in found] == ["hull-out-of-reach"] * is_told
