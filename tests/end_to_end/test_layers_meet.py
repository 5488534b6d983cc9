# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One corner of an object measured in every file: table, PLY, GeoPackage, GeoJSON and GeoTIFF agree
to 5 mm.

The files are joined as chart.json says, without the code that wrote them.
"""

import json
import sqlite3
import struct

import numpy as np
import open3d
import pytest
import rasterio
from end_to_end.true_hull import read_ply, read_table

pytestmark = pytest.mark.slow
AGREE_M = 0.005


@pytest.fixture(scope="module")
def deliver(demo_run):
    return demo_run / "deliver"


@pytest.fixture(scope="module")
def objects(deliver):
    return json.loads((deliver / "objects.json").read_text())["objects"]


@pytest.fixture(scope="module")
def chart(deliver):
    return Chart(deliver)


class Chart:
    """The mapping of chart.json, both ways."""

    def __init__(self, deliver):
        document = json.loads((deliver / "chart.json").read_text())
        self.signs = np.array([document["map"]["along_from_x"], document["map"]["girth_from_y"]])
        vertex, faces = read_ply(deliver / document["mesh"]["file"])
        self.at = np.stack([vertex["along"], vertex["girth"]], axis=1)
        self.point = np.stack([vertex[k] for k in "xyz"], axis=1)
        self.normal = np.stack([vertex[f"n{k}"] for k in "xyz"], axis=1)
        self.faces = faces.astype(int)

    def to_frame(self, xy, offset=0.0):
        """The point (3,) of the ship at map coordinates, so far off the hull."""
        a, b, c = self.at[self.faces].transpose(1, 0, 2)
        at = xy * self.signs
        share = np.linalg.solve(np.stack([b - a, c - a], axis=2), (at - a)[..., None])[..., 0]
        share = np.column_stack([1 - share.sum(axis=1), share])
        face = int(np.argmax(share.min(axis=1)))
        assert share[face].min() > -1e-9, "off the chart"
        corner = self.faces[face]
        return share[face] @ self.point[corner] + offset * (share[face] @ self.normal[corner])

    def to_map(self, point):
        """Map coordinates (2,) of a point of the ship: those whose point plus offset times normal
        it is.
        """
        candidates = [self._inverted(face, point) for face in self._faces_near(point)]
        inside, at = max(candidates, key=lambda found: found[0])
        assert inside > -1e-6, "off the chart"
        return at * self.signs

    def closest_aside(self, point):
        """How far from there the closest point may lie, as chart.json says: the offset times the
        angle between faces.
        """
        foot, normal = (
            table[self.faces[self._faces_near(point)]].reshape(-1, 3)
            for table in (self.point, self.normal)
        )
        offset = np.abs(np.einsum("ni,ni->n", point - foot, normal)).max()
        return offset * np.arccos(np.clip((normal @ normal.T).min(), -1, 1))

    def _faces_near(self, point):
        return np.argsort(np.linalg.norm(self.point[self.faces].mean(axis=1) - point, axis=1))[:12]

    def _inverted(self, face, point):
        """The least share of a corner, negative outside the face, and along and girth; by Newton's
        method.
        """
        corner = self.faces[face]
        p, n = self.point[corner], self.normal[corner]
        u, v, offset = 1 / 3, 1 / 3, 0.0
        for _ in range(20):
            share = np.array([1 - u - v, u, v])
            edges = (p[1:] - p[0]) + offset * (n[1:] - n[0])
            missing = point - share @ (p + offset * n)
            du, dv, more = np.linalg.solve(np.column_stack([*edges, share @ n]), missing)
            u, v, offset = u + du, v + dv, offset + more
        share = np.array([1 - u - v, u, v])
        np.testing.assert_allclose(share @ (p + offset * n), point, atol=1e-9)
        return share.min(), share @ self.at[corner]


def rings(deliver):
    """Outline (k, 2) on the map of each object, from the GeoPackage."""
    base = sqlite3.connect(f"file:{deliver / 'objects.gpkg'}?mode=ro", uri=True)
    found = {}
    for number, blob in base.execute("SELECT id, geom FROM objects"):
        (count,) = struct.unpack_from("<I", blob, 49)
        found[number] = np.frombuffer(blob, "<f8", 2 * count, 53).reshape(-1, 2)
    return found


def value_at(path, xy):
    """The raster's value at map coordinates, linear between the four nearest pixels."""
    with rasterio.open(path) as file:
        column, row = ~file.transform @ tuple(xy)
        low = np.floor([row - 0.5, column - 0.5]).astype(int)
        four = file.read(1, window=rasterio.windows.Window(low[1], low[0], 2, 2)).astype(float)
    a, b = np.array([row - 0.5, column - 0.5]) - low
    return float(np.array([1 - a, a]) @ four @ np.array([1 - b, b]))


