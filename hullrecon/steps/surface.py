# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull's surface from the DVL's returns, with the adjusted poses when there are any, dead reckoned else; where no DVL was
carried, from the landmarks."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from hullrecon.artifacts.graph.stage import Context, Stage, load_arrays
from hullrecon.errors import StageError
from hullrecon.geometry import poses
from hullrecon.geometry.charts.chart import Chart, chart_for_hull, chart_for_points, chart_from_arrays
from hullrecon.geometry.charts.plane_chart import PlaneChart, fit_plane_chart
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.solution import Solution
from hullrecon.records.surface import Surface
from hullrecon.records.trajectory import Returns, Trajectory
from hullrecon.surface.build import MIN_FACING, SurfacePoints, build_surface
from hullrecon.surface.options import SurfaceOptions
from hullrecon.surface.outliers import statistical_inliers
from hullrecon.surface.returns import pose_sigma_along, return_points
from hullrecon.typing import Array, Mask

MAX_FOLDED_SHARE = 0.01  # share of returns that may lie where the hull turns away from the plane


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
    hull = _hull(context.inputs["ingest"])
    solution = _solution(context)
    place = _adjusted(solution) if solution is not None else _dead_reckoned(context, hull)
    returns, points, counts = _returned(context, place, options)
    marks, noise = _landmarks(solution, hull, options) if solution is not None else (np.zeros((0, 3)), np.zeros(0))
    if not len(points) and not len(marks):
        raise StageError(
            "neither DVL returns nor landmarks", where="surface", remedy="check topics.dvl and the cameras' topics"
        )
    chart = _chart(context, hull, points if len(points) else marks, place)
    cloud = _cloud(points, returns, place, chart, context.settings["dvl"].sigma_range)
    if options.landmarks or not len(points):
        cloud = _with_landmarks(cloud, marks, noise)
    on, datum = _reference(cloud, chart, options.reference, place)
    surface, facts = build_surface(cloud, on, options, datum)
    facts["reference"], facts["comparison"] = _circularity(options.reference, hull is not None, solution is not None)
    if hull is not None:
        surface = replace(surface, deviation=Scene(hull).closest(surface.vertices).distance)
    _write(context, surface, chart, {**facts, "poses": place.source, **counts})


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


def _adjusted(solution: Solution) -> Placement:
    track = solution.track()
    return Placement(track.poses, track.covariance, track.tray, solution.mounts.tray_from_dvl, "adjusted")


def _dead_reckoned(context: Context, hull: Mesh | None) -> Placement:
    """In M by the first guess of the hull's pose, whose sigma then dominates; in g without a CAD model."""
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


def _returned(context: Context, place: Placement, options: SurfaceOptions) -> tuple[Returns, Array, dict[str, object]]:
    """The returns that count, where they are, and how many were left out; none where no DVL was carried."""
    path = context.inputs["navigate"] / "returns.npz"
    if not path.exists():
        nothing = np.zeros(0, np.int64)
        blank = Returns(
            t_ns=nothing,
            node=nothing,
            quaternion=np.zeros((0, 4)),
            translation=np.zeros((0, 3)),
            tray_offset=np.zeros(0),
            beam=np.zeros((0, 3)),
            range_m=np.zeros(0),
            flagged=np.zeros(0, bool),
        )
        return blank, np.zeros((0, 3)), {"returns": 0}
    returns = from_arrays(Returns, load_arrays(path))
    points = return_points(returns, place.T_x_v, place.tray, np.array(context.settings["tray"].origin), place.T_s_d)
    kept = _inliers(points, returns, options)
    return _rows(returns, kept), points[kept], _counts(returns, kept)


def _inliers(points: Array, returns: Returns, options: SurfaceOptions) -> Mask:
    """Returns that navigation did not flag and that do not stand apart."""
    kept = ~returns.flagged & np.isfinite(points).all(axis=1)
    if kept.sum() < 4:
        raise StageError("the DVL gave fewer than four returns", where="surface", remedy="check topics.dvl and the log's span")
    kept[kept] = statistical_inliers(points[kept], options.outlier_neighbours, options.outlier_deviations)
    return kept


def _rows(returns: Returns, which: Mask) -> Returns:
    return from_arrays(Returns, {name: values[which] for name, values in to_arrays(returns).items()})


