# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""as_found.las, read back by laspy."""

from __future__ import annotations

from dataclasses import replace
from datetime import date
from io import BytesIO

import laspy
import numpy as np
import pytest
import rasterio

from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.report.export.las import STEP_M, frame_wkt, las_bytes

T_NS = 1_777_887_000_468_241_234


def read(data: bytes) -> laspy.LasData:
    return laspy.read(BytesIO(data))


@pytest.fixture
def partly_seen(plate: Surface) -> Surface:
    """A plate far from the origin, of which one vertex was not seen."""
    support = np.arange(len(plate.vertices))
    return replace(
        plate, vertices=plate.vertices + np.array([123.4567, -45.6, 7.0]), support=support
    )


def test_points_are_the_seen_vertices_to_a_tenth_of_a_mm(
    partly_seen: Surface, split: DeviationSplit
) -> None:
    cloud = read(las_bytes(partly_seen, split, "M", T_NS))
    np.testing.assert_allclose(cloud.xyz, partly_seen.vertices[1:], atol=STEP_M / 2 + 1e-9)
    np.testing.assert_array_equal(cloud.support, partly_seen.support[1:])
    assert (np.asarray(cloud.return_number) == 1).all()


def test_sigma_deviation_and_form_go_with_the_points(
    partly_seen: Surface, split: DeviationSplit
) -> None:
    cloud = read(las_bytes(partly_seen, split, "M", T_NS))
    for name, values in (
        ("sigma", partly_seen.sigma),
        ("deviation", partly_seen.deviation),
        ("form", split.form),
    ):
        np.testing.assert_array_equal(cloud[name], values[1:].astype(np.float32))


def test_the_support_says_what_it_counts(partly_seen: Surface) -> None:
    said = [
        {
            d.name: d.description
            for d in read(
                las_bytes(partly_seen, None, "M", T_NS, by_images=by)
            ).point_format.extra_dimensions
        }
        for by in (True, False)
    ]
    assert [words["support"] for words in said] == ["images that saw it", "DVL returns near"]


def test_without_a_cad_model_there_is_no_deviation(partly_seen: Surface) -> None:
    names = list(read(las_bytes(partly_seen, None, "g", T_NS)).point_format.extra_dimension_names)
    assert names == ["sigma", "support"]


def test_the_header_fits_the_points_and_the_dive(
    partly_seen: Surface, split: DeviationSplit
) -> None:
    header = read(las_bytes(partly_seen, split, "M", T_NS)).header
    assert (str(header.version), header.point_format.id) == ("1.4", 6)
    assert (header.scales == STEP_M).all()
    assert (np.abs(header.mins - header.offsets) < 1).all()
    np.testing.assert_allclose(header.maxs, partly_seen.vertices[1:].max(axis=0), atol=STEP_M)
    assert header.creation_date == date(2026, 5, 4)
    assert header.global_encoding.wkt


@pytest.mark.parametrize(("frame", "down"), [("M", "UP"), ("g", "DOWN")])
def test_the_coordinate_system_is_a_local_one_in_metres(
    partly_seen: Surface, frame: str, down: str
) -> None:
    (record,) = read(las_bytes(partly_seen, None, frame, T_NS)).header.vlrs.get(
        "WktCoordinateSystemVlr"
    )
    assert record.string == frame_wkt(frame)
    read_by_gdal = rasterio.CRS.from_wkt(record.string)
    assert not read_by_gdal.is_geographic
    assert 'UNIT["metre",1' in read_by_gdal.to_wkt()
    assert f'AXIS["z",{down}]' in record.string


def test_equal_surfaces_give_equal_bytes(partly_seen: Surface, split: DeviationSplit) -> None:
    assert las_bytes(partly_seen, split, "M", T_NS) == las_bytes(partly_seen, split, "M", T_NS)


@pytest.mark.parametrize(
    ("up", "ways"),
    [
        ((0, 1, 0), "EAST UP SOUTH"),
        ((0, 0, -1), "EAST SOUTH DOWN"),
        ((-1, 0, 0), "DOWN EAST SOUTH"),
        ((0, 0, 1), "EAST NORTH UP"),
    ],
)
def test_the_coordinate_system_names_the_axis_that_is_up(
    up: tuple[int, int, int], ways: str
) -> None:
    x, y, z = ways.split()
    assert f'AXIS["x",{x}],AXIS["y",{y}],AXIS["z",{z}]' in frame_wkt("M", up)
