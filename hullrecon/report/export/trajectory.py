# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The trajectory as people take it away: the vehicle in the hull frame (global without a CAD model), with sigmas."""

from __future__ import annotations

from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import Trajectory, VehicleTrack
from hullrecon.report.export.csv_export import csv_text, numbers, seconds


def track_of(trajectory: Trajectory, solution: Solution | None) -> VehicleTrack:
    """Return the best path there is: adjusted in M, adjusted in g, or dead reckoned in g."""
    return trajectory.track() if solution is None else solution.track()


def trajectory_csv(track: VehicleTrack) -> str:
    """Return trajectory.csv (docs/deliverables.md): t, x .. qw, sigma_x .. sigma_yaw, tray."""
    pose = {n: numbers(track.poses.translation[:, k]) for k, n in enumerate("xyz")}
    turn = {n: numbers(track.poses.quaternion[:, k]) for k, n in enumerate(("qx", "qy", "qz", "qw"))}
    names = ("sigma_x", "sigma_y", "sigma_z", "sigma_roll", "sigma_pitch", "sigma_yaw")
    one_sigma = track.sigma
    sigma = {n: numbers(one_sigma[:, k], ".6g") for k, n in enumerate(names)}
    return csv_text({"t": seconds(track.t_ns), **pose, **turn, **sigma, "tray": numbers(track.tray)})


def trajectory_tum(track: VehicleTrack) -> str:
    """Return the same poses as lines of `t x y z qx qy qz qw`."""
    columns = [seconds(track.t_ns)]
    columns += [numbers(c) for c in (*track.poses.translation.T, *track.poses.quaternion.T)]
    return "".join(" ".join(row) + "\n" for row in zip(*columns, strict=True))
