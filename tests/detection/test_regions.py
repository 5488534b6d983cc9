# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hullrecon.detection.objects.regions import find_regions, fit_hull_around
from hullrecon.detection.options import DetectOptions

OPTIONS = DetectOptions()
NORMAL = np.array([0.0, 0.6, -0.8])
EAST, NORTH = np.array([1.0, 0, 0]), np.array([0.0, 0.8, 0.6])
MIDDLE = np.array([30.0, 4.0, 1.0])


def test_the_disc_and_the_recess_are_found_highest_first(found) -> None:
    regions = find_regions(found, OPTIONS)
    assert [r.sign for r in regions] == [1.0, -1.0]
    assert regions[0].height == pytest.approx(0.10, abs=0.005)
    assert regions[1].height == pytest.approx(-0.05, abs=0.004)


def test_the_footprint_is_the_structure_and_the_ring_is_hull(found, height_at) -> None:
    for region in find_regions(found, OPTIONS):
        at = found.base.vertices
        assert np.mean(height_at(*at[region.core][:, [0, 2]].T) != 0) > 0.9
        assert (height_at(*at[region.ring][:, [0, 2]].T) == 0).all()
        assert np.abs(region.hull.offset(at[region.core]) + 0.012).max() < 0.002


def test_heights_count_from_hull_around_not_cad_model(found) -> None:
    lifted = replace(found, height=found.height + 0.015)
    assert find_regions(lifted, OPTIONS)[0].height == pytest.approx(
        find_regions(found, OPTIONS)[0].height, abs=0.002
    )


def test_heights_ignore_background_drawn_to_structure(
    found,
) -> None:
    """Landmarks on the flanks of what rises gently are hull to the deviation field."""
    x, z = found.base.vertices[:, [0, 2]].T
    lump = 0.14 * np.exp(-0.5 * (np.hypot(x - 1.2, z - 1.0) / 0.09) ** 2)
    drawn = 0.015 * np.exp(-0.5 * (np.hypot(x - 1.2, z - 1.0) / 0.25) ** 2)
    bulging = replace(
        found, height=lump - drawn, hull=found.hull + drawn, measured=np.ones_like(found.measured)
    )
    region = find_regions(bulging, OPTIONS)[0]
    top_8_cm2 = 0.14 * np.exp(-0.5 * (0.016 / 0.09) ** 2)
    # 13 mm less above what was drawn outward
    assert region.height == pytest.approx(top_8_cm2, abs=0.003)
    assert np.abs(region.rise(bulging, region.core) - lump[region.core]).max() < 0.004


def test_unmeasured_heights_make_no_region(found) -> None:
    assert find_regions(replace(found, measured=np.zeros_like(found.measured)), OPTIONS) == []


def test_a_structure_without_hull_around_it_has_no_height(found) -> None:
    x, z = found.base.vertices[:, [0, 2]].T
    alone = found.measured & (np.hypot(x - 1.2, z - 1.0) < 0.12)
    assert find_regions(replace(found, measured=alone), OPTIONS) == []


def test_specks_are_not_even_candidates(found) -> None:
    height = np.zeros_like(found.height)
    x, z = found.base.vertices[:, [0, 2]].T
    height[np.hypot(x - 1.2, z - 1.0) < 0.012] = 0.2
    assert find_regions(replace(found, height=height), OPTIONS) == []


def test_parts_with_a_gap_narrower_than_the_reach_are_one(found) -> None:
    x = found.base.vertices[:, 0]
    split = replace(found, height=np.where(np.abs(x - 1.2) < 0.02, 0.0, found.height))
    assert sum(r.sign > 0 for r in find_regions(split, OPTIONS)) == 1
    assert sum(r.sign > 0 for r in find_regions(split, DetectOptions(cluster_reach_m=0.02))) == 2


def _two_peaks(found, saddle_m: float):
    """Raised discs of 0.10 and 0.08 m, 0.15 m of hull between them at the saddle's height."""
    x, z = found.base.vertices[:, [0, 2]].T
    height = np.zeros_like(found.height)
    height[(np.abs(x - 1.2) < 0.18) & (np.abs(z - 1.0) < 0.05)] = saddle_m
    height[np.hypot(x - 1.02, z - 1.0) < 0.1] = 0.10
    height[np.hypot(x - 1.38, z - 1.0) < 0.1] = 0.08
    return replace(found, height=height)


def test_neighbours_with_a_low_bridge_between_them_are_two(found) -> None:
    regions = find_regions(_two_peaks(found, saddle_m=0.03), OPTIONS)
    assert [r.height for r in regions] == pytest.approx([0.10, 0.08], abs=0.005)
    assert not set(regions[0].footprint) & set(regions[1].footprint)


def test_peaks_with_a_high_saddle_between_them_are_one(found) -> None:
    assert len(find_regions(_two_peaks(found, saddle_m=0.05), OPTIONS)) == 1


def test_a_cone_is_blunt_and_a_disc_is_not(found) -> None:
    x, z = found.base.vertices[:, [0, 2]].T
    away = np.hypot(x - 1.2, z - 1.0)
    cone, disc = (
        find_regions(replace(found, height=h), OPTIONS)[0]
        for h in (np.maximum(0.0, 0.10 - 0.5 * away), np.where(away < 0.1, 0.10, 0.0))
    )
    assert disc.bluntness < 0.001
    # 8 and 24 cm2 are circles of 16 and 28 mm: the cone falls by 0.5 of that
    assert cone.bluntness == pytest.approx(0.5 * (0.0276 - 0.0160), abs=0.003)


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
