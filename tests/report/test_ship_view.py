# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The picture of the ship on top of the page."""

from __future__ import annotations

import re
from base64 import b64decode
from dataclasses import replace
from io import BytesIO
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh
from PIL import Image

from hullrecon.geometry.charts.axis_chart import build_axis_chart
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.surface import Surface
from hullrecon.report.content.page_context import draw_ship
from hullrecon.report.figures.ship_view import BELOW, PORT, STARBOARD, Side, facing_side, ship_svg
from hullrecon.report.survey import Survey

SVG = "{http://www.w3.org/2000/svg}"


def box(size: tuple[float, float, float], center: tuple[float, float, float] = (0, 0, 0)) -> Mesh:
    made = trimesh.creation.box(size)
    return Mesh(np.asarray(made.vertices) + center, np.asarray(made.faces, np.int32))


def plate(center: tuple[float, float, float], along: np.ndarray, other: np.ndarray) -> Mesh:
    """Two triangles of 2 m by 2 m whose normal is along x other."""
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float) @ np.stack([along, other])
    return Mesh(corners + center, np.array([[0, 1, 2], [0, 2, 3]], np.int32))


X, Y, Z = np.eye(3)
SHIP = box((40.0, 8.0, 6.0))
PATCHES = {
    "port": (plate((10, 4.05, 0), -X, Z), PORT),
    "starboard": (plate((10, -4.05, 0), X, Z), STARBOARD),
    "below": (plate((10, 0, -3.05), X, -Y), BELOW),
}


@pytest.mark.parametrize("name", PATCHES)
def test_the_ship_is_seen_from_where_the_patch_is(name: str) -> None:
    patch, side = PATCHES[name]
    assert facing_side(patch) is side
    assert ship_svg(SHIP, patch)[1] == side.words


@pytest.mark.parametrize("side", [PORT, STARBOARD, BELOW])
def test_a_picture_is_no_mirror_image(side: Side) -> None:
    np.testing.assert_allclose(np.linalg.det(np.stack([side.right, side.up, side.toward])), 1)
    assert side.bow_is_left == (side is PORT)  # as one sees a ship that lies at the quay


@pytest.mark.parametrize("name", PATCHES)
def test_the_patch_is_in_colour_where_its_frame_is(name: str) -> None:
    root = ElementTree.fromstring(ship_svg(SHIP, PATCHES[name][0])[0])
    image, frame = root.find(f"{SVG}image"), root.find(f"{SVG}rect")
    assert image is not None
    assert frame is not None
    with Image.open(BytesIO(b64decode(image.attrib["href"].split(",")[1]))) as png:
        picture = np.asarray(png.convert("RGBA"))
    orange = (picture[..., 0] > 1.3 * picture[..., 2]) & (picture[..., 3] == 255)
    rows, columns = np.nonzero(orange)
    factor = float(image.attrib["width"]) / picture.shape[1]
    middle = (
        factor * columns.mean() + float(image.attrib["x"]),
        factor * rows.mean() + float(image.attrib["y"]),
    )
    place = {k: float(frame.attrib[k]) for k in ("x", "y", "width", "height")}
    np.testing.assert_allclose(
        middle, (place["x"] + place["width"] / 2, place["y"] + place["height"] / 2), atol=1.5
    )
    assert (picture[..., 3] == 255).mean() > 0.95  # a box fills its picture


def test_a_small_patch_on_a_long_ship_has_a_frame_that_is_seen() -> None:
    svg, _ = ship_svg(box((300.0, 40.0, 20.0)), PATCHES["port"][0])
    (width,) = re.findall(r'class="patch"[^>]* width="([\d.]+)"', svg)
    assert float(width) >= 26


def test_the_scale_bar_is_as_long_as_it_says() -> None:
    svg, _ = ship_svg(SHIP, PATCHES["port"][0])
    (pixels,) = re.findall(r'class="bar" d="[^h]*h([\d.]+)', svg)
    (metres,) = re.findall(r">([\d.]+) m</text>", svg)
    assert float(pixels) / float(metres) == pytest.approx((1000 - 2 * 26) / 40, rel=1e-3)


def test_the_ship_is_drawn_from_chart_and_hull_as_found(survey: Survey, bare: Survey) -> None:
    chart = build_axis_chart(Mesh(SHIP.vertices, SHIP.faces), Z)
    patch = PATCHES["starboard"][0]
    count = len(patch.vertices)
    seen = Surface(
        vertices=patch.vertices,
        faces=patch.faces,
        deviation=np.zeros(count),
        sigma=np.ones(count),
        support=np.ones(count, int),
    )
    shown = draw_ship(
        replace(survey, surfaces=replace(survey.surfaces, chart=chart, as_found=seen))
    )
    assert shown is not None
    assert shown[1] == "starboard side"
    unseen = replace(seen, support=np.zeros(count, int))
    assert (
        draw_ship(replace(survey, surfaces=replace(survey.surfaces, chart=chart, as_found=unseen)))
        is None
    )
    assert draw_ship(survey) is None  # its chart is not that of a ship
    assert draw_ship(bare) is None
