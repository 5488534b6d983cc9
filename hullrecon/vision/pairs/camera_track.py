# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Poses of the leading cameras, the covariance between two of them, and the depth of the scene."""

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

# Sigmas of errors that navigation's error model leaves out: stamps of the images, the camera's
# mount, gaps in the attitude.
WHITE_TRANSLATION_M = 0.01
WHITE_ROTATION_RAD = np.radians(0.2)
RANGE_MARGIN = (
    1.8  # factor on the DVL's depths, both ways, within which stereo matches are searched
)
WINDOW = 4  # nodes to either side whose returns count: a footprint's width
# Least time to either side: a DVL may give a ping a second where a camera gives fifteen images.
WINDOW_S = 1.0
# Least spread (RMS) of returns along their second principal axis: less is a line, not a plane.
LEAST_SPREAD_M = 0.05
# Largest spread along the third principal axis over that along the second for which the points are
# taken as a plane
MOST_RELIEF = 0.5


class RelativeErrors(Protocol):
    """Uncertainty of the relative poses of nodes' leading cameras."""

    def relative_covariance(self, first: Ints, second: Ints) -> Array:
        """Compute the covariance (m, 6, 6) of second_from_first as Motion defines it."""
        ...


@dataclass(frozen=True, kw_only=True)
class NavigationErrors:
    """The errors of dead reckoning by cause."""

    global_from_camera: Poses  # by node
    model: TrajectoryErrorModel  # of these poses, the servo's backlash in its white part

    def relative_covariance(self, first: Ints, second: Ints) -> Array:
        """Compute the covariance (m, 6, 6) of second_from_first as Motion defines it.

        It is what the path of dead reckoning may err between two nodes. It sums (J_b - J_a) P (J_b
        - J_a)' of the errors that are constant over the dive, the random walk between the two nodes
        a and b, and the white noise at each. With twist (rho, omega) = twist_a - twist_b in global
        axes, the pose becomes T_b^-1 Exp(twist) T_a: the translation moves by R_b' (rho + omega x
        p_a), the rotation by R_a' omega.

        first, second: (m,) nodes a and b.
        """
        model = self.model
        apart = model.by_error[first] - model.by_error[second]
        # The covariance of the random walk is summed up from the start of the path.
        gained = model.walk[np.maximum(first, second)] - model.walk[np.minimum(first, second)]
        twist = (
            apart @ model.error_covariance @ apart.swapaxes(1, 2)
            + gained
            + model.white[first]
            + model.white[second]
        )
        first_from_global, second_from_global = (
            self.global_from_camera[nodes].rotation.inv().as_matrix() for nodes in (first, second)
        )
        lever = cross_matrix(self.global_from_camera.translation[first])
        by_twist = np.zeros((len(first), 6, 6))
        by_twist[:, :3, :3] = second_from_global
        by_twist[:, :3, 3:] = -second_from_global @ lever
        by_twist[:, 3:, 3:] = first_from_global
        return np.asarray(by_twist @ twist @ by_twist.swapaxes(1, 2))


@dataclass(frozen=True, kw_only=True)
class CameraTrack:
    """The leading camera of every node: the one whose images are compared with other nodes'.

    It is the top one, or the bottom one where the top one is dark or missing.
    """

    global_from_camera: Poses
    errors: RelativeErrors

    def __len__(self) -> int:
        return len(self.global_from_camera)

    def relative_poses(self, first: Ints, second: Ints) -> Array:
        """Compute second_from_first (m, 4, 4) for m pairs of nodes."""
        poses = self.global_from_camera
        return (poses[second].inverse() @ poses[first]).matrix()

    def motions(self, first: Ints, second: Ints) -> list[Motion]:
        """Compute second_from_first with its covariance for m pairs of nodes.

        Errors that the error model leaves out are added (WHITE_TRANSLATION_M, WHITE_ROTATION_RAD).
        first, second: (m,) nodes.
        """
        relative = self.relative_poses(first, second)
        floor = np.diag(np.repeat([WHITE_TRANSLATION_M**2, WHITE_ROTATION_RAD**2], 3))
        covariance = self.errors.relative_covariance(first, second) + floor
        return [Motion(*pair) for pair in zip(relative, covariance, strict=True)]

    def motion(self, first: int, second: int) -> Motion:
        """Compute second_from_first with its covariance for one pair."""
        return self.motions(np.array([first]), np.array([second]))[0]

    def relative_sigma(self, first: Ints, second: Ints) -> Array:
        """Compute the sigma (m,) of the relative position, m, the mean over the axes."""
        covariance = self.errors.relative_covariance(first, second)[:, :3, :3]
        # 0 of a node to itself
        return np.asarray(np.sqrt(np.maximum(np.trace(covariance, axis1=1, axis2=2), 0) / 3))


