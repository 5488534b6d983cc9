# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""When the images of the nodes were exposed, and how the tray with the cameras moved meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.navigation.sensors.tray_motion import SPAN_S
from hullrecon.records.sensors import ImageIndex
from hullrecon.records.trajectory import Exposures, Returns, Trajectory, VehiclePath
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints

NEAR_S = 1.0  # between a node and the DVL returns that measure the depth of its scene


@dataclass(frozen=True, kw_only=True)
class CameraTiming:
    """When rows of images are exposed relative to the images' stamps."""

    # how long after its stamps the bottom camera is exposed (positive where its stamps are early)
    bottom_after_stamp_s: float = 0.0
    readout_s: tuple[float, float] = (0.0, 0.0)  # of top and bottom, first row to last

    @property
    def is_ideal(self) -> bool:
        """Whether each image is exposed at its stamp, all rows at once."""
        return not (self.bottom_after_stamp_s or any(self.readout_s))


def exposures_of(
    trajectory: Trajectory,
    returns: Returns,
    images: tuple[ImageIndex | None, ImageIndex | None],
    timing: CameraTiming,
    path_at: Callable[[Ints], VehiclePath],
    rig: Rig,
) -> Exposures | None:
    """Compute how long after its node each image was exposed, and how the tray moved then.

    Nodes have one pose, but the bottom image may be later and rows are read out one after the
    other: later steps move each feature to its node's time with this. None where all were exposed
    at their node's time, all rows at once, or without a mounted camera.

    Parameters
    ----------
    trajectory
        The nodes, with the rows of their images.
    returns
        DVL returns, which give the depth of each node's scene.
    images
        Indices of top and bottom camera, None where there is none.
    timing
        When rows are exposed, relative to the images' stamps.
    path_at
        Interpolates vehicle and tray at any times, ns.
    rig
        Where tray, cameras and DVL sit.
    """
    late_s = np.zeros((len(trajectory.t_ns), 2))
    for column, index in enumerate(images):
        if index is not None:
            row = trajectory.image[:, column]
            after_s = 1e-9 * (index.t_ns[row] - trajectory.t_ns)
            late_s[:, column] = np.where(row >= 0, after_s, 0.0)
    late_s[trajectory.image[:, 1] >= 0, 1] += timing.bottom_after_stamp_s
    if rig.tray_from_top is None or (not late_s.any() and timing.is_ideal):
        return None
    half_ns = round(0.5e9 * SPAN_S)
    # midway between the exposures of the two cameras (late_s of a missing one is zero)
    middle_ns = trajectory.t_ns + np.rint(0.5e9 * late_s.sum(axis=1)).astype(np.int64)
    before, after = (
        rig.poses_along(path_at(middle_ns + step), "tray") for step in (-half_ns, half_ns)
    )
    return Exposures(
        late_s=late_s,
        twist=(before.inverse() @ after).log() / SPAN_S,
        depth_m=_scene_depths(trajectory, returns, rig),
        readout_s=np.array(timing.readout_s),
    )


def _scene_depths(trajectory: Trajectory, returns: Returns, rig: Rig) -> Array:
    """Measure the median depth (n,), m, of DVL returns near each node in the top camera.

    NaN where none near in time lies in front of the camera.
    """
    path = trajectory.track().path
    good = returns.take(np.flatnonzero(~returns.flagged & np.isfinite(returns.range_m)))
    good = good.take(np.argsort(good.t_ns, kind="stable"))
    points = rig.dvl_points(good, path).points
    reach_ns = round(1e9 * NEAR_S)
    start = np.searchsorted(good.t_ns, trajectory.t_ns - reach_ns)
    stop = np.searchsorted(good.t_ns, trajectory.t_ns + reach_ns)
    camera_from_global = rig.poses_along(path, Camera.TOP).inverse()
    depth = np.full(len(path), np.nan)
    for k in np.flatnonzero(stop > start).tolist():
        ahead = camera_from_global[k].apply(points[start[k] : stop[k]])[:, 2]
        if (ahead > 0).any():
            depth[k] = np.median(ahead[ahead > 0])
    return depth
