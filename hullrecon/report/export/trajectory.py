# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The trajectory as people take it away: the vehicle in the hull frame (global without a drawing), with sigmas."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.records import Solution, Trajectory
from hullrecon.geometry.poses import Poses, of_seven
from hullrecon.report.export.csv_export import csv_text, numbers, seconds

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Track:
    """t_ns (n,); poses: T_M_v, or T_g_v when frame is "g"; covariance (n, 6, 6) of (translation in that frame,
    rotation perturbed on the right); tray (n,) rad; image (n, 2) rows in the indices of the cameras, -1 where none."""

    t_ns: NDArray[np.int64]
    poses: Poses
    covariance: Array
    tray: Array
    image: NDArray[np.int64]
    frame: str

    @property
    def sigma(self) -> Array:
        """(n, 6) one sigma of x, y, z (m), roll, pitch, yaw (rad)."""
        return np.asarray(np.sqrt(np.einsum("nii->ni", self.covariance)))

    def sigma_towards(self, directions: Array) -> Array:
        """(n,) one sigma of the position along unit vectors (n, 3) of the frame."""
        return np.asarray(np.sqrt(np.einsum("ni,nij,nj->n", directions, self.covariance[:, :3, :3], directions)))


def hull_motion(solution: Solution | None) -> Poses | None:
    """T_g_M of the adjustment, None without a drawing."""
    if solution is None or not np.isfinite(solution.T_g_M).all():
        return None
    return of_seven(solution.T_g_M)


def track_of(trajectory: Trajectory, solution: Solution | None) -> Track:
    """The best there is: adjusted and in M, adjusted in g, or dead reckoned in g. T_M_v = T_g_M^-1 T_g_v."""
    if solution is None:
        return Track(trajectory.t_ns, trajectory.poses(), trajectory.covariance, trajectory.tray, trajectory.image, "g")
    global_from_hull = hull_motion(solution)
    poses = solution.poses() if global_from_hull is None else global_from_hull.inverse() @ solution.poses()
    frame = "g" if global_from_hull is None else "M"
    return Track(solution.t_ns, poses, solution.pose_covariance, solution.tray, solution.image, frame)


def trajectory_csv(track: Track) -> str:
    """trajectory.csv (docs/deliverables.md): t, x .. qw, sigma_x .. sigma_yaw, tray."""
    pose = {n: numbers(track.poses.translation[:, k]) for k, n in enumerate("xyz")}
    turn = {n: numbers(track.poses.quaternion[:, k]) for k, n in enumerate(("qx", "qy", "qz", "qw"))}
    names = ("sigma_x", "sigma_y", "sigma_z", "sigma_roll", "sigma_pitch", "sigma_yaw")
    one_sigma = track.sigma
    sigma = {n: numbers(one_sigma[:, k], ".6g") for k, n in enumerate(names)}
    return csv_text({"t": seconds(track.t_ns), **pose, **turn, **sigma, "tray": numbers(track.tray)})


def trajectory_tum(track: Track) -> str:
    """The same poses as lines of `t x y z qx qy qz qw`."""
    columns = [seconds(track.t_ns)]
    columns += [numbers(c) for c in (*track.poses.translation.T, *track.poses.quaternion.T)]
    return "".join(" ".join(row) + "\n" for row in zip(*columns, strict=True))
