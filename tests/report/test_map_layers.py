# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The pictures of the page's map."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import rasterio
from PIL import Image

from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.report.figures import map_pictures
from hullrecon.report.figures.hull_map import (
    Extent,
    MapField,
    Shading,
    form_shadings,
    hull_map,
    project_surface,
)
from hullrecon.report.figures.map_pictures import (
    MapLayer,
    field_layer,
    mosaic_layer,
    palette,
    survey_layers,
)
from hullrecon.report.survey import Mosaic, MosaicFacts, Mosaics, Survey

SHADING = Shading(colours="RdBu_r", low=-10.0, high=10.0, label="form (mm)", extend="both")


def field(values: np.ndarray) -> MapField:
    return MapField(name="form", title="Form", values=values, shading=SHADING, note="")


def pixels_of(layer: MapLayer) -> np.ndarray:
    with Image.open(BytesIO(layer.webp)) as picture:
        return np.asarray(picture.convert("RGBA"))


@pytest.fixture
def ortho(tmp_path: Path) -> Path:
    """6 by 4 pixels of 0.5 m from x = 10, y = 7: red on the left, nothing seen on the right."""
    values = np.zeros((4, 4, 6), np.uint8)
    values[0, :, :3], values[3, :, :3] = 200, 255
    profile = {
        "driver": "GTiff",
        "width": 6,
        "height": 4,
        "count": 4,
        "dtype": "uint8",
        "photometric": "RGB",
        "alpha": "YES",
    }
    with rasterio.open(
        tmp_path / "ortho.tif", "w", transform=rasterio.Affine(0.5, 0, 10, 0, -0.5, 7), **profile
    ) as file:
        file.write(values)
    return tmp_path / "ortho.tif"


def test_a_mosaic_lies_where_its_raster_lies(ortho: Path) -> None:
    layer = mosaic_layer("optical", "Camera mosaic", ortho)
    assert layer.bounds == (10.0, 5.0, 13.0, 7.0)
    picture = pixels_of(layer)
    assert picture.shape == (4, 6, 4)
    assert picture[:, :2, 0].min() > picture[:, :2, 1].max()
    np.testing.assert_array_equal(picture[..., 3], np.tile([255, 255, 255, 0, 0, 0], (4, 1)))
    assert layer.legend is None


def test_a_hazy_mosaic_is_stretched_and_its_colours_stay(
    tmp_path: Path,
) -> None:
    values = np.full((4, 20, 20), 255, np.uint8)
    values[0], values[1], values[2] = np.linspace(60, 120, 20)[None], 90, 75
    profile = {
        "driver": "GTiff",
        "width": 20,
        "height": 20,
        "count": 4,
        "dtype": "uint8",
        "photometric": "RGB",
        "alpha": "YES",
    }
    with rasterio.open(
        tmp_path / "hazy.tif", "w", transform=rasterio.Affine(1, 0, 5, 0, -1, 0), **profile
    ) as file:
        file.write(values)
    picture = pixels_of(mosaic_layer("optical", "Camera mosaic", tmp_path / "hazy.tif")).astype(int)
    level = picture[..., :3].mean(axis=2)
    assert level[10, 1] < 40
    assert level[10, 18] > 160
    # 15 before: colours do not glare
    assert 10 <= (picture[5:15, 5:15, 1] - picture[5:15, 5:15, 2]).mean() <= 25


