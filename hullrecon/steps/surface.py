# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull's surface from the DVL's returns, with the adjusted poses when there are any, dead reckoned else."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hullrecon.artifacts.stage import Context, Stage, load_arrays
from hullrecon.dive.records import Returns, Solution, Surface, Trajectory, from_arrays, to_arrays
from hullrecon.errors import StageError
from hullrecon.geometry import poses
from hullrecon.geometry.casting import Scene
from hullrecon.geometry.chart import Chart, chart_for_hull, chart_for_points, chart_from_arrays
from hullrecon.geometry.meshes import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.surface.build import Cloud, build_surface
from hullrecon.surface.options import SurfaceOptions
from hullrecon.surface.outliers import statistical_inliers
from hullrecon.surface.returns import pose_sigma_along, return_points

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Placement:
    """The vehicle in the frame of the surface: T_x_v and covariance (n, 6, 6) at the nodes, tray (n,) rad, T_s_d."""

    T_x_v: Poses
    covariance: Array
    tray: Array
    T_s_d: Poses
    source: str


def run(context: Context) -> None:
    options: SurfaceOptions = context.parameters
    returns = from_arrays(Returns, load_arrays(context.inputs["navigate"] / "returns.npz"))
    hull = _hull(context.inputs["ingest"])
    solution = _solution(context)
    place = _adjusted(solution, hull) if solution is not None else _dead_reckoned(context, hull)
    origin = np.array(context.settings["tray"].origin)
    points = return_points(returns, place.T_x_v, place.tray, origin, place.T_s_d)
    kept = _inliers(points, returns, options)
    chart = _chart(context, hull, points[kept])
    cloud = _cloud(points[kept], _rows(returns, kept), place, chart, context.settings["dvl"].sigma_range)
    if options.landmarks and solution is not None:
        cloud = _with_landmarks(cloud, solution, hull, chart)
    surface, facts = build_surface(cloud, chart, options)
    if hull is not None:
        surface = replace(surface, deviation=Scene(hull).closest(surface.vertices).distance)
    _write(context, surface, chart, {**facts, "poses": place.source, **_counts(returns, kept)})


def _hull(ingest: Path) -> Mesh | None:
    path = ingest / "hull.npz"
    if not path.exists():
        return None
    arrays = load_arrays(path)
    return Mesh(arrays["vertices"], arrays["faces"])


def _solution(context: Context) -> Solution | None:
    if "adjust" not in context.inputs:
        return None
    return from_arrays(Solution, load_arrays(context.inputs["adjust"] / "solution.npz"))


def _motion(seven: Array) -> Poses:
    return Poses(seven[None, 3:], seven[None, :3])


def _adjusted(solution: Solution, hull: Mesh | None) -> Placement:
    T_x_g = _motion(solution.T_g_M).inverse() if hull is not None else poses.identity()
    T_x_v = T_x_g[np.zeros(len(solution.t_ns), np.int64)] @ solution.poses()
    return Placement(T_x_v, solution.pose_covariance, solution.tray, _motion(solution.T_s_d), "adjusted")


def _dead_reckoned(context: Context, hull: Mesh | None) -> Placement:
    """In M by the first guess of the hull's pose, whose sigma then dominates; in g without a drawing."""
    track = from_arrays(Trajectory, load_arrays(context.inputs["navigate"] / "trajectory.npz"))
    settings = context.settings["hull"]
    T_s_d = poses.from_mount(context.settings["dvl"].mount)
    if hull is None or settings is None:
        return Placement(track.poses(), track.covariance, track.tray, T_s_d, "dead reckoned")
    T_x_g = poses.from_mount(settings.pose).inverse()
    turn = np.zeros((6, 6))
    turn[:3, :3], turn[3:, 3:] = T_x_g.rotation.as_matrix()[0], np.eye(3)
    covariance = turn @ track.covariance @ turn.T
    covariance[:, :3, :3] += np.diag(np.square(settings.pose_sigma[:3]))
    T_x_v = T_x_g[np.zeros(len(track.t_ns), np.int64)] @ track.poses()
    return Placement(T_x_v, covariance, track.tray, T_s_d, "dead reckoned, placed by hull.pose")


def _inliers(points: Array, returns: Returns, options: SurfaceOptions) -> NDArray[np.bool_]:
    """Returns that navigation did not flag and that do not stand apart."""
    kept = ~returns.flagged & np.isfinite(points).all(axis=1)
    if kept.sum() < 4:
        raise StageError("the DVL gave fewer than four returns", where="surface", remedy="check topics.dvl and the log's span")
    kept[kept] = statistical_inliers(points[kept], options.outlier_neighbours, options.outlier_deviations)
    return kept


def _rows(returns: Returns, which: NDArray[np.bool_]) -> Returns:
    return from_arrays(Returns, {name: values[which] for name, values in to_arrays(returns).items()})


def _chart(context: Context, hull: Mesh | None, points: Array) -> Chart:
    """The adjustment's chart when it left one, so that all later steps speak of the same addresses."""
    path = context.inputs["adjust"] / "chart.npz" if "adjust" in context.inputs else None
    if path is not None and path.exists():
        return chart_from_arrays(load_arrays(path))
    return chart_for_hull(hull) if hull is not None else chart_for_points(points)


def _cloud(points: Array, returns: Returns, place: Placement, chart: Chart, sigma_range: float) -> Cloud:
    _, normals = chart.from_chart(chart.to_chart(points)[:, :2])
    T_x_v = place.T_x_v[returns.node]
    levers = points - T_x_v.translation
    shared = pose_sigma_along(normals, levers, place.covariance[returns.node], T_x_v.rotation.as_matrix())
    return Cloud(points, np.full(len(points), sigma_range), np.nan_to_num(shared), np.ones(len(points), bool))


def _with_landmarks(cloud: Cloud, solution: Solution, hull: Mesh | None, chart: Chart) -> Cloud:
    """Landmarks on the hull (any with three views without a drawing) join the returns."""
    good = np.isfinite(solution.landmark).all(axis=1) & (solution.views >= 3)
    good &= (solution.label == 1) if hull is not None else True
    T_x_g = _motion(solution.T_g_M).inverse() if hull is not None else poses.identity()
    points = T_x_g.apply(solution.landmark[good])
    _, normals = chart.from_chart(chart.to_chart(points)[:, :2])
    noise = np.sqrt(np.einsum("ni,nij,nj->n", normals, solution.landmark_covariance[good], normals))
    known = np.isfinite(noise) & (noise > 0)
    n = int(known.sum())
    return Cloud(
        np.vstack([cloud.point, points[known]]),
        np.concatenate([cloud.noise, noise[known]]),
        np.concatenate([cloud.pose_sigma, np.full(n, float(np.median(cloud.pose_sigma)))]),
        np.concatenate([cloud.gives_support, np.zeros(n, bool)]),
    )


def _counts(returns: Returns, kept: NDArray[np.bool_]) -> dict[str, object]:
    flagged = int(returns.flagged.sum())
    return {"returns": len(kept), "flagged": flagged, "outliers": int((~kept).sum()) - flagged, "used": int(kept.sum())}


def _write(context: Context, surface: Surface, chart: Chart, facts: dict[str, object]) -> None:
    context.out.arrays("surface.npz", to_arrays(surface))
    context.out.arrays("chart.npz", chart.to_arrays())
    context.out.json("surface.json", facts)


STAGE = Stage(
    name="surface",
    summary="make a surface of the DVL's returns",
    inputs=("ingest", "navigate"),
    optional=("adjust",),
    parameters=SurfaceOptions,
    version=1,
    run=run,
    uses=("tray", "dvl", "hull"),
)
