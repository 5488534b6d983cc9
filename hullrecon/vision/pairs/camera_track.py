# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where the cameras stood, how well two nodes' relative pose is known, and how far the scene was."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.geometry.rotations import cross_matrix
from hullrecon.records.trajectory import Returns, Trajectory, TrajectoryErrorModel, VehiclePath
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.stereo.node_view import DepthPrior

# What navigation's error model does not hold: stamps of the images, the camera's mount, holes in
# the attitude.
WHITE_TRANSLATION_M = 0.01
WHITE_ROTATION_RAD = np.radians(0.2)
# of the returns across the direction in which they spread most: less is a line, not a plane
LEAST_SPREAD_M = 0.05
WINDOW = 4  # nodes to either side whose returns count: a footprint's width
# to either side, at least: a DVL may give a ping a second where a camera gives fifteen images
WINDOW_S = 1.0
MOST_RELIEF = 0.5  # scatter off the plane over that spread: more has no normal


class RelativeErrors(Protocol):
    """How well the relative pose of two nodes' leading cameras is known."""

    def relative_covariance(self, first: Ints, second: Ints) -> Array:
        """Return the covariance (m, 6, 6) of second_from_first as Motion defines it."""
        ...


@dataclass(frozen=True, kw_only=True)
class NavigationErrors:
    """The errors of dead reckoning by cause. global_from_camera: T_g_c by node; model: of these
    poses, the servo's backlash in its white part.
    """

    global_from_camera: Poses
    model: TrajectoryErrorModel

    def relative_covariance(self, first: Ints, second: Ints) -> Array:
        """Return (m, 6, 6) of second_from_first as Motion defines it: (J_b - J_a) P (J_b - J_a)'
        for the errors that are one unknown for the dive, what accumulated between the two nodes,
        and what is new at each.

        T_b^-1 Exp(twist_a - twist_b) T_a: the translation moves by R_b' (rho + omega x p_a), the
        rotation by R_a' omega.
        """
        e = self.model
        apart = e.by_error[first] - e.by_error[second]
        gained = e.walk[np.maximum(first, second)] - e.walk[np.minimum(first, second)]
        twist = (
            apart @ e.error_covariance @ apart.swapaxes(1, 2)
            + gained
            + e.white[first]
            + e.white[second]
        )
        a, b = (self.global_from_camera[k].rotation.inv().as_matrix() for k in (first, second))
        by_twist = np.zeros((len(first), 6, 6))
        by_twist[:, :3, :3] = b
        by_twist[:, :3, 3:] = -b @ cross_matrix(self.global_from_camera.translation[first])
        by_twist[:, 3:, 3:] = a
        return np.asarray(by_twist @ twist @ by_twist.swapaxes(1, 2))


@dataclass(frozen=True, kw_only=True)
class CameraTrack:
    """global_from_camera: T_g_c of the leading camera of every node (the top one, or the bottom one
    where that leads), and how well the nodes are known relative to each other.
    """

    global_from_camera: Poses
    errors: RelativeErrors

    def __len__(self) -> int:
        return len(self.global_from_camera)

    def motions(self, first: Ints, second: Ints) -> list[Motion]:
        """Return second_from_first of the cameras with the covariance of that relative pose, for m
        pairs.
        """
        relative = (
            self.global_from_camera[second].inverse() @ self.global_from_camera[first]
        ).matrix()
        floor = np.diag(np.repeat([WHITE_TRANSLATION_M**2, WHITE_ROTATION_RAD**2], 3))
        covariance = self.errors.relative_covariance(first, second) + floor
        return [Motion(*pair) for pair in zip(relative, covariance, strict=True)]

    def motion(self, first: int, second: int) -> Motion:
        """Return second_from_first of one pair."""
        return self.motions(np.array([first]), np.array([second]))[0]

    def relative_sigma(self, first: Ints, second: Ints) -> Array:
        """Return the sigma (m,) in metres of the relative position, the mean over the axes."""
        covariance = self.errors.relative_covariance(first, second)[:, :3, :3]
        # of a node to itself: 0
        return np.asarray(np.sqrt(np.maximum(np.trace(covariance, axis1=1, axis2=2), 0) / 3))


