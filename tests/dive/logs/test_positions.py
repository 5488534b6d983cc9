# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Positions from outside: each message type to a sample, and samples to metres north and east."""

import numpy as np
import pytest

from hullrecon.dive.logs.messages.decode import decode
from hullrecon.dive.logs.messages.samples import TYPES
from hullrecon.dive.logs.positions import is_acoustic, position_fixes
from hullrecon.dive.logs.readers.protocol import Channel
from hullrecon.dive.logs.samples import PositionSample
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences
from hullrecon.records.sensors import PressureSamples

T = 1_777_887_000_123_456_789
KIEL = (54.33, 10.15, 2.0)


def covariance(north_east, size):
    full = np.zeros((size, size))
    full[0, 0], full[1, 1] = north_east
    return full.ravel()


def satellite_fix(kit, status=0, variances=(0.16, 0.36), known=2, ros=2):
    return kit.make(
        "sensor_msgs/msg/NavSatFix",
        ros,
        header=kit.header(T, ros),
        status=kit.make("sensor_msgs/msg/NavSatStatus", ros, status=status, service=1),
        latitude=KIEL[0],
        longitude=KIEL[1],
        altitude=KIEL[2],
        position_covariance=covariance(variances, 3),
        position_covariance_type=known,
    )


def local_pose(kit, xyz, variances=None):
    quaternion = kit.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)
    point = kit.make("geometry_msgs/msg/Point", x=xyz[0], y=xyz[1], z=xyz[2])
    pose = kit.make("geometry_msgs/msg/Pose", position=point, orientation=quaternion)
    if variances is None:
        return kit.make("geometry_msgs/msg/PoseStamped", header=kit.header(T), pose=pose)
    pose = kit.make(
        "geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=covariance(variances, 6)
    )
    return kit.make("geometry_msgs/msg/PoseWithCovarianceStamped", header=kit.header(T), pose=pose)


def geographic(kit, kind):
    at = kit.make(
        "geographic_msgs/msg/GeoPoint", latitude=KIEL[0], longitude=KIEL[1], altitude=KIEL[2]
    )
    if kind == "GeoPointStamped":
        return kit.make("geographic_msgs/msg/GeoPointStamped", header=kit.header(T), position=at)
    quaternion = kit.make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)
    pose = kit.make("geographic_msgs/msg/GeoPose", position=at, orientation=quaternion)
    if kind == "GeoPoseWithCovarianceStamped":
        pose = kit.make(
            "geographic_msgs/msg/GeoPoseWithCovariance",
            pose=pose,
            covariance=covariance((4.0, 4.0), 6),
        )
    return kit.make(f"geographic_msgs/msg/{kind}", header=kit.header(T), pose=pose)


def read(kit, message):
    """The sample of a message, by way of its bytes and the definition that stands in no log."""
    kind = message.__msgtype__
    data = bytes(kit.stores[2].serialize_cdr(message, kind))
    fields = decode(Channel("/usbl", kind, "cdr"), data)
    (sample,) = TYPES["position"][kind](fields, T, "position")
    return sample


def test_satellite_fix_has_place_and_sigma_of_its_covariance(kit):
    sample = read(kit, satellite_fix(kit))
    assert tuple(sample.place) == KIEL
    assert sample.sigma_m == pytest.approx(np.sqrt(0.26))
    assert (sample.geographic, sample.by_satellite) == (True, True)


@pytest.mark.parametrize(
    ("variances", "known"),
    [((0.16, 0.36), 0), ((0.0, 0.0), 2), ((np.nan, 1.0), 2), ((-1.0, 0.0), 1)],
)
def test_a_covariance_that_is_unknown_gives_no_sigma(kit, variances, known):
    assert np.isnan(read(kit, satellite_fix(kit, variances=variances, known=known)).sigma_m)


def test_a_status_of_minus_one_is_no_fix(kit):
    assert np.isnan(read(kit, satellite_fix(kit, status=-1)).place).all()


@pytest.mark.parametrize(
    "kind", ["GeoPointStamped", "GeoPoseStamped", "GeoPoseWithCovarianceStamped"]
)
def test_geographic_messages_are_of_any_depth(kit, kind):
    sample = read(kit, geographic(kit, kind))
    assert tuple(sample.place) == KIEL
    assert (sample.geographic, sample.by_satellite) == (True, False)
    assert sample.sigma_m == 2.0 if "Covariance" in kind else np.isnan(sample.sigma_m)


def test_messages_of_a_local_frame_are_metres(kit):
    point = kit.make("geometry_msgs/msg/Point", x=1.0, y=2.0, z=-3.0)
    of_point = read(
        kit, kit.make("geometry_msgs/msg/PointStamped", header=kit.header(T), point=point)
    )
    of_pose, known = (
        read(kit, local_pose(kit, (1.0, 2.0, -3.0))),
        read(kit, local_pose(kit, (1.0, 2.0, -3.0), (0.25, 0.25))),
    )
    for sample in (of_point, of_pose, known):
        assert tuple(sample.place) == (1.0, 2.0, -3.0)
        assert not sample.geographic
    assert known.sigma_m == 0.5
    assert np.isnan([of_point.sigma_m, of_pose.sigma_m]).all()


# samples to fixes


def local(t_s, x, y, sigma=np.nan):
    return PositionSample(int(t_s * 1e9), np.array([x, y, 0.0]), sigma, False)