def _chart(context: Context, hull: Mesh | None, points: Array, place: Placement) -> Chart:
    """The adjustment's chart when it left one, so that all later steps speak of the same addresses."""
    path = context.inputs["adjust"] / "chart.npz" if "adjust" in context.inputs else None
    if path is not None and path.exists():
        return chart_from_arrays(load_arrays(path))
    return chart_for_hull(hull) if hull is not None else chart_for_points(points, toward=place.T_x_v.translation)


def _cloud(points: Array, returns: Returns, place: Placement, chart: Chart, sigma_range: float) -> SurfacePoints:
    _, normals = chart.from_chart(chart.to_chart(points)[:, :2])
    T_x_v = place.T_x_v[returns.node]
    levers = points - T_x_v.translation
    shared = pose_sigma_along(normals, levers, place.covariance[returns.node], T_x_v.rotation.as_matrix())
    return SurfacePoints(points, np.full(len(points), sigma_range), np.nan_to_num(shared), np.ones(len(points), bool))


def _landmarks(solution: Solution, hull: Mesh | None, options: SurfaceOptions) -> tuple[Array, Array]:
    """Places (n, 3) and sigmas (n,) m of landmarks on the hull with three views; of all such without a CAD model."""
    variance = np.linalg.eigvalsh(np.nan_to_num(solution.landmarks.covariance, nan=-1.0))[:, -1]
    good = np.isfinite(solution.landmarks.position).all(axis=1) & (solution.landmarks.views >= 3) & (variance > 0)
    good &= (solution.landmarks.label == 1) if hull is not None else True
    points = solution.result_from_global().apply(solution.landmarks.position[good])
    kept = statistical_inliers(points, options.outlier_neighbours, 2 * options.outlier_deviations)
    return points[kept], np.sqrt(variance[good])[kept]


def _with_landmarks(cloud: SurfacePoints, points: Array, noise: Array) -> SurfacePoints:
    """Landmarks join the returns; where there are none, they support the surface themselves."""
    n, alone = len(points), not len(cloud.point)
    return SurfacePoints(
        np.vstack([cloud.point, points]),
        np.concatenate([cloud.noise, noise]),
        np.concatenate([cloud.pose_sigma, np.full(n, 0.0 if alone else float(np.median(cloud.pose_sigma)))]),
        np.concatenate([cloud.gives_support, np.full(n, alone)]),
    )


def _reference(cloud: SurfacePoints, chart: Chart, reference: str, place: Placement) -> tuple[Chart, PlaneChart | None]:
    """The chart on which is regressed, and the plane whose heights are, None where it is the chart's own offsets."""
    if reference == "cad":
        return chart, None
    plane = fit_plane_chart(cloud.point, place.T_x_v.translation.mean(axis=0), np.array([0.0, 0.0, 1.0]))
    if reference == "none":
        return chart, plane
    _, normals = chart.from_chart(chart.to_chart(cloud.point)[:, :2])
    facing = normals[np.isfinite(normals).all(axis=1)] @ plane.axes[2]
    if np.mean(facing < MIN_FACING) > MAX_FOLDED_SHARE:
        raise StageError(
            "the hull bends too far around for a plane",
            where="surface",
            remedy='set surface.reference = "cad", or a shorter survey',
        )
    return plane, None


def _circularity(reference: str, drawn: bool, adjusted: bool) -> tuple[str, str | None]:
    """The reference in force, and what a comparison of the surface with the CAD model is worth; None without a CAD model."""
    if not drawn:
        return "none" if reference == "none" else "plane", None
    placed = " The poses that place the returns were adjusted to the CAD model." if adjusted else ""
    if reference == "cad":
        return reference, (
            "The surface is a regression of the returns' offsets from the CAD model and leans on it between and beyond returns: "
            f"a comparison with the CAD model is partly circular.{placed} "
            'surface.reference = "plane" or "none" regresses without it.'
        )
    return reference, f"The CAD model's shape does not enter the regression of the returns.{placed}"


def _counts(returns: Returns, kept: Mask) -> dict[str, object]:
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
    version=2,
    run=run,
    uses=("tray", "dvl", "hull"),
)
