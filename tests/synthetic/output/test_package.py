# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from hullrecon.dive.config.schema import DiveConfig
from hullrecon.errors import StorageError
from hullrecon.geometry.poses import from_mount
from hullrecon.synthetic.dive import Dive, simulate_dive
from hullrecon.synthetic.options import spec_from, with_options
from hullrecon.synthetic.output import package as package_module
from hullrecon.synthetic.output.package import camera_info, dive_toml, initial_guess, write_package
from hullrecon.synthetic.spec import DiveSpec
from hullrecon.synthetic.vehicle.rig import CAMERA_MOUNT


def decode(text: str) -> DiveConfig:
    return msgspec.convert(tomllib.loads(text), DiveConfig)


def test_the_package_holds_what_the_format_names(package: Path) -> None:
    found = {p.relative_to(package).as_posix() for p in package.rglob("*") if p.is_file()}
    truth = {"poses.csv", "alignment.json", "servo.csv", "sonar_servo.csv", "as_built.ply", "objects.json", "extrinsics.json"}
    assert found == {
        "dive.toml",
        "hull.stl",
        "logs/dive.mcap",
        "calibration/camera_top.yaml",
        "calibration/camera_bottom.yaml",
        *(f"truth/{name}" for name in truth),
    }


def test_dive_toml_is_strictly_valid_and_nominal(package: Path) -> None:
    config = decode((package / "dive.toml").read_text())
    assert config.dive.name == "small"
    assert config.camera.top is not None
    assert config.camera.top.mount == CAMERA_MOUNT
    assert config.sonar is not None
    assert config.hull is not None


def test_the_first_guess_is_off_by_what_was_asked_for_in_the_middle_of_the_survey(dive: Dive) -> None:
    config = decode(dive_toml(dive))
    assert config.hull is not None
    slip = dive.motion.T_g_M.inverse() @ from_mount(config.hull.pose)
    middle = dive.hull.near(0.0).patch.point.reshape(-1, 3).mean(0)
    off = slip.apply(middle[None])[0] - middle
    assert abs(off[0]) == pytest.approx(dive.spec.guess.along_m, abs=1e-4)
    assert abs(off[1]) == pytest.approx(dive.spec.guess.across_m, abs=1e-4)
    assert abs(np.degrees(slip.log()[0, 5])) == pytest.approx(dive.spec.guess.turn_deg, abs=0.01)


def test_a_perfect_guess_is_the_truth(dive: Dive) -> None:
    spec = with_options(dive.spec, guess_along_m=0.0, guess_across_m=0.0, guess_turn_deg=0.0)
    np.testing.assert_allclose(initial_guess(replace(dive, spec=spec)).matrix(), dive.motion.T_g_M.matrix(), atol=1e-9)


def test_camera_info_reads_as_ros_writes_it(dive: Dive) -> None:
    text = camera_info("camera_top", dive.rig.camera_top)
    lines = [line.strip() for line in text.splitlines()]
    assert lines[:3] == ["image_width: 240", "image_height: 192", "camera_name: camera_top"]
    rows = [[float(v) for v in line[7:-1].split(",")] for line in lines if line.startswith("data: [")]
    np.testing.assert_allclose(rows[0], dive.rig.camera_top.matrix().ravel(), rtol=1e-8)
    np.testing.assert_allclose(rows[1], dive.rig.camera_top.distortion(), rtol=1e-8)


@pytest.mark.parametrize(("cameras", "kept"), [("mono", {"top"}), ("none", set())])
def test_a_rig_with_fewer_cameras_says_so(cameras: str, kept: set[str]) -> None:
    spec = spec_from(legs=1, leg_length_m=1.0, structures=0, marks=0, barnacles=0, cameras=cameras, sonar=False)
    config = decode(dive_toml(simulate_dive(spec)))
    assert {name for name in ("top", "bottom") if getattr(config.camera, name) is not None} == kept
    assert (config.topics.camera_top is not None) == ("top" in kept)
    assert config.sonar is None
    assert config.topics.sonar is None


def test_a_plain_package_names_its_folder_and_its_beams(tmp_path: Path) -> None:
    spec = spec_from(legs=1, leg_length_m=0.8, structures=0, marks=0, barnacles=0, cameras="none", form="plain")
    write_package(tmp_path / "plain", spec)
    config = decode((tmp_path / "plain" / "dive.toml").read_text())
    assert config.logs.files == ("logs",)
    assert config.dvl.beams is not None
    np.testing.assert_allclose(np.linalg.norm(config.dvl.beams, axis=1), 1)
    names = {p.name for p in (tmp_path / "plain" / "logs").iterdir()}
    assert names == {"dvl.csv", "imu.csv", "pressure.csv", "joints.csv", "sonar.csv", "sonar"}