def track_cameras(
    trajectory: Trajectory,
    errors: TrajectoryErrorModel,
    cameras: Rig,
    tray_sigma_rad: float,
    bottom: Mask,
) -> CameraTrack:
    """Return the leading camera of every node as dead reckoning has it. bottom (n,): where that is
    the bottom one.
    """
    path = trajectory.track().path
    leading = leading_cameras(cameras, path, bottom)
    backlash = _backlash_twist(path.poses, cameras.tray_origin, tray_sigma_rad)
    model = replace(errors, white=errors.white + backlash)
    return CameraTrack(
        global_from_camera=leading, errors=NavigationErrors(global_from_camera=leading, model=model)
    )


def leading_cameras(cameras: Rig, path: VehiclePath, bottom: Mask) -> Poses:
    """Return T_g_c of the leading camera of every node: the top one, or the bottom one where
    `bottom` (n,) says so.
    """
    top = cameras.poses_along(path, Camera.TOP)
    if not bottom.any():
        return top
    lower, leads = cameras.poses_along(path, Camera.BOTTOM), bottom[:, None]
    return Poses(
        np.where(leads, lower.quaternion, top.quaternion),
        np.where(leads, lower.translation, top.translation),
    )


def _backlash_twist(global_from_vehicle: Poses, tray_origin: Array, sigma_rad: float) -> Array:
    """Return (n, 6, 6) of the twist that turns the tray about the vehicle's y through its origin,
    independent at each node.
    """
    axis = global_from_vehicle.rotation.as_matrix()[:, :, 1]
    origin = global_from_vehicle.apply(np.tile(tray_origin, (len(axis), 1)))
    twist = np.hstack([np.cross(origin, axis), axis])
    return np.asarray(sigma_rad**2 * twist[:, :, None] * twist[:, None, :])


def depth_priors(
    track: CameraTrack, trajectory: Trajectory, returns: Returns, rig: Rig, margin: float
) -> list[DepthPrior | None]:
    """Return depth along each camera's axis, and the surface's normal, from the unflagged returns
    of the node and its neighbours; None where there are none.
    """
    good = ~returns.flagged & np.isfinite(returns.range_m)
    points, node = rig.dvl_points(returns, trajectory.track().path).points[good], returns.node[good]
    order = np.argsort(node, kind="stable")
    points, node = points[order], node[order]
    t_ns, row, span_ns = trajectory.t_ns, np.arange(len(track)), round(1e9 * WINDOW_S)
    start = np.searchsorted(node, np.minimum(row - WINDOW, np.searchsorted(t_ns, t_ns - span_ns)))
    stop = np.searchsorted(
        node,
        np.maximum(row + WINDOW, np.searchsorted(t_ns, t_ns + span_ns, side="right") - 1),
        side="right",
    )
    camera_from_global = track.global_from_camera.inverse()
    return [_prior(camera_from_global[k].apply(points[a:b]), margin) if b > a else None
            for k, (a, b) in enumerate(zip(start, stop, strict=True))]  # fmt: skip


def _prior(points: Array, margin: float) -> DepthPrior | None:
    in_front = points[:, 2] > 0.05
    ahead = points[in_front, 2]
    if len(ahead) == 0:
        return None
    middle = float(np.median(ahead))
    low, high = np.percentile(ahead, [2, 98])
    sigma = max(0.15 * middle, 0.5 * float(high - low))
    return DepthPrior(
        mean=middle,
        sigma=sigma,
        nearest=float(low) / margin,
        farthest=float(high) * margin,
        normal=_surface_normal(points[in_front]),
    )


def _surface_normal(points: Array) -> tuple[float, float, float] | None:
    """Return the unit normal of the plane through (n, 3), away from the camera; None where the
    points lie on a line or scatter.
    """
    if len(points) < 3:
        return None
    _, extent, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    if extent[1] < LEAST_SPREAD_M * np.sqrt(len(points)) or extent[2] > MOST_RELIEF * extent[1]:
        return None
    normal = axes[2] * np.sign(axes[2] @ points.mean(axis=0) or 1.0)
    return float(normal[0]), float(normal[1]), float(normal[2])
