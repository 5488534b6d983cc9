# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Registration of DVL returns to the CAD model [Ozog2016 4.2.5] (docs/methods.md 5).

Generalised ICP from a grid of starts finds the basin. It treats points as independent, though a CAD
model that is wrong by centimetres over metres shifts neighbouring points alike. So the last step is
a generalised least-squares fit, whose noise holds the CAD model's error as a Matern 3/2 field over
the chart, together with the package's prior. Its covariance says what the geometry resolves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, TypeVar

import numpy as np
from scipy.linalg import cho_factor
from scipy.spatial import cKDTree

from hullrecon.adjustment.hull_pose import cad_error
from hullrecon.adjustment.hull_pose.pose_cost import (
    HullPoseCost,
    perturb_pose,
    prior_step,
    signed_distances,
)
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry import poses
from hullrecon.geometry.meshes.mesh import Mesh, face_areas
from hullrecon.geometry.open3d_import import import_open3d
from hullrecon.geometry.pose_solver import minimise_over_pose
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array

Key = TypeVar("Key")
# Share of points within three sigma of the CAD model from which it is the hull that was surveyed
GOOD_FITNESS = 0.6
# Another interpretation of the ranges has to lower the RMS distance to this share. Two that fit
# equally well by chance differ to 0.9, wrong orders of a dive's beams give 0.55 and more, the right
# one 0.17.
FITS_BETTER = 0.5
# Root mean square of the distances to the CAD model, in the sigma of a range and of the CAD model,
# beyond which no interpretation fits: a package may be mistaken by a factor of two
# (docs/adr/0010). Right ones have 0.6, and those that fit best at a wrong hull.pose 4 to 11.
FITS_SIGMAS = 2.0
# Sigma of a guess that may be far off: m, rad in the ship's axes (forward, port, up)
DISTANT_SIGMA = np.r_[5.0, 2.0, 0.5, np.radians([2.0, 2.0, 15.0])]
DISTANT_STARTS = 8  # of the coarse grid, from which ICP starts
GUESS_SIGMAS = 3.5  # beyond which the package's guess is contradicted
# Sigma of the guess's height from which a hull may fit at several heights: without a measured depth
# the height is known to metres, and the faces of a bilge lie this far apart
OPEN_HEIGHT_M = 0.6
FEW_CELL_M, FEW_POINTS = 0.1, 600  # voxels and most points of registrations that are only tried
FIT_ITERATIONS = 60  # of the last fit, at most
SAMPLES = 20_000  # points sampled on the CAD model's faces
NEAR_M = 3.0  # largest distance from the survey of faces that are sampled
KEPT_M = 4.0  # largest distance from the survey of samples that are kept


@dataclass(frozen=True, kw_only=True)
class Registration:
    """The pose at which the CAD model fits surveyed points."""

    cad_model: CadModel  # the guess's sigmas are multiplied by `sigmas_off`
    sigmas_off: float  # error of the guess in its sigmas, at least 1
    global_from_hull: Poses  # a batch of one
    covariance: Array  # (6, 6) of (translation in g, rotation in M) about `center`
    center: Array  # (3,) m in M, of the survey
    residual: Array  # (n,) m, signed distances of the points used
    fitness: float  # share of points within three sigma


