# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
import trimesh
from mosaic.conftest import FlatChart
from scipy import ndimage

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.geometry.frames import Frame
from hullrecon.mosaic.blend import Tile
from hullrecon.mosaic.grid import TexelGrid, Window
from hullrecon.mosaic.mosaic_surface import MosaicSurface
from hullrecon.mosaic.output.deliverables import (
    PREVIEW_PX,
    Presentation,
    gap_area_m2,
    make_deliverables,
    mosaic_document,
    near_outside,
    reduced_picture,
)
from hullrecon.mosaic.output.tile_store import TileStore, make_tiles
from hullrecon.threads import in_threads

GRID = TexelGrid(west=-0.4, north=0.3, step_m=0.01, height=60, width=80)
SHOWN = Presentation(
    title="Optical mosaic",
    frame=Frame.HULL,
    outside=OutsideMap(x_sign=-1, y_sign=1, frame="M"),
    frame_spacing_m=0.5,
    max_faces=500,
    facts={"surface": "as found", "images": 3},
)


def tiles(views: int) -> TileStore:
    """A mosaic of gray 120 that so many views saw everywhere in its right half."""

    def make(window: Window) -> Tile:
        columns = np.mgrid[window.top : window.bottom, window.left : window.right][1]
        count = np.where(columns >= 40, views, 0).astype(np.uint8)
        gray = np.full((*window.shape, 1), 120, np.float32)
        return Tile(value=gray, variance=np.full(window.shape, 4.0, np.float32), views=count)

    return make_tiles(GRID, 1, 16, 80, make, in_threads, BytesIO())


def test_the_document_says_where_and_how_large_the_mosaic_is() -> None:
    document = mosaic_document(tiles(2), Frame.HULL, SHOWN.facts)
    assert document["frame"] == "M"
    assert document["area_m2"] == pytest.approx(0.6 * 0.4)
    assert document["along_m"] == pytest.approx([-0.4, 0.4])
    assert document["girth_m"] == pytest.approx([-0.3, 0.3])
    assert document["texels_by_views"] == {"0": 2400, "1": 0, "2": 2400, "3": 0, "4": 0}
    assert document["images"] == 3


def test_the_caption_names_the_surface_and_the_known_uncertainty() -> None:
    plain = str(mosaic_document(tiles(2), Frame.HULL, SHOWN.facts)["caption"])
    assert (
        plain == "10.0 mm a pixel, at most four best views a pixel, laid on the surface as found."
    )
    known = str(
        mosaic_document(tiles(2), Frame.HULL, {**SHOWN.facts, "position_sigma_m": 0.0312})[
            "caption"
        ]
    )
    assert known == plain + " A pixel's position on the hull is known to 31 mm (one sigma)."
    unknown = mosaic_document(tiles(2), Frame.HULL, {**SHOWN.facts, "position_sigma_m": None})[
        "caption"
    ]
    assert unknown == plain


def test_a_mosaic_that_saw_nothing_has_no_variance_and_no_mesh(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    made = make_deliverables(flat_surface(), tiles(0), SHOWN)
    assert made.document["variance_gray_levels_squared"] == {}
    assert made.document["area_m2"] == 0.0
    assert made.textured_mesh is None


def test_a_mosaic_comes_with_a_preview_and_a_mesh(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    made = make_deliverables(flat_surface(), tiles(2), SHOWN)
    assert made.preview.startswith(b"\x89PNG")
    assert made.textured_mesh is not None
    assert made.textured_mesh.startswith(b"glTF")


def test_the_mesh_stands_upright_by_the_axes_of_its_chart(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    class Lying(FlatChart):
        ship_axes = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])

    made = make_deliverables(replace(flat_surface(), chart=Lying()), tiles(2), SHOWN)
    assert made.textured_mesh is not None
    scene = trimesh.load(BytesIO(made.textured_mesh), file_type="glb")
    turn, _ = scene.graph[scene.graph.nodes_geometry[0]]
    np.testing.assert_array_equal(turn, np.eye(4))  # y is up in the file of this model, as in glTF


def test_frame_numbers_are_shown_in_the_ships_frame_only(
    flat_surface: Callable[..., MosaicSurface],
) -> None:
    numbered, bare = (
        make_deliverables(flat_surface(), tiles(2), replace(SHOWN, frame_spacing_m=s))
        for s in (0.5, None)
    )
    assert numbered.preview != bare.preview
    numbered, bare = (
        make_deliverables(
            flat_surface(), tiles(2), replace(SHOWN, frame=Frame.GLOBAL, frame_spacing_m=s)
        )
        for s in (0.5, None)
    )
    assert numbered.preview == bare.preview


def test_gaps_inside_outline_count_and_shape_does_not() -> None:
    """A mosaic of 2 m by 1 m at 1 cm: a hole of 30 cm in it, a notch of 20 cm and a bay of 1 m at
    its rim.
    """
    alpha = np.zeros((160, 260), np.uint8)
    alpha[30:130, 30:230] = 255
    assert gap_area_m2(alpha, 0.01) == 0.0
    alpha[60:90, 60:90] = 0
    assert gap_area_m2(alpha, 0.01) == pytest.approx(0.09)
    alpha[30:60, 150:170] = 0
    assert gap_area_m2(alpha, 0.01) == pytest.approx(0.09 + 0.06, rel=0.1)
    alpha[30:130, 190:230] = 0
    assert gap_area_m2(alpha, 0.01) == pytest.approx(0.09 + 0.06, rel=0.1)


def test_a_mosaic_with_a_gap_says_so() -> None:
    def torn(window: Window) -> Tile:
        rows, columns = np.mgrid[window.top : window.bottom, window.left : window.right]
        gone = (np.abs(columns - 40) < 10) & (np.abs(rows - 30) < 10)
        return Tile(
            value=np.full((*window.shape, 1), 120, np.float32),
            variance=np.zeros(window.shape, np.float32),
            views=np.where(gone, 0, 2).astype(np.uint8),
        )

    document = mosaic_document(
        make_tiles(GRID, 1, 16, 80, torn, in_threads, BytesIO()),
        Frame.HULL,
        SHOWN.facts,
    )
    assert "Gaps inside its outline: 0.04 m²." in str(document["caption"])


def test_a_reduced_picture_keeps_the_mean_of_what_was_seen() -> None:
    picture = np.zeros((50, 2 * PREVIEW_PX, 4), np.uint8)
    picture[:, ::2] = [10, 100, 201, 255]  # every other column was seen
    small = reduced_picture(picture)
    assert small.shape == (25, PREVIEW_PX, 4)
    np.testing.assert_allclose(
        small[..., :3], np.broadcast_to([10, 100, 201], (25, PREVIEW_PX, 3)), atol=1
    )
    np.testing.assert_allclose(small[..., 3], 128, atol=1)


@pytest.mark.parametrize("most_px", [5, 13, 25])
def test_distances_are_those_of_scipy(most_px: int) -> None:
    inside = np.random.default_rng(4).random((120, 90)) > 0.002
    exact = ndimage.distance_transform_edt(inside) <= most_px
    np.testing.assert_array_equal(near_outside(inside, most_px), exact)
