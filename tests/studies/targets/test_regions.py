# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Regions of interest in images by edges and hue, and their features."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.studies.targets.region_study import BARE, ROCKS, STAINS, RegionTrial, try_regions
from hullrecon.studies.targets.regions import find_regions, hue_of
from hullrecon.studies.targets.sea_floor import draw_floor, look


@pytest.fixture(scope="module")
def trial() -> RegionTrial:
    return try_regions(2)


def test_regions_cover_rocks_and_little_else(trial: RegionTrial) -> None:
    assert trial.recall.min() >= 0.9
    assert trial.false.max() <= 0.05


def test_a_floor_without_rocks_gets_no_region(trial: RegionTrial) -> None:
    assert trial.bare == 0


def test_twenty_matches_survive_a_quarter_turn(trial: RegionTrial) -> None:
    assert trial.inliers.min() >= 20
    assert trial.right.min() >= 0.95


def test_each_line_alone_takes_more_for_a_region() -> None:
    floor = draw_floor(0, ROCKS, STAINS)
    stained = find_regions(look(floor, 50, tuple(BARE[1])).image)
    assert stained.by_hue.any()  # a soft stain has a rock's hue
    assert stained.by_edges.any()  # ripples and pebbles have edges
    assert not stained.region.any()


def test_hue_ignores_shading_and_highlights() -> None:
    colour = np.array([[[120, 80, 50]]], np.uint8)
    shaded = (colour * 0.5).astype(np.uint8)
    highlight = colour + np.uint8(60)  # white light added
    np.testing.assert_allclose(hue_of(shaded), hue_of(colour), atol=1e-12)
    np.testing.assert_allclose(hue_of(highlight), hue_of(colour), atol=1e-12)
