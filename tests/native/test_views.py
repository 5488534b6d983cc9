# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The mosaic's kernels against their twins in NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import map_coordinates
from scipy.spatial.transform import Rotation

from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.native import BlendSums, incidence, insert_view, least_tangents, project_into

CAMERA = CameraModel(
    width=40, height=30, fx=35.0, fy=36.0, cx=19.0, cy=15.5, k1=-0.2, k2=0.05, p1=0.003, p2=-0.002
)
STEEPNESS = (5.0, 10.0, 50.0)


def twin_weight(ratio: np.ndarray, steepness: float) -> np.ndarray:
    return np.exp(-steepness * ratio) / (1 + np.exp(-2 * steepness * ratio))


def test_projection_equals_its_twin() -> None:
    random = np.random.default_rng(1)
    points = random.normal(size=(3001, 3))
    rotation, center = Rotation.random(random_state=2).as_matrix(), np.array([0.1, -0.2, 0.3])
    pixel, ratio = project_into(points, rotation, center, CAMERA.parameters(), (40, 30), 1.0)
    inside = (points - center) @ rotation.T
    expected = CAMERA.project(inside)
    u, v = expected.T
    held = (np.abs(inside[:, :2]).max(axis=1) < inside[:, 2]) & (u >= 1) & (u <= 38)
    held &= (v >= 1) & (v <= 28)
    away = np.hypot(u - 19.5, v - 14.5) / (0.5 * np.hypot(40, 30))
    np.testing.assert_allclose(pixel, expected, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(ratio, np.where(held, away, np.nan), rtol=1e-12)
    assert 20 < held.sum() < 2900


def test_incidence_equals_its_twin() -> None:
    random = np.random.default_rng(3)
    points, normals = random.normal(size=(2, 50, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    sensor = np.array([0.0, 0.5, 3.0])
    away = sensor - points
    expected = (away * normals).sum(axis=1) / np.linalg.norm(away, axis=1)
    np.testing.assert_allclose(incidence(points, normals, sensor), expected, rtol=1e-13)


def test_lists_of_best_views_are_those_of_sorting() -> None:
    random = np.random.default_rng(4)
    cost = random.integers(0, 6, (9, 60)).astype(np.float32)  # with many equals
    cost[random.random(cost.shape) < 0.3] = np.inf
    view, best = np.full((4, 60), -1, np.int32), np.full((4, 60), np.inf, np.float32)
    for k in random.permutation(9).tolist():
        insert_view(view, best, k, cost[k])
    order = np.argsort(cost, axis=0, kind="stable")[:4]
    expected = np.take_along_axis(cost, order, axis=0)
    np.testing.assert_array_equal(best, expected)
    np.testing.assert_array_equal(view, np.where(np.isfinite(expected), order, -1))


@pytest.mark.parametrize("channels", [1, 3])
def test_sums_of_two_views_equal_their_twin(channels: int) -> None:
    random = np.random.default_rng(channels)
    sums, texels = BlendSums.zero(3, channels, 80), 80
    value = np.zeros((texels, 3, channels))
    weight, moment, count = np.zeros((texels, 3)), np.zeros((texels, 3)), np.zeros(texels)
    for _ in range(2):
        bands = random.uniform(0, 80, (3, 12, 17, channels)).astype(np.float32)
        rows = random.permutation(texels)[:50]
        pixel = random.uniform(-2, 18, (50, 2)).astype(np.float32)  # past the border too
        ratio = random.uniform(0, 1, 50)
        sums.add(bands, rows, pixel, ratio, STEEPNESS)
        sampled = np.stack(
            [
                [map_coordinates(b[..., c], pixel.T[::-1], order=1, mode="nearest") for b in bands]
                for c in range(channels)
            ]
        ).transpose(2, 1, 0)
        share = np.stack([twin_weight(ratio, k) for k in STEEPNESS], axis=1)
        mean, intensity = share.mean(axis=1), sampled.sum(axis=1).mean(axis=1)
        value[rows] += share[:, :, None] * sampled
        weight[rows] += share
        moment[rows] += mean[:, None] * np.stack([intensity**0, intensity, intensity**2], axis=1)
        count[rows] += 1
    np.testing.assert_allclose(sums.value, value, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(sums.weight, weight, rtol=1e-6)
    np.testing.assert_allclose(sums.moment, moment, rtol=1e-5)
    np.testing.assert_array_equal(sums.views, count)


def test_a_texel_that_the_view_does_not_hold_weighs_nothing() -> None:
    sums = BlendSums.zero(1, 1, 1)
    picture = np.ones((4, 4, 1), np.float32)
    sums.add([picture], np.array([0]), np.ones((1, 2), np.float32), np.array([np.nan]), [5.0])
    assert sums.weight[0, 0] == 0
    assert sums.value[0, 0, 0] == 0


def test_rows_and_shapes_that_cannot_be_are_refused() -> None:
    picture, row = np.ones((4, 4, 1), np.float32), np.array([0])
    at, ratio = np.ones((1, 2), np.float32), np.array([0.1])
    for rows, pixel, bands, name in (
        (np.array([1]), at, [picture], "rows"),
        (row, np.ones((2, 2), np.float32), [picture], "pixel"),
        (row, at, [picture, np.ones((4, 5, 1), np.float32)], "bands"),
        (row, at, [np.ones((4, 4, 2), np.float32)], "bands"),
    ):
        with pytest.raises(InputError, match=name):
            BlendSums.zero(len(bands), 1, 1).add(bands, rows, pixel, ratio, [5.0] * len(bands))
    with pytest.raises(InputError, match="best_cost"):
        insert_view(
            np.zeros((4, 2), np.int32), np.zeros((4, 3), np.float32), 0, np.zeros(2, np.float32)
        )


def test_least_tangents_equal_their_twin() -> None:
    """Of the texels of a block the nearest to a cell, and the lowest under it, may be any."""
    random = np.random.default_rng(7)
    top, up = random.uniform(-1, 1, (25, 3)) * [1, 1, 0.1], random.normal(size=(25, 3))
    up = (up * 0.1 + [0, 0, 1]) / np.linalg.norm(up * 0.1 + [0, 0, 1], axis=1, keepdims=True)
    points = random.uniform(-0.05, 0.05, (30, 1, 3)) + random.uniform(-0.04, 0.04, (30, 9, 3))
    points[:, :, :2] += random.uniform(-1, 1, (30, 1, 2))
    points[random.random((30, 9)) < 0.3] = np.nan
    points[5] = np.nan
    normals = np.broadcast_to([0.0, 0.28, 0.96], points.shape)
    cell, span, relief = 0.05, 0.5, 0.03
    expected = np.full(30, np.inf)
    for k, block in enumerate(points):
        known = block[np.isfinite(block[:, 0])]
        if not len(known):
            continue
        off = known - known.mean(axis=0)
        floor, radius = (off @ normals[0, 0]).min(), np.linalg.norm(off, axis=1).max()
        away = top - known.mean(axis=0)
        above = away @ normals[0, 0]
        tilt = np.sqrt(1 - (up @ normals[0, 0]) ** 2)
        rise = above + np.sqrt(2) * cell * tilt - floor
        level = np.sqrt(np.maximum((away**2).sum(axis=1) - above**2, 0))
        level -= radius + (1 + np.sqrt(2)) * cell
        counts = (rise > relief) & (level < span)
        expected[k] = np.min(np.maximum(level, 0)[counts] / rise[counts], initial=np.inf)
    found = least_tangents(top, up, (cell, span, relief), points, normals)
    np.testing.assert_allclose(found, expected, rtol=1e-9)
    assert np.isinf(found).any()
    assert len(np.unique(found)) > 10