def by_gps(t_s, latitude, longitude):
    return PositionSample(
        int(t_s * 1e9), np.array([latitude, longitude, 0.0]), np.nan, True, by_satellite=True
    )


def test_east_and_north_become_north_and_east_of_the_first_fix():
    samples = [local(0, 500_000.0, 6_000_000.0), local(1, 500_003.0, 6_000_001.0, 0.7)]
    fixes = position_fixes(samples, 2.0, "enu", None, [])
    np.testing.assert_array_equal(fixes.north_east, [[0, 0], [1, 3]])
    np.testing.assert_array_equal(fixes.sigma, [2.0, 0.7])
    np.testing.assert_array_equal(
        position_fixes(samples, 2.0, "ned", None, []).north_east, [[0, 0], [3, 1]]
    )


def test_latitude_and_longitude_become_metres():
    fixes = position_fixes([by_gps(0, 45.0, 9.0), by_gps(1, 45.001, 9.0)], 2.0, "ned", None, [])
    np.testing.assert_allclose(fixes.north_east[1], [111.13, 0], atol=0.01)


@pytest.mark.parametrize(
    "place", [(np.nan, 9.0), (45.0, np.inf), (0.0, 0.0), (91.0, 9.0), (45.0, 4e5)]
)
def test_a_message_without_a_fix_is_left_out_and_counted(place):
    notes = []
    fixes = position_fixes([by_gps(0, 45.0, 9.0), by_gps(1, *place)], 2.0, "enu", None, notes)
    assert len(fixes.t_ns) == 1
    assert sentences(notes) == ["position: 1 of 2 messages have no fix and were left out"]


def test_no_fix_at_all_is_no_record():
    notes = []
    assert position_fixes([by_gps(0, np.nan, np.nan)] * 3, 2.0, "enu", None, notes) is None
    assert sentences(notes) == ["position: 3 of 3 messages have no fix and were left out"]
    assert position_fixes([], 2.0, "enu", None, notes) is None


def test_a_gps_fix_under_water_is_refused_and_usbl_is_not():
    depth = PressureSamples(t_ns=np.arange(0, 100, 10) * 10**9, depth=np.linspace(0.2, 9.2, 10))
    notes = []
    fixes = position_fixes(
        [by_gps(t, 45.0 + 1e-5 * t, 9.0) for t in (1, 5, 40, 80)], 2.0, "enu", depth, notes
    )
    assert len(fixes.t_ns) == 2
    assert sentences(notes) == [
        "position: 2 of 4 GPS fixes are of a vehicle deeper than 1 m, where no antenna receives: "
        "they are not used; acoustic positions of this type are, with position.source = "
        '"acoustic"'
    ]
    assert (
        len(position_fixes([local(t, t, 0.0) for t in (1, 5, 40, 80)], 2.0, "enu", depth, []).t_ns)
        == 4
    )


def test_where_no_depth_is_known_a_gps_fix_is_believed():
    depth = PressureSamples(t_ns=np.arange(100, 110) * 10**9, depth=np.full(10, 5.0))
    notes = []
    assert (
        len(position_fixes([by_gps(t, 45.0, 9.0) for t in (1, 2)], 2.0, "enu", depth, notes).t_ns)
        == 2
    )
    assert sentences(notes) == []


def test_fixes_of_another_form_than_the_first_are_left_out():
    notes = []
    fixes = position_fixes(
        [local(0, 0, 0), by_gps(1, 45.0, 9.0), local(2, 1, 1)], 2.0, "enu", None, notes
    )
    assert len(fixes.t_ns) == 2
    assert "1 of 3 fixes are not of the form of the first" in notes[0].sentence


@pytest.mark.parametrize(
    ("source", "topic", "acoustic"),
    [
        (None, "/usbl/fix", True),
        (None, "/waterlinked/ugps/global", True),
        (None, "/gps/fix", False),
        (None, "/mavros/global_position/raw/fix", False),
        ("acoustic", "/gps/fix", True),
        ("satellite", "/usbl/fix", False),
    ],
)
def test_a_topics_name_or_a_key_says_that_positions_are_acoustic(source, topic, acoustic):
    assert is_acoustic(source, topic) == acoustic


def test_a_fix_that_may_be_anywhere_is_lost(kit):
    assert np.isnan(read(kit, satellite_fix(kit, variances=(1e9, 1e9))).place).all()


UNITS = {
    "radians": lambda degrees: np.radians(degrees),
    "1e-7 degrees": lambda degrees: np.round(1e7 * np.array(degrees)),
    "ddmm": lambda degrees: 100 * np.floor(degrees) + 60 * (np.array(degrees) % 1),
}


@pytest.mark.parametrize("unit", UNITS)
def test_places_in_another_unit_than_degrees_are_refused_until_they_are(unit):
    def fixes(change):
        places = [(54.33 + 1e-5 * k, 10.15, 0.0) for k in range(5)]
        samples = [
            PositionSample(T + k, np.array([*change(place[:2]), 0.0]), 0.3, True)
            for k, place in enumerate(places)
        ]
        return position_fixes(samples, 2.0, "enu", None, [])

    with pytest.raises(InputError, match=unit) as caught:
        fixes(UNITS[unit])
    assert "log them in degrees" in caught.value.remedy
    assert len(fixes(lambda place: place)) == 5
