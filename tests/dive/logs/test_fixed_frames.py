# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where tf_static has the sensors, on the vehicle and on a servo."""

import numpy as np
import pytest

from hullrecon.dive.check.package_check import check_package
from hullrecon.dive.config.load import load_config
from hullrecon.dive.logs.fixed_frames import FixedSensor, fixed_sensors
from hullrecon.dive.logs.messages.descriptions import frame_doubts, frame_tree
from hullrecon.findings.finding import sentences
from hullrecon.steps.ingest import ingest_settings, request_of
from tests.dive.init.test_proposals import entries_of, static

JOINTS = {"tray": "tray", "sonar_tray": "other"}
# two steps of the kit's `static`: axes forward, port, up in the vehicle's
FLIPPED = (0.4, -0.2, 0.0, 180.0, 0.0, 0.0)


def sensors(kit, *steps, frames=None, joints=JOINTS):
    messages = [static(kit, *step) for step in steps]
    frames, doubts = frames or {"dvl": "x"}, frame_doubts(messages)
    return fixed_sensors(frame_tree(messages), frames, joints, doubts)


def test_a_sensor_is_placed_on_the_vehicle(kit):
    found = sensors(kit, ("base_link", "rig", 0.3), ("rig", "x", 0.1))
    assert found == {"dvl": FixedSensor(frame="x", pose=FLIPPED)}


@pytest.mark.parametrize("name", ["tray", "tray_link", "robot/tray_frame"])
def test_the_frame_of_the_servo_on_its_way_says_where_that_turns(kit, name):
    (found,) = sensors(kit, ("base_link", name, 0.3), (name, "x", 0.1)).values()
    assert (found.pose, found.servo_origin, found.on_servo) == (FLIPPED, (0.3, -0.1, 0.0), False)


def test_sensor_on_servo_moved_by_log_is_placed_on_the_servo(kit):
    (found,) = sensors(kit, ("tray_link", "x", 0.1)).values()
    assert (found.pose, found.servo_origin, found.on_servo) == (
        (0.1, -0.1, 0.0, 180.0, 0.0, 0.0),
        None,
        True,
    )


def test_a_frame_of_another_servo_says_nothing(kit):
    assert sensors(kit, ("other_link", "x", 0.1)) == {}
    assert sensors(kit, ("tray_link", "x", 0.1), joints={}) == {}
    assert sensors(kit, ("other_link", "x", 0.1), frames={"sonar": "x"})["sonar"].on_servo


@pytest.mark.parametrize("parent", ["x", "rig"])
def test_a_vehicle_that_hangs_on_its_sensor_places_it(kit, parent):
    steps = [(parent, "base_link", -0.4)] + ([("rig", "x", 0.0)] if parent == "rig" else [])
    (found,) = sensors(kit, *steps).values()
    moved = (0.4, 0.0) if parent == "rig" else (0.4, 0.1)
    assert found.pose == (*moved, 0.0, 180.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("again", "why"),
    [
        (("rig", "x", 0.3), "two places in rig, [0.1, 0.1, 0, 0, 0, 0] and [0.3, 0.1, 0, 0, 0, 0]"),
        (("world", "x", 0.1), "two parents, rig and world"),
    ],
)
def test_a_frame_with_two_places_is_not_placed(kit, again, why):
    steps = [("base_link", "rig", 0.3), ("rig", "x", 0.1), again]
    assert sensors(kit, *steps)["dvl"].doubt == f"tf_static gives x {why}"


def test_a_frame_that_is_sent_again_has_one_place(kit):
    steps = [("base_link", "rig", 0.3), ("rig", "x", 0.1)]
    assert sensors(kit, *steps, *steps) == sensors(kit, *steps)


def test_a_frame_without_rotation_is_named(kit):
    message = static(kit, "base_link", "x", 0.1)
    message.transforms[0].transform.rotation.w = 0.0
    doubts = frame_doubts([message])
    found = fixed_sensors(frame_tree([message]), {"dvl": "x"}, JOINTS, doubts)
    assert "x no rotation" in found["dvl"].doubt


def check(package, *overrides):
    loaded = load_config(package, {}, overrides)
    return check_package(
        loaded,
        request_of(ingest_settings(loaded)),
    )


def log_with_frames(package, kit, *steps):
    more = [
        ("/tf_static", "tf2_msgs/msg/TFMessage", kit.start_ns + k, static(kit, *step))
        for k, step in enumerate(steps)
    ]
    kit.mcap(package / "logs" / "dive.mcap", entries_of(kit, more))


def test_check_lists_mounts_of_the_log_and_asks_for_others(package, kit):
    log_with_frames(package, kit, ("base_link", "tray_link", 0.3), ("tray_link", "x", 0.1))
    found = check(package, "dvl.mount=[0, 0, 0.08, 0, 90, 0]")
    assert sentences(found.mounts) == [
        "tray.origin = [0.3, -0.1, 0] by tf_static, on the way to x",
        "pressure.origin = [0.4, -0.2, 0] by tf_static, frame x",
        "camera.top.mount = [0.1, -0.1, 0, 180, 0, 0] by tf_static, frame x",
    ]
    assert {f"note: {line}" for line in sentences(found.mounts)} <= set(found.lines())
    assert sentences(found.to_fill_in) == []
    assert not any("tf_static" in line for line in sentences(found.found.unused))
    assert not found.defaults.keys() & {
        "tray.origin",
        "pressure.origin",
        "dvl.mount",
        "camera.top.mount",
    }


def test_without_path_to_vehicle_default_mounts_are_listed(package, kit):
    log_with_frames(package, kit, ("odom", "x", 0.1))
    found = check(package)
    assert found.mounts == []
    assert len(sentences(found.to_fill_in)) == 4
    assert found.defaults["dvl.mount"] == (0.0, 0.0, 0.0, 0.0, 90.0, 0.0)
    assert any("tf_static" in line for line in sentences(found.found.unused))


def test_mounts_of_the_log_are_checked_like_those_of_dive_toml(package, kit):
    """The camera's frame looks up there, the DVL forward."""
    log_with_frames(package, kit, ("base_link", "x", 0.1))
    assert any(
        "camera.top looks 90 degrees away" in line
        for line in sentences(check(package, "dvl.mount=[0,0,0,0,90,0]").warnings)
    )
    assert np.isfinite(check(package).found.records.dvl.ranges).all()
