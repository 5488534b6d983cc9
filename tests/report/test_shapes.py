# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Surveys of any shape are shown: long and narrow, tall and narrow, tiny, with a hole."""

from __future__ import annotations

import re
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import rasterio
from PIL import Image
from report_pages import page_context

from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.report.content.objects import jpeg_uri
from hullrecon.report.figures.hull_map import Extent, hull_map
from hullrecon.report.figures.map_pictures import (
    MapLayer,
    field_step_m,
    form_map,
    form_png,
    ground_png,
    mosaic_layer,
    survey_layers,
)
from hullrecon.report.figures.plan_view import Plan, plan_svg
from hullrecon.report.format_limits import WEBP_SIDE_PX, reduction
from hullrecon.report.render import render_page, render_pdf
from hullrecon.report.survey import Survey

JPEG_SIDE_PX = 65_500  # JPEG_MAX_DIMENSION of libjpeg-turbo, which OpenCV and Pillow write with
PNG_SIDE_PX = 2**16 - 1  # matplotlib's Agg renderer until 3.8; PNG itself has 2^31 - 1
PDF_SIDE_UNITS = 14_400  # of a page, 200 in (ISO 32000-1, annex C.2)
CANVAS_PIXELS = 16_777_216  # a canvas whose pixels are read: Safari (4096 squared) has the fewest
LONG, TALL, PATCH, FAN = (330.0, 2.0), (2.0, 330.0), (3.0, 2.0), (3.0, 40.0)
SHAPES = pytest.mark.parametrize("size", [LONG, TALL, FAN, (0.004, 0.004)])


def surveyed(survey: Survey, size: tuple[float, float], hole: bool = False) -> Survey:
    """The survey with a plate of that size (m), 6 mm off its CAD model, and no object."""
    counts = [max(3, min(60, round(4 * span))) for span in size]
    x, y = np.meshgrid(*(np.linspace(0, span, n) for span, n in zip(size, counts, strict=True)))
    index = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (
        index[rows, columns].ravel()
        for rows in (np.s_[:-1], np.s_[1:])
        for columns in (np.s_[:-1], np.s_[1:])
    )
    faces = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)]).astype(np.int32)
    inside = hole & (np.abs(x / size[0] - 0.5) < 0.2) & (np.abs(y / size[1] - 0.5) < 0.2)
    plate = Surface(
        vertices=np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]),
        faces=faces,
        deviation=np.full(x.size, 0.006),
        sigma=np.full(x.size, 0.002),
        support=np.where(inside.ravel(), 0, 5),
    )
    split = DeviationSplit(
        offset=np.asarray(0.006),
        offset_sigma=np.asarray(0.02),
        tilt=np.zeros(2),
        tilt_sigma=np.full(2, 0.004),
        form=np.where(plate.support > 0, 0.003 * np.sin(x.ravel() + y.ravel()), np.nan),
        form_sigma=np.where(plate.support > 0, 0.002, np.nan),
    )
    poses = survey.track.poses
    along = np.linspace(0, 1, len(poses))[:, None] * [*size, 0.0]
    track = replace(survey.track, poses=replace(poses, translation=along - [0.0, 0.0, 1.0]))
    surfaces = replace(survey.surfaces, surveyed=plate, as_found=plate, deviation=split)
    return replace(
        survey, track=track, surfaces=surfaces, findings=replace(survey.findings, objects=())
    )


def pixels_of(picture: bytes) -> np.ndarray:
    with Image.open(BytesIO(picture)) as image:
        return np.asarray(image.convert("RGBA"))


def assert_square_pixels(layer: MapLayer) -> None:
    height, width = pixels_of(layer.webp).shape[:2]
    left, bottom, right, top = layer.bounds
    assert abs(width * layer.step_m - (right - left)) <= layer.step_m
    assert abs(height * layer.step_m - (top - bottom)) <= layer.step_m


@SHAPES
def test_layers_of_any_shape_are_within_the_limits(
    survey: Survey, size: tuple[float, float]
) -> None:
    shown = surveyed(survey, size)
    layers = survey_layers(shown, hull_map(shown))
    assert [layer.name for layer in layers] == ["form", "form_sigma", "coverage"]
    for layer in layers:
        height, width = pixels_of(layer.webp).shape[:2]
        assert max(height, width) <= WEBP_SIDE_PX
        assert height * width <= CANVAS_PIXELS
        assert_square_pixels(layer)


