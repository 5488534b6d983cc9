# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.detection.objects.heights import local_heights

UP = np.array([[0.0, 0, 1]])


def _feet(n: int = 4000, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(0, 1, n), rng.uniform(0, 1, n), np.zeros(n)])


def _at(
    points: list[list[float]],
    feet: np.ndarray,
    height: np.ndarray,
    sigma: float = 0.003,
    reach: float = 0.08,
):
    at = np.column_stack([np.array(points), np.zeros(len(points))])
    return local_heights(
        at, np.repeat(UP, len(at), 0), feet, height, np.full(len(feet), sigma), 20, reach
    )


def test_a_slope_is_followed_without_bias() -> None:
    feet = _feet()
    heights = _at([[0.5, 0.5], [0.2, 0.7]], feet, 0.2 * feet[:, 0] - 0.1 * feet[:, 1])
    assert np.allclose(heights.value, [0.05, -0.03], atol=1e-4)


def test_the_top_of_a_lump_is_not_cut_off() -> None:
    feet = _feet(1000)
    off = np.hypot(feet[:, 0] - 0.5, feet[:, 1] - 0.5)
    heights = _at([[0.5, 0.5]], feet, 0.05 - 4.0 * off**2)
    assert heights.value[0] == pytest.approx(0.05, abs=0.003)  # 6 mm too low by a plane alone


def test_noise_is_averaged_and_sigma_says_how_far() -> None:
    feet = _feet()
    noise = np.random.default_rng(2).normal(0, 0.003, len(feet))
    at = np.random.default_rng(3).uniform(0.1, 0.9, (400, 2)).tolist()
    heights = _at(at, feet, noise)
    assert np.sqrt(np.mean(heights.value**2)) < 0.0015
    assert 0.7 < np.sqrt(np.mean((heights.value / heights.sigma) ** 2)) < 1.5


@pytest.mark.parametrize(("x", "want"), [(0.48, 0.0), (0.52, 0.1)])
def test_a_step_stays_sharp(x: float, want: float) -> None:
    feet = _feet()
    heights = _at([[x, 0.5]], feet, np.where(feet[:, 0] > 0.5, 0.1, 0.0))
    assert heights.value[0] == pytest.approx(want, abs=0.002)


def test_wild_landmarks_in_the_minority_do_not_count() -> None:
    feet, rng = _feet(), np.random.default_rng(4)
    height = rng.normal(0, 0.002, len(feet))
    wild = rng.random(len(feet)) < 0.2
    height[wild] = 0.15
    heights = _at(rng.uniform(0.1, 0.9, (200, 2)).tolist(), feet, height)
    assert np.mean(np.abs(heights.value) < 0.005) > 0.95  # four wild ones of the nearest seven: 3 %
    assert 0.6 < heights.agreement.mean() < 0.95


def test_without_three_landmarks_in_reach_nothing_is_known() -> None:
    feet = np.array([[0.0, 0, 0], [0.01, 0, 0], [0.5, 0.5, 0], [0.51, 0.5, 0], [0.5, 0.51, 0]])
    heights = _at([[0.0, 0.0], [0.5, 0.5]], feet, np.full(5, 0.02))
    assert np.isnan(heights.value[0])
    assert heights.value[1] == pytest.approx(0.02, abs=1e-4)
    assert heights.count.tolist() == [2, 3]


def test_parts_are_put_together_in_order() -> None:
    feet = _feet()
    first, second = (_at([[x, 0.5]], feet, feet[:, 0]) for x in (0.3, 0.6))
    assert np.allclose(first.followed_by(second).value, [0.3, 0.6], atol=1e-3)


def test_no_vertex_gives_no_height() -> None:
    empty = local_heights(
        np.zeros((0, 3)), np.zeros((0, 3)), _feet(), np.zeros(4000), np.ones(4000), 20, 0.1
    )
    assert empty.value.shape == (0,)
