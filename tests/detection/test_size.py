# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.detection.objects.regions import find_regions
from hullrecon.detection.objects.size import EDGE_SIGMA_M, ObjectSize, measure_size
from hullrecon.detection.options import DetectOptions
from hullrecon.geometry.meshes.mesh import vertex_areas


@pytest.fixture(scope="module")
def sizes(scenery, found) -> list[ObjectSize]:
    area = vertex_areas(found.base)
    regions = find_regions(found, DetectOptions())
    return [measure_size(found, region, area, 0.004, np.array([0.0, 1, 0]), scenery.chart) for region in regions]


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
