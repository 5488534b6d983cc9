# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The sources' figures of scenes that need no dive."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon import native
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import exp, pose_from_vector
from hullrecon.navigation.planes.planar_graph import PlanarGraph
from hullrecon.navigation.pose_graph.graph import OPTIONS, GraphSolution, PoseGraph
from hullrecon.records.links import no_links
from hullrecon.studies.figure_style import PublishedFigure
from hullrecon.studies.scenes.ellipsoid_dive import (
    POLE_DEPTH_M,
    EllipsoidDive,
    spiral_around_a_sphere,
)
from hullrecon.studies.scenes.gic_by_relief import CriterionTrials, gic_by_relief
from hullrecon.studies.scenes.search_ellipses import TransferredPoints, search_ellipses
from hullrecon.studies.scenes.sphere import MappedSphere, SphereSurvey, sphere
from hullrecon.typing import Array
from hullrecon.vision.pairs import two_view
from hullrecon.vision.pairs.gating import Motion, transfer

CAMERA = CameraModel(width=1360, height=1024, fx=1200.0, fy=1200.0, cx=679.5, cy=511.5)
PIXEL_SIGMA = 1.0
PIXEL_IDEAL = PIXEL_SIGMA / CAMERA.fx  # in ideal coordinates
DISTANCE_M, BASELINE_M = 1.5, 0.3
SECOND_FROM_FIRST = exp([[-BASELINE_M, 0.0, 0.0, *np.radians([1.0, 5.0, 0.5])]])

PEAKS_M = np.array([0, 5, 10, 20, 30, 50, 100, 200, 400]) * 1e-3
PEAKS_SIZE_M = np.array([1.0, 0.7])
PEAKS_POINTS, PEAKS_TRIALS = 100, 25

POSE_SIGMAS = {
    "1 cm and 0.5°": (0.01, 0.5),
    "5 cm and 2°": (0.05, 2.0),
    "15 cm and 6°": (0.15, 6.0),
}  # m, degrees about each axis
DEPTH_SIGMA_M = 0.05
SAMPLES = 3000

# radius, turns around it, drift of the heading in degrees an hour
SPHERE_M, SPHERE_TURNS, SPHERE_DRIFT = 10.0, 2.0, 20.0
CHARACTERISTIC_M = (4.0, 6.0, 10.0, 14.0, 20.0)


def draw_scene_figures() -> list[PublishedFigure]:
    """Draw [KimEustice2009 Fig. 2], [Ozog2016 Figs D.4, C.1, C.2], computed anew."""
    return [
        gic_by_relief(criterion_trials()),
        search_ellipses(transferred_points(), (CAMERA.width, CAMERA.height)),
        sphere(sphere_survey()),
    ]


def criterion_trials() -> dict[str, CriterionTrials]:
    """Score both two-view models on noisy views of MATLAB's peaks.

    Outliers count in full, as in [KimEustice2009 III-B], and capped, as in two_view.
    """
    rng = np.random.default_rng(0)
    full, capped = np.empty((2, 2, len(PEAKS_M), PEAKS_TRIALS))
    for k, peak_m in enumerate(PEAKS_M):
        for trial in range(PEAKS_TRIALS):
            both = two_view.fit_both(*views_of_peaks(rng, float(peak_m)), 2 * PIXEL_IDEAL)
            assert both is not None  # a hundred matches without outliers
            for of, (found, size) in enumerate(
                ((both.homography, two_view.HOMOGRAPHY), (both.essential, two_view.ESSENTIAL))
            ):
                penalty = two_view.criterion(np.zeros(PEAKS_POINTS), *size)
                full[of, k, trial] = found.squared_error.sum() / PIXEL_IDEAL**2 + penalty
                capped[of, k, trial] = found.criterion
    return {
        "as published": CriterionTrials(peak_m=PEAKS_M, homography=full[0], essential=full[1]),
        "outliers capped (the software)": CriterionTrials(
            peak_m=PEAKS_M, homography=capped[0], essential=capped[1]
        ),
    }


def views_of_peaks(rng: np.random.Generator, peak_m: float) -> tuple[Array, Array]:
    """Project points of MATLAB's peaks into two cameras, with pixel noise: (n, 2) in each.

    Coordinates are ideal. The middle of the surface lies DISTANCE_M ahead of the middle of both
    cameras. Its peaks rise towards them.
    """
    across = PEAKS_SIZE_M * rng.uniform(-0.5, 0.5, (PEAKS_POINTS, 2))
    height = peak_m * peaks(*(6 * across / PEAKS_SIZE_M).T)
    points = np.column_stack([across + np.array([0.5 * BASELINE_M, 0.0]), DISTANCE_M - height])
    return seen_twice(rng, points, PIXEL_IDEAL)


