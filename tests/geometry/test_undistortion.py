# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.undistortion import undistortion

BARREL = CameraModel(640, 512, 600.0, 610.0, 331.0, 250.0, -0.21, 0.07, 0.001, -0.0008, -0.01)
# a flat port under water
PINCUSHION = CameraModel(640, 512, 700.0, 690.0, 312.5, 260.25, 0.4, 0.1, -0.002, 0.001)
PLAIN = CameraModel(640, 512, 600.0, 610.0, 319.5, 255.5)
CAMERAS = pytest.mark.parametrize("camera", [BARREL, PINCUSHION, PLAIN])


def corners(camera: CameraModel) -> np.ndarray:
    """Ideal coordinates (4, 2) of the corner pixels of a camera without distortion."""
    u, v = (np.array([0, size - 1]) for size in (camera.width, camera.height))
    return np.stack(
        np.meshgrid((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy), axis=-1
    ).reshape(-1, 2)


def is_seen(camera: CameraModel, ideal: np.ndarray) -> np.ndarray:
    pixel = camera.distort(ideal)
    return np.all(
        (pixel > -0.01) & (pixel < np.array([camera.width, camera.height]) - 0.99), axis=1
    )


@CAMERAS
def test_every_pixel_of_the_pinhole_was_seen(camera: CameraModel) -> None:
    pinhole = undistortion(camera).pinhole
    side = np.linspace(0, 1, 50)
    left, right = corners(pinhole).min(axis=0), corners(pinhole).max(axis=0)
    for at in ([0, 1], [1, 0]):
        for fixed in (0.0, 1.0):
            share = np.full((50, 2), fixed)
            share[:, at[0]] = side
            assert is_seen(camera, left + share * (right - left)).all()


@CAMERAS
def test_hardly_anything_is_cut_away_that_a_rectangle_could_hold(camera: CameraModel) -> None:
    """An image a hundredth wider and higher would have pixels that the camera did not see."""
    pinhole = undistortion(camera).pinhole
    x, y = 1.01 * corners(pinhole).max(axis=0)
    side = np.linspace(-1, 1, 201)
    border = [np.stack([s * np.full(201, x), y * side], axis=1) for s in (-1, 1)]
    border += [np.stack([x * side, s * np.full(201, y)], axis=1) for s in (-1, 1)]
    assert not is_seen(camera, np.vstack(border)).all()


@CAMERAS
def test_pinhole_keeps_focal_lengths(
    camera: CameraModel,
) -> None:
    pinhole = undistortion(camera).pinhole
    assert (pinhole.fx, pinhole.fy) == (camera.fx, camera.fy)
    assert (pinhole.cx, pinhole.cy) == ((pinhole.width - 1) / 2, (pinhole.height - 1) / 2)
    assert not pinhole.distortion().any()


def test_a_camera_without_distortion_keeps_its_image() -> None:
    found = undistortion(PLAIN)
    assert found.pinhole == PLAIN
    image = np.random.default_rng(3).integers(0, 255, (512, 640, 3), np.uint8)
    np.testing.assert_array_equal(found.resample(image), image)


@CAMERAS
def test_what_lies_at_a_pixel_lies_at_its_undistorted_pixel(camera: CameraModel) -> None:
    """A dot drawn into the source, wider than a pixel, has its centroid where `pixels` says."""
    found = undistortion(camera)
    v, u = np.mgrid[: camera.height, : camera.width]
    for at in ([150.3, 120.7], [camera.cx, camera.cy], [500.2, 400.6]):
        dot = 200 * np.exp(-((u - at[0]) ** 2 + (v - at[1]) ** 2) / (2 * 3.0**2))
        seen = found.resample(np.repeat(dot.astype(np.uint8)[..., None], 3, axis=2))[..., 0].astype(
            float
        )
        rows, columns = np.mgrid[: seen.shape[0], : seen.shape[1]]
        centroid = [(seen * columns).sum() / seen.sum(), (seen * rows).sum() / seen.sum()]
        np.testing.assert_allclose(
            centroid, found.pixels(np.array([at]))[0], atol=0.1
        )  # the dot's own shape bends by some hundredths


@CAMERAS
def test_opencv_brings_an_undistorted_pixel_back(camera: CameraModel) -> None:
    import cv2

    found, some = (
        undistortion(camera),
        np.random.default_rng(5).uniform([20, 20], [620, 490], (100, 2)),
    )
    rays = (
        np.column_stack([found.pixels(some), np.ones(100)])
        @ np.linalg.inv(found.pinhole.matrix()).T
    )
    back, _ = cv2.projectPoints(
        rays, np.zeros(3), np.zeros(3), camera.matrix(), camera.distortion()
    )
    np.testing.assert_allclose(back[:, 0], some, atol=1e-3)


def test_a_pixel_beyond_the_smaller_image_is_not_held() -> None:
    found = undistortion(PINCUSHION)
    last = np.array([found.pinhole.width - 1.0, found.pinhole.height - 1.0])
    assert found.holds(np.array([[0, 0], last, last / 2])).all()
    outside = np.vstack([-np.eye(2), last + np.eye(2), [[np.nan, 5.0]]])
    assert not found.holds(outside).any()


def test_an_image_of_another_size_is_refused_with_both_sizes() -> None:
    with pytest.raises(InputError, match="320 x 256 pixels, its calibration says 640 x 512"):
        undistortion(BARREL).resample(np.zeros((256, 320, 3), np.uint8))


def test_a_distortion_that_folds_the_image_is_refused() -> None:
    with pytest.raises(InputError, match="cannot be undone"):
        undistortion(replace(BARREL, k1=-3.0))
