# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""From a survey's DVL returns (its landmarks where no DVL was carried) to the hull's surface."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hullrecon.errors import StageError
from hullrecon.estimation.landmark_variance import variance_along_normals
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.plane_chart import PlaneChart, fit_plane_chart
from hullrecon.records.solution import Solution
from hullrecon.records.surface import Surface
from hullrecon.records.trajectory import Returns, VehicleTrack
from hullrecon.rig import Rig
from hullrecon.surface.build import MIN_FACING, SurfacePoints, build_surface
from hullrecon.surface.hull_reference import HullReference
from hullrecon.surface.options import SurfaceOptions
from hullrecon.surface.outliers import statistical_inliers
from hullrecon.surface.placement import pose_sigma_along
from hullrecon.typing import Array, Ints, Mask

Facts = dict[str, object]
MAX_FOLDED_SHARE = 0.01  # of the returns that may lie where the hull turns away from the plane


@dataclass(frozen=True, kw_only=True)
class SurfaceInputs:
    """What a surface is made of. track: the vehicle in the surface's frame; chart: the
    adjustment's, None where it left none; solution: None before the adjustment; returns: None where
    no DVL was carried; range_sigma_m: white part of a range.
    """

    hull: HullReference
    track: VehicleTrack
    rig: Rig
    returns: Returns | None
    range_sigma_m: float
    solution: Solution | None
    chart: Chart | None


@dataclass(frozen=True, kw_only=True)
class ChartedResult:
    """The surface, the chart that all later steps use, and what was found on the way
    (surface.json).
    """

    surface: Surface
    chart: Chart
    facts: Facts


def surface_from_survey(survey: SurfaceInputs, options: SurfaceOptions) -> ChartedResult:
    """Return the hull's surface in the frame of the track. Raises StageError where there is too
    little to make one of.
    """
    # Where the beams ended, and the landmarks on the hull
    returns, counts = _points_of_returns(survey, options)
    landmarks = _find_landmarks(survey, options)
    if not len(returns.points) and not len(landmarks.points):
        raise StageError(
            "neither DVL returns nor landmarks",
            where="surface",
            remedy="check topics.dvl and the cameras' topics",
        )
    # The chart, on which the points' shared uncertainty is taken along the normals
    sensors = survey.track.poses.translation
    chart = survey.chart or survey.hull.chart(
        returns.points if len(returns.points) else landmarks.points, sensors
    )
    observed = _add_sigmas(returns, survey, chart)
    if options.landmarks or not len(returns.points):
        observed = _join(observed, _measure_landmarks(landmarks, survey, chart))
    # The regression
    regressed_on, datum = _choose_reference(observed.point, chart, options.reference, sensors)
    surface, facts = build_surface(observed, regressed_on, options, datum)
    comparison = survey.hull.comparison(options.reference, survey.solution is not None)
    facts |= {"reference": comparison.reference, "comparison": comparison.note, **counts}
    return ChartedResult(
        surface=replace(surface, deviation=survey.hull.deviation(surface.vertices)),
        chart=chart,
        facts=facts,
    )


@dataclass(frozen=True, kw_only=True)
class _ReturnPoints:
    """Points (n, 3) where the beams of those returns that count ended, and the nodes (n,) that they
    belong to.
    """

    points: Array
    node: Ints


def _points_of_returns(
    survey: SurfaceInputs, options: SurfaceOptions
) -> tuple[_ReturnPoints, Facts]:
    """Return where the returns ended, without those that navigation flagged or that stand apart,
    and how many were left out.
    """
    returns = survey.returns
    if returns is None:
        return _ReturnPoints(points=np.zeros((0, 3)), node=np.zeros(0, np.int64)), {"returns": 0}
    points = survey.rig.dvl_points(returns, survey.track.path).points
    inlier = _find_inliers(points, returns.flagged, options)
    flagged = int(returns.flagged.sum())
    counts: Facts = {
        "returns": len(inlier),
        "flagged": flagged,
        "outliers": int((~inlier).sum()) - flagged,
        "used": int(inlier.sum()),
    }
    return _ReturnPoints(points=points[inlier], node=returns.node[inlier]), counts


def _find_inliers(points: Array, flagged: Mask, options: SurfaceOptions) -> Mask:
    """Return which points (n, 3) count. Raises StageError with fewer than four to choose from."""
    inlier = ~flagged & np.isfinite(points).all(axis=1)
    if inlier.sum() < 4:
        raise StageError(
            "the DVL gave fewer than four returns",
            where="surface",
            remedy="check topics.dvl and the log's span",
        )
    inlier[inlier] = statistical_inliers(
        points[inlier], options.outlier_neighbours, options.outlier_sigmas
    )
    return inlier


