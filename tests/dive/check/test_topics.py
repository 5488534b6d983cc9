# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import re

import pytest

from hullrecon.dive.check.topics import (
    CLOUDS,
    COMMANDS,
    DEPTHS,
    ECHOES,
    POSITIONS,
    RANGES,
    describe_unused,
    unread_dvls,
)
from hullrecon.dive.logs.messages.samples import TYPES
from hullrecon.dive.logs.readers.protocol import Channel
from hullrecon.findings.finding import sentences

POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"


def channel(topic, kind, encoding="cdr"):
    return Channel(topic, kind, encoding)


@pytest.mark.parametrize(
    ("topic", "kind", "reason"),
    [
        ("/altimeter", "sensor_msgs/msg/Range", RANGES),
        ("/altimeter", "sensor_msgs/Range", RANGES),
        ("/fix", "gps_common/msg/GPSFix", POSITIONS),
        ("/usbl/range", "usbl/msg/SlantRange", POSITIONS),
        ("/ping360_node/sonar/data", "ping360_sonar_msgs/msg/SonarEcho", ECHOES),
        ("/ping360_data", "ping360_sonar/SonarEcho", ECHOES),
        ("/sonar3d/points", "sensor_msgs/msg/PointCloud2", CLOUDS),
        ("/bar30", "bluerov_interfaces/msg/Bar30", DEPTHS),
        ("/bar30/data", "orca_msgs/msg/Barometer", DEPTHS),
        ("/GPS1/odom", "nav_msgs/msg/Odometry", POSITIONS),
        ("/cmd_vel", "geometry_msgs/msg/TwistStamped", COMMANDS),
        ("/goal", "geometry_msgs/msg/PoseStamped", COMMANDS),
    ],
)
def test_topic_of_no_use_is_told_with_type_and_reason(topic, kind, reason):
    (found,) = describe_unused([channel(topic, kind)], set())
    assert found.code == reason
    assert found.sentence.startswith(f"a run would not use {topic} ({kind}): ")


@pytest.mark.parametrize(
    ("topic", "kind", "sensors"),
    [
        ("/odometry/filtered", "nav_msgs/msg/Odometry", "dvl or imu or pressure"),
        ("/pose", POSE, "imu or pressure or position"),
        ("/fix", "sensor_msgs/msg/NavSatFix", "position"),
        ("/surface", "geographic_msgs/msg/GeoPointStamped", "position"),
        ("/usbl/pose", POSE, "position"),
        ("/usbl_point", "geometry_msgs/msg/PointStamped", "position"),
        ("/twist", "geometry_msgs/msg/TwistWithCovarianceStamped", "dvl"),
        # an instrument's own type says more than its name
        ("/gps/imu", "sensor_msgs/msg/Imu", "imu"),
        ("/fixed_cam", "sensor_msgs/msg/Image", "camera_top or camera_bottom"),
    ],
)
def test_a_topic_of_a_type_that_is_read_is_told_as_what(topic, kind, sensors):
    (line,) = sentences(describe_unused([channel(topic, kind)], set()))
    assert (
        line
        == f"not chosen, though of a type that is read: {topic} (could be {sensors}); name it in "
        "[topics] to use it"
    )
    assert all(kind in TYPES[name] for name in sensors.split(" or "))


def test_types_of_depths_that_are_advised_are_read():
    (line,) = sentences(describe_unused([channel("/bar30", "orca_msgs/msg/Barometer")], set()))
    advised = re.findall(r"\w+_msgs/\w+", line.partition("read from")[2])
    assert len(advised) == 3
    assert {kind.replace("/", "/msg/") for kind in advised} <= set(TYPES["pressure"])


def test_used_topics_are_omitted_and_others_share_a_line():
    found = [
        channel("/usbl", POSE),
        channel("/rosout", "rcl_interfaces/msg/Log"),
        channel("/a", "x/msg/Y"),
        channel("/b", ""),
    ]
    assert sentences(describe_unused(found, {"/usbl", "/b"})) == [
        "a run would not use /a, /rosout: of other types than it reads"
    ]


def test_unreadable_encoding_makes_a_topic_unreadable():
    assert sentences(describe_unused([channel("/imu", "sensor_msgs/msg/Imu", "json")], set())) == [
        "a run would not use /imu: of other types than it reads"
    ]


def test_dvl_topics_of_unreadable_types_are_found_by_name():
    found = [
        channel("/teledyne_navigator/ensemble", "teledyne_navigator/Ensemble", "ros1"),
        channel("/vel", "cirs/LinkquestDvl"),
        channel("/dvl", "marine_acoustic_msgs/msg/Dvl"),
        channel("/dvl/gps", "sensor_msgs/msg/NavSatFix"),
        channel("/rosout", "rosgraph_msgs/Log"),
    ]
    assert unread_dvls(found) == [
        "/teledyne_navigator/ensemble (teledyne_navigator/Ensemble)",
        "/vel (cirs/LinkquestDvl)",
    ]
