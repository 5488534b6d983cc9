# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The trajectory as people take it away: the vehicle in the hull frame (global without a CAD
model), with sigmas.
"""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.charts.tangents import tangents_at
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
        Column(
            name=n,
            unit="m",
            meaning=f"position of the vehicle in {frame}",
            values=numbers(place[:, k]),
        )
        for k, n in enumerate("xyz")
    ]
    columns += [
        Column(
            name=n,
            unit="",
            meaning=f"rotation of the vehicle in {frame}, unit quaternion",
            values=numbers(turn[:, k]),
        )
        for k, n in enumerate(("qx", "qy", "qz", "qw"))
    ]
    columns += [
        Column(
            name=f"sigma_{n}",
            unit=unit,
            meaning=f"one sigma of {what}",
            values=numbers(track.sigma[:, k], ".6g"),
        )
        for k, (n, unit, what) in enumerate(_SIGMAS)
    ]
    columns.append(
        Column(name="tray", unit="rad", meaning="angle of the tray", values=numbers(track.tray))
    )
    return Table(
        file="trajectory.csv",
        title="the vehicle at every node",
        columns=[*columns, *_ship_columns(survey)],
    )


_SIGMAS = (
    ("x", "m", "the position along x"),
    ("y", "m", "the position along y"),
    ("z", "m", "the position along z"),
    ("roll", "rad", "a small rotation about the vehicle's x"),
    ("pitch", "rad", "a small rotation about its y"),
    ("yaw", "rad", "a small rotation about its z"),
)


def _ship_columns(survey: Survey) -> list[Column]:
    """Return where on the ship the vehicle stood, and how well that is known."""
    track = survey.track
    at = chart_coordinates(survey, track.poses.translation)
    along_sigma, girth_sigma = chart_sigmas(survey)
    lost = np.full(len(at.along), np.nan)
    depth = vehicle_depth(survey)
    depth, depth_sigma = (lost, lost) if depth is None else (depth, vehicle_depth_sigma(survey))

    def length(name: str, meaning: str, values: Array, form: str = ".4f") -> Column:
        return Column(name=name, unit="m", meaning=meaning, values=numbers(values, form))

    return [
        length("along", "along the hull, of the point below the vehicle", at.along),
        length("girth", "girth from the keel, port positive", at.girth),
        Column(name="side", unit="", meaning="port, starboard or keel", values=at.side, words=True),
        Column(
            name="frame",
            unit="",
            meaning="number of the ship's frame",
            values=numbers(at.frame, ".3f"),
        ),
        length("depth", "below the water surface", depth),
        length("sigma_along", "one sigma along the hull", along_sigma, ".6g"),
        length("sigma_girth", "one sigma in girth", girth_sigma, ".6g"),
        length("depth_sigma", "one sigma of the depth", depth_sigma, ".6g"),
    ]


def chart_sigmas(survey: Survey) -> tuple[Array, Array]:
    """Return one sigma (n,) m of the vehicle along the hull and in girth, by the chart's tangents
    below it; NaN off the chart.
    """
    track, chart = survey.track, survey.surfaces.chart
    if chart is None:
        return np.full(len(track.t_ns), np.nan), np.full(len(track.t_ns), np.nan)
    along, girth = (
        track.sigma_towards(direction) for direction in tangents_at(chart, track.poses.translation)
    )
    return along, girth


def vehicle_depth(survey: Survey) -> Array | None:
    """Return the depth (n,) m of the vehicle at the nodes, adjusted where it was; None where none
    was measured.
    """
    if not survey.facts.has_depth:
        return None
    if survey.adjusted is not None:
        return survey.adjusted.solution.global_from_vehicle.translation[:, 2]
    return survey.trajectory.translation[:, 2]


def vehicle_depth_sigma(survey: Survey) -> Array:
    """Return one sigma (n,) m of the depth at the nodes: in g that of the position; in M, whose
    covariance says how the vehicle lies to the hull, that of the pressure sensor's bias and noise.
    """
    adjusted, nodes = survey.adjusted, len(survey.track.t_ns)
    if adjusted is None:
        return np.asarray(np.sqrt(survey.trajectory.covariance[:, 2, 2]))
    known = adjusted.depth_sigma_m
    if not survey.is_in_hull_frame or known is None:
        down = adjusted.solution.result_from_global().rotation.as_matrix()[:, :, 2]
        return survey.track.sigma_towards(np.broadcast_to(down, (nodes, 3)))
    return np.full(nodes, known)


def trajectory_tum(track: VehicleTrack) -> str:
    """Return the same poses as lines of `t x y z qx qy qz qw`."""
    columns = [seconds(track.t_ns)]
    columns += [numbers(c) for c in (*track.poses.translation.T, *track.poses.quaternion.T)]
    return "".join(" ".join(row) + "\n" for row in zip(*columns, strict=True))
