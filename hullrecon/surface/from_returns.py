# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""From a survey's DVL returns (its landmarks where no DVL was carried) to the hull's surface."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hullrecon.errors import StageError
from hullrecon.estimation.landmark_variance import variance_along_normals
from hullrecon.geometry.charts.chart import Chart, chart_for_hull, chart_for_points
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.geometry.frames import Frame
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.neighbours import nearest
from hullrecon.geometry.poses import Poses
from hullrecon.records.solution import Solution
from hullrecon.records.surface import Surface
from hullrecon.records.trajectory import Returns, VehicleTrack
from hullrecon.rig import Rig
from hullrecon.surface.build import Regression, SurfacePoints, build_surface, gaussian_process
from hullrecon.surface.options import SurfaceOptions
from hullrecon.typing import Array, Ints, Mask


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """How far the surface depends on the CAD model that it is compared with."""

    reference: str  # what the returns' offsets were regressed from
    note: str | None  # what a comparison with the CAD model is worth, None without one


@dataclass(frozen=True, kw_only=True)
class CadHull:
    """A hull with a CAD model, in M."""

    mesh: Mesh
    up: Sequence[float] | Array = (0.0, 0.0, 1.0)  # (3,) roughly up
    bow: str | None = None  # as `chart_for_hull` has it
    aft_perpendicular_m: float | None = None  # as `chart_for_hull` has it

    def chart(self, points: Array, sensors: Array) -> Chart:
        """Unroll the CAD model, whatever points and sensors are."""
        return chart_for_hull(self.mesh, self.up, self.bow, self.aft_perpendicular_m)

    def on_hull(self, label: Ints) -> Mask:
        """Mark the landmarks (n,) labelled as lying on the CAD model's surface."""
        return np.asarray(label == 1)

    def deviation(self, vertices: Array) -> Array:
        """Measure the signed distance (n,) m of vertices (n, 3), outward positive."""
        return Scene(self.mesh).closest(vertices).distance

    def comparison(self, poses_are_adjusted: bool) -> Comparison:
        """Say how far the surface depends on the CAD model that it is compared with."""
        note = (
            "The surface is a regression of the returns' offsets from the CAD model and leans on "
            "it between and beyond returns: a comparison with the CAD model is partly circular."
        )
        if poses_are_adjusted:
            note += " The poses that place the returns were adjusted to the CAD model."
        return Comparison(reference="cad", note=note)


@dataclass(frozen=True, kw_only=True)
class UnknownHull:
    """A hull without a CAD model: everything stays in g."""

    def chart(self, points: Array, sensors: Array) -> Chart:
        """Fit a plane or a cylinder to points (n, 3), its normals towards the sensors (m, 3)."""
        return chart_for_points(points, toward=sensors)

    def on_hull(self, label: Ints) -> Mask:
        """Mark every landmark (n,): nothing tells those on the hull from others."""
        return np.ones(len(label), bool)

    def deviation(self, vertices: Array) -> Array:
        """Return NaN (n,), as there is nothing to deviate from."""
        return np.full(len(vertices), np.nan)

    def comparison(self, poses_are_adjusted: bool) -> Comparison:
        """Say that offsets are from the survey's own chart, with no CAD model to compare with."""
        return Comparison(reference="survey", note=None)


HullReference = CadHull | UnknownHull


Facts = dict[str, object]
OUTLIER_NEIGHBOURS = 30  # with which a return is compared [Ozog2016 3.2.2.1]
# chart to regress offsets on, plane over which heights are regressed instead, and what surface.json
# says of it, from the points (n, 3), their chart and where the sensors were (m, 3)
Reference = Callable[[Array, Chart, Array], tuple[Chart, PlaneChart | None, Facts]]


def own_chart(
    points: Array, chart: Chart, sensors: Array
) -> tuple[Chart, PlaneChart | None, Facts]:
    """Regress offsets from the chart's own base surface."""
    return chart, None, {}


@dataclass(frozen=True, kw_only=True)
class SurfaceInputs:
    """What a surface is made of."""

    hull: HullReference
    track: VehicleTrack  # the vehicle in the surface's frame
    rig: Rig
    returns: Returns | None  # None where no DVL was carried
    range_sigma_m: float  # white part of a range
    solution: Solution | None  # None before the adjustment
    chart: Chart | None  # the adjustment's, None where it left none


@dataclass(frozen=True, kw_only=True)
class ChartedResult:
    """The surface and the chart that all later steps use."""

    surface: Surface
    chart: Chart
    facts: Facts  # surface.json


def surface_from_survey(
    survey: SurfaceInputs,
    options: SurfaceOptions,
    regression: Regression = gaussian_process,
    reference: Reference = own_chart,
) -> ChartedResult:
    """Estimate the hull's surface in the frame of the track.

    Raises StageError where there is too little to make one of.
    """
    # Where the beams ended, and the landmarks on the hull
    returns, counts = _points_of_returns(survey, options)
    landmarks = _find_landmarks(survey, options)
    if not len(returns.points) and not len(landmarks.points):
        raise StageError("neither DVL returns nor landmarks", where="surface")
    # The chart, on which the points' shared uncertainty is taken along the normals
    sensors = survey.track.poses.translation
    chart = survey.chart or survey.hull.chart(
        returns.points if len(returns.points) else landmarks.points, sensors
    )
    observed = _add_sigmas(returns, survey, chart)
    if options.landmarks or not len(returns.points):
        observed = _join(observed, _measure_landmarks(landmarks, survey, chart))
    # The regression
    regressed_on, datum, said = reference(observed.point, chart, sensors)
    surface, facts = build_surface(observed, regressed_on, options, datum, regression)
    comparison = survey.hull.comparison(survey.solution is not None)
    facts |= {"reference": comparison.reference, "comparison": comparison.note, **said}
    facts |= counts
    return ChartedResult(
        surface=replace(surface, deviation=survey.hull.deviation(surface.vertices)),
        chart=chart,
        facts=facts,
    )


