# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Estimate the hull's surface from a survey's DVL returns, or landmarks where there is no DVL."""

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

Facts = dict[str, object]


@dataclass(frozen=True, kw_only=True)
class CadHull:
    """A hull with a CAD model, in M."""

    mesh: Mesh
    # As parameters of `chart_for_hull`
    up: Sequence[float] | Array = (0.0, 0.0, 1.0)
    bow: str | None = None
    aft_perpendicular_m: float | None = None

    def chart(self, points: Array, sensors: Array) -> Chart:
        """Make the chart of the CAD model. Points and sensors are not needed."""
        return chart_for_hull(self.mesh, self.up, self.bow, self.aft_perpendicular_m)

    def on_hull(self, label: Ints) -> Mask:
        """Tell which landmarks (n,) are labelled as on the CAD model's surface."""
        return np.asarray(label == 1)

    def deviation(self, vertices: Array) -> Array:
        """Compute signed distances (n,) m of vertices (n, 3) to the CAD model, outward positive."""
        return Scene(self.mesh).closest(vertices).distance

    def comparison(self, poses_are_adjusted: bool) -> Facts:
        """Say how far the surface depends on the CAD model that it is compared with.

        The members of surface.json are the surface from which offsets were regressed, and what a
        comparison with the CAD model is worth.
        """
        note = (
            "The surface is a regression of the returns' offsets from the CAD model and leans on "
            "it between and beyond returns: a comparison with the CAD model is partly circular."
        )
        if poses_are_adjusted:
            note += " The poses that place the returns were adjusted to the CAD model."
        return {"reference": "cad", "comparison": note}


@dataclass(frozen=True, kw_only=True)
class UnknownHull:
    """A hull without a CAD model: everything stays in g."""

    def chart(self, points: Array, sensors: Array) -> Chart:
        """Fit a plane or a cylinder to points (n, 3), with normals towards the sensors (k, 3)."""
        return chart_for_points(points, toward=sensors)

    def on_hull(self, label: Ints) -> Mask:
        """Take every landmark (n,), as labels are not known."""
        return np.ones(len(label), bool)

    def deviation(self, vertices: Array) -> Array:
        """Return NaN (n,), as there is no CAD model."""
        return np.full(len(vertices), np.nan)

    def comparison(self, poses_are_adjusted: bool) -> Facts:
        """Say that offsets are from the survey's own chart, with no CAD model to compare with."""
        return {"reference": "survey", "comparison": None}


HullReference = CadHull | UnknownHull
OUTLIER_NEIGHBOURS = 30  # neighbours with which a return is compared [Ozog2016 3.2.2.1]
# From points (n, 3), their chart and positions of the sensors (k, 3), chooses the chart on which
# offsets are regressed, or a plane from which heights are, with facts for surface.json
Reference = Callable[[Array, Chart, Array], tuple[Chart, PlaneChart | None, Facts]]


def own_chart(
    points: Array, chart: Chart, sensors: Array
) -> tuple[Chart, PlaneChart | None, Facts]:
    """Regress offsets from the chart's own base surface."""
    return chart, None, {}


@dataclass(frozen=True, kw_only=True)
class SurfaceInputs:
    """The inputs of a surface."""

    hull: HullReference
    track: VehicleTrack  # of the vehicle, in the surface's frame
    rig: Rig
    returns: Returns | None  # None where no DVL was carried
    range_sigma_m: float  # independent part of a range's sigma
    solution: Solution | None  # None before the adjustment
    chart: Chart | None  # of the adjustment. None: it is made here


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

    It is made of DVL returns without outliers. Landmarks are added if the options say so, and serve
    alone where no DVL was carried.

    Parameters
    ----------
    survey
        Path, returns, landmarks, and the CAD model if there is one.
    options
        The section [surface] of dive.toml.
    regression
        The method of regression.
    reference
        Chooses the surface from which offsets are regressed. By default it is the chart's own.

    Raises
    ------
    StageError
        Where there are too few returns and landmarks.
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
    if len(landmarks.points) and (options.landmarks or not len(returns.points)):
        measured = _measure_landmarks(landmarks, survey, chart)
        # Landmarks sharpen the surface where returns are, and extend it only without any returns
        alone = np.full(len(measured), not len(returns.points))
        observed = observed.followed_by(replace(measured, gives_support=alone))
    # The regression
    regressed_on, datum, said = reference(observed.point, chart, sensors)
    surface, facts = build_surface(observed, regressed_on, options, datum, regression)
    return ChartedResult(
        surface=replace(surface, deviation=survey.hull.deviation(surface.vertices)),
        chart=chart,
        facts={**facts, **survey.hull.comparison(survey.solution is not None), **said, **counts},
    )


