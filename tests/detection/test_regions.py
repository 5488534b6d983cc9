# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hullrecon.detection.objects.regions import find_regions
from hullrecon.detection.options import DetectOptions

OPTIONS = DetectOptions()


def test_the_disc_and_the_recess_are_found_highest_first(found) -> None:
    regions = find_regions(found, OPTIONS)
    assert [r.side for r in regions] == [1.0, -1.0]
    assert regions[0].height == pytest.approx(0.10, abs=0.005)
    assert regions[1].height == pytest.approx(-0.05, abs=0.004)


def test_the_footprint_is_the_structure_and_the_ring_is_hull(found, height_at) -> None:
    for region in find_regions(found, OPTIONS):
        at = found.base.vertices
        assert np.mean(height_at(*at[region.core][:, [0, 2]].T) != 0) > 0.9
        assert (height_at(*at[region.ring][:, [0, 2]].T) == 0).all()
        assert np.abs(region.hull.offset(at[region.core]) + 0.012).max() < 0.002


def test_heights_count_from_the_hull_around_not_from_the_cad_model(found) -> None:
    lifted = replace(found, height=found.height + 0.015)
    assert find_regions(lifted, OPTIONS)[0].height == pytest.approx(
        find_regions(found, OPTIONS)[0].height, abs=0.002
    )


def test_heights_count_from_the_hull_beneath_where_the_background_was_drawn_outward_there(
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
    assert sum(r.side > 0 for r in find_regions(split, OPTIONS)) == 1
    assert sum(r.side > 0 for r in find_regions(split, DetectOptions(cluster_reach_m=0.02))) == 2


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
    assert not set(regions[0].foot) & set(regions[1].foot)


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