def seen_twice(rng: np.random.Generator, points: Array, sigma: float) -> tuple[Array, Array]:
    """Project points (n, 3) into both views (n, 2), with noise in ideal coordinates."""
    noise = sigma * rng.standard_normal((2, len(points), 2))
    there = SECOND_FROM_FIRST.apply(points)
    return points[:, :2] / points[:, 2:] + noise[0], there[:, :2] / there[:, 2:] + noise[1]


def peaks(x: Array, y: Array) -> Array:
    """Evaluate MATLAB's peaks for x and y from -3 to 3, scaled to a highest peak of 1."""
    first = 3 * (1 - x) ** 2 * np.exp(-(x**2) - (y + 1) ** 2)
    middle = 10 * (x / 5 - x**3 - y**5) * np.exp(-(x**2) - y**2)
    last = np.exp(-((x + 1) ** 2) - y**2) / 3
    return np.asarray((first - middle - last) / 8.1062)


def transferred_points() -> dict[str, TransferredPoints]:
    """Transfer a grid of pixels to a second camera, by PCCS and by sampling.

    A 4 x 4 grid of a scene DISTANCE_M away. Samples draw pose, depth and both images' noise.
    Returns the points by the name of the pose's sigmas.
    """
    rng = np.random.default_rng(0)
    columns, rows = np.meshgrid(
        (np.arange(4) + 0.5) * CAMERA.width / 4, (np.arange(4) + 0.5) * CAMERA.height / 4
    )
    xy = CAMERA.undistort(np.column_stack([columns.ravel(), rows.ravel()]))
    depth, depth_sigma = np.full(len(xy), DISTANCE_M), np.full(len(xy), DEPTH_SIGMA_M)
    found = {}
    for name, (sigma_m, sigma_deg) in POSE_SIGMAS.items():
        sigma = np.repeat([sigma_m, np.radians(sigma_deg)], 3)
        motion = Motion(SECOND_FROM_FIRST.matrix()[0], np.diag(sigma**2))
        mean, covariance = transfer(motion, xy, depth, depth_sigma, PIXEL_IDEAL)
        found[name] = TransferredPoints(
            mean=CAMERA.distort(mean),
            covariance=CAMERA.fx**2 * covariance,
            samples=np.stack([_sampled(rng, point, sigma) for point in xy]),
        )
    return found


def _sampled(rng: np.random.Generator, xy: Array, sigma: Array) -> Array:
    """Draw where a point of the first image falls in the second, px (SAMPLES, 2).

    xy: (2,) ideal coordinates of the point. sigma: (6,) of the motion's translation, in the second
    camera's axes, and of its rotation, perturbed on the right.
    """
    errors = sigma * rng.standard_normal((SAMPLES, 6))
    seen = xy + PIXEL_IDEAL * rng.standard_normal((SAMPLES, 2))
    depth = DISTANCE_M + DEPTH_SIGMA_M * rng.standard_normal((SAMPLES, 1))
    turn = exp(np.hstack([np.zeros((SAMPLES, 3)), errors[:, 3:]]))
    there = (
        SECOND_FROM_FIRST.apply(turn.apply(depth * np.hstack([seen, np.ones((SAMPLES, 1))])))
        + errors[:, :3]
    )
    return CAMERA.project(there) + PIXEL_SIGMA * rng.standard_normal((SAMPLES, 2))


def sphere_survey() -> SphereSurvey:
    """Simulate a spiral around a sphere and solve it with and without planes."""
    dive = spiral_around_a_sphere(
        5, radius_m=SPHERE_M, turns=SPHERE_TURNS, drift_deg_per_hour=SPHERE_DRIFT
    )
    graph = PoseGraph(
        trajectory=dive.trajectory, odometry=dive.odometry, attitude=dive.attitude, rig=dive.rig
    )
    planes = {}
    for radius in CHARACTERISTIC_M:
        curvature = np.array([1.0, 0.3, 1.0]) / radius  # azimuth, twist, elevation
        solved = PlanarGraph(graph=graph, returns=dive.returns, curvature=curvature).solve(
            no_links()
        )
        planes[radius] = _mapped(dive, solved)
    return SphereSurvey(
        radius_m=SPHERE_M,
        middle=np.array([SPHERE_M, 0.0, POLE_DEPTH_M]),
        truth=dive.truth.translation,
        reckoned=_mapped(dive, graph.solve(no_links())),
        planes=planes,
    )


def _mapped(dive: EllipsoidDive, solved: GraphSolution) -> MappedSphere:
    """Read path, sigma and beams' ends from a solution, with the DVL's mount as found."""
    found = replace(dive.rig, tray_from_dvl=pose_from_vector(solved.problem.unknowns.T_s_d))
    position = native.covariance(solved.problem, OPTIONS).pose[:, :3, :3]
    return MappedSphere(
        path=solved.path.poses.translation,
        sigma=np.sqrt(np.trace(position, axis1=1, axis2=2)),
        points=found.dvl_points(dive.returns, solved.path).points,
    )