@dataclass(frozen=True, kw_only=True)
class _ReturnPoints:
    """The ends of the beams that are used."""

    points: Array  # (n, 3) m
    node: Ints  # (n,) node to which each return is attached


def _points_of_returns(
    survey: SurfaceInputs, options: SurfaceOptions
) -> tuple[_ReturnPoints, Facts]:
    """Compute the ends of the returns without flagged ones and outliers, and count these.

    Empty where no DVL was carried. The counts are members of surface.json.
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
    """Tell which points (n, 3) are used: finite ones, not flagged (n,), and no outliers.

    Raises StageError with fewer than four.
    """
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
    """Select landmarks on the hull with three observations or more, without outliers.

    Left out are those without a covariance. Empty before the adjustment.
    """
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
    """Compute the landmarks' sigmas along the normals: their own, and that common to neighbours.

    Errors of the hull's pose and of the path's position are common to neighbours.
    """
    _, normals = chart.from_chart(chart.to_chart(landmarks.points)[:, :2])
    # Off the chart there is no normal: such points are left out later
    pose = survey.solution.hull_pose if survey.solution is not None else None
    along = variance_along_normals(
        landmarks.points, np.nan_to_num(normals), landmarks.covariance, pose
    )
    return SurfacePoints(
        point=landmarks.points,
        noise=np.sqrt(along.own),
        pose_sigma=np.sqrt(along.common),
        gives_support=np.zeros(len(landmarks.points), bool),
    )


def _add_sigmas(returns: _ReturnPoints, survey: SurfaceInputs, chart: Chart) -> SurfacePoints:
    """Give returns the sigma of their ranges, and that of their nodes' poses along the normals.

    Neighbours share a pose's error, so the regression does not average it away.
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


def statistical_inliers(
    points: Array, neighbours: int = OUTLIER_NEIGHBOURS, deviations: float = 1.0
) -> Mask:
    """Tell which points (n, 3) are not far from their neighbours [Rusu2008; Ozog2016 3.2.2.1].

    All are inliers where there are fewer than two. A point is an inlier if its mean distance to its
    neighbours is at most `deviations` standard deviations above the mean of all. [Ozog2016] takes
    30 neighbours and one standard deviation.
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

    `sigma_m` (3,): of the guess along M's axes. It is added to the covariance, of which it soon is
    the largest part.
    """
    hull_from_global = global_from_hull.inverse()
    # Translations are turned into M. Rotations are in the vehicle's axes, and stay as they are.
    turn = np.zeros((6, 6))
    turn[:3, :3], turn[3:, 3:] = hull_from_global.rotation.as_matrix()[0], np.eye(3)
    covariance = turn @ track.covariance @ turn.T
    covariance[:, :3, :3] += np.diag(np.square(sigma_m))
    return replace(
        track, poses=hull_from_global @ track.poses, covariance=covariance, frame=Frame.HULL
    )


def pose_sigma_along(normals: Array, levers: Array, covariance: Array, rotation: Array) -> Array:
    """Compute the sigmas (n,) m of points along normals due to the vehicle's poses.

    A point R p + t moves by dt + R (w x p).

    Parameters
    ----------
    normals
        Unit vectors (n, 3) in the result's frame, along which the sigmas are.
    levers
        (n, 3) m from the vehicle to the points, in the result's frame.
    covariance
        (n, 6, 6) of the poses: translation, then rotation perturbed on the right in v.
    rotation
        Rotations R (n, 3, 3) of the vehicle, by which levers and normals are turned into its axes.
    """
    lever_v = np.einsum("nji,nj->ni", rotation, levers)
    normal_v = np.einsum("nji,nj->ni", rotation, normals)
    # n . (dt + R (w x p)) = n . dt + (p x R^T n) . w, with p and R^T n in the vehicle's axes
    by_pose = np.hstack([normals, np.cross(lever_v, normal_v)])
    return np.asarray(
        np.sqrt(np.maximum(0.0, np.einsum("ni,nij,nj->n", by_pose, covariance, by_pose)))
    )
