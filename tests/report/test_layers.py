# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What is laid over the orthos: the chart itself, outlines and photos of objects. Read back without
the code that wrote it.
"""

from __future__ import annotations

import sqlite3
import struct
from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np
import pytest

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.records.deliverables import ReportedObject
from hullrecon.report.content.objects import object_crops, photo_jpeg
from hullrecon.report.export.geometry import chart_document, chart_mesh, chart_ply
from hullrecon.report.export.layers import geojson, geopackage, object_layers, photo_name
from hullrecon.report.survey import Survey

CHART = PlaneChart(np.array([0.0, 0, 0]), np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, -1]]))
OUTSIDE = OutsideMap(x_sign=-1, y_sign=1, frame="M")
CORNERS = np.array([[0.0, 0, 0], [2.0, 1.0, 0.0]])


def database(data: bytes) -> sqlite3.Connection:
    base = sqlite3.connect(":memory:")
    base.deserialize(data)
    return base


def polygon(blob: bytes) -> np.ndarray:
    """The ring of a GeoPackage polygon with an envelope of x and y."""
    assert blob[:2] == b"GP"
    assert blob[3] & 0b1110 == 0b10
    byte_order, kind, rings, count = struct.unpack_from("<BIII", blob, 40)
    assert (byte_order, kind, rings) == (1, 3, 1)
    return np.frombuffer(blob, "<f8", 2 * count, 53).reshape(-1, 2)


def test_the_chart_mesh_lies_on_the_ship_facing_outward() -> None:
    mesh = chart_mesh(CHART, CORNERS)
    assert mesh.step_m == 0.1
    np.testing.assert_allclose(
        mesh.points, np.column_stack([mesh.along_girth, 0 * mesh.along_girth[:, 0]]), atol=1e-12
    )
    a, b, c = mesh.points[mesh.faces].transpose(1, 0, 2)
    assert (np.cross(b - a, c - a)[:, 2] < 0).all()
    assert np.ptp(mesh.along_girth[:, 0]) == pytest.approx(3.0, abs=0.21)


def test_a_large_chart_is_coarser_rather_than_larger() -> None:
    mesh = chart_mesh(CHART, np.array([[0.0, 0, 0], [400.0, 40.0, 0.0]]))
    assert len(mesh.points) < 260_000
    assert mesh.step_m > 0.2


def test_where_the_chart_ends_its_mesh_does() -> None:
    class Half(PlaneChart):
        def from_chart(self, along_girth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            points, normals = super().from_chart(along_girth)
            points[along_girth[:, 0] > 1] = np.nan
            return points, normals

    mesh = chart_mesh(Half(CHART.origin, CHART.axes), CORNERS)
    assert np.isfinite(mesh.points).all()
    assert mesh.points[:, 0].max() == pytest.approx(1.0, abs=0.11)


def test_the_chart_file_holds_both_coordinates(
    survey: Survey, ply_reader: Callable[[bytes], tuple[np.ndarray, np.ndarray]]
) -> None:
    vertices, faces = ply_reader(chart_ply(survey, chart_mesh(CHART, CORNERS)))
    assert vertices.dtype.names == ("x", "y", "z", "nx", "ny", "nz", "along", "girth")
    np.testing.assert_allclose(vertices["x"], vertices["along"])
    assert faces.max() == len(vertices) - 1


def test_the_chart_document_gives_the_map_and_a_plane_exactly() -> None:
    document = chart_document(CHART, OUTSIDE, chart_mesh(CHART, CORNERS))
    assert document["map"]["along_from_x"] == -1  # type: ignore[index]
    assert document["kind"] == "plane"
    assert document["plane"] == {
        "origin": [0, 0, 0],
        "along": [1, 0, 0],
        "girth": [0, 1, 0],
        "normal": [0, 0, -1],
    }


def test_an_outline_lies_on_the_map_in_every_layer(found: ReportedObject) -> None:
    layers = object_layers([found], {1}, CHART, OUTSIDE)
    want = np.array(found.outline)[:, :2] * [-1, 1]
    (feature,) = geojson(layers[0], OUTSIDE, [1])["features"]  # type: ignore[misc]
    ring = np.array(feature["geometry"]["coordinates"][0])
    np.testing.assert_allclose(ring[:-1], want, atol=1e-5)
    np.testing.assert_array_equal(ring[0], ring[-1])
    assert feature["properties"]["photo"] == "objects/1.jpg"
    base = database(geopackage(layers, OUTSIDE, 1_777_887_000_468_241_234))
    (blob,) = base.execute("SELECT geom FROM objects").fetchone()
    np.testing.assert_array_equal(polygon(blob)[:-1], want)
    (blob,) = base.execute("SELECT geom FROM object_centers").fetchone()
    np.testing.assert_array_equal(struct.unpack_from("<2d", blob, 13), [-1.0, -1.2])


def test_a_feature_says_each_number_with_its_sigma(found: ReportedObject) -> None:
    fields = object_layers([found], set(), CHART, OUTSIDE)[0].fields[0]
    sure = {"id", "kind", "views", "p_value", "side", "frame", "open_edge", "address", "photo"}
    bare = {
        n
        for n in fields
        if n not in sure and "sigma" not in n and not {f"{n}_sigma", f"sigma_{n}"} & fields.keys()
    }
    assert bare == set()


def test_the_geopackage_keeps_to_the_standards_tables(found: ReportedObject) -> None:
    layers = object_layers(
        [found, replace(found, id=2, outline=(), depth=None)], set(), CHART, OUTSIDE
    )
    base = database(geopackage(layers, OUTSIDE, 1_777_887_000_468_241_234))
    assert base.execute("PRAGMA application_id").fetchone() == (0x47504B47,)
    assert base.execute("PRAGMA integrity_check").fetchone() == ("ok",)
    assert base.execute("PRAGMA foreign_key_check").fetchall() == []
    systems = dict(base.execute("SELECT srs_id, definition FROM gpkg_spatial_ref_sys"))
    assert {-1, 0, 4326} < set(systems)
    (local,) = set(systems) - {-1, 0, 4326}
    assert systems[local] == OUTSIDE.wkt
    kinds = base.execute(
        "SELECT table_name, geometry_type_name, srs_id FROM gpkg_geometry_columns"
    ).fetchall()
    assert kinds == [("objects", "POLYGON", local), ("object_centers", "POINT", local)]
    (changed,) = base.execute("SELECT DISTINCT last_change FROM gpkg_contents").fetchone()
    assert changed == "2026-05-04T09:30:00.468Z"
    assert base.execute("SELECT id, height, depth FROM object_centers").fetchall() == [
        (1, 0.1, 2.9),
        (2, 0.1, None),
    ]
    # the second has no outline
    assert base.execute("SELECT count(*) FROM objects").fetchone() == (1,)


def test_a_dive_without_objects_has_empty_layers() -> None:
    layers = object_layers([], set(), CHART, OUTSIDE)
    assert geojson(layers[0], OUTSIDE, [])["features"] == []
    base = database(geopackage(layers, OUTSIDE, 0))
    assert base.execute("SELECT min_x FROM gpkg_contents").fetchall() == [(None,), (None,)]


def test_the_same_objects_give_the_same_bytes(found: ReportedObject) -> None:
    one, two = (
        geopackage(object_layers([found], {1}, CHART, OUTSIDE), OUTSIDE, 5) for _ in range(2)
    )
    assert one == two


def test_a_photo_shows_the_outline(survey: Survey) -> None:
    (crop,) = object_crops(survey).values()
    drawn = cv2.imdecode(np.frombuffer(photo_jpeg(crop), np.uint8), cv2.IMREAD_COLOR)
    plain = cv2.resize(crop.picture[..., ::-1], drawn.shape[1::-1], interpolation=cv2.INTER_CUBIC)
    assert drawn.shape[1] >= 800
    changed = np.abs(drawn.astype(int) - plain).max(axis=2) > 60
    v, u = np.nonzero(changed)
    line = (crop.outline + 0.5) * drawn.shape[1] / crop.width
    near = np.linalg.norm(np.column_stack([u, v])[:, None] - line, axis=2).min(axis=1)
    assert changed.sum() > 300
    assert np.percentile(near, 95) < 0.6 * np.linalg.norm(np.diff(line, axis=0), axis=1).max()
    assert photo_name(7) == "objects/7.jpg"
