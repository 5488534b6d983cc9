# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.detection.objects.regions import fit_hull_around

NORMAL = np.array([0.0, 0.6, -0.8])
EAST, NORTH = np.array([1.0, 0, 0]), np.array([0.0, 0.8, 0.6])
MIDDLE = np.array([30.0, 4.0, 1.0])


def _points(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return MIDDLE + a[:, None] * EAST + b[:, None] * NORTH


def _ring(
    count: int = 600, seed: int = 0, sides: float = 2 * np.pi
) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    angle, away = random.uniform(0, sides, count), random.uniform(0.2, 0.35, count)
    return away * np.cos(angle), away * np.sin(angle)


def _bulge(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return 0.01 + 0.02 * a - 0.015 * b + 0.04 * a * a - 0.03 * a * b + 0.02 * b * b


def _beneath() -> tuple[np.ndarray, np.ndarray]:
    grid = np.linspace(-0.12, 0.12, 5)
    a, b = np.meshgrid(grid, grid)
    return a.ravel(), b.ravel()


def test_a_bulge_of_the_hull_goes_on_beneath_the_structure() -> None:
    a, b = _ring()
    hull = fit_hull_around(_points(a, b), _bulge(a, b), np.ones(len(a)), NORMAL)
    under = _beneath()
    assert hull.offset(_points(*under)) == pytest.approx(_bulge(*under), abs=0.0005)


def test_a_third_of_the_ring_that_is_no_hull_does_not_count() -> None:
    a, b = _ring()
    offset = _bulge(a, b) + np.random.default_rng(1).normal(0, 0.001, len(a))
    offset[np.arctan2(b, a) > np.pi / 3] += 0.05
    hull = fit_hull_around(_points(a, b), offset, np.ones(len(a)), NORMAL)
    under = _beneath()
    assert np.abs(hull.offset(_points(*under)) - _bulge(*under)).max() < 0.003


def test_the_offset_is_within_its_sigma_of_the_truth() -> None:
    """Noise that neighbours share: eight sides, each with an error of its own."""
    under, z = _beneath(), []
    for seed in range(300):
        random = np.random.default_rng(seed)
        a, b = _ring(seed=seed)
        side = (np.arctan2(b, a) // (np.pi / 4)).astype(int) + 4
        bend, slope = random.normal(0, 0.03, 3), random.normal(0, 0.02, 2)

        def true(
            x: np.ndarray, y: np.ndarray, bend: np.ndarray = bend, slope: np.ndarray = slope
        ) -> np.ndarray:
            return slope[0] * x + slope[1] * y + bend[0] * x * x + bend[1] * x * y + bend[2] * y * y

        offset = true(a, b) + random.normal(0, 0.002, 9)[side]
        hull = fit_hull_around(_points(a, b), offset, np.ones(len(a)), NORMAL)
        z.append((hull.offset(_points(*under)) - true(*under)) / hull.sigma(_points(*under)))
    assert 0.6 < np.sqrt(np.mean(np.square(z))) < 1.4


def test_hull_on_one_side_alone_leaves_more_open_beneath() -> None:
    around, beside = (
        fit_hull_around(
            _points(a, b),
            _bulge(a, b) + np.random.default_rng(2).normal(0, 0.001, len(a)),
            np.ones(len(a)),
            NORMAL,
        )
        for a, b in (_ring(), _ring(sides=np.pi / 2))
    )
    middle = MIDDLE[None]
    assert beside.sigma(middle)[0] > 3 * around.sigma(middle)[0]


def test_parts_of_the_ring_count_by_their_weight() -> None:
    a, b = _ring()
    dense = np.r_[np.arange(len(a)), np.repeat(np.flatnonzero(a > 0.2), 20)]
    offset = 0.003 * (a > 0.2)
    even = fit_hull_around(_points(a, b), offset, np.ones(len(a)), NORMAL)
    weight = np.where(np.arange(len(dense)) < len(a), 1.0, 1e-6)
    same = fit_hull_around(_points(a[dense], b[dense]), offset[dense], weight, NORMAL)
    assert same.offset(MIDDLE[None])[0] == pytest.approx(even.offset(MIDDLE[None])[0], abs=2e-4)