def register(points: Array, cad_model: CadModel, sigma_range: float, seed: int = 0) -> Registration:
    """Register the CAD model to points (n, 3) in g.

    Starts are the package's guess and a grid around it within its sigma. Where none of them fits,
    a coarse grid metres wide is searched for poses at which the points lie near the CAD model. Its
    result is taken only if it fits clearly better. Where the result lies far from the guess, the
    guess's sigmas are widened (`Registration.sigmas_off`).

    Parameters
    ----------
    points
        On the hull, from DVL returns or landmarks.
    cad_model
        The mesh, and the guess of its pose, which is the first start and the prior.
    sigma_range
        Sigma of a DVL range, m, the noise of a point.
    seed
        Decides which points are sampled on the CAD model for ICP.
    """
    kept = thin_points(points, voxel_m=0.10, most_points=2500)
    found = register_near(kept, cad_model, sigma_range, seed)
    center = found.center
    if found.fitness >= GOOD_FITNESS:
        return _with_wider_guess(found, kept, cad_model, sigma_range)
    starts = _distant_starts(kept, cad_model, center)
    # DISTANT_SIGMA is along the ship's axes, the guess's sigma along M's
    in_hull = np.abs(cad_model.chart.ship_axes.T)
    distant_sigma = np.r_[in_hull @ DISTANT_SIGMA[:3], in_hull @ DISTANT_SIGMA[3:]]
    loose = replace(cad_model, guess_sigma=cad_model.guess_sigma + distant_sigma)
    distant = _register_from(starts, kept, loose, center, sigma_range, seed)
    if distant.fitness < max(GOOD_FITNESS, found.fitness + 0.1):
        return found
    return _with_wider_guess(distant, kept, cad_model, sigma_range)


def register_near(
    points: Array, cad_model: CadModel, sigma_range: float, seed: int = 0
) -> Registration:
    """Register the CAD model to points (n, 3) in g within the sigma of the package's guess."""
    center = cad_model.guess.inverse().apply(points).mean(0)
    return _register_from(_starts(cad_model, center), points, cad_model, center, sigma_range, seed)


def _register_from(
    starts: list[Poses],
    points: Array,
    cad_model: CadModel,
    center: Array,
    sigma_range: float,
    seed: int,
) -> Registration:
    """Run generalised ICP from each start, and refine the best of the results.

    Parameters
    ----------
    starts
        Poses global_from_hull. The first is a candidate itself.
    points
        (n, 3) m in g, on the hull.
    cad_model
        The mesh, its guess as prior, and its stated error as noise of the fit.
    center
        (3,) m in M, of the survey.
    sigma_range
        Sigma of a DVL range, m, the noise of a point.
    seed
        Decides which points are sampled on the CAD model.
    """
    target = _target_cloud(
        cad_model.mesh, np.vstack([start.inverse().apply(points[::10]) for start in starts]), seed
    )
    candidates = [*(_gicp(points, target, starts) if len(target) else []), starts[0]]
    distances = [
        np.abs(cad_model.mesh.index.closest(pose.inverse().apply(points)).distance)
        for pose in candidates
    ]
    costs = [
        trimmed_cost(distance, pose, cad_model, center)
        for distance, pose in zip(distances, candidates, strict=True)
    ]
    return fit_correlated(points, candidates[int(np.argmin(costs))], cad_model, center, sigma_range)


