# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Views of the hull by the top camera: its poses, and which points each image shows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.neighbours import Around, nearest
from hullrecon.geometry.poses import Poses
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints

GRAZING = 0.2  # cosine of the flattest incidence at which a surface still shows texture
CLEARANCE_M = 0.005  # a surface less than this in front of a point does not occlude it


@dataclass(frozen=True, kw_only=True)
class CameraViews:
    """The n images of the top camera."""

    result_from_camera: Poses  # (n,) in the frame of the surface
    node: Ints  # (n,) node of each image
    name: tuple[str, ...]  # (n,) name of each image
    camera: CameraModel
    farthest_m: float  # largest distance at which a surface counts as seen

    def __len__(self) -> int:
        return len(self.node)


@dataclass(frozen=True, kw_only=True)
class Visibility:
    """How the views saw n points of a surface."""

    views: Ints  # (n,) number of images that saw each point
    distance: Array  # (n,) m of the best (nearest) view, NaN where unseen
    cosine: Array  # (n,) of the incidence of that view, NaN where unseen


def views_of_top_camera(
    rig: Rig, track: VehicleTrack, image_t_ns: Ints, landmarks: Array
) -> CameraViews | None:
    """Collect the top camera's images with their poses. None without camera, image or landmark.

    Parameters
    ----------
    rig
        Gives the camera, and its mount on the vehicle.
    track
        Gives the images that have a node, and the vehicle's pose at each.
    image_t_ns
        Stamps of the images in the camera's index, by which image files are named.
    landmarks
        (n, 3) m in the track's frame, whose distances limit how far surfaces are seen.
    """
    camera = Camera.TOP
    node = np.flatnonzero(track.image[:, camera.column] >= 0)
    if camera not in rig.cameras or not len(node) or not len(landmarks):
        return None
    model, poses = rig.camera_models[camera], rig.image_poses(track, node, camera)
    names = tuple(
        f"{camera.key}/{t}.jpg" for t in image_t_ns[track.image[node, camera.column]].tolist()
    )
    farthest_m = _farthest(poses.translation, landmarks, model)
    return CameraViews(
        result_from_camera=poses, node=node, name=names, camera=model, farthest_m=farthest_m
    )


def _farthest(centers: Array, landmarks: Array, camera: CameraModel) -> float:
    """Estimate the largest distance at which surfaces are seen in an image, m.

    centers, landmarks: (v, 3) and (l, 3) m, of the cameras and of what they saw. In turbid water
    nothing is seen beyond some distance. Landmarks show it: at the image's middle it is 1.25 times
    the 95 % percentile of their distances from the nearest camera. Rays to the image's corners are
    longer for the same depth, so it is divided by the smaller z of theirs.
    """
    known = landmarks[np.isfinite(landmarks).all(axis=1)]
    usual = np.percentile(nearest(centers, known[:: max(1, len(known) // 5000)], 1)[0], 95)
    corner = camera.rays(np.array([[0.0, 0], [camera.width, camera.height]]))[:, 2].min()
    return float(1.25 * usual / max(corner, 0.3))


def rows_in_image(views: CameraViews, view: int, points: Array, near: Ints) -> Ints:
    """Select those rows of points (n, 3), among the rows `near`, that project into an image."""
    camera_from_result = views.result_from_camera[view].inverse()
    pixel = views.camera.project(camera_from_result.apply(points[near]))
    size = np.array([views.camera.width, views.camera.height]) - 0.5
    return np.asarray(near[((pixel > -0.5) & (pixel < size)).all(axis=1)])


def iterate_views(views: CameraViews, points: Array) -> Iterator[tuple[int, Ints]]:
    """Yield each view with the rows of points (n, 3) in its image and reach, occluded or not.

    Views without any point in reach are left out.
    """
    around = Around(points)
    for view in range(len(views)):
        center = views.result_from_camera.translation[view]
        near = around(center, views.farthest_m)
        if len(near):
            yield view, rows_in_image(views, view, points, near)


def find_visibility(views: CameraViews, points: Array, normals: Array, scene: Scene) -> Visibility:
    """Find how many views saw each of the points (n, 3) m, and the best view of each.

    normals: (n, 3) outward unit vectors. A view sees a point that projects into its image, faces
    it, and is not occluded by the scene.
    """
    count = np.zeros(len(points), np.int64)
    best, cosine = np.full(len(points), np.inf), np.full(len(points), np.nan)
    for view, rows in iterate_views(views, points):
        rows, distance, facing = visible_rows(
            views.result_from_camera.translation[view], rows, points, normals, scene
        )
        count[rows] += 1
        closer = distance < best[rows]
        best[rows[closer]], cosine[rows[closer]] = distance[closer], facing[closer]
    return Visibility(
        views=count, distance=np.where(np.isfinite(best), best, np.nan), cosine=cosine
    )


def find_visibility_by_cell(
    views: CameraViews, points: Array, normals: Array, scene: Scene, cell_m: Array
) -> Visibility:
    """Find visibility for one point in each cell, and give it to all points of the cell.

    It is many times faster than `find_visibility`, as neighbours are mostly seen alike. points,
    normals: (n, 3) m and unit vectors. cell_m: (n,) side of the cell at each point.
    """
    # The side is part of the key: cells of different sides are not the same cell
    key = np.column_stack([np.floor(points / cell_m[:, None]), cell_m])
    _, first, cell = np.unique(key, axis=0, return_index=True, return_inverse=True)
    few = find_visibility(views, points[first], normals[first], scene)
    cell = cell.reshape(-1)
    return Visibility(views=few.views[cell], distance=few.distance[cell], cosine=few.cosine[cell])


def visible_rows(
    center: Array, rows: Ints, points: Array, normals: Array, scene: Scene
) -> tuple[Ints, Array, Array]:
    """Find the points that a camera sees: those that face it and are not occluded.

    Parameters
    ----------
    center
        Position (3,) m of the camera.
    rows
        (k,) rows of the points that are tested.
    points, normals
        All points (n, 3) m, and the outward unit normals (n, 3) of the surface there.
    scene
        Surfaces that may lie between the camera and a point.

    Returns
    -------
    rows, distance, cosine
        Rows of the visible points, distances in m and cosines of the incidence. Points seen more
        flatly than GRAZING are left out.
    """
    ray = points[rows] - center
    distance = np.linalg.norm(ray, axis=1)
    facing = -np.einsum("ni,ni->n", ray, normals[rows]) / np.maximum(distance, 1e-9)
    front = facing > GRAZING
    rows, ray, distance, facing = rows[front], ray[front], distance[front], facing[front]
    clear = scene.cast(center, ray / distance[:, None]) > distance - CLEARANCE_M
    return rows[clear], distance[clear], facing[clear]
