# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.detection.as_found.hull_as_found import (
    HullAsFound,
    as_found_surface,
    estimate_hull_as_found,
)
from hullrecon.detection.as_found.landmarks import Background, MedianBackground, SurfaceLandmarks
from hullrecon.detection.base_surface import BaseSurface
from hullrecon.detection.objects.find_objects import find_objects
from hullrecon.detection.options import DetectOptions
from hullrecon.detection.views import CameraViews
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses, identity

CAMERA = CameraModel(640, 512, 640.0, 640.0, 319.5, 255.5)
TOWARD_WALL = Rotation.from_matrix(np.array([[-1.0, 0, 0], [0, 0, -1], [0, -1, 0]]).T)


def wall_mesh(width: float = 4.0, height: float = 2.0, step: float = 0.5) -> Mesh:
    """A wall at y = 2 whose outside is +y."""
    x, z = np.arange(0, width + 1e-9, step), np.arange(0, height + 1e-9, step)
    grid = np.stack(np.meshgrid(x, [2.0], z, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(x) * len(z)).reshape(len(x), len(z))
    a, b, c, d = (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    faces = np.concatenate([np.stack([a, c, b], axis=-1), np.stack([a, d, c], axis=-1)]).reshape(
        -1, 3
    )
    return Mesh(grid, faces.astype(np.int32))


def views_along(x: np.ndarray, z: float = 1.0, standoff: float = 1.3) -> CameraViews:
    centers = np.stack([x, np.full(len(x), 2 + standoff), np.full(len(x), z)], axis=1)
    poses = Poses(np.tile(TOWARD_WALL.as_quat(), (len(x), 1)), centers)
    return CameraViews(
        result_from_camera=poses,
        node=np.arange(len(x)),
        name=tuple(f"camera_top/{k}.jpg" for k in range(len(x))),
        camera=CAMERA,
        farthest_m=2.2,
    )


@dataclass(frozen=True)
class Scenery:
    """A wall with a disc 0.10 m high and 0.24 m wide at (1.2, 1.0), a square recess 0.05 m deep and
    0.2 m wide at (2.2, 1.0), and a stain at (3, 1): where landmarks are dense but lie on the wall.
    The wall itself is off by -0.012 m.
    """

    base: Mesh
    measured: SurfaceLandmarks
    background: Background
    views: CameraViews
    chart: PlaneChart


DISC, RECESS, STAIN, OFF = (1.2, 1.0), (2.2, 1.0), (3.0, 1.0), -0.012


def true_height(x: np.ndarray, z: np.ndarray) -> np.ndarray:
    disc = np.hypot(x - DISC[0], z - DISC[1]) < 0.12
    recess = (np.abs(x - RECESS[0]) < 0.1) & (np.abs(z - RECESS[1]) < 0.1)
    return 0.10 * disc - 0.05 * recess


def landmarks_on_wall(x: np.ndarray, z: np.ndarray, noise: np.ndarray) -> SurfaceLandmarks:
    n, offset = len(x), OFF + true_height(x, z) + noise
    foot = np.stack([x, np.full(n, 2.0), z], axis=1)
    normal = np.tile([0.0, 1, 0], (n, 1))
    position = foot + normal * offset[:, None]
    return SurfaceLandmarks(
        row=np.arange(n),
        position=position,
        foot=foot,
        normal=normal,
        offset=offset,
        sigma=np.full(n, 0.003),
        common=np.full(n, 0.004),
        covariance=np.tile(np.diag([0.3, 0.004, 0.05]) ** 2, (n, 1, 1)),
        views=np.full(n, 6),
    )


def reported(scenery, found, with_cad_model: bool = True, **options):
    surveyed = as_found_surface(found, scenery.measured)
    base = BaseSurface(
        cad_model=scenery.base if with_cad_model else None,
        surveyed=surveyed,
        chart=scenery.chart,
        result_from_global=identity(),
        frame_spacing_m=None,
    )
    return find_objects(found, scenery.measured, scenery.views, base, DetectOptions(**options))


@pytest.fixture(scope="session")
def scenery() -> Scenery:
    rng = np.random.default_rng(5)
    x, z = rng.uniform(0.4, 3.6, 9000), rng.uniform(0.5, 1.5, 9000)
    x, z = np.r_[x, rng.normal(STAIN[0], 0.1, 2000)], np.r_[z, rng.normal(STAIN[1], 0.1, 2000)]
    noise = rng.normal(0, 0.003, len(x))
    wild = rng.random(len(x)) < 0.02
    noise[wild] += rng.uniform(-0.3, 0.3, wild.sum())
    measured = landmarks_on_wall(x, z, noise)
    background = MedianBackground(
        node=np.array([[2.0, 2.0, 1.0]]),
        value=np.array([OFF]),
        spread=np.array([0.002]),
        reach_m=1.0,
    )
    chart = PlaneChart(np.array([0.0, 2.0, 0.0]), np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]))
    views = views_along(np.arange(0.5, 3.6, 0.25))
    return Scenery(wall_mesh(), measured, background, views, chart)


@pytest.fixture(scope="session")
def found(scenery: Scenery) -> HullAsFound:
    return estimate_hull_as_found(
        scenery.base, scenery.measured, scenery.background, scenery.views, DetectOptions()
    )


@pytest.fixture
def views_at() -> Callable[[list[float]], CameraViews]:
    return lambda x: views_along(np.array(x))


@pytest.fixture
def wall() -> Mesh:
    return wall_mesh()


@pytest.fixture
def height_at() -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    return true_height