def track_cameras(
    trajectory: Trajectory,
    errors: TrajectoryErrorModel,
    cameras: Rig,
    tray_sigma_rad: float,
    bottom: Mask,
) -> CameraTrack:
    """Place the leading camera of every node by dead reckoning.

    The first pairs are proposed, and features searched, where this track puts them.

    Parameters
    ----------
    trajectory, errors
        Path by dead reckoning, and its error model.
    cameras
        The rig, which places the cameras on the path.
    tray_sigma_rad
        Sigma of the tray's angle, which the servo's backlash adds to the errors.
    bottom
        Nodes (n,) whose leading camera is the bottom one.
    """
    path = trajectory.track().path
    leading = leading_cameras(cameras, path, bottom)
    backlash = _backlash_twist(path.poses, cameras.tray_origin, tray_sigma_rad)
    model = replace(errors, white=errors.white + backlash)
    return CameraTrack(
        global_from_camera=leading, errors=NavigationErrors(global_from_camera=leading, model=model)
    )


def leading_cameras(cameras: Rig, path: VehiclePath, bottom: Mask) -> Poses:
    """Place the leading camera of every node of a path.

    bottom: (n,) nodes whose leading camera is the bottom one.
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
    """Compute the covariance (n, 6, 6) of each node's pose due to an error of the tray's angle.

    The error is a twist (translation, rotation) in global axes. The tray turns about the vehicle's
    y axis through `tray_origin` (3,) in the vehicle.
    """
    # A turn about the axis moves the point at the global origin by origin x axis.
    axis = global_from_vehicle.rotation.as_matrix()[:, :, 1]
    origin = global_from_vehicle.apply(np.tile(tray_origin, (len(axis), 1)))
    twist = np.hstack([np.cross(origin, axis), axis])
    return np.asarray(sigma_rad**2 * twist[:, :, None] * twist[:, None, :])


def depth_priors(
    track: CameraTrack, trajectory: Trajectory, returns: Returns, rig: Rig
) -> list[DepthPrior | None]:
    """Measure the depth of each node's scene by the DVL's returns of the nodes around it.

    It bounds the search for stereo matches, and stands in where there are none. Flagged returns do
    not count. The window is WINDOW nodes or WINDOW_S to either side, whichever is wider. None where
    it has no return in front of the camera.
    """
    good = ~returns.flagged & np.isfinite(returns.range_m)
    points, node = rig.dvl_points(returns, trajectory.track().path).points[good], returns.node[good]
    order = np.argsort(node, kind="stable")
    points, node = points[order], node[order]
    # Returns are sorted by node now. Those of node k's window are the rows start[k] to stop[k].
    t_ns, row, span_ns = trajectory.t_ns, np.arange(len(track)), round(1e9 * WINDOW_S)
    start = np.searchsorted(node, np.minimum(row - WINDOW, np.searchsorted(t_ns, t_ns - span_ns)))
    stop = np.searchsorted(
        node,
        np.maximum(row + WINDOW, np.searchsorted(t_ns, t_ns + span_ns, side="right") - 1),
        side="right",
    )
    camera_from_global = track.global_from_camera.inverse()
    return [
        _depth_prior(camera_from_global[k].apply(points[a:b])) if b > a else None
        for k, (a, b) in enumerate(zip(start, stop, strict=True))
    ]


def _depth_prior(points: Array) -> DepthPrior | None:
    """Summarise DVL points (n, 3) in the camera: median depth, spread, limits, surface normal.

    The limits (nearest, farthest) have a margin, as stereo matches are searched within them alone.
    None where none is in front of the camera.
    """
    in_front = points[:, 2] > 0.05  # m, nearer than any hull
    ahead = points[in_front, 2]
    if len(ahead) == 0:
        return None
    middle = float(np.median(ahead))
    low, high = np.percentile(ahead, [2, 98])
    # Generous, as it only widens the search: the depths seen by the beams span some sigmas.
    sigma = max(0.15 * middle, 0.5 * float(high - low))
    return DepthPrior(
        mean=middle,
        sigma=sigma,
        nearest=float(low) / RANGE_MARGIN,
        farthest=float(high) * RANGE_MARGIN,
        normal=_surface_normal(points[in_front]),
    )


def _surface_normal(points: Array) -> tuple[float, float, float] | None:
    """Fit a plane to points (n, 3) and return its unit normal, pointing away from the camera.

    By it the right one of a homography's two motions is chosen. None where the points are on a
    line, or too rough for a plane.
    """
    if len(points) < 3:
        return None
    _, extent, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    if extent[1] < LEAST_SPREAD_M * np.sqrt(len(points)) or extent[2] > MOST_RELIEF * extent[1]:
        return None
    normal = axes[2] * np.sign(axes[2] @ points.mean(axis=0) or 1.0)
    return float(normal[0]), float(normal[1]), float(normal[2])
