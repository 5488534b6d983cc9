# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Lever arms and mounts that dive.toml leaves to the log."""

from dataclasses import replace

import numpy as np
import pytest

from hullrecon.dive.config.load import load_config
from hullrecon.dive.config.mounts import (
    choose_mounts,
    describe_mounts,
    filled_in,
    numbers_of,
    refuse_mounts,
)
from hullrecon.dive.config.schema import DEFAULT_MOUNTS, FROM_LOG
from hullrecon.dive.logs.fixed_frames import FixedSensor
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences

LEFT = dict.fromkeys(DEFAULT_MOUNTS, FROM_LOG)
ORIGIN = (0.45, 0.0, 0.1)
DVL = FixedSensor(frame="d", pose=(0.45, 0.0, 0.18, 0.0, 90.0, 0.0), servo_origin=ORIGIN)


def values(mounts):
    return {key: mount.value for key, mount in mounts.items()}


def test_without_tf_static_the_defaults_stand():
    chosen = choose_mounts(LEFT, {})
    assert values(chosen) == DEFAULT_MOUNTS
    assert sentences(describe_mounts(chosen)) == []


def test_mount_on_servo_is_relative_to_the_servo_axis():
    chosen = choose_mounts(LEFT, {"dvl": DVL})
    assert chosen["tray.origin"].value == ORIGIN
    assert chosen["dvl.mount"].value == (0.0, 0.0, 0.08, 0.0, 90.0, 0.0)
    assert sentences(describe_mounts(chosen)) == [
        "tray.origin = [0.45, 0, 0.1] by tf_static, on the way to d",
        "dvl.mount = [0, 0, 0.08, 0, 90, 0] by tf_static, frame d",
    ]


def test_mounts_of_dive_toml_take_precedence_over_the_log():
    chosen = choose_mounts({**LEFT, "tray.origin": (0.4, 0.0, 0.0)}, {"dvl": DVL})
    assert "tray.origin" not in chosen
    assert chosen["dvl.mount"].value == (0.05, 0.0, 0.18, 0.0, 90.0, 0.0)
    assert "dvl.mount" not in choose_mounts({**LEFT, "dvl.mount": (0.0,) * 6}, {"dvl": DVL})


def test_without_servo_frame_tray_origin_is_the_vehicles():
    fixed = FixedSensor(frame="d", pose=(1.0, 0.0, 0.0, 0.0, 90.0, 0.0))
    chosen = choose_mounts(LEFT, {"dvl": fixed})
    assert (chosen["tray.origin"].value, chosen["dvl.mount"].value) == ((0.0, 0.0, 0.0), fixed.pose)
    assert (
        chosen["tray.origin"].source
        == "tf_static, which has no frame of the servo: the vehicle's origin"
    )


def test_servo_moved_by_log_leaves_tray_origin_to_fill_in():
    chosen = choose_mounts(
        LEFT, {"dvl": FixedSensor(frame="d", pose=(0.0, 0.0, 0.08, 0.0, 90.0, 0.0), on_servo=True)}
    )
    assert chosen["dvl.mount"].value == (0.0, 0.0, 0.08, 0.0, 90.0, 0.0)
    assert (chosen["tray.origin"].value, chosen["tray.origin"].source) == ((0.0, 0.0, 0.0), "")


FIXED_DVL = FixedSensor(frame="dvl_link", pose=(0.0, 0.0, 0.1, 0.0, 0.0, 0.0))
TILTED_CAMERA = FixedSensor(frame="optical", pose=(0.05, 0.0, 0.0, 90.0, 0.0, 90.0), on_servo=True)


