# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from hullrecon.dive.config.schema import DiveConfig
from hullrecon.geometry.poses import from_mount
from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.dive_toml import dive_toml, initial_guess
from hullrecon.synthetic.options import with_options
from hullrecon.synthetic.vehicle import CAMERA_MOUNT, TRANSPONDER, true_rig


def decode(text: str) -> DiveConfig:
    return msgspec.convert(tomllib.loads(text), DiveConfig)


def test_dive_toml_is_strictly_valid_and_nominal(package: Path) -> None:
    config = decode((package / "dive.toml").read_text())
    assert config.dive.name == "small"
    assert config.camera.top is not None
    assert config.camera.top.mount == CAMERA_MOUNT
    assert config.sonar is not None
    assert config.hull is not None


def test_first_guess_is_off_by_what_was_asked_for(
    dive: Dive,
) -> None:
    config = decode(dive_toml(dive))
    assert config.hull is not None
    slip = dive.motion.global_from_hull.inverse() @ from_mount(config.hull.pose)
    middle = dive.hull.near(0.0).patch.point.reshape(-1, 3).mean(0)
    off = slip.apply(middle[None])[0] - middle
    assert abs(off[0]) == pytest.approx(dive.spec.guess.along_m, abs=1e-4)
    assert abs(off[1]) == pytest.approx(dive.spec.guess.across_m, abs=1e-4)
    assert abs(np.degrees(slip.log()[0, 5])) == pytest.approx(dive.spec.guess.turn_deg, abs=0.01)


def test_perfect_guess_is_truth(dive: Dive) -> None:
    spec = with_options(dive.spec, guess_along_m=0.0, guess_across_m=0.0, guess_turn_deg=0.0)
    np.testing.assert_allclose(
        initial_guess(replace(dive, spec=spec)).matrix(),
        dive.motion.global_from_hull.matrix(),
        atol=1e-9,
    )


def test_positions_are_told_with_their_lever_arm_and_sigma(dive: Dive) -> None:
    assert "[position]" not in dive_toml(dive)
    config = decode(
        dive_toml(
            replace(dive, spec=with_options(dive.spec, position_every_s=5.0, position_sigma_m=0.4))
        )
    )
    assert config.topics.position == "/usbl"
    assert config.position.origin == TRANSPONDER
    assert (config.position.sigma_m, config.position.frame) == (0.4, "enu")


@pytest.mark.parametrize(("cameras", "kept"), [("mono", {"top"}), ("none", set())])
def test_rig_with_fewer_cameras_says_so(dive: Dive, cameras: str, kept: set[str]) -> None:
    spec = with_options(dive.spec, cameras=cameras, sonar=False)
    config = decode(dive_toml(replace(dive, spec=spec, rig=true_rig(spec))))
    assert {name for name in ("top", "bottom") if getattr(config.camera, name) is not None} == kept
    assert (config.topics.camera_top is not None) == ("top" in kept)
    assert config.sonar is None
    assert config.topics.sonar is None


def told(dive: Dive, **errors: float) -> DiveConfig:
    return decode(dive_toml(replace(dive, spec=with_options(dive.spec, **errors))))


@pytest.mark.parametrize("drift", [144.0, -144.0])
def test_dive_toml_tells_sigma_as_large_as_drift(dive: Dive, drift: float) -> None:
    assert told(dive, heading_drift_deg_per_hour=drift).imu.heading_drift_deg_per_hour == 144.0


@pytest.mark.parametrize("error", [0.02, -0.02])
def test_dive_toml_tells_sigma_as_large_as_scale_error(dive: Dive, error: float) -> None:
    assert told(dive, dvl_scale_error=error).dvl.scale_sigma == 0.02


def test_dive_toml_tells_sigma_as_large_as_backlash(dive: Dive) -> None:
    assert told(dive, backlash_deg=3.0, servo_sigma_deg=0.0).tray.sigma_deg == 3.0
    assert told(dive, backlash_deg=3.0, servo_sigma_deg=4.0).tray.sigma_deg == 5.0


def test_dive_toml_gives_class_of_instrument_for_smaller_errors(dive: Dive) -> None:
    config = told(
        dive,
        heading_drift_deg_per_hour=0.0,
        dvl_scale_error=0.0,
        backlash_deg=0.0,
        servo_sigma_deg=0.0,
    )
    assert config == decode(dive_toml(dive))
    assert (
        config.imu.heading_drift_deg_per_hour,
        config.dvl.scale_sigma,
        config.tray.sigma_deg,
    ) == (1.0, 0.005, 0.8)
