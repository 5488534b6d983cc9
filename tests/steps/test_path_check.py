# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""`check` refuses what the step navigate would refuse, by tables of a dive along a plane."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import pytest

import hullrecon
from hullrecon.api.package import check
from hullrecon.errors import StageError

START_S, WIDTH, HEIGHT, FOCAL_PX = 1_777_887_000, 320, 240, 300.0
SHIFT_PX, DISPARITY_PX = 20, 30  # of the plane from image to image, and between the cameras
HULL = cv2.resize(
    np.random.default_rng(3).integers(0, 255, (90, 160), dtype=np.uint8), None, fx=4, fy=4
)
CALIBRATION = f"""image_width: {WIDTH}
image_height: {HEIGHT}
camera_matrix: {{data: [{FOCAL_PX}, 0, 160, 0, {FOCAL_PX}, 120, 0, 0, 1]}}
distortion_model: plumb_bob
distortion_coefficients: {{data: [0, 0, 0, 0, 0]}}
"""
STEREO = """
[camera.top]
calibration = "camera.yaml"
[camera.bottom]
calibration = "camera.yaml"
pose_in_top = [0.0, 0.1, 0.0, 0.0, 0.0, 0.0]
"""


def write_table(package: Path, sensor: str, header: str, rows: Sequence[Sequence[object]]) -> None:
    lines = [header, *(",".join(map(str, row)) for row in rows)]
    (package / "logs" / f"{sensor}.csv").write_text("\n".join(lines) + "\n")


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A dive whose sensors have no table yet."""
    (tmp_path / "logs").mkdir()
    (tmp_path / "camera.yaml").write_text(CALIBRATION)
    (tmp_path / "dive.toml").write_text('[dive]\nname = "x"\n[logs]\nfiles = ["logs"]\n')
    return tmp_path


def write_dvl_dive(package: Path, pings: int, readings: int) -> None:
    """Five pings a second and twenty readings of the IMU, at 0.2 m/s along a wall."""
    text = (package / "dive.toml").read_text()
    beams = "[dvl]\nbeam_angle_deg = 30\nbeam_azimuth_deg = [180, 0, 90, -90]\n"
    (package / "dive.toml").write_text(text + beams)
    noise = np.random.default_rng(1).normal(0, 0.003, (pings, 3))
    rows = [[START_S + 0.2 * k, *(noise[k] + [0, 0.2, 0]), 1, 1, 1, 1] for k in range(pings)]
    ranges = ",".join(f"range_{k}" for k in range(1, 5))
    write_table(package, "dvl", f"t,vx,vy,vz,{ranges}", rows)
    still = [[START_S + 0.05 * k, 0, 0, 0.001 * (k % 2), 1] for k in range(readings)]
    write_table(package, "imu", "t,qx,qy,qz,qw", still)


def write_stereo_dive(package: Path, pairs: int, hidden: bool) -> None:
    """Pairs along a plane. hidden: by noise, each anew."""
    with (package / "dive.toml").open("a") as stream:
        stream.write(STEREO)
    random = np.random.default_rng(5)
    for sensor, down in (("top", 0), ("bottom", DISPARITY_PX)):
        rows = []
        for k in range(pairs):
            across = SHIFT_PX * k
            picture = HULL[down : down + HEIGHT, across : across + WIDTH]
            if hidden:
                picture = random.integers(0, 255, picture.shape, dtype=np.uint8)
            cv2.imwrite(str(package / "logs" / f"{sensor}{k}.png"), picture)
            rows.append([START_S + 0.5 * k, f"{sensor}{k}.png"])
        write_table(package, f"camera_{sensor}", "t,file", rows)


@pytest.mark.parametrize(
    ("pings", "readings", "why"),
    [
        (50, 200, ""),
        (1, 200, "the DVL gave no velocity to reckon with"),
        (50, 1, "the IMU gave a single orientation"),
    ],
)
def test_check_foresees_whether_dvl_and_imu_give_a_path(package, tmp_path, pings, readings, why):
    write_dvl_dive(package, pings, readings)
    agree_on_path(package, tmp_path, why)


@pytest.mark.parametrize(
    ("pairs", "hidden", "why"),
    [
        (5, False, ""),
        (5, True, "the stereo pairs do not join"),
        (1, False, "fewer than two stereo pairs"),
    ],
)
def test_check_foresees_whether_stereo_pairs_give_a_path(package, tmp_path, pairs, hidden, why):
    write_stereo_dive(package, pairs, hidden)
    agree_on_path(package, tmp_path, why)


def agree_on_path(package: Path, tmp_path: Path, why: str) -> None:
    """Assert that check and run refuse a package with the same words, or neither does."""
    found = check(package)
    if not why:
        assert found.reasons == []
        hullrecon.run(package, tmp_path / "runs", last_step="navigate", jobs=1)
        return
    assert why in "; ".join(found.reasons)
    with pytest.raises(StageError, match=why):
        hullrecon.run(package, tmp_path / "runs", last_step="navigate", jobs=1)


def test_images_that_no_others_match_are_named_before_a_run(package):
    write_dvl_dive(package, 50, 200)
    write_stereo_dive(package, 10, hidden=True)
    assert "images-unmatched" in [finding.code for finding in check(package).warnings]


def test_images_that_match_are_not_accused(package):
    write_dvl_dive(package, 50, 200)
    write_stereo_dive(package, 10, hidden=False)
    assert "images-unmatched" not in [finding.code for finding in check(package).warnings]


@pytest.mark.parametrize("still", [("top", "bottom"), ("top",)])
def test_cameras_that_stood_still_are_refused_where_no_other_moved(package, still):
    write_dvl_dive(package, 50, 200)
    write_stereo_dive(package, 6, hidden=False)
    for camera in still:
        for k in range(1, 6):
            shutil.copy(package / "logs" / f"{camera}0.png", package / "logs" / f"{camera}{k}.png")
    reasons = "; ".join(check(package).reasons)
    assert [
        camera for camera in ("top", "bottom") if f"camera_{camera} are one pic" in reasons
    ] == (list(still) if len(still) == 2 else [])


def test_one_image_of_each_camera_is_refused_until_the_dvl_is_alone(package):
    write_dvl_dive(package, 50, 200)
    text = (package / "dive.toml").read_text()
    write_stereo_dive(package, 1, hidden=False)
    assert "no camera has two images" in "; ".join(check(package).reasons)
    (package / "dive.toml").write_text(text)
    assert check(package).run_is_possible
