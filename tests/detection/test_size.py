# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hullrecon.detection.objects.footprint import (
    EDGE_SIGMA_M,
    ObjectSize,
    find_open_edge,
    measure_size,
)
from hullrecon.detection.objects.regions import find_regions
from hullrecon.detection.options import DetectOptions
from hullrecon.geometry.meshes.mesh import vertex_areas
from hullrecon.geometry.neighbours import Around


@pytest.fixture(scope="module")
def sizes(scenery, found) -> list[ObjectSize]:
    return _sizes(scenery, found)


def _sizes(scenery, found) -> list[ObjectSize]:
    area, around, up = vertex_areas(found.base), Around(found.base.vertices), np.array([0.0, 1, 0])
    regions = find_regions(found, DetectOptions())
    edges = [find_open_edge(found, region, area, around) for region in regions]
    return [
        measure_size(found, r, edge, area, 0.004, up, scenery.chart)
        for r, edge in zip(regions, edges, strict=True)
    ]


def test_the_truth_lies_within_two_sigmas_of_every_size(sizes: list[ObjectSize]) -> None:
    true = ((0.24, np.pi * 0.12**2, np.pi * 0.12**2 * 0.10), (0.2, 0.04, -0.04 * 0.05))
    for size, (extent, area, volume) in zip(sizes, true, strict=True):
        assert np.abs(np.array(size.extent) - extent).max() < 2 * size.extent_sigma[0]
        assert abs(size.area - area) < 2 * size.area_sigma
        assert abs(size.volume - volume) < 2 * size.volume_sigma


def test_sizes_are_as_uncertain_as_the_edge_and_the_height(sizes: list[ObjectSize]) -> None:
    disc = sizes[0]
    assert disc.extent_sigma[0] == pytest.approx(EDGE_SIGMA_M * 2**0.5, abs=1e-5)
    assert 0.1 < disc.area_sigma / disc.area < 0.3
    assert disc.volume_sigma > disc.area * 0.004


@pytest.mark.parametrize("beyond_m", [0.07, 0.03, 0.0, -0.03])
def test_the_truth_lies_within_the_sigmas_of_what_the_edge_of_the_survey_cuts(
    scenery, found, beyond_m: float
) -> None:
    unseen = found.base.vertices[:, 0] > 1.2 + beyond_m
    cut = replace(
        found, measured=found.measured & ~unseen, height=np.where(unseen, 0.0, found.height)
    )
    size, whole = _sizes(scenery, cut)[0], _sizes(scenery, found)[0]
    off = np.abs(np.array(size.extent) - 0.24) / size.extent_sigma
    assert off.max() < 3
    assert abs(size.area - np.pi * 0.12**2) < 2 * size.area_sigma
    assert abs(size.volume - np.pi * 0.12**2 * 0.10) < 2 * size.volume_sigma
    assert size.extent_sigma[0] > 2 * whole.extent_sigma[0]
    assert size.volume_sigma > 4 * whole.volume_sigma
