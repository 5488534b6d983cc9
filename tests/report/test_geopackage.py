# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The bytes of a GeoPackage, read back by SQLite and by hand."""

from __future__ import annotations

import sqlite3
import struct

import numpy as np
import pytest

from hullrecon.report.export.layers import SRS_ID, Layer, geometry_blob, geopackage_bytes

SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
WKT = 'LOCAL_CS["a wall",UNIT["metre",1]]'


def layer(shapes: list[np.ndarray], fields: list[dict[str, int | float | str | None]]) -> Layer:
    return Layer(
        name="walls",
        description="of a house",
        polygons=True,
        shapes=shapes,
        fields=fields,
        types={"number": int, "height": float, "name": str},
    )


@pytest.fixture
def base() -> sqlite3.Connection:
    two = layer(
        [SQUARE, SQUARE + 5],
        [{"number": 1, "height": 2.5, "name": "it's"}, {"number": 2, "height": None, "name": None}],
    )
    found = sqlite3.connect(":memory:")
    found.deserialize(geopackage_bytes([two], "a wall", WKT, "2026-05-04T09:30:00.000Z"))
    return found


def test_a_polygon_is_closed_and_has_its_envelope() -> None:
    blob = geometry_blob(SQUARE, polygon=True)
    magic, version, flags, system = struct.unpack_from("<2sBBi", blob)
    assert (magic, version, system) == (b"GP", 0, SRS_ID)
    assert flags == 0b00000011  # little endian, envelope of x and y, not empty
    assert struct.unpack_from("<4d", blob, 8) == (0.0, 2.0, 0.0, 1.0)
    assert struct.unpack_from("<BIII", blob, 40) == (1, 3, 1, 5)
    ring = np.frombuffer(blob, "<f8", 10, 53).reshape(5, 2)
    np.testing.assert_array_equal(ring, np.vstack([SQUARE, SQUARE[:1]]))
    assert len(blob) == 53 + 80


def test_a_point_has_no_envelope() -> None:
    blob = geometry_blob(np.array([[3.0, -4.0]]), polygon=False)
    assert blob[3] == 0b00000001
    assert struct.unpack_from("<BI2d", blob, 8) == (1, 1, 3.0, -4.0)
    assert len(blob) == 29


def test_fields_come_back_with_their_types(base: sqlite3.Connection) -> None:
    assert base.execute("SELECT fid, number, height, name FROM walls").fetchall() == [
        (1, 1, 2.5, "it's"),
        (2, 2, None, None),
    ]
    columns = {name: kind for _, name, kind, *_ in base.execute("PRAGMA table_info(walls)")}
    assert columns == {
        "fid": "INTEGER",
        "geom": "POLYGON",
        "number": "INTEGER",
        "height": "DOUBLE",
        "name": "TEXT",
    }


def test_the_contents_have_the_layers_bounds(base: sqlite3.Connection) -> None:
    (row,) = base.execute(
        "SELECT table_name, data_type, min_x, min_y, max_x, max_y, srs_id FROM gpkg_contents"
    )
    assert row == ("walls", "features", 0.0, 0.0, 7.0, 6.0, SRS_ID)


def test_the_coordinate_system_is_the_one_given(base: sqlite3.Connection) -> None:
    query = "SELECT srs_name, definition FROM gpkg_spatial_ref_sys WHERE srs_id = ?"
    assert base.execute(query, (SRS_ID,)).fetchone() == ("a wall", WKT)


def test_the_file_is_marked_as_a_geopackage_of_version_1_3() -> None:
    data = geopackage_bytes([layer([], [])], "a wall", WKT, "2026-01-01T00:00:00.000Z")
    assert data[:16] == b"SQLite format 3\0"
    assert data[68:72] == b"GPKG"
    assert int.from_bytes(data[60:64], "big") == 10300
