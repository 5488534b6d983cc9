# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Lenses that are off, rows exposed in turn, and late stamps, held to the geometry."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import map_coordinates
from synthetic.sensors.test_rendering import CAMERA, TOWARDS, scene, shoot

from hullrecon.geometry.poses import Poses
from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.dive_toml import cameras_of
from hullrecon.synthetic.options import spec_from, with_options
from hullrecon.synthetic.recorder import record
from hullrecon.synthetic.rendering import lens, lens_error, photograph, row_times
from hullrecon.synthetic.truth import write_truth

SPOTS = ((900, 600), (650, 950))  # row, column of the atlas, whose texels are 2 mm


def spot_at(image: np.ndarray, bare: np.ndarray, near: np.ndarray) -> np.ndarray:
    """Centre of the spot within 12 px of a pixel; bare: the same image without spots."""
    u, v = np.meshgrid(np.arange(image.shape[1]), np.arange(image.shape[0]))
    weight = np.abs(image.astype(float) - bare).sum(axis=2)
    weight *= np.hypot(u - near[0], v - near[1]) < 12
    return np.array([(u * weight).sum(), (v * weight).sum()]) / weight.sum()


def wall_point(spot: tuple[int, int]) -> np.ndarray:
    return np.array([-1.5 + 0.002 * spot[1], 0.0, -1.5 + 0.002 * spot[0]])


def test_lens_error_has_rms_asked_for_and_no_affine_part() -> None:
    error = lens_error(spec_from(lens_error_px=0.3), "camera_top", CAMERA)
    assert error is not None
    assert np.sqrt((error**2).sum(axis=2).mean()) == pytest.approx(0.3)
    v, u = np.mgrid[-1:1:192j, -1:1:240j]
    for basis in (np.ones_like(u), u, v):
        assert np.abs((error * basis[..., None]).mean(axis=(0, 1))).max() < 1e-9
    assert np.abs(np.diff(error, axis=1)).max() < 0.03  # px a pixel: smooth


def test_lenses_of_two_cameras_are_off_differently() -> None:
    spec = spec_from(lens_error_px=1.0)
    top, bottom = (lens_error(spec, f"camera_{name}", CAMERA) for name in ("top", "bottom"))
    assert top is not None
    assert bottom is not None
    assert np.abs(top - bottom).max() > 0.5


def test_spots_move_by_the_lens_error() -> None:
    error = lens_error(spec_from(lens_error_px=3.0), "camera_top", CAMERA)
    assert error is not None
    plain, off = (
        [shoot(scene(spots=spots), view=lens(CAMERA, shift)) for spots in (SPOTS, ())]
        for shift in (None, error)
    )
    for spot in SPOTS:
        point = (wall_point(spot) - [0.0, 1.0, 0.0]) @ TOWARDS
        before = spot_at(*plain, CAMERA.project(point[None])[0])
        after = spot_at(*off, before)
        moved = [map_coordinates(error[..., k], after[::-1, None], order=1)[0] for k in range(2)]
        assert np.hypot(*moved) > 1.0
        np.testing.assert_allclose(after + moved, before, atol=0.25)


def test_rows_are_exposed_one_after_another() -> None:
    """A camera that moves along the wall while it reads out sees each row from its own place."""
    speed, readout_s = 0.5, 0.08  # m/s, s
    cameras = spec_from(image_width=240, image_height=192, readout_s=readout_s).cameras
    t_s = row_times(np.array([10.0]), cameras)[0]
    assert len(t_s) == 192
    assert t_s[0] == 10.0
    assert t_s[-1] == pytest.approx(10.0 + readout_s)
    place = np.array([0.0, 1.0, 0.0]) + np.outer(t_s - 10.0, [speed, 0.0, 0.0])
    turn = np.tile(_turn(), (192, 1))
    lamp = place + np.array([0.2, 0.0, 0.3])
    images = [
        photograph(
            scene(spots=spots), lens(CAMERA), Poses(turn, place), lamp, np.random.default_rng(0)
        )
        for spots in (SPOTS, ())
    ]
    for spot in SPOTS:
        row = CAMERA.project(((wall_point(spot) - place[96]) @ TOWARDS)[None])[0, 1]
        at = place[round(row)]
        expected = CAMERA.project(((wall_point(spot) - at) @ TOWARDS)[None])[0]
        np.testing.assert_allclose(spot_at(*images, expected), expected, atol=0.3)


def _turn() -> np.ndarray:
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(TOWARDS).as_quat()[None]


def test_stamps_are_late_by_the_offset(dive: Dive) -> None:
    late = replace(dive, spec=with_options(dive.spec, camera_offset_s=0.02))
    np.testing.assert_allclose(record(late).frame_s - record(dive).frame_s, 0.02, atol=1e-9)


def test_truth_says_what_was_applied(dive: Dive, tmp_path: Path) -> None:
    options = {"lens_error_px": 0.5, "readout_s": 0.03, "camera_offset_s": -0.01}
    off = replace(dive, spec=with_options(dive.spec, **options))
    write_truth(tmp_path, off)
    found = json.loads((tmp_path / "camera_errors.json").read_text())
    assert {name: found[name] for name in options} == options
    for name, camera in cameras_of(off).items():
        error, grid = lens_error(off.spec, name, camera), found["lenses"]
        assert error is not None
        rows = np.ix_(grid[name]["v"], grid[name]["u"])
        np.testing.assert_allclose(grid[name]["du"], error[rows][..., 0], atol=1e-5)
        np.testing.assert_allclose(grid[name]["dv"], error[rows][..., 1], atol=1e-5)


def test_truth_of_exact_cameras_says_nothing_of_errors(package: Path) -> None:
    assert not (package / "truth" / "camera_errors.json").exists()
