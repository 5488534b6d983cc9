# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Landmarks triangulated from their rays, and reprojection errors, of a block of observations."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from hullrecon.adjustment.problem.state import State
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.records.tracks import Tracks
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints


class Cameras(Protocol):
    """Has the two cameras, as a rig does."""

    @property
    def top(self) -> CameraModel | None: ...
    @property
    def bottom(self) -> CameraModel | None: ...


def camera_poses(rig: Rig, state: State) -> tuple[Poses, Poses | None]:
    """Compute both cameras' poses (n,) in g at the nodes. None without a bottom camera."""
    mounted = state.mounted(rig)
    top = mounted.poses_along(state.path, Camera.TOP)
    if state.mounts.top_from_bottom is None:
        return top, None
    return top, mounted.poses_along(state.path, Camera.BOTTOM)


def triangulate(
    tracks: Tracks, n_landmarks: int, top: Poses, bottom: Poses | None, rig: Rig
) -> tuple[Array, Array]:
    """Triangulate landmarks as the points with least squared distance to their rays.

    Parameters
    ----------
    tracks
        Observations, landmarks numbered from 0 on.
    n_landmarks
        Number of landmarks L.
    top, bottom
        Poses of the cameras in g at the nodes. None without a bottom camera.
    rig
        The camera models, which turn pixels into rays.

    Returns
    -------
    position, spread
        (L, 3) m in g, NaN with fewer than two rays or a spread below 0.3 degrees, and the angle
        over which the rays are spread, (L,) rad.
    """
    seen = [
        (tracks.landmark[rows], *rays_in_global(pixels[rows], tracks.node[rows], camera, pose))
        for pixels, camera, pose in (
            (tracks.top, rig.top, top),
            (tracks.bottom, rig.bottom, bottom),
        )
        if camera is not None and pose is not None
        for rows in [np.flatnonzero(np.isfinite(pixels[:, 0]))]
    ]
    owner, origin, ray = (np.concatenate(parts) for parts in zip(*seen, strict=True))
    # Takes a vector's part across its ray. At the point with least squared distances, the sum over
    # the rays of across @ (point - origin) is zero
    across = np.eye(3) - ray[:, :, None] * ray[:, None, :]

    def summed(values: Array) -> Array:
        """Sum values (n, ...) of rays by their landmarks."""
        columns = values.reshape(len(values), -1).T
        sums = [np.bincount(owner, column, n_landmarks) for column in columns]
        return np.asarray(np.stack(sums, axis=1).reshape(n_landmarks, *values.shape[1:]), float)

    normal, right = summed(across), summed(np.einsum("nij,nj->ni", across, origin))
    mean_ray, count = summed(ray), summed(np.ones(len(owner)))
    spread = _ray_spread(mean_ray, count)
    good = (count >= 2) & (spread > np.radians(0.3))
    position = np.full((n_landmarks, 3), np.nan)
    position[good] = np.linalg.solve(normal[good], right[good][..., None])[..., 0]
    return position, spread


def rays_in_global(
    pixels: Array, node: Ints, camera: CameraModel, pose: Poses
) -> tuple[Array, Array]:
    """Compute origins (n, 3) m and unit directions (n, 3) in g of the rays through pixels.

    Parameters
    ----------
    pixels
        (n, 2) px.
    node
        (n,) node of each.
    camera
        Camera model.
    pose
        Poses of the camera in g at the nodes.
    """
    return pose.translation[node], pose.turn_rows(node, camera.rays(pixels))


def _ray_spread(mean_ray: Array, count: Array) -> Array:
    """Compute the angle over which the unit rays of each landmark are spread, (L,) rad.

    It is twice the angle whose cosine is the length of the rays' mean: exactly the angle between
    two rays, and of its size for more.

    Parameters
    ----------
    mean_ray
        Sum (L, 3) of the unit rays.
    count
        Their number (L,).
    """
    length = np.linalg.norm(mean_ray, axis=1) / np.maximum(count, 1)
    return np.asarray(2 * np.arccos(np.clip(length, -1, 1)))


def reprojection_errors(
    tracks: Tracks, landmark: Array, top: Poses, bottom: Poses | None, rig: Cameras
) -> tuple[Array, Array]:
    """Compute the lengths of reprojection errors in the top and the bottom camera, each (m,) px.

    NaN where the camera has no observation, or where the landmark is not in front of it.

    Parameters
    ----------
    tracks
        Observations (m,).
    landmark
        Positions (L, 3) m, in the frame of the poses.
    top, bottom
        Poses of the cameras at the nodes.
    rig
        The camera models, which project the landmarks.
    """
    errors = np.full((2, len(tracks.node)), np.nan)
    cameras = ((tracks.top, rig.top, top), (tracks.bottom, rig.bottom, bottom))
    for error, (pixels, camera, pose) in zip(errors, cameras, strict=True):
        if camera is None or pose is None:
            continue
        in_camera = pose.inverse().apply_rows(tracks.node, landmark[tracks.landmark])
        u, v = (camera.project(in_camera) - pixels).T  # numpy's norm takes thrice as long
        error[:] = np.sqrt(u * u + v * v)
    return errors[0], errors[1]
