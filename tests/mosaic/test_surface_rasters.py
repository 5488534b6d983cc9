# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.geometry.meshes.mesh import corner_shares
from hullrecon.mosaic.grid import TexelGrid
from hullrecon.mosaic.mosaic_surface import MosaicSurface, interpolate_values, sample_surface
from hullrecon.mosaic.output.raster import (
    RasterLayout,
    surface_bands,
    surface_values,
)
from hullrecon.records.surface import DeviationSplit, Surface

GRID = TexelGrid(west=-1.2, north=1.2, step_m=0.1, height=24, width=24)
LAYOUT = RasterLayout(grid=GRID, size=32, outside=OutsideMap(x_sign=-1, y_sign=1, frame="M"))


def values_at_texels(surface: MosaicSurface) -> dict[str, NDArray[Any]]:
    return interpolate_values(surface, sample_surface(surface, GRID, GRID.whole))


def test_linear_field_is_linear_over_texels(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    surface = flat_surface()
    slope = 0.01 * surface.mesh.vertices[:, 0] + 0.02 * surface.mesh.vertices[:, 1]
    tile = values_at_texels(replace(surface, values={"form": slope}))["form"]
    at = GRID.centers(np.arange(24.0), np.arange(24.0))
    on = (np.abs(at) < 1).all(axis=2)
    np.testing.assert_allclose(tile[on], (at @ [0.01, 0.02])[on], atol=6e-5)
    assert np.isnan(tile[~on]).all()


def test_counts_are_of_nearest_corner_and_zero_off_surface(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    support = {"support": np.array([1.0, 2, 3, 4])}
    tile = values_at_texels(replace(flat_surface(), values=support))["support"]
    assert tile.dtype == np.uint16
    assert set(np.unique(tile)) == {0, 1, 2, 3, 4}
    assert tile[3, 3] == 4  # along -0.85, girth 0.85
    assert tile[0, 0] == 0


def test_shares_of_a_face_give_its_points_back() -> None:
    face = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0]])
    points = np.array([[0.2, 0.4, 0.0], [0.0, 0.0, 0.0], [0.5, 0.5, 0.0]])
    share = corner_shares(np.tile(face, (3, 1, 1)), points)
    np.testing.assert_allclose(share @ face, points, atol=1e-12)


def test_unseen_is_nan_and_without_model_support_alone() -> None:
    n = 3
    surface = Surface(
        vertices=np.zeros((n, 3)),
        faces=np.zeros((0, 3), np.int32),
        deviation=np.full(n, 0.01),
        sigma=np.full(n, 0.02),
        support=np.array([0, 2, 5]),
    )
    one = np.asarray(0.0)
    split = DeviationSplit(
        offset=one,
        offset_sigma=one,
        tilt=np.zeros(2),
        tilt_sigma=np.zeros(2),
        form=np.full(n, 0.003),
        form_sigma=np.full(n, 0.002),
    )
    values = surface_values(surface, split)
    assert set(values) == {"support", "deviation", "deviation_sigma", "form", "form_sigma"}
    np.testing.assert_array_equal(values["form"], [np.nan, 0.003, 0.003])
    assert set(surface_values(surface, None)) == {"support"}


@pytest.mark.parametrize(
    ("name", "unit", "dtype"), [("form_sigma", "m", "float32"), ("support", "", "uint16")]
)
def test_each_raster_says_what_it_holds(name: str, unit: str, dtype: str) -> None:
    bands = surface_bands(name)
    assert (bands.names, bands.unit, bands.dtype) == ((name,), unit, dtype)
    assert bands.title


def test_the_support_says_whether_it_counts_images_or_returns() -> None:
    assert (
        surface_bands("support").title == "images that saw the surface where landmarks measured it"
    )
    assert (
        surface_bands("support", by_images=False).title == "DVL returns within reach of the surface"
    )
    assert surface_bands("form", by_images=False).title == surface_bands("form").title
