# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A corner of an object is at one place, to 5 mm, whichever of the demo's files it is measured in.

Files are read as others read them (rasterio, trimesh, SQLite with well-known binary, JSON, CSV), and go between map and ship by
chart.ply, as docs/deliverables.md says; nothing of hullrecon is asked.
"""

import csv
import json
import sqlite3
import struct
from types import SimpleNamespace

import numpy as np
import open3d
import pytest
import rasterio
import trimesh

pytestmark = pytest.mark.slow
AGREES_M = 0.005
DIRECTIONS = [np.array([np.cos(a), np.sin(a)]) for a in np.radians(np.arange(0, 360, 45))]
AROUND_M = 0.05  # beyond an outline, where its object ends


@pytest.fixture(scope="module")
def deliver(demo_run):
    return demo_run / "deliver"


def read_ply(path):
    mesh = trimesh.load(path, process=False)
    return SimpleNamespace(
        vertices=np.array(mesh.vertices), faces=np.array(mesh.faces), of=mesh.metadata["_ply_raw"]["vertex"]["data"]
    )


@pytest.fixture(scope="module")
def to_map(deliver):
    """The way from the ship to the map that chart.json describes: points (n, 3) to (n, 2)."""
    chart, document = read_ply(deliver / "chart.ply"), json.loads((deliver / "chart.json").read_text())["map"]
    signs = [document["along_from_x"], document["girth_from_y"]]
    scene = open3d.t.geometry.RaycastingScene()
    middle = chart.vertices.mean(axis=0)  # in single precision beside it
    scene.add_triangles((chart.vertices - middle).astype(np.float32), chart.faces.astype(np.uint32))
    chart_points = np.stack([chart.of["along"], chart.of["girth"]], axis=1).reshape(-1, 2)

    def on_map(points):
        near = scene.compute_closest_points(open3d.core.Tensor((np.atleast_2d(points) - middle).astype(np.float32)))
        share = near["primitive_uvs"].numpy()
        corners = chart_points[chart.faces[near["primitive_ids"].numpy()]]
        share = np.column_stack([1 - share.sum(axis=1), share])
        return np.einsum("nk,nkc->nc", share, corners) / signs

    return on_map


@pytest.fixture(scope="module")
def geopackage(deliver):
    """The rings (k, 2) of objects.gpkg by id, and the centers (2,)."""
    with sqlite3.connect(deliver / "objects.gpkg") as database:
        rings = dict(database.execute("SELECT id, geom FROM objects"))
        centers = dict(database.execute("SELECT id, geom FROM object_centers"))
    head = 8 + 32 + 9  # of GeoPackage with an envelope, of a polygon of one ring; then the number of corners
    assert {struct.unpack_from("<BII", blob, 40) for blob in rings.values()} == {(1, 3, 1)}
    return (
        {number: np.frombuffer(blob, "<f8", offset=head + 4).reshape(-1, 2)[:-1] for number, blob in rings.items()},
        {number: np.frombuffer(blob, "<f8", offset=13) for number, blob in centers.items()},
    )


@pytest.fixture(scope="module")
def objects(deliver):
    return {found["id"]: found for found in json.loads((deliver / "objects.json").read_text())["objects"]}


@pytest.fixture(scope="module")
def as_found(deliver):
    return read_ply(deliver / "as_found.ply")


def corners(ring):
    """Numbers of the corners that lie farthest in eight directions."""
    return sorted({int(np.argmax(ring @ direction)) for direction in DIRECTIONS})


def apart(first, second):
    return np.linalg.norm(np.asarray(first) - np.asarray(second), axis=-1).max()


def test_the_geopackage_the_geojson_and_the_table_have_a_corner_at_one_place(deliver, geopackage, objects, to_map):
    rings, centers = geopackage
    features = json.loads((deliver / "objects.geojson").read_text())["features"]
    geojson = {f["properties"]["id"]: np.array(f["geometry"]["coordinates"][0][:-1]) for f in features}
    assert rings.keys() == geojson.keys() == objects.keys()
    for number, ring in rings.items():
        at = corners(ring)
        assert apart(geojson[number][at], ring[at]) < 1e-4
        assert apart(to_map(objects[number]["outline"])[at], ring[at]) < AGREES_M
    for row in csv.DictReader((deliver / "objects.csv").read_text().splitlines()):
        center = [float(row[f"center_{axis}"]) for axis in "xyz"]
        assert apart(to_map(center)[0], centers[int(row["id"])]) < AGREES_M


def test_the_ply_has_a_vertex_at_the_corner(geopackage, objects, as_found, to_map):
    for number, ring in geopackage[0].items():
        for corner in corners(ring):
            away = np.linalg.norm(as_found.vertices - objects[number]["outline"][corner], axis=1)
            assert away.min() < 1e-4
            assert apart(to_map(as_found.vertices[away.argmin()])[0], ring[corner]) < AGREES_M


def contour(mesh, value, level, on_map):
    """Points (n, 2) on the map where a value of a mesh's vertices passes a level, along its edges."""
    sides = np.vstack([mesh[:, [0, 1]], mesh[:, [1, 2]], mesh[:, [2, 0]]])
    low, high = value[sides[:, 0]], value[sides[:, 1]]
    crossed = (low > level) != (high > level)
    share = ((level - low) / (high - low))[crossed][:, None]
    return on_map[sides[crossed, 0]] * (1 - share) + on_map[sides[crossed, 1]] * share


