# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tiles of a mosaic that is larger than its picture in the page."""

from __future__ import annotations

from base64 import b64decode
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import rasterio
from PIL import Image

from hullrecon.report.figures import map_pictures
from hullrecon.report.figures.hull_map import hull_map
from hullrecon.report.figures.map_pictures import ContrastStretch, read_mosaic, survey_layers
from hullrecon.report.figures.map_tiles import TILE_PX, TileIndex, index_tiles, stream_tiles
from hullrecon.report.survey import Mosaic, MosaicFacts, Mosaics, Survey

WIDTH, HEIGHT, STEP_M = 1200, 600, 0.002
UNSEEN = 200  # columns on the right


@pytest.fixture
def tiled(survey: Survey, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Survey:
    """A survey with a mosaic of waves, of which the right side was not seen.

    The page's picture of it has a third of its pixels a side.
    """
    monkeypatch.setattr(map_pictures, "MOST_PIXELS", WIDTH * HEIGHT / 9)
    x, y = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    wave = 120 + 60 * np.sin(x / 25) * np.cos(y / 35)
    values = np.stack([wave, wave / 2, 255 - wave, np.where(x < WIDTH - UNSEEN, 255, 0)])
    path, to_map = tmp_path / "ortho_optical.tif", rasterio.Affine(STEP_M, 0, 40, 0, -STEP_M, 7)
    with rasterio.open(
        path,
        "w",
        driver="GTiff",
        width=WIDTH,
        height=HEIGHT,
        count=4,
        dtype="uint8",
        photometric="RGB",
        alpha="YES",
        transform=to_map,
    ) as file:
        file.write(values.astype(np.uint8))
    return replace(
        survey,
        mosaics=Mosaics(
            optical=Mosaic(facts=MosaicFacts(caption="As seen."), preview=b"", has_mesh=False)
        ),
        provenance=replace(survey.provenance, copies={"ortho_optical.tif": path}),
    )


def tiles_of(survey: Survey) -> dict[str, bytes]:
    return dict(stream_tiles(survey, lambda function, items, _: map(function, items)))


def pixels(script: bytes) -> np.ndarray:
    start, end = b'hullreconTile("data:image/webp;base64,', b'")\n'
    assert script.startswith(start)
    assert script.endswith(end)
    webp = b64decode(script[len(start) : -len(end)], validate=True)
    with Image.open(BytesIO(webp)) as picture:
        return np.asarray(picture.convert("RGBA")).astype(int)


def test_tiles_put_together_are_the_mosaic_as_the_page_shows_it(tiled: Survey) -> None:
    files = tiles_of(tiled)
    ortho = tiled.provenance.copies["ortho_optical.tif"]
    stretch = ContrastStretch.of(*read_mosaic(ortho, 3))
    for level, factor in enumerate((1, 2)):
        expected = stretch.apply(*read_mosaic(ortho, factor)).astype(int)
        together = np.zeros_like(expected)
        for name, script in files.items():
            if name.startswith(f"report/tiles/optical/{level}/"):
                column, row = (TILE_PX * int(number) for number in Path(name).stem.split("_"))
                tile = pixels(script)
                together[row : row + tile.shape[0], column : column + tile.shape[1]] = tile
        seen = expected[..., 3] > 0
        np.testing.assert_array_equal(together[..., 3], expected[..., 3])
        assert np.abs(together - expected)[seen].mean() < 4  # WebP at quality 84


def test_a_tile_of_which_nothing_was_seen_is_left_out_and_the_index_says_so(tiled: Survey) -> None:
    index = index_tiles(tiled, ["report/index.html", *tiles_of(tiled)])
    assert index == {"optical": TileIndex(step_m=STEP_M, levels=[["11", "11"], ["1"]])}


def test_a_mosaic_that_the_page_holds_has_no_tiles(
    tiled: Survey, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(map_pictures, "MOST_PIXELS", WIDTH * HEIGHT)
    assert tiles_of(tiled) == {}
    assert index_tiles(tiled, ["report/index.html"]) == {}


def test_the_legend_says_where_the_map_is_finer(tiled: Survey) -> None:
    view = hull_map(tiled)
    alone, beside = (survey_layers(tiled, view, tiles)[0].note for tiles in ((), {"optical"}))
    assert alone.endswith("Shown at 6.0 mm a pixel; ortho_optical.tif has 2.0 mm.")
    assert beside.endswith(
        "Shown at 6.0 mm a pixel, closer up at 2.0 mm where the folder tiles is beside this page."
    )