def test_a_large_mosaic_is_shown_smaller(ortho: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(map_pictures, "MOST_PIXELS", 6)
    layer = mosaic_layer("optical", "Camera mosaic", ortho)
    assert pixels_of(layer).shape == (2, 3, 4)
    assert layer.bounds == (10.0, 5.0, 13.0, 7.0)


def test_every_pixel_of_a_field_has_a_colour_of_its_legend(survey: Survey, plate: Surface) -> None:
    view = hull_map(survey)
    values = 8.0 * np.sin(np.arange(len(plate.vertices)))
    picture = pixels_of(field_layer(view.found, field(values), view.extent))
    shown = picture[picture[..., 3] == 255][:, :3]
    assert set(np.unique(picture[..., 3])) == {0, 255}
    known = {tuple(colour) for colour in palette("RdBu_r").tolist()}
    assert {tuple(colour) for colour in np.unique(shown, axis=0).tolist()} <= known


def test_a_field_is_read_back_from_its_pixels(survey: Survey, plate: Surface) -> None:
    view = hull_map(survey)
    layer = field_layer(view.found, field(4.0 * plate.vertices[:, 0]), view.extent)
    picture = pixels_of(layer)
    left, bottom, right, top = layer.bounds
    level = {tuple(colour): k for k, colour in enumerate(palette("RdBu_r").tolist())}
    # along, girth: on the map x is minus along
    for x, y in ((-0.4, -1.3), (0.3, -0.5), (0.8, -1.6)):
        row = int((top - y) / (top - bottom) * len(picture))
        column = int((-x - left) / (right - left) * picture.shape[1])
        value = -10 + 20 * level[tuple(picture[row, column, :3].tolist())] / 255
        assert value == pytest.approx(4 * x, abs=0.2)


def test_what_was_not_seen_is_transparent(survey: Survey, plate: Surface) -> None:
    view = hull_map(survey)
    picture = pixels_of(field_layer(view.found, field(np.zeros(15)), view.extent))
    left, _, right, _ = view.extent.bounds
    # the plate is seen up to along = 1, which is x = -1
    seen_to = int((-1.0 - left) / (right - left) * picture.shape[1])
    middle = picture[picture.shape[0] // 2, :, 3]
    assert not middle[: seen_to - 3].any()
    assert middle[seen_to + 3]


def test_bounds_are_in_map_coordinates() -> None:
    extent = Extent(along=(30.0, 40.0), girth=(2.0, 7.0), flips=(True, False))
    assert extent.bounds == (-40.0, 2.0, -30.0, 7.0)
    assert replace(extent, flips=(False, True)).bounds == (30.0, -7.0, 40.0, -2.0)


def test_the_bare_hull_sets_the_colours_and_not_its_objects(
    survey: Survey, plate: Surface, split: DeviationSplit
) -> None:
    found = project_surface(plate, survey.surfaces.chart)
    form, sigma = form_shadings(found, split)
    high = split.form.copy()
    high[0] = 0.110  # a corner of the patch stands out by 110 mm
    with_object, _ = form_shadings(found, replace(split, form=high))
    assert with_object.high == pytest.approx(form.high, rel=0.4)
    assert with_object.high < 25
    assert (form.low, form.extend) == (-form.high, "both")
    assert (sigma.low, sigma.high) == (0, 2.0)
    assert form_shadings(found, replace(split, form=np.full(15, np.nan))) is None


def test_a_dive_has_the_layers_that_it_gives(survey: Survey, bare: Survey, ortho: Path) -> None:
    def names(dive: Survey) -> list[str]:
        view = hull_map(dive)
        return [] if view is None else [layer.name for layer in survey_layers(dive, view)]

    assert names(survey) == ["form", "form_sigma", "coverage"]
    optical = Mosaic(facts=MosaicFacts(caption="At 5 mm a pixel."), preview=b"", has_mesh=False)
    copies = replace(survey.provenance, copies={"ortho_optical.tif": ortho})
    assert (
        names(replace(survey, mosaics=Mosaics(optical=optical), provenance=copies))[0] == "optical"
    )
    no_cad = replace(bare, surfaces=replace(survey.surfaces, deviation=None, outside=None))
    assert names(no_cad) == ["sigma", "coverage"]
    assert names(replace(survey, surfaces=replace(survey.surfaces, as_found=None))) == []
    assert names(bare) == []


def test_coverage_by_the_dvl_is_not_called_the_cameras(survey: Survey) -> None:
    view = hull_map(survey)
    assert view is not None
    of_dvl = replace(survey, surfaces=replace(survey.surfaces, found_by_images=False))
    layers = [survey_layers(dive, view)[-1] for dive in (survey, of_dvl)]
    assert [layer.title for layer in layers] == ["Coverage by the cameras", "Coverage by the DVL"]
    assert "image" in layers[0].note
    assert "image" not in layers[1].note


def test_the_note_of_the_form_says_what_it_leaves_out(survey: Survey) -> None:
    form = survey_layers(survey, hull_map(survey))[0]
    assert (
        "as a whole the patch lies 6 mm outside it "
        "(one sigma 20 mm, not significantly different from zero)" in form.note
    )
