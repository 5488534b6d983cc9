# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Dense stereo on a wall with a step, seen by two cameras that are turned a little."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import exp
from hullrecon.studies.structures.dense_stereo import (
    RectifiedPair,
    column_gaps,
    dense_points,
    disparities,
    ranges,
    turn_image,
)
from hullrecon.typing import Array, Pixels
from hullrecon.vision.stereo.matching import rectify

CAMERA = CameraModel(width=320, height=240, fx=300.0, fy=300.0, cx=160.0, cy=120.0, k1=-0.1)
TOP_FROM_BOTTOM = exp([[0.002, 0.1, -0.001, 0.01, -0.015, 0.012]])
NEAR_M, FAR_M = 0.9, 1.0  # of a plate, and of the wall behind it


def render(rotation: Array, center: Array, texture: Pixels) -> Pixels:
    """See a wall at FAR_M with a plate of 0.3 m before it, in the top camera's frame."""
    u, v = np.meshgrid(np.arange(CAMERA.width), np.arange(CAMERA.height))
    rays = CAMERA.rays(np.column_stack([u.ravel(), v.ravel()]).astype(float)) @ rotation.T
    at = [center + (z - center[2]) / rays[:, 2:] * rays for z in (NEAR_M, FAR_M)]
    on_plate = (np.abs(at[0][:, :2]) < 0.15).all(axis=1)
    points = np.where(on_plate[:, None], at[0], at[1])[:, :2]
    pixel = (1000 * (points + 0.7)).reshape(CAMERA.height, CAMERA.width, 2).astype(np.float32)
    return np.asarray(cv2.remap(texture, pixel, None, cv2.INTER_LINEAR), np.uint8)


@pytest.fixture(scope="module")
def pair() -> RectifiedPair:
    rng = np.random.default_rng(1)
    noise = rng.integers(0, 255, (350, 350, 3)).astype(np.uint8)
    texture = cv2.resize(noise, (1400, 1400), interpolation=cv2.INTER_CUBIC)
    rectification = rectify(TOP_FROM_BOTTOM)
    bottom_pose = TOP_FROM_BOTTOM.rotation.as_matrix()[0], TOP_FROM_BOTTOM.translation[0]
    raw = render(np.eye(3), np.zeros(3), texture), render(*bottom_pose, texture)
    level = CameraModel(width=320, height=240, fx=300.0, fy=300.0, cx=160.0, cy=120.0)
    turned = (
        turn_image(raw[0], CAMERA, rectification.rotation_top, level),
        turn_image(raw[1], CAMERA, rectification.rotation_bottom, level),
    )
    return RectifiedPair(raw=raw, turned=turned, camera=level, rectification=rectification)


def test_matched_features_of_a_turned_pair_share_their_column(pair: RectifiedPair) -> None:
    gaps: Any = [np.median(np.abs(column_gaps(images))) for images in (pair.raw, pair.turned)]
    assert gaps[0] > 2.0
    assert gaps[1] < 0.3


def test_plate_and_wall_lie_at_their_distances(pair: RectifiedPair) -> None:
    points = dense_points(pair, disparities(pair, FAR_M))
    on_plate = (np.abs(points[:, :2]) < 0.12).all(axis=1)
    beside = (np.abs(points[:, :2]) > 0.2).any(axis=1)
    assert on_plate.sum() > 500
    assert beside.sum() > 500
    # the matcher is off by up to a fifth of a pixel, which is 6 mm
    assert np.median(points[on_plate, 2]) == pytest.approx(NEAR_M, abs=0.007)
    assert np.median(points[beside, 2]) == pytest.approx(FAR_M, abs=0.007)


def test_depth_by_q_takes_one_over_the_baseline(pair: RectifiedPair) -> None:
    """[Ozog2016 D.2.2] says that q43 "scales the disparity": it is one over the baseline.

    And q14, q24 are minus the principal point, printed "the camera center".
    """
    disparity = np.full((1, 1), 31.0, np.float32)
    camera, baseline = pair.camera, pair.rectification.baseline_m
    q = np.zeros((4, 4))
    q[0, 0] = q[1, 1] = 1.0
    q[:3, 3] = -camera.cx, -camera.cy, camera.fx
    q[3, 2] = 1 / baseline
    x = q @ [200.0, 90.0, 31.0, 1.0]
    point = x[:3] / x[3]
    assert point[2] == pytest.approx(float(ranges(pair, disparity)[0, 0]))
    np.testing.assert_allclose(camera.project(point[None])[0], [200.0, 90.0], atol=1e-9)
    q[:2, 3] = camera.cx, camera.cy
    printed = (q @ [200.0, 90.0, 31.0, 1.0])[:3] / x[3]
    assert np.linalg.norm(camera.project(printed[None])[0] - [200.0, 90.0]) > 100