def test_a_hole_in_the_middle_stays_transparent(survey: Survey) -> None:
    shown = surveyed(survey, LONG, hole=True)
    for layer in survey_layers(shown, hull_map(shown)):
        alpha = pixels_of(layer.webp)[..., 3]
        height, width = alpha.shape
        assert not alpha[height // 2, width // 2]
        assert alpha[height // 2, width // 8]


@pytest.mark.parametrize(
    ("size", "words"),
    [(PATCH, "Shown at 5.0 mm a pixel."), (TALL, "Shown at 20 mm a pixel.")],
)
def test_a_layers_note_says_its_resolution(
    survey: Survey, size: tuple[float, float], words: str
) -> None:
    shown = surveyed(survey, size)
    assert all(layer.note.endswith(words) for layer in survey_layers(shown, hull_map(shown)))


def test_a_layers_note_names_the_finer_raster(survey: Survey, tmp_path: Path) -> None:
    raster = write_ortho(tmp_path / "form.tif", 4, 4)
    shown = surveyed(survey, LONG)
    copies = replace(shown.provenance, copies={"form.tif": raster})
    form, sigma, _ = survey_layers(replace(shown, provenance=copies), hull_map(shown))
    assert form.note.endswith("Shown at 20 mm a pixel; form.tif has 1.0 mm.")
    assert sigma.note.endswith("Shown at 20 mm a pixel.")


def write_ortho(path: Path, width: int, height: int) -> Path:
    """A mosaic of 1 mm a texel, gray where anything was seen: everywhere."""
    profile = {"driver": "GTiff", "width": width, "height": height, "count": 4, "dtype": "uint8"}
    transform = rasterio.Affine(0.001, 0, 10, 0, -0.001, 7)
    with rasterio.open(
        path, "w", transform=transform, **profile, photometric="RGB", alpha="YES"
    ) as file:
        values = np.full((4, height, width), 255, np.uint8)
        values[:3, ::2] = 90
        file.write(values)
    return path


@pytest.mark.parametrize(
    ("width", "height"), [(45_000, 3), (3, 45_000), (1, 20_000), (20_000, 1), (1, 1)]
)
def test_a_narrow_mosaic_is_reduced_to_what_webp_holds(
    tmp_path: Path, width: int, height: int
) -> None:
    layer = mosaic_layer("optical", "Mosaic", write_ortho(tmp_path / "ortho.tif", width, height))
    picture = pixels_of(layer.webp)
    assert max(picture.shape[:2]) == min(max(width, height), WEBP_SIDE_PX)
    assert (picture[..., 3] == 255).all()
    assert_square_pixels(layer)


@pytest.mark.parametrize("size", [LONG, TALL])
def test_plan_and_form_map_of_any_shape_are_drawn(
    survey: Survey, size: tuple[float, float]
) -> None:
    shown = surveyed(survey, size)
    view = hull_map(shown)
    ground = pixels_of(ground_png(view.found, view.extent))
    form = pixels_of(form_png(form_map(view.found, shown.surfaces.deviation, view)))
    assert max(ground.shape + form.shape) <= PNG_SIDE_PX
    assert (ground[..., 3] > 0).any()
    assert len(np.unique(form.reshape(-1, 4), axis=0)) > 50
    svg = plan_svg(Plan(extent=view.extent, path=view.path, path_sigma=(0.1, 0.1), marks=()), "t")
    _, _, width, height = map(float, re.search(r'viewBox="([^"]*)"', svg)[1].split())
    assert max(width, height) < 2100


def test_the_page_and_the_pdf_of_a_narrow_survey_are_written(survey: Survey) -> None:
    from pypdf import PdfReader

    context = page_context(surveyed(survey, TALL), [], {}, {})
    assert "Shown at 20 mm a pixel." in render_page(context)
    pages = PdfReader(BytesIO(render_pdf(context))).pages
    assert all(max(page.mediabox[2:]) < PDF_SIDE_UNITS for page in pages)


def test_a_sliver_of_an_image_is_enlarged_within_reason() -> None:
    import base64

    sliver = np.full((3000, 2, 3), 90, np.uint8)
    picture = pixels_of(base64.b64decode(jpeg_uri(sliver).split(",")[1]))
    assert max(picture.shape[:2]) <= 3000 < JPEG_SIDE_PX


def test_a_reduction_keeps_to_side_and_area() -> None:
    assert reduction(100, 50, 200) == 1
    assert reduction(400, 50, 200) == 2
    assert reduction(400, 400, 1000, 40_000) == 2
    assert field_step_m(Extent(along=(0, 10), girth=(0, 4))) == 0.005