def distance_to_grid(points, columns):
    """Distance from the origin to the surface between points (n, 3) given row by row, where they
    have a value.
    """
    a, b = np.arange(len(points)).reshape(-1, columns)[:-1, :-1].ravel(), columns
    faces = np.concatenate(
        [np.stack([a, a + 1, a + b], axis=1), np.stack([a + 1, a + b + 1, a + b], axis=1)]
    )
    faces = faces[np.isfinite(points[faces]).all(axis=(1, 2))]
    assert len(faces), "no value near"
    scene = open3d.t.geometry.RaycastingScene()
    scene.add_triangles(np.nan_to_num(points).astype(np.float32), faces.astype(np.uint32))
    return float(
        scene.compute_distance(open3d.core.Tensor(np.zeros((1, 3), np.float32))).numpy()[0]
    )


def test_outline_is_equal_in_json_geopackage_and_geojson(deliver, objects, chart):
    outlines = rings(deliver)
    features = {
        f["id"]: f for f in json.loads((deliver / "objects.geojson").read_text())["features"]
    }
    for found in objects:
        corners = np.array(found["outline"])
        on_map = outlines[found["id"]][:-1]
        np.testing.assert_allclose(
            features[found["id"]]["geometry"]["coordinates"][0][:-1], on_map, atol=1e-5
        )
        error = np.linalg.norm(
            [chart.to_map(corner) - at for corner, at in zip(corners, on_map, strict=True)], axis=1
        )
        assert np.quantile(error, 0.9) < AGREE_M
        assert (error < [max(AGREE_M, chart.closest_aside(corner)) for corner in corners]).all()


def test_corner_on_the_geotiff_lies_where_the_table_says(deliver, objects, chart):
    """The raster's surface passes within 5 mm of each corner: on the wall of a structure a pixel
    aside is centimetres in height, so the pixels within two of it are asked, and the triangles
    between them.
    """
    outlines = rings(deliver)
    with rasterio.open(deliver / "deviation.tif") as file:
        pixels, transform = file.read(1).astype(float), file.transform
    for found in objects:
        gaps = []
        for corner, xy in zip(
            np.array(found["outline"])[::4], outlines[found["id"]][::4], strict=False
        ):
            column, row = np.floor(~transform @ tuple(xy)).astype(int)
            rows, columns = (
                k.ravel() for k in np.mgrid[row - 2 : row + 3, column - 2 : column + 3]
            )
            at = np.column_stack(transform @ (columns + 0.5, rows + 0.5))
            points = [chart.to_frame(*pair) for pair in zip(at, pixels[rows, columns], strict=True)]
            gaps.append(distance_to_grid(np.array(points) - corner, 5))
        assert np.mean(np.array(gaps) < AGREE_M) > 0.9, found["id"]


def test_a_corner_is_a_vertex_of_the_hull_as_found(deliver, objects):
    vertex, _ = read_ply(deliver / "as_found.ply")
    xyz = np.stack([vertex[k] for k in "xyz"], axis=1)
    for found in objects:
        for corner in np.array(found["outline"]):
            assert np.linalg.norm(xyz - corner, axis=1).min() < AGREE_M


def test_a_center_is_the_same_in_table_and_layers(deliver, objects, chart):
    table = read_table(deliver / "objects.csv")
    base = sqlite3.connect(f"file:{deliver / 'objects.gpkg'}?mode=ro", uri=True)
    points = {
        number: struct.unpack_from("<2d", blob, 13)
        for number, blob in base.execute("SELECT id, geom FROM object_centers")
    }
    for k, found in enumerate(objects):
        xy = np.array(points[found["id"]])
        at = np.array([float(table["along"][k]), float(table["girth"][k])])
        np.testing.assert_allclose(xy * chart.signs, at, atol=AGREE_M)
        center = [float(table[f"center_{a}"][k]) for a in "xyz"]
        np.testing.assert_allclose(center, found["center"], atol=AGREE_M)
        point = chart.to_frame(xy, value_at(deliver / "deviation.tif", xy))
        # the top's height is that of 8 cm2, not of one pixel
        assert np.linalg.norm(point - center) < 2 * AGREE_M


def test_rasters_share_one_grid_and_objects_have_photos(deliver, objects):
    names = (
        "ortho_optical",
        "variance_optical",
        "views_optical",
        "deviation",
        "deviation_sigma",
        "form",
        "form_sigma",
        "support",
    )
    grids = set()
    for name in names:
        with rasterio.open(deliver / f"{name}.tif") as file:
            grids.add((file.transform, file.shape, file.crs.to_wkt()))
            assert file.overviews(1)
    assert len(grids) == 1
    assert all(
        (deliver / "objects" / f"{found['id']}.jpg").stat().st_size > 10_000 for found in objects
    )


def test_the_painted_number_reads_forward(deliver):
    """Seen from outside x, y and the outward normal are right-handed, and y points up the side of
    the ship.
    """
    chart = Chart(deliver)
    with rasterio.open(deliver / "ortho_optical.tif") as file:
        west, south, east, north = file.bounds
    middle = np.array([(west + east) / 2, (south + north) / 2])
    right, up = (chart.to_frame(middle + step) - chart.to_frame(middle) for step in np.eye(2) * 0.2)
    outward = chart.to_frame(middle, 1.0) - chart.to_frame(middle)
    assert np.cross(right, up) @ outward > 0
    assert up[2] > 0
