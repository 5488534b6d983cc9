# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The adjusted dive, by parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.frames import Frame
from hullrecon.geometry.poses import Poses, identity
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.typing import Array, Ints, Mask

# |deviation| at which a landmark's label changes, m: where the two parts of the mixture of
# native/factors/mixture.h are equal.
LABEL_BOUNDARY_M = 0.05595


@dataclass(frozen=True, kw_only=True)
class Landmarks:
    """L landmarks. position (L, 3) in g; covariance (L, 3, 3) in M (g without a CAD model); label
    (L,): 1 = on the CAD model's surface; deviation (L,) m, signed distance to the CAD model (NaN
    without one); views (L,); color (L, 3) RGB.
    """

    position: Array
    covariance: Array
    label: Ints
    deviation: Array
    views: Ints
    color: NDArray[np.uint8]

    def __len__(self) -> int:
        return len(self.position)


@dataclass(frozen=True, kw_only=True)
class HullPose:
    """T_g_M (a batch of one) and its covariance (6, 6) of (translation in g, rotation
    right-perturbed in M).

    Both parts are about survey_center (3,) in M. The covariance is that of where the hull lies
    given the dive's own frame, with the CAD model's error in it; as published, the solve's own
    marginal.
    """

    global_from_hull: Poses
    covariance: Array
    survey_center: Array


@dataclass(frozen=True, kw_only=True)
class Mounts:
    """Where the sensors sit as adjusted, each a batch of one; None where the sensor was not
    carried.
    """

    tray_from_dvl: Poses
    tray_from_top: Poses | None
    top_from_bottom: Poses | None


@dataclass(frozen=True, kw_only=True)
class DeviationField:
    """Normal offsets of the hull from its CAD model, outward positive, at the nodes of a grid on
    the hull chart.

    origin (2,) m and step (2,) m along and girth; value, sigma (a, g) m.
    """

    origin: Array
    step: Array
    value: Array
    sigma: Array

    def covers(self, along_girth: Array) -> Mask:
        """Return which of chart points (n, 2) lie within the grid; a point off the chart (NaN) does
        not.
        """
        cell = (along_girth - self.origin) / self.step
        return np.asarray(np.all((cell >= 0) & (cell <= np.array(self.value.shape) - 1), axis=1))

    def value_at(self, along_girth: Array) -> Array:
        """Return the offset (n,) m at chart points (n, 2), bilinear; held beyond the grid's ends,
        NaN where a point is NaN.
        """
        return self._interpolate(self.value, along_girth)

    def sigma_at(self, along_girth: Array) -> Array:
        """Return one sigma (n,) m of the offset at chart points (n, 2), interpolated as the offset
        is.
        """
        return self._interpolate(self.sigma, along_girth)

    def _interpolate(self, grid: Array, along_girth: Array) -> Array:
        last = np.array(grid.shape) - 1
        cell = np.clip((along_girth - self.origin) / self.step, 0, last)
        low = np.minimum(np.nan_to_num(cell).astype(np.int64), np.maximum(last - 1, 0))
        high, (a, g) = np.minimum(low + 1, last), (cell - low).T
        near = grid[low[:, 0], low[:, 1]] * (1 - g) + grid[low[:, 0], high[:, 1]] * g
        far = grid[high[:, 0], low[:, 1]] * (1 - g) + grid[high[:, 0], high[:, 1]] * g
        return np.asarray(near * (1 - a) + far * a)


@dataclass(frozen=True, kw_only=True)
class Solution:
    """The adjusted dive. By node: t_ns (n,), image (n, 2) rows in the cameras' indices (-1 where
    none), global_from_vehicle, tray (n,) rad and its sigma, pose_covariance (n, 6, 6) of T_M_v (of
    T_g_v without a CAD model): (translation in M, rotation right-perturbed in v). navigation_errors
    (6,): DVL scale error, heading drift rad/s, roll and pitch bias rad, depth bias m, tray backlash
    rad. hull_pose, deviation_field: None without a CAD model.
    """

    t_ns: Ints
    image: Ints
    global_from_vehicle: Poses
    tray: Array
    tray_sigma: Array
    pose_covariance: Array
    landmarks: Landmarks
    mounts: Mounts
    navigation_errors: Array
    hull_pose: HullPose | None
    deviation_field: DeviationField | None

    @property
    def frame(self) -> Frame:
        """Return the frame that results are given in: M, or g without a CAD model."""
        return Frame.GLOBAL if self.hull_pose is None else Frame.HULL

    def result_from_global(self) -> Poses:
        """Return T_M_g (a batch of one); the identity without a CAD model, where results stay in g."""
        return identity() if self.hull_pose is None else self.hull_pose.global_from_hull.inverse()

    def track(self) -> VehicleTrack:
        """Return the vehicle in the result's frame: T_M_v, or T_g_v without a CAD model."""
        return VehicleTrack(
            t_ns=self.t_ns,
            poses=self.result_from_global() @ self.global_from_vehicle,
            tray=self.tray,
            covariance=self.pose_covariance,
            image=self.image,
            frame=self.frame,
        )
