# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hullrecon.evaluation.truth import read_truth
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.mosaic.grid import TexelGrid
from hullrecon.records.surface import Surface
from hullrecon.studies.surfaces.by_source import measure
from hullrecon.studies.surfaces.mosaics import correlation


def test_deviations_are_counted_apart_along_the_waterline(package: Path) -> None:
    truth = read_truth(package)
    at = truth.built_mesh.vertices
    middle = np.median(at, axis=0)
    near = at[np.abs(at - middle).max(axis=1) < 0.8][::7]
    chart = PlaneChart(middle, np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]))
    girth = chart.to_chart(near)[:, 1]
    top = girth > np.quantile(girth, 0.9)
    surface = Surface(
        vertices=near,
        faces=np.zeros((0, 3), np.int32),
        deviation=np.where(top, -0.03, 0.01),
        sigma=np.full(len(near), 0.01),
        support=np.ones(len(near), np.int64),
    )
    found = measure(surface, chart, truth)
    assert (found.rms_top, found.rms_rest) == (pytest.approx(0.03), pytest.approx(0.01))
    assert found.rms == pytest.approx(np.sqrt(0.1 * 9e-4 + 0.9 * 1e-4), rel=0.05)
    assert found.rms_true < 1e-9


def test_pictures_on_shifted_grids_correlate_where_they_overlap(rng: np.random.Generator) -> None:
    whole = rng.normal(size=(60, 80))
    grid = TexelGrid(west=1.0, north=5.0, step_m=0.1, height=50, width=60)
    other = TexelGrid(west=1.0 + 1.2, north=5.0 - 0.7, step_m=0.1, height=50, width=60)
    first, second = whole[:50, :60].copy(), whole[7:57, 12:72].copy()
    second[3, 4] = np.nan
    assert correlation((grid, first), (other, second)) == pytest.approx(1.0)
    assert abs(correlation((grid, first), (grid, second))) < 0.2