def test_same_seed_same_bytes_another_seed_others(tmp_path: Path) -> None:
    spec = spec_from(legs=1, leg_length_m=0.7, structures=1, marks=0, barnacles=0, image_width=160, image_height=128, views=1.0)
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        write_package(tmp_path / name, with_options(spec, seed=seed))
    files = [p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*") if p.is_file()]
    assert all((tmp_path / "a" / f).read_bytes() == (tmp_path / "b" / f).read_bytes() for f in files)
    differ = {f.as_posix() for f in files if (tmp_path / "a" / f).read_bytes() != (tmp_path / "c" / f).read_bytes()}
    assert {"logs/dive.mcap", "truth/poses.csv", "truth/as_built.ply", "dive.toml"} <= differ


def test_a_folder_with_something_in_it_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(StorageError, match="not empty"):
        write_package(tmp_path, DiveSpec())
    assert (tmp_path / "mine.txt").read_text() == "mine"


def test_a_file_in_the_way_is_named(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("")
    with pytest.raises(StorageError, match="taken"):
        write_package(tmp_path / "taken" / "dive", DiveSpec())


@pytest.mark.parametrize("error", [KeyboardInterrupt, StorageError("the disk is full"), OSError(28, "No space left on device")])
def test_a_simulation_that_fails_or_is_interrupted_leaves_nothing_behind(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(package_module, "write_truth", fail)
    spec = spec_from(legs=1, leg_length_m=0.8, structures=0, marks=0, barnacles=0, cameras="none", sonar=False)
    with pytest.raises((KeyboardInterrupt, StorageError)):
        write_package(tmp_path / "dive", spec)
    assert list(tmp_path.iterdir()) == []
    monkeypatch.undo()
    write_package(tmp_path / "dive", spec)
    assert [p.name for p in tmp_path.iterdir()] == ["dive"]


def test_an_empty_folder_is_filled(tmp_path: Path) -> None:
    (tmp_path / "dive").mkdir()
    spec = spec_from(legs=1, leg_length_m=0.8, structures=0, marks=0, barnacles=0, cameras="none", sonar=False)
    write_package(tmp_path / "dive", spec)
    assert (tmp_path / "dive" / "dive.toml").exists()


def test_progress_counts_every_image_while_it_is_written(tmp_path: Path) -> None:
    seen: list[tuple[str, int, int]] = []

    def track(items: Iterator[bytes], label: str, total: int) -> Iterator[bytes]:
        for k, item in enumerate(items):
            seen.append((label, k + 1, total))
            yield item

    spec = spec_from(
        legs=1, leg_length_m=0.7, structures=0, marks=0, barnacles=0, image_width=160, image_height=128, views=1.0, sonar=False
    )
    dive = write_package(tmp_path / "dive", spec, track)
    images = 2 * len(dive.frame_s)
    assert seen == [("images written", k + 1, images) for k in range(images)]


def told(dive: Dive, **errors: float) -> DiveConfig:
    return decode(dive_toml(replace(dive, spec=with_options(dive.spec, **errors))))


@pytest.mark.parametrize("drift", [144.0, -144.0])
def test_dive_toml_tells_a_sigma_as_large_as_the_drift(dive: Dive, drift: float) -> None:
    assert told(dive, heading_drift_deg_per_hour=drift).imu.heading_drift_deg_per_hour == 144.0


@pytest.mark.parametrize("error", [0.02, -0.02])
def test_dive_toml_tells_a_sigma_as_large_as_the_scale_error(dive: Dive, error: float) -> None:
    assert told(dive, dvl_scale_error=error).dvl.scale_sigma == 0.02


def test_dive_toml_tells_a_sigma_as_large_as_the_backlash(dive: Dive) -> None:
    assert told(dive, backlash_deg=3.0, servo_sigma_deg=0.0).tray.sigma_deg == 3.0
    assert told(dive, backlash_deg=3.0, servo_sigma_deg=4.0).tray.sigma_deg == 5.0


def test_dive_toml_tells_an_instruments_class_where_its_errors_are_smaller(dive: Dive) -> None:
    config = told(dive, heading_drift_deg_per_hour=0.0, dvl_scale_error=0.0, backlash_deg=0.0, servo_sigma_deg=0.0)
    assert config == decode(dive_toml(dive))
    assert (config.imu.heading_drift_deg_per_hour, config.dvl.scale_sigma, config.tray.sigma_deg) == (1.0, 0.005, 0.8)