def _distant_starts(points: Array, cad_model: CadModel, center: Array) -> list[Poses]:
    """Find the DISTANT_STARTS poses of a coarse grid at which points (n, 3) in g fit best.

    The grid reaches 8 m along the hull, 2 m across and 25 degrees in yaw from the guess of
    `cad_model`. Yaw turns about `center` (3,) in M. Of the distances of some 400 points, the
    largest fifth is not counted, as structures and outliers are far off at any pose.
    """
    hull_from_ship = cad_model.chart.ship_axes.T
    rotate = cad_model.guess.rotation.as_matrix()[0] @ hull_from_ship
    few = points[:: max(1, len(points) // 400)]
    found: list[tuple[float, int, Poses]] = []
    for along, across, yaw in product(
        np.arange(-8.0, 8.1, 1.0), (-2.0, 0.0, 2.0), np.radians(np.arange(-25, 26, 5.0))
    ):
        step = np.r_[rotate @ np.array([along, across, 0.0]), hull_from_ship @ [0.0, 0.0, yaw]]
        pose = perturb_pose(cad_model.guess, center, step)
        distance = np.sort(np.abs(cad_model.mesh.index.closest(pose.inverse().apply(few)).distance))
        found.append((float(np.mean(distance[: int(0.8 * len(distance))])), len(found), pose))
    return [pose for _, _, pose in sorted(found, key=lambda entry: entry[:2])[:DISTANT_STARTS]]


def _with_wider_guess(
    found: Registration, points: Array, cad_model: CadModel, sigma_range: float
) -> Registration:
    """Repeat the fit with the guess of `cad_model` as prior, and widen its sigmas if contradicted.

    Where the fit lies farther from the guess than GUESS_SIGMAS, all sigmas of the guess are
    multiplied so that it lies within one sigma: a guess that is wrong in one direction cannot be
    trusted in the others.

    Parameters
    ----------
    found
        The registration, maybe found with other sigmas of the guess.
    points
        (n, 3) m in g, on the hull.
    cad_model
        The mesh, and the guess with the sigmas that the package states.
    sigma_range
        Sigma of a DVL range, m, the noise of a point.
    """
    step = prior_step(found.global_from_hull, cad_model, found.center)
    off = float(np.abs(step / cad_model.guess_sigma).max())
    if off <= GUESS_SIGMAS and found.cad_model is cad_model:
        return found
    if off <= GUESS_SIGMAS:  # found with wider sigmas, but near the guess after all
        return fit_correlated(points, found.global_from_hull, cad_model, found.center, sigma_range)
    wider = replace(cad_model, guess_sigma=cad_model.guess_sigma * off, contradicted=True)
    again = fit_correlated(points, found.global_from_hull, wider, found.center, sigma_range)
    return replace(again, sigmas_off=off)


def thin_points(points: Array, voxel_m: float, most_points: int) -> Array:
    """Average points (n, 3) m in voxels, whose side grows until at most `most_points` remain.

    Then legs with more points count no more, and a fit with a dense covariance takes little time.
    """
    while True:
        cell = np.floor(points / voxel_m).astype(np.int64)
        _, owner = np.unique(cell, axis=0, return_inverse=True)
        count = np.bincount(owner)
        if len(count) <= most_points:
            return np.stack([np.bincount(owner, points[:, k]) / count for k in range(3)], axis=1)
        voxel_m *= 1.25


def few_points(points: Array) -> Array:
    """Thin points (n, 3) for registrations of which many are tried."""
    return thin_points(points, FEW_CELL_M, FEW_POINTS)


def _starts(cad_model: CadModel, center: Array) -> list[Poses]:
    """List poses global_from_hull to start from: the guess, and poses around it.

    They are one sigma off it along the hull and in yaw, and at other heights. center: (3,) m in M,
    about which the hull is turned.
    """
    rotate = cad_model.guess.rotation.as_matrix()[0]
    forward, _, up = cad_model.chart.ship_axes
    starts = []
    for along in (0.0, -1.0, 1.0):
        for yaw in (0.0, -1.0, 1.0):
            shift = rotate @ (along * forward * cad_model.guess_sigma[:3])
            turn = yaw * up * cad_model.guess_sigma[3:]
            starts.append(perturb_pose(cad_model.guess, center, np.r_[shift, turn]))
    return [*starts, *at_other_heights(cad_model.guess, cad_model, center)]


def at_other_heights(pose: Poses, cad_model: CadModel, center: Array) -> list[Poses]:
    """Move a pose up and down by half a sigma and by one sigma of the guess's height.

    A fit ends at the nearest height at which the hull's faces fit, so several are tried. Empty
    where that sigma is below OPEN_HEIGHT_M, as where depth was measured: the height of the guess is
    good enough then.

    Parameters
    ----------
    pose
        Pose global_from_hull that is moved.
    cad_model
        The sigmas of its guess say how far up and down, and its chart which way is up.
    center
        (3,) m in M, of the survey.
    """
    up = cad_model.chart.ship_axes[2]
    shift = pose.rotation.as_matrix()[0] @ (up * cad_model.guess_sigma[:3])
    if np.linalg.norm(shift) < OPEN_HEIGHT_M:
        return []
    return [
        perturb_pose(pose, center, np.r_[sigmas * shift, np.zeros(3)])
        for sigmas in (-1.0, -0.5, 0.5, 1.0)
    ]


def _target_cloud(mesh: Mesh, near: Array, seed: int) -> Array:
    """Sample points (k, 3) m in M, uniform by area, on the CAD model's faces near the survey.

    Empty where no face lies within NEAR_M of it.

    Parameters
    ----------
    mesh
        The CAD model, in M.
    near
        (n, 3) m in M, surveyed points at the starts. Samples within KEPT_M of them are kept.
    seed
        Decides which points are sampled.
    """
    corner = mesh.vertices[mesh.faces]
    middle = corner.mean(1)
    reach = np.linalg.norm(corner - middle[:, None], axis=2).max(1)
    distance, _ = cKDTree(near).query(middle, distance_upper_bound=NEAR_M + reach.max())
    part = Mesh(mesh.vertices, mesh.faces[distance <= NEAR_M + reach])
    if len(part.faces) == 0:
        return np.zeros((0, 3))  # a CAD model in other units, or guessed far off
    area = face_areas(part)
    rng = np.random.default_rng(seed)
    face = rng.choice(len(area), SAMPLES, p=area / area.sum())
    # Uniform in a triangle: the half of the unit square beyond its diagonal is folded back
    u, v = rng.random((2, SAMPLES))
    fold = u + v > 1
    u[fold], v[fold] = 1 - u[fold], 1 - v[fold]
    a, b, c = part.vertices[part.faces[face]].transpose(1, 0, 2)
    samples = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    distance, _ = cKDTree(near).query(samples, distance_upper_bound=KEPT_M)
    return np.asarray(samples[np.isfinite(distance)])


def _gicp(points: Array, target: Array, starts: list[Poses]) -> list[Poses]:
    """Register points (n, 3) in g to samples `target` (k, 3) in M by generalised ICP.

    Returns the registered pose global_from_hull for each start, itself such a pose.
    """
    o3d = import_open3d()

    def cloud(xyz: Array) -> Any:
        out = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(xyz))
        out.estimate_normals(o3d.geometry.KDTreeSearchParamKNN(20))
        return out

    register = o3d.pipelines.registration
    surveyed, sampled = cloud(points), cloud(target)
    found = [
        register.registration_generalized_icp(
            surveyed,
            sampled,
            1.0,  # m, largest distance of a pair
            start.inverse().matrix()[0],
            register.TransformationEstimationForGeneralizedICP(),
            register.ICPConvergenceCriteria(max_iteration=40),
        ).transformation
        for start in starts
    ]
    # ICP's sums differ in the last digit from call to call. Rounding makes the result repeatable.
    return [poses.from_matrix(np.round(each, 6)).inverse() for each in found]


def rms_m(found: Registration) -> float:
    """Compute the root mean square of the distances from the CAD model, m."""
    return float(np.sqrt(np.mean(np.square(found.residual))))


def fits_far_better(
    as_is: Registration, others: Mapping[Key, Registration], range_sigma_m: float
) -> Key | None:
    """Choose the interpretation of ranges that fits the CAD model best. None if none is far better.

    None too where even the best leaves distances that neither ranges nor the CAD model have: where
    hull.pose is wrong, one interpretation is better than the others by chance.

    Parameters
    ----------
    as_is
        Registration to the ranges as they were interpreted.
    others
        Registrations to other interpretations, by a key of each.
    range_sigma_m
        Sigma of a DVL range.
    """
    most_m = FITS_SIGMAS * float(np.hypot(range_sigma_m, as_is.cad_model.deviation_sigma))
    fits = {
        key: rms_m(one)
        for key, one in others.items()
        if one.fitness >= GOOD_FITNESS and rms_m(one) <= most_m
    }
    best = min(fits, key=lambda key: fits[key], default=None)
    return None if best is None or fits[best] > FITS_BETTER * rms_m(as_is) else best


def share_within(points: Array, found: Registration, sigma_range: float) -> float:
    """Compute the share of points (n, 3) m in g within three sigma of the registered CAD model.

    sigma_range: of a point along its beam, m. The CAD model's own error is added to it.
    """
    distance = found.cad_model.mesh.index.closest(
        found.global_from_hull.inverse().apply(points)
    ).distance
    return _share_within(distance, found.cad_model, sigma_range)


def _share_within(distance: Array, cad_model: CadModel, sigma_range: float) -> float:
    return float(np.mean(np.abs(distance) < 3 * np.hypot(sigma_range, cad_model.deviation_sigma)))


def trimmed_cost(
    distance: Array, global_from_hull: Poses, cad_model: CadModel, center: Array
) -> float:
    """Compute the cost by which starts are compared: robust distances and the prior.

    It is the mean square of the smallest 80 % of distances, in the CAD model's sigma, plus the mean
    square of the prior's whitened step. So a start cannot win by a few points alone, nor far from
    the guess.

    Parameters
    ----------
    distance
        (n,) m, of the points to the CAD model, not negative.
    global_from_hull
        The pose that is judged.
    cad_model
        Gives the guess with its sigmas, and the sigma of distances.
    center
        (3,) m in M, at which the pose is compared with the guess.
    """
    trimmed = np.sort(distance)[: max(1, int(0.8 * len(distance)))]
    prior = prior_step(global_from_hull, cad_model, center) / cad_model.guess_sigma
    return float(
        np.mean(trimmed**2) / cad_model.deviation_sigma**2
        + prior @ prior / len(cad_model.guess_sigma)
    )


def fit_correlated(
    points: Array,
    start: Poses,
    cad_model: CadModel,
    center: Array,
    sigma_range: float,
) -> Registration:
    """Fit the hull's pose by generalised least squares with a correlated error of the CAD model.

    Outliers are weighted down once, by their distance at the start. Weights that changed with the
    pose would change the cost from step to step, and the iterations might not end.

    Parameters
    ----------
    points
        (n, 3) m in g, on the hull.
    start
        Pose to start from.
    cad_model
        The mesh, its guess as prior, and its stated error as noise of the fit.
    center
        (3,) m in M, about which steps turn.
    sigma_range
        Sigma of a DVL range, m, the noise of a point that is no outlier.
    """
    # The noise of the points is added below, for each its own
    expected = replace(cad_error.expected_cad_error(cad_model), noise=0.0)
    field = cad_error.distance_covariance(expected, cad_model, start.inverse().apply(points))
    noise = _robust_sigmas(
        signed_distances(points, start, center, cad_model.mesh)[0],
        sigma_range,
        cad_model.deviation_sigma,
    )
    cost = HullPoseCost(
        points=points,
        cad_model=cad_model,
        center=center,
        factor=cho_factor(field + np.diag(noise**2)),
    )
    found = minimise_over_pose(
        start,
        cost.linearise,
        cost.update,
        max_iterations=FIT_ITERATIONS,
        min_relative_decrease=1e-6,
    )
    distance, _ = signed_distances(points, found.pose, center, cad_model.mesh)
    return Registration(
        cad_model=cad_model,
        sigmas_off=1.0,
        global_from_hull=found.pose,
        covariance=np.asarray(np.linalg.inv(found.at_minimum.information)),
        center=center,
        residual=distance,
        fitness=_share_within(distance, cad_model, sigma_range),
    )


def _robust_sigmas(distance: Array, sigma_range: float, sigma_field: float) -> Array:
    """Compute a sigma for each point, m (n,): that of a range, larger for outliers.

    Distances are compared with their median. Beyond 1.345 sigmas the sigma grows so that the weight
    is Huber's. Gross outliers, beyond three times that threshold, have a sigma ten times larger
    still, and hardly count.

    Parameters
    ----------
    distance
        (n,) m, signed, of the points to the CAD model at the start.
    sigma_range
        Sigma of a DVL range, m, that of a point which is no outlier.
    sigma_field
        Sigma of the CAD model's error, m, by which a point may be off too.
    """
    ratio = np.abs(distance - np.median(distance)) / (1.345 * np.hypot(sigma_range, sigma_field))
    return np.asarray(
        sigma_range * np.sqrt(np.maximum(1.0, ratio)) * np.where(ratio > 3, 10.0, 1.0)
    )
