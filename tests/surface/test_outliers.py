# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.surface.from_returns import statistical_inliers


def _grid() -> np.ndarray:
    x, z = np.meshgrid(np.arange(20) * 0.1, np.arange(20) * 0.1)
    return np.stack([x.ravel(), np.zeros(x.size), z.ravel()], axis=1)


def test_a_return_far_from_its_neighbours_is_an_outlier() -> None:
    points = np.vstack([_grid(), [[1.0, 3.0, 1.0]]])
    kept = statistical_inliers(points)
    assert not kept[-1]
    assert kept[:-1].all()


def test_a_stricter_threshold_keeps_fewer() -> None:
    points = np.vstack(
        [_grid(), np.random.default_rng(2).uniform([0, 0.3, 0], [2, 2.3, 2], (40, 3))]
    )
    strict = statistical_inliers(points, deviations=0.5)
    loose = statistical_inliers(points, deviations=3.0)
    assert strict.sum() < loose.sum()
    assert not (strict & ~loose).any()


def test_the_mean_distance_is_that_to_the_neighbours_asked_for() -> None:
    line = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [10, 0, 0]])
    # mean distance to two neighbours: 1.5, 1, 1, 1.5, 7.5; mean 2.5, deviation 2.51
    assert statistical_inliers(line, neighbours=2, deviations=1.0).tolist() == [
        True,
        True,
        True,
        True,
        False,
    ]
    assert statistical_inliers(line, neighbours=2, deviations=2.0).all()


def test_a_single_point_is_kept() -> None:
    assert statistical_inliers(np.zeros((1, 3))).tolist() == [True]
