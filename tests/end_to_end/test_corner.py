# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The raster has an object's corners where the PLY has them, to 5 mm, in every direction;
test_layers_meet.py: the other files.

Files are read as others read them (rasterio, trimesh, JSON), and go from ship to map by chart.ply,
as the documents say.
"""

import json
from types import SimpleNamespace

import numpy as np
import open3d
import pytest
import rasterio
import trimesh
from end_to_end.test_layers_meet import Chart

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
        vertices=np.array(mesh.vertices),
        faces=np.array(mesh.faces),
        of=mesh.metadata["_ply_raw"]["vertex"]["data"],
    )


@pytest.fixture(scope="module")
def to_map(deliver):
    """The way from the ship to the map that chart.json describes: points (n, 3) to (n, 2)."""
    chart, document = (
        read_ply(deliver / "chart.ply"),
        json.loads((deliver / "chart.json").read_text())["map"],
    )
    signs = [document["along_from_x"], document["girth_from_y"]]
    scene = open3d.t.geometry.RaycastingScene()
    middle = chart.vertices.mean(axis=0)  # in single precision beside it
    scene.add_triangles((chart.vertices - middle).astype(np.float32), chart.faces.astype(np.uint32))
    chart_points = np.stack([chart.of["along"], chart.of["girth"]], axis=1).reshape(-1, 2)

    def on_map(points):
        near = scene.compute_closest_points(
            open3d.core.Tensor((np.atleast_2d(points) - middle).astype(np.float32))
        )
        share = near["primitive_uvs"].numpy()
        corners = chart_points[chart.faces[near["primitive_ids"].numpy()]]
        share = np.column_stack([1 - share.sum(axis=1), share])
        return np.einsum("nk,nkc->nc", share, corners) / signs

    return on_map


@pytest.fixture(scope="module")
def rings(deliver):
    """The rings (k, 2) of objects.geojson by id."""
    features = json.loads((deliver / "objects.geojson").read_text())["features"]
    return {f["properties"]["id"]: np.array(f["geometry"]["coordinates"][0][:-1]) for f in features}


@pytest.fixture(scope="module")
def objects(deliver):
    return {
        found["id"]: found
        for found in json.loads((deliver / "objects.json").read_text())["objects"]
    }


@pytest.fixture(scope="module")
def as_found(deliver):
    return read_ply(deliver / "as_found.ply")


def corners(ring):
    """Numbers of the corners that lie farthest in eight directions."""
    return sorted({int(np.argmax(ring @ direction)) for direction in DIRECTIONS})


def contour(mesh, value, level, on_map):
    """Points (n, 2) on the map where a value given at vertices passes a level, along edges."""
    sides = np.vstack([mesh[:, [0, 1]], mesh[:, [1, 2]], mesh[:, [2, 0]]])
    low, high = value[sides[:, 0]], value[sides[:, 1]]
    crossed = (low > level) != (high > level)
    low, high = low[crossed], high[crossed]
    share = ((level - low) / (high - low))[:, None]
    return on_map[sides[crossed, 0]] * (1 - share) + on_map[sides[crossed, 1]] * share


@pytest.mark.parametrize("share_of_height", [0.25, 0.5])
def test_the_geotiff_has_the_corners_of_the_ply(
    deliver, rings, objects, as_found, to_map, share_of_height
):
    """Where the deviation passes a level: on the raster by its pixels, on the mesh by its edges."""
    deviation = as_found.of["deviation"].reshape(-1).astype(float)
    with rasterio.open(deliver / "deviation.tif") as raster:
        pixels, transform = raster.read(1), raster.transform
    for number, found in objects.items():
        ring = rings[number]
        low, high = ring.min(axis=0) - AROUND_M, ring.max(axis=0) + AROUND_M
        level = found["deviation"] - (1 - share_of_height) * found["height"]
        near = np.linalg.norm(as_found.vertices - found["center"], axis=1) < 1.0
        on_map = np.full((len(near), 2), np.nan)
        on_map[near] = to_map(as_found.vertices[near])
        line = contour(as_found.faces[near[as_found.faces].all(axis=1)], deviation, level, on_map)
        rows, columns = np.nonzero(pixels > level)
        above = np.column_stack(transform @ (columns + 0.5, rows + 0.5))
        line, above = (
            points[((points > low) & (points < high)).all(axis=1)] for points in (line, above)
        )
        for direction in DIRECTIONS:
            assert (above @ direction).max() == pytest.approx(
                (line @ direction).max(), abs=AGREES_M
            )


def test_the_pixels_around_a_corner_lie_on_the_ply(deliver, rings, as_found):
    """In space, by the chart: on a wall of 80 degrees the height of a corner that stands out is in
    no pixel beside it.
    """
    with rasterio.open(deliver / "deviation.tif") as raster:
        pixels, transform = raster.read(1).astype(float), raster.transform
    rows, columns = np.mgrid[: pixels.shape[0], : pixels.shape[1]]
    x, y = transform @ (columns + 0.5, rows + 0.5)
    chart, scene = Chart(deliver), open3d.t.geometry.RaycastingScene()
    middle = as_found.vertices.mean(axis=0)  # in single precision beside it
    scene.add_triangles(
        (as_found.vertices - middle).astype(np.float32), as_found.faces.astype(np.uint32)
    )
    for ring in rings.values():
        for corner in corners(ring):
            close = (np.hypot(x - ring[corner, 0], y - ring[corner, 1]) < AGREES_M) & np.isfinite(
                pixels
            )
            assert close.any()
            at = np.column_stack([x[close], y[close]])
            points = (
                np.array([chart.to_frame(*pair) for pair in zip(at, pixels[close], strict=True)])
                - middle
            )
            assert (
                scene.compute_distance(open3d.core.Tensor(points.astype(np.float32))).numpy().max()
                < AGREES_M
            )
