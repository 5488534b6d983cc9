# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The adjusted dive, by parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.frames import Frame
from hullrecon.geometry.poses import Poses, identity
from hullrecon.records.trajectory import Exposures, VehicleTrack
from hullrecon.typing import Array, Ints, Mask

# |deviation| at which a landmark's label changes, m: where the two parts of the mixture of
# native/factors/mixture.h are equal.
LABEL_BOUNDARY_M = 0.05595


@dataclass(frozen=True, kw_only=True)
class Landmarks:
    """L landmarks."""

    position: Array  # (L, 3) m in g
    covariance: Array  # (L, 3, 3) in M (g without a CAD model)
    label: Ints  # (L,) 1 = on the CAD model's surface
    deviation: Array  # (L,) m, signed distance to the CAD model, NaN without a CAD model
    views: Ints  # (L,) images that saw it
    color: NDArray[np.uint8]  # (L, 3) RGB

    def __len__(self) -> int:
        return len(self.position)


@dataclass(frozen=True, kw_only=True)
class HullPose:
    """The pose of the hull, about the survey's centre."""

    global_from_hull: Poses  # a batch of one
    # (6, 6) of (translation in g, rotation right-perturbed in M): of the hull's pose given the
    # dive's own frame, the CAD model's error included
    covariance: Array
    survey_center: Array  # (3,) m in M


@dataclass(frozen=True, kw_only=True)
class Mounts:
    """Mounts of the sensors, batches of one. None if the sensor was not carried."""

    tray_from_dvl: Poses
    tray_from_top: Poses | None
    top_from_bottom: Poses | None


@dataclass(frozen=True, kw_only=True)
class DeviationField:
    """Normal offsets of the hull from its CAD model, outward positive, on a grid of the chart."""

    origin: Array  # (2,) m along and in girth
    step: Array  # (2,) m
    value: Array  # (a, g) m
    sigma: Array  # (a, g) m

    def covers(self, along_girth: Array) -> Mask:
        """Test whether chart points (n, 2) lie within the grid. False for NaN."""
        cell = (along_girth - self.origin) / self.step
        return np.asarray(np.all((cell >= 0) & (cell <= np.array(self.value.shape) - 1), axis=1))

    def value_at(self, along_girth: Array) -> Array:
        """Interpolate the offset (n,) m at chart points (n, 2), bilinear.

        Constant beyond the grid's ends. NaN for a point with NaN.
        """
        return self._interpolate(self.value, along_girth)

    def sigma_at(self, along_girth: Array) -> Array:
        """Interpolate the offset's sigma (n,) m at chart points (n, 2), as the offset is."""
        return self._interpolate(self.sigma, along_girth)

    def _interpolate(self, grid: Array, along_girth: Array) -> Array:
        """Interpolate values of the grid's nodes (a, g) bilinearly at chart points (n, 2) m.

        Beyond the grid's ends they are constant.
        """
        last = np.array(grid.shape) - 1
        cell = np.clip((along_girth - self.origin) / self.step, 0, last)
        low = np.minimum(np.nan_to_num(cell).astype(np.int64), np.maximum(last - 1, 0))
        high, (a, g) = np.minimum(low + 1, last), (cell - low).T
        near = grid[low[:, 0], low[:, 1]] * (1 - g) + grid[low[:, 0], high[:, 1]] * g
        far = grid[high[:, 0], low[:, 1]] * (1 - g) + grid[high[:, 0], high[:, 1]] * g
        return np.asarray(near * (1 - a) + far * a)


@dataclass(frozen=True, kw_only=True)
class Solution:
    """The adjusted dive: path, landmarks, mounts, errors of sensors and the hull's pose."""

    t_ns: Ints  # (n,) of the nodes
    image: Ints  # (n, 2) rows in the cameras' indices, -1 without an image
    global_from_vehicle: Poses  # (n,)
    tray: Array  # (n,) rad
    tray_sigma: Array  # (n,) rad
    # (n, 6, 6) of the vehicle in M (g without a CAD model): (translation, rotation right-perturbed
    # in v)
    pose_covariance: Array
    landmarks: Landmarks
    mounts: Mounts
    # (6,) DVL scale, heading drift rad/s, roll and pitch bias rad, depth bias m, tray backlash rad
    navigation_errors: Array
    hull_pose: HullPose | None  # None without a CAD model
    deviation_field: DeviationField | None  # None without a CAD model
    exposures: Exposures | None = None  # None: all images were exposed at their node's time

    @property
    def frame(self) -> Frame:
        """Frame that results are given in: M, or g without a CAD model."""
        return Frame.GLOBAL if self.hull_pose is None else Frame.HULL

    def result_from_global(self) -> Poses:
        """Compute hull_from_global, or the identity without a CAD model."""
        return identity() if self.hull_pose is None else self.hull_pose.global_from_hull.inverse()

    def track(self) -> VehicleTrack:
        """Transform the vehicle's path to the frame of the results."""
        return VehicleTrack(
            t_ns=self.t_ns,
            poses=self.result_from_global() @ self.global_from_vehicle,
            tray=self.tray,
            covariance=self.pose_covariance,
            image=self.image,
            frame=self.frame,
            exposures=self.exposures,
        )
