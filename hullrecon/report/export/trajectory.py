# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The trajectory as people take it away: the vehicle in the frame of the results, with sigmas."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.address import is_hull_chart, side_of
from hullrecon.geometry.charts.tangents import tangents_at
from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import Trajectory, VehicleTrack
from hullrecon.report.export.table import Column, Table, numbers, seconds
from hullrecon.report.survey import Survey
from hullrecon.typing import Array


def track_of(trajectory: Trajectory, solution: Solution | None) -> VehicleTrack:
    """Choose the best path available: adjusted in M, adjusted in g, or dead reckoned in g."""
    return trajectory.track() if solution is None else solution.track()


@dataclass(frozen=True, kw_only=True)
class ChartCoordinates:
    """Where n points lie on the ship."""

    along: Array  # (n,) m, NaN off the chart
    girth: Array
    side: list[str]  # "" off the ship
    frame: Array  # (n,) number of the ship's frame, NaN without a spacing


def chart_coordinates(survey: Survey, points: Array) -> ChartCoordinates:
    """Project points (n, 3) in the results' frame onto the chart. All are NaN without a chart."""
    chart, hull = survey.surfaces.chart, survey.facts.hull
    lost = np.full(len(points), np.nan)
    if chart is None or not len(points):
        return ChartCoordinates(along=lost, girth=lost, side=[""] * len(points), frame=lost)
    along, girth = chart.to_chart(points)[:, :2].T
    on_ship = is_hull_chart(chart)
    spacing = hull.frame_spacing if hull is not None and on_ship else None
    return ChartCoordinates(
        along=along,
        girth=girth,
        side=[side_of(float(g)) if on_ship and np.isfinite(g) else "" for g in girth],
        frame=along / spacing if spacing else lost,
    )


def trajectory_table(survey: Survey) -> Table:
    """Make trajectory.csv (docs/deliverables.md): one row per node."""
    track, frame = survey.track, survey.track.frame
    where, turn = f"position of the vehicle in {frame}", f"rotation of the vehicle in {frame}"
    cells: list[tuple[str, str, str, list[str]]] = [
        ("t", "s", "since 1970 (UTC)", seconds(track.t_ns))
    ]
    for name, values in zip("xyz", track.poses.translation.T, strict=True):
        cells.append((name, "m", where, numbers(values)))
    for name, values in zip(("qx", "qy", "qz", "qw"), track.poses.quaternion.T, strict=True):
        cells.append((name, "", f"{turn}, unit quaternion", numbers(values)))
    for (name, unit, what), values in zip(_SIGMAS, track.sigma[:, :6].T, strict=True):
        cells.append((f"sigma_{name}", unit, f"one sigma of {what}", numbers(values, ".6g")))
    cells.append(("tray", "rad", "angle of the tray", numbers(track.tray)))
    cells += _ship_cells(survey)
    return Table(
        file="trajectory.csv",
        title="the vehicle at every node",
        columns=[
            Column(name=name, unit=unit, meaning=meaning, values=values, words=name == "side")
            for name, unit, meaning, values in cells
        ],
    )


_SIGMAS = (
    ("x", "m", "the position along x"),
    ("y", "m", "the position along y"),
    ("z", "m", "the position along z"),
    ("roll", "rad", "a small rotation about the vehicle's x"),
    ("pitch", "rad", "a small rotation about its y"),
    ("yaw", "rad", "a small rotation about its z"),
)


def _ship_cells(survey: Survey) -> list[tuple[str, str, str, list[str]]]:
    """Tabulate the vehicle's place on the ship and its sigmas."""
    track = survey.track
    at = chart_coordinates(survey, track.poses.translation)
    along_sigma, girth_sigma = chart_sigmas(survey)
    depth = depth_sigma = np.full(len(at.along), np.nan)
    if survey.facts.has_depth:
        depth, depth_sigma = vehicle_depth(survey), vehicle_depth_sigma(survey)
    below = "along the hull, of the point below the vehicle"
    return [
        ("along", "m", below, numbers(at.along, ".4f")),
        ("girth", "m", "girth from the keel, port positive", numbers(at.girth, ".4f")),
        ("side", "", "port, starboard or keel", at.side),
        ("frame", "", "number of the ship's frame", numbers(at.frame, ".3f")),
        ("depth", "m", "below the water surface", numbers(depth, ".4f")),
        ("sigma_along", "m", "one sigma along the hull", numbers(along_sigma, ".6g")),
        ("sigma_girth", "m", "one sigma in girth", numbers(girth_sigma, ".6g")),
        ("depth_sigma", "m", "one sigma of the depth", numbers(depth_sigma, ".6g")),
    ]


def chart_sigmas(survey: Survey) -> tuple[Array, Array]:
    """Compute one sigma (n,) m of the vehicle along the hull and in girth, NaN off the chart."""
    track, chart = survey.track, survey.surfaces.chart
    if chart is None:
        return np.full(len(track.t_ns), np.nan), np.full(len(track.t_ns), np.nan)
    along, girth = map(track.sigma_towards, tangents_at(chart, track.poses.translation))
    return along, girth


def vehicle_depth(survey: Survey) -> Array:
    """Select the vehicle's depth (n,) m at the nodes, adjusted if the dive was."""
    if survey.adjusted is not None:
        return survey.adjusted.solution.global_from_vehicle.translation[:, 2]
    return survey.trajectory.translation[:, 2]


def vehicle_depth_sigma(survey: Survey) -> Array:
    """Compute one sigma (n,) m of the depth at the nodes.

    In g it is that of the position. In M, whose covariance is relative to the hull, it is that of
    the pressure sensor's bias and noise, if that is known.
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
    """Write the poses as lines of `t x y z qx qy qz qw`."""
    columns = [seconds(track.t_ns)]
    columns += [numbers(c) for c in (*track.poses.translation.T, *track.poses.quaternion.T)]
    return "".join(" ".join(row) + "\n" for row in zip(*columns, strict=True))