@pytest.mark.parametrize("share_of_height", [0.25, 0.5])
def test_the_geotiff_has_the_corners_of_the_ply(deliver, geopackage, objects, as_found, to_map, share_of_height):
    """Where the deviation passes a level: on the raster by its pixels, on the mesh by its edges."""
    deviation = as_found.of["deviation"].reshape(-1).astype(float)
    with rasterio.open(deliver / "deviation.tif") as raster:
        pixels, transform = raster.read(1), raster.transform
    for number, found in objects.items():
        ring = geopackage[0][number]
        low, high = ring.min(axis=0) - AROUND_M, ring.max(axis=0) + AROUND_M
        level = found["deviation"] - (1 - share_of_height) * found["height"]
        near = np.linalg.norm(as_found.vertices - found["center"], axis=1) < 1.0
        on_map = np.full((len(near), 2), np.nan)
        on_map[near] = to_map(as_found.vertices[near])
        line = contour(as_found.faces[near[as_found.faces].all(axis=1)], deviation, level, on_map)
        rows, columns = np.nonzero(pixels > level)
        above = np.column_stack(transform @ (columns + 0.5, rows + 0.5))
        line, above = (points[((points > low) & (points < high)).all(axis=1)] for points in (line, above))
        for direction in DIRECTIONS:
            assert (above @ direction).max() == pytest.approx((line @ direction).max(), abs=AGREES_M)


def test_the_geotiff_passes_the_corners_height_at_the_corner(deliver, geopackage, objects, as_found):
    deviation = as_found.of["deviation"].reshape(-1)
    with rasterio.open(deliver / "deviation.tif") as raster:
        pixels, transform = raster.read(1), raster.transform
    rows, columns = np.mgrid[: pixels.shape[0], : pixels.shape[1]]
    x, y = transform @ (columns + 0.5, rows + 0.5)
    for number, ring in geopackage[0].items():
        for corner in corners(ring):
            away = np.linalg.norm(as_found.vertices - objects[number]["outline"][corner], axis=1)
            close = np.hypot(x - ring[corner, 0], y - ring[corner, 1]) < AGREES_M
            values = pixels[close & np.isfinite(pixels)]
            assert values.min() - 0.001 <= deviation[away.argmin()] <= values.max() + 0.001


def test_all_rasters_of_one_kind_lie_on_one_grid_with_the_geopackages_system(deliver):
    with sqlite3.connect(deliver / "objects.gpkg") as database:
        wkt = database.execute("SELECT definition FROM gpkg_spatial_ref_sys WHERE srs_id = 100000").fetchone()[0]
    surface = ("deviation", "deviation_sigma", "form", "form_sigma", "support")
    for kind, more in (("optical", surface), ("sonar", ())):
        grids = set()
        for name in (f"ortho_{kind}", f"variance_{kind}", f"views_{kind}", *more):
            with rasterio.open(deliver / f"{name}.tif") as raster:
                grids.add((raster.transform, raster.shape))
                assert raster.crs.to_wkt().split('"')[1] == wkt.split('"')[1]
                assert 'UNIT["metre",1' in raster.crs.to_wkt()
        assert len(grids) == 1
