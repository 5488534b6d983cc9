# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The trajectory as people take it away: the vehicle in the hull frame (global without a CAD model), with sigmas."""

from __future__ import annotations

import numpy as np

from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import Trajectory, VehicleTrack
from hullrecon.report.export.chart_coordinates import chart_coordinates
from hullrecon.report.export.csv_export import numbers, seconds
from hullrecon.report.export.table import Column, Table
from hullrecon.report.survey import Survey
from hullrecon.typing import Array


def track_of(trajectory: Trajectory, solution: Solution | None) -> VehicleTrack:
    """Return the best path there is: adjusted in M, adjusted in g, or dead reckoned in g."""
    return trajectory.track() if solution is None else solution.track()


def trajectory_table(survey: Survey) -> Table:
    """Return trajectory.csv (docs/deliverables.md): a row a node."""
    track, frame = survey.track, survey.track.frame
    place, turn = track.poses.translation, track.poses.quaternion
    columns = [Column(name="t", unit="s", meaning="since 1970 (UTC)", values=seconds(track.t_ns))]
    columns += [
        Column(name=n, unit="m", meaning=f"position of the vehicle in {frame}", values=numbers(place[:, k]))
        for k, n in enumerate("xyz")
    ]
    columns += [
        Column(name=n, unit="", meaning=f"rotation of the vehicle in {frame}, unit quaternion", values=numbers(turn[:, k]))
        for k, n in enumerate(("qx", "qy", "qz", "qw"))
    ]
    columns += [
        Column(name=f"sigma_{n}", unit=unit, meaning=f"one sigma of {what}", values=numbers(track.sigma[:, k], ".6g"))
        for k, (n, unit, what) in enumerate(_SIGMAS)
    ]
    columns.append(Column(name="tray", unit="rad", meaning="angle of the tray", values=numbers(track.tray)))
    return Table(file="trajectory.csv", title="the vehicle at every node", columns=[*columns, *_ship_columns(survey)])


_SIGMAS = (
    ("x", "m", "the position along x"), ("y", "m", "the position along y"), ("z", "m", "the position along z"),
    ("roll", "rad", "a small rotation about the vehicle's x"), ("pitch", "rad", "a small rotation about its y"),
    ("yaw", "rad", "a small rotation about its z"),
)  # fmt: skip


def _ship_columns(survey: Survey) -> list[Column]:
    """Return where on the ship the vehicle stood."""
    at = chart_coordinates(survey, survey.track.poses.translation)
    depth = vehicle_depth(survey)
    lost = np.full(len(at.along), np.nan)
    return [
        Column(
            name="along_m", unit="m", meaning="along the hull, of the point below the vehicle", values=numbers(at.along, ".4f")
        ),
        Column(name="girth_m", unit="m", meaning="girth from the keel, port positive", values=numbers(at.girth, ".4f")),
        Column(name="side", unit="", meaning="port, starboard or keel", values=at.side, words=True),
        Column(name="frame", unit="", meaning="number of the ship's frame", values=numbers(at.frame, ".3f")),
        Column(
            name="depth_m", unit="m", meaning="below the water surface", values=numbers(lost if depth is None else depth, ".4f")
        ),
    ]


def vehicle_depth(survey: Survey) -> Array | None:
    """Return the depth (n,) m of the vehicle at the nodes, adjusted where it was; None where none was measured."""
    if not survey.facts.has_depth:
        return None
    if survey.adjusted is not None:
        return survey.adjusted.solution.global_from_vehicle.translation[:, 2]
    return survey.trajectory.translation[:, 2]


def trajectory_tum(track: VehicleTrack) -> str:
    """Return the same poses as lines of `t x y z qx qy qz qw`."""
    columns = [seconds(track.t_ns)]
    columns += [numbers(c) for c in (*track.poses.translation.T, *track.poses.quaternion.T)]
    return "".join(" ".join(row) + "\n" for row in zip(*columns, strict=True))