@pytest.mark.parametrize(
    "camera", [TILTED_CAMERA, replace(TILTED_CAMERA, on_servo=False, servo_origin=(0.2, 0.0, 0.05))]
)
def test_camera_on_servo_beside_fixed_dvl_is_refused(camera):
    """One tray carries both: the DVL would turn with the camera."""
    sensors = {"dvl": FIXED_DVL, "camera_top": camera}
    with pytest.raises(
        InputError, match="optical on the tray's servo and dvl_link fixed to the vehicle"
    ) as error:
        refuse_mounts(LEFT, sensors, True)
    assert error.value.exit_code == 3
    refuse_mounts({**LEFT, "dvl.mount": (0.0,) * 6, "camera.top.mount": (0.0,) * 6}, sensors, True)
    refuse_mounts(LEFT, {"dvl": DVL, "camera_top": camera}, True)
    refuse_mounts(LEFT, {"dvl": FIXED_DVL}, True)


def test_servo_origin_is_not_claimed_for_a_fixed_sensor():
    chosen = choose_mounts(LEFT, {"dvl": FIXED_DVL, "camera_top": TILTED_CAMERA})
    assert chosen["tray.origin"].source == ""


def test_the_lower_camera_is_placed_in_the_upper_one():
    top = FixedSensor(frame="t", pose=(0.4, 0.0, 0.0, 90.0, 0.0, 90.0))
    bottom = FixedSensor(frame="b", pose=(0.4, 0.0, 0.1, 90.0, 0.0, 90.0))
    chosen = choose_mounts(LEFT, {"camera_top": top, "camera_bottom": bottom})
    np.testing.assert_allclose(
        chosen["camera.bottom.pose_in_top"].value, [0.0, 0.1, 0.0, 0.0, 0.0, 0.0], atol=1e-9
    )
    assert choose_mounts(LEFT, {"camera_bottom": bottom})["camera.bottom.pose_in_top"].source == ""


def test_mounts_are_filled_in_only_where_sections_exist(tmp_path):
    (tmp_path / "dive.toml").write_text(
        '[dive]\nname = "x"\n[logs]\nfiles = ["l"]\n[camera.top]\n[dvl]\nscale_sigma = 0.1\n'
    )
    loaded = load_config(tmp_path)
    assert loaded.value("dvl.mount") == FROM_LOG
    mounts = choose_mounts({key: loaded.value(key) for key in DEFAULT_MOUNTS}, {"dvl": DVL})
    assert not any(key.startswith(("sonar", "camera.bottom")) for key in mounts)
    filled = filled_in(loaded, mounts)
    assert filled.value("dvl.mount") == filled.config.dvl.mount == (0.0, 0.0, 0.08, 0.0, 90.0, 0.0)
    assert (
        filled.config.camera.top.mount
        == filled.value("camera.top.mount")
        == DEFAULT_MOUNTS["camera.top.mount"]
    )
    assert (filled.config.dvl.scale_sigma, filled.config.sonar, filled.given) == (
        0.1,
        None,
        loaded.given,
    )


def test_a_mount_that_is_left_to_the_log_is_no_numbers():
    with pytest.raises(TypeError, match="tf_static"):
        numbers_of(FROM_LOG)


def test_a_place_of_which_tf_static_says_two_has_to_be_given():
    sensors = {"dvl": replace(DVL, doubt="tf_static gives d two parents, a and b")}
    with pytest.raises(InputError, match="two parents") as caught:
        refuse_mounts(LEFT, sensors, True)
    assert caught.value.remedy == "give dvl.mount in dive.toml"
    given = LEFT | {"dvl.mount": (0.0, 0.0, 0.08, 0.0, 90.0, 0.0)}
    refuse_mounts(given, sensors, True)
    assert values(choose_mounts(given, sensors))["tray.origin"] == DEFAULT_MOUNTS["tray.origin"]


def test_lever_arms_in_millimetres_are_refused():
    far = replace(DVL, pose=(450.0, 0.0, 180.0, 0.0, 90.0, 0.0), servo_origin=(450.0, 0.0, 100.0))
    with pytest.raises(InputError, match=r"tray\.origin reaches 450 m by tf_static.*millimetres"):
        refuse_mounts(LEFT, {"dvl": far}, True)