@dataclass(frozen=True, kw_only=True)
class _ReturnPoints:
    """Where the beams of the returns that count ended."""

    points: Array  # (n, 3)
    node: Ints  # (n,) that each belongs to


def _points_of_returns(
    survey: SurfaceInputs, options: SurfaceOptions
) -> tuple[_ReturnPoints, Facts]:
    """Place the returns without flagged ones and outliers, and count these."""
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
    """Mark the points (n, 3) that count. Raises StageError with fewer than four."""
    inlier = ~flagged & np.isfinite(points).all(axis=1)
    if inlier.sum() < 4:
        raise StageError("the DVL gave fewer than four returns", where="surface")
    inlier[inlier] = statistical_inliers(points[inlier], deviations=options.outlier_sigmas)
    return inlier


@dataclass(frozen=True, kw_only=True)
class _LandmarkPoints:
    """Landmarks on the hull in the frame of the surface."""

    points: Array  # (n, 3)
    covariance: Array  # (n, 3, 3)


def _find_landmarks(survey: SurfaceInputs, options: SurfaceOptions) -> _LandmarkPoints:
    """Find landmarks on the hull that three images saw; none before the adjustment."""
    if survey.solution is None:
        return _LandmarkPoints(points=np.zeros((0, 3)), covariance=np.zeros((0, 3, 3)))
    landmarks = survey.solution.landmarks
    good = np.isfinite(landmarks.position).all(axis=1) & (landmarks.views >= 3)
    good &= np.einsum("nii->n", np.nan_to_num(landmarks.covariance, nan=-1.0)) > 0
    good &= survey.hull.on_hull(landmarks.label)
    points = survey.solution.result_from_global().apply(landmarks.position[good])
    inlier = statistical_inliers(points, deviations=options.outlier_sigmas)
    return _LandmarkPoints(points=points[inlier], covariance=landmarks.covariance[good][inlier])


def _measure_landmarks(
    landmarks: _LandmarkPoints, survey: SurfaceInputs, chart: Chart
) -> SurfacePoints:
    """Give landmarks their own sigma along the normals and the one that they share.

    Landmarks share the hull's pose and the dive's place.
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
    """Give returns the sigma of their ranges, and of their poses along the normals."""
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
    """Join both. Landmarks support the surface where there are no returns."""
    n, alone = len(landmarks.point), not len(returns.point)
    return SurfacePoints(
        point=np.vstack([returns.point, landmarks.point]),
        noise=np.concatenate([returns.noise, landmarks.noise]),
        pose_sigma=np.concatenate([returns.pose_sigma, landmarks.pose_sigma]),
        gives_support=np.concatenate([returns.gives_support, np.full(n, alone)]),
    )


def statistical_inliers(
    points: Array, neighbours: int = OUTLIER_NEIGHBOURS, deviations: float = 1.0
) -> Mask:
    """Reject points (n, 3) far from their neighbours [Rusu2008; Ozog2016 3.2.2.1].

    A point belongs whose mean distance to its neighbours is within so many standard deviations of
    the mean of all. [Ozog2016] takes 30 neighbours and one standard deviation.
    """
    count = min(neighbours, len(points) - 1)
    if count < 1:
        return np.ones(len(points), bool)
    distance, _ = nearest(points, points, count + 1)
    mean = distance[:, 1:].mean(axis=1)
    return np.asarray(mean <= mean.mean() + deviations * mean.std())


def move_to_hull_frame(
    track: VehicleTrack, global_from_hull: Poses, sigma_m: Array
) -> VehicleTrack:
    """Move a track from g to M by a first guess of the hull's pose (a batch of one).

    `sigma_m`: of the guess, along M's axes (3,). It is added to the covariance and soon exceeds the
    rest of it.
    """
    hull_from_global = global_from_hull.inverse()
    turn = np.zeros((6, 6))
    turn[:3, :3], turn[3:, 3:] = hull_from_global.rotation.as_matrix()[0], np.eye(3)
    covariance = turn @ track.covariance @ turn.T
    covariance[:, :3, :3] += np.diag(np.square(sigma_m))
    return replace(
        track, poses=hull_from_global @ track.poses, covariance=covariance, frame=Frame.HULL
    )


def pose_sigma_along(normals: Array, levers: Array, covariance: Array, rotation: Array) -> Array:
    """Propagate poses' covariances to points along the normals, (m,) m.

    A point R p + t moves by dt + R (w x p).

    Parameters
    ----------
    normals
        (m, 3) in the result's frame.
    levers
        point minus vehicle (m, 3).
    covariance
        (m, 6, 6) of translation and of rotation, right-perturbed in v.
    rotation
        of the vehicle (m, 3, 3).
    """
    lever_v = np.einsum("nji,nj->ni", rotation, levers)
    normal_v = np.einsum("nji,nj->ni", rotation, normals)
    by_pose = np.hstack([normals, np.cross(lever_v, normal_v)])
    return np.asarray(
        np.sqrt(np.maximum(0.0, np.einsum("ni,nij,nj->n", by_pose, covariance, by_pose)))
    )
