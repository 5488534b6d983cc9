# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Triangles that are drawn, against their twin in NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.errors import InputError
from hullrecon.native import draw_triangles

SHAPE = (9, 12)


def twin(points: np.ndarray, faces: np.ndarray, values: np.ndarray) -> np.ndarray:
    picture = np.full((*SHAPE, values.shape[1]), np.nan)
    middle = np.stack(np.meshgrid(np.arange(SHAPE[1]), np.arange(SHAPE[0])), axis=-1) + 0.5
    for a, b, c in faces:
        edges = np.stack([points[b] - points[a], points[c] - points[a]], axis=1)
        share = (middle - points[a]) @ np.linalg.inv(edges).T
        share = np.concatenate([1 - share.sum(axis=2, keepdims=True), share], axis=2)
        held = (share > -1e-9).all(axis=2)
        picture[held] = share[held] @ values[[a, b, c]]
    return picture


def test_drawn_triangles_equal_their_twin() -> None:
    random = np.random.default_rng(1)
    points, values = random.uniform(-4, 15, (20, 2)), random.normal(size=(20, 2))
    faces = random.permuted(np.tile(np.arange(20), (8, 1)), axis=1)[:, :3]
    drawn = draw_triangles(points, faces, values, SHAPE)
    np.testing.assert_allclose(drawn, twin(points, faces, values), rtol=1e-5, atol=1e-6)
    assert 20 < np.isnan(drawn[..., 0]).sum() < 100


def test_no_pixel_slips_between_two_triangles() -> None:
    corners = np.array([[0.0, 0.0], [12.0, 0.0], [12.0, 9.0], [0.0, 9.0]])
    drawn = draw_triangles(corners, np.array([[0, 1, 2], [0, 2, 3]]), np.ones((4, 1)), SHAPE)
    assert (drawn == 1).all()


def test_triangle_of_no_area_is_not_drawn() -> None:
    line = np.array([[0.0, 0.0], [6.0, 4.5], [12.0, 9.0]])
    assert np.isnan(draw_triangles(line, np.array([[0, 1, 2]]), np.ones((3, 1)), SHAPE)).all()


def test_corner_that_is_not_there_is_refused() -> None:
    with pytest.raises(InputError, match="a corner is not there"):
        draw_triangles(np.zeros((3, 2)), np.array([[0, 1, 3]]), np.ones((3, 1)), SHAPE)