@dataclass(frozen=True, kw_only=True)
class _LandmarkPoints:
    """Landmarks (n, 3) on the hull in the frame of the surface, with their covariances (n, 3, 3)."""

    points: Array
    covariance: Array


def _find_landmarks(survey: SurfaceInputs, options: SurfaceOptions) -> _LandmarkPoints:
    """Return the landmarks on the hull that three images saw; none before the adjustment."""
    if survey.solution is None:
        return _LandmarkPoints(points=np.zeros((0, 3)), covariance=np.zeros((0, 3, 3)))
    landmarks = survey.solution.landmarks
    good = np.isfinite(landmarks.position).all(axis=1) & (landmarks.views >= 3)
    good &= np.einsum("nii->n", np.nan_to_num(landmarks.covariance, nan=-1.0)) > 0
    good &= survey.hull.on_hull(landmarks.label)
    points = survey.solution.result_from_global().apply(landmarks.position[good])
    inlier = statistical_inliers(points, options.outlier_neighbours, options.outlier_sigmas)
    return _LandmarkPoints(points=points[inlier], covariance=landmarks.covariance[good][inlier])


def _measure_landmarks(
    landmarks: _LandmarkPoints, survey: SurfaceInputs, chart: Chart
) -> SurfacePoints:
    """Return the landmarks with their own sigmas along the chart's normals, and with what they
    share: the hull's pose and the dive's place.
    """
    n = len(landmarks.points)
    if survey.solution is None or n == 0:
        return SurfacePoints(
            point=np.zeros((0, 3)),
            noise=np.zeros(0),
            pose_sigma=np.zeros(0),
            gives_support=np.zeros(0, bool),
        )
    _, normals = chart.from_chart(chart.to_chart(landmarks.points)[:, :2])
    pose = survey.solution.hull_pose
    along = variance_along_normals(
        landmarks.points, np.nan_to_num(normals), landmarks.covariance, pose
    )
    return SurfacePoints(
        point=landmarks.points,
        noise=np.sqrt(along.own),
        pose_sigma=np.sqrt(along.common),
        gives_support=np.zeros(n, bool),
    )


def _add_sigmas(returns: _ReturnPoints, survey: SurfaceInputs, chart: Chart) -> SurfacePoints:
    """Return the returns with the sigma of their ranges, and with that of their poses along the
    chart's normals.
    """
    points, poses = returns.points, survey.track.poses[returns.node]
    _, normals = chart.from_chart(chart.to_chart(points)[:, :2])
    shared = pose_sigma_along(
        normals,
        points - poses.translation,
        survey.track.covariance[returns.node],
        poses.rotation.as_matrix(),
    )
    n = len(points)
    return SurfacePoints(
        point=points,
        noise=np.full(n, survey.range_sigma_m),
        pose_sigma=np.nan_to_num(shared),
        gives_support=np.ones(n, bool),
    )


def _join(returns: SurfacePoints, landmarks: SurfacePoints) -> SurfacePoints:
    """Return both; landmarks support the surface where there are no returns."""
    n, alone = len(landmarks.point), not len(returns.point)
    return SurfacePoints(
        point=np.vstack([returns.point, landmarks.point]),
        noise=np.concatenate([returns.noise, landmarks.noise]),
        pose_sigma=np.concatenate([returns.pose_sigma, landmarks.pose_sigma]),
        gives_support=np.concatenate([returns.gives_support, np.full(n, alone)]),
    )


def _choose_reference(
    points: Array, chart: Chart, reference: str, sensors: Array
) -> tuple[Chart, PlaneChart | None]:
    """Return the chart on which to regress, and the plane over which heights are counted: None for
    the chart's own offsets.

    Raises StageError where offsets from a plane are asked of a hull that bends around.
    """
    if reference == "cad":
        return chart, None
    plane = fit_plane_chart(points, sensors.mean(axis=0), np.array([0.0, 0.0, 1.0]))
    if reference == "none":
        return chart, plane
    _, normals = chart.from_chart(chart.to_chart(points)[:, :2])
    facing = normals[np.isfinite(normals).all(axis=1)] @ plane.axes[2]
    if np.mean(facing < MIN_FACING) > MAX_FOLDED_SHARE:
        raise StageError(
            "the hull bends too far around for a plane",
            where="surface",
            remedy='set surface.reference = "cad", or a shorter survey',
        )
    return plane, None
