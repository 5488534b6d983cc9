# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The Solution record of an adjusted dive: unknowns and covariances in the results' frame."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from hullrecon import native
from hullrecon.adjustment.bundle_adjustment import Adjusted
from hullrecon.adjustment.hull_pose import estimate
from hullrecon.adjustment.partition import join
from hullrecon.adjustment.problem.deviation_field import hold_combinations
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.state import HullState, State
from hullrecon.adjustment.results.covariance import points_in_hull, poses_in_hull
from hullrecon.geometry import poses
from hullrecon.memory import empty_array, release_pages, return_free_memory
from hullrecon.records.solution import DeviationField, HullPose, Landmarks, Solution
from hullrecon.typing import Array, Ints

POINTS = 1 << 16  # landmarks whose covariances are turned at a time, with some 700 bytes each


def marginal_covariances(m: Measurements, adjusted: Adjusted) -> native.Covariance:
    """Compute the covariances at the solution.

    They come from three problems, as no single one gives them all:

    - Poses and landmarks from the problem with the hull's pose held and the deviation field free,
      but for the parts of the field that would move the hull as a whole.
    - The hull's pose from its own fit, whose noise is the correlated error of the CAD model. In the
      solve, a field and many beams with white noise make it look better known than the few
      independent cells of that error allow (docs/adr/0011).
    - Errors of the sensors, and the field, from the problem with the hull's pose free, as the
      hull's height and a bias of the depths cannot be separated.

    Without a CAD model or a deviation field, all are those of the solve.
    """
    return_free_memory()  # of the last solve
    hull = adjusted.state.hull
    if hull is None:
        return join.covariance(adjusted.problem, adjusted.plan, adjusted.settings)
    # The last round holds the hull's pose. Here it is an unknown again.
    with_hull_free = adjusted.problem.free("T_g_M")
    if not adjusted.strategy.deviation_field:
        return join.covariance(with_hull_free, adjusted.plan, adjusted.settings)
    evidence = adjusted.placement.evidence if adjusted.placement is not None else None
    evidence = evidence or _evidence_of_solution(m, adjusted, hull)
    with ThreadPoolExecutor(1) as beside:  # it takes one core, and the problems all of them
        of_hull = beside.submit(estimate.hull_pose_covariance, evidence, hull.global_from_hull)
        free = join.covariance(with_hull_free, adjusted.plan, adjusted.settings, of_landmarks=False)
        held = _with_hull_held(adjusted.problem, evidence, hull)
        with_hull_held = join.covariance(held, adjusted.plan, adjusted.settings)
    return replace(
        with_hull_held,
        navigation=free.navigation,
        deviation=free.deviation,
        T_g_M=of_hull.result(),
    )


def _with_hull_held(
    problem: native.Problem, evidence: estimate.HullPoseEvidence, hull: HullState
) -> native.Problem:
    """Hold the hull's pose, and the parts of the deviation field that the fit takes for a motion.

    Those parts are in the covariance of the hull's pose, and would count twice.
    """
    held = problem.hold("T_g_M")
    if hull.grid is None:
        return held
    prior, added = hold_combinations(
        held.priors.deviation,
        hull.grid,
        estimate.field_as_motion(evidence, hull.global_from_hull, hull.grid),
        hull.cad_model.deviation_sigma,
    )
    nodes = np.r_[held.unknowns.deviation, np.zeros(added)]
    return replace(
        held,
        priors=replace(held.priors, deviation=prior),
        unknowns=replace(held.unknowns, deviation=nodes),
    )


def _evidence_of_solution(
    m: Measurements, adjusted: Adjusted, hull: HullState
) -> estimate.HullPoseEvidence:
    """Collect the points that determine the hull's pose at the solution.

    Needed where no pose was fitted before the last round, as with `adjust.rounds = 1`.
    """
    points = estimate.collect_hull_points(m, adjusted.state, adjusted.chosen, adjusted.result.label)
    return estimate.fit_hull_pose(
        points, hull.global_from_hull, hull.cad_model, hull.survey_center
    )[0]


def build_solution(m: Measurements, adjusted: Adjusted, marginals: native.Covariance) -> Solution:
    """Build the record of the adjusted dive: unknowns with covariances, in M with a CAD model.

    Parameters
    ----------
    m
        Measurements, with the rig as calibrated.
    adjusted
        The solution.
    marginals
        Covariances, as of `marginal_covariances`.
    """
    state, used = adjusted.state, adjusted.chosen.landmarks
    position = state.landmark[used]
    pose_covariance, landmark_covariance = _covariances(state, position, marginals)
    label, deviation = _labels(adjusted, len(used))
    return Solution(
        t_ns=m.trajectory.t_ns,
        image=m.trajectory.image,
        global_from_vehicle=state.nodes,
        tray=state.tray,
        # A pose has six rows, of translation and rotation, and one of the tray's angle
        tray_sigma=np.sqrt(np.maximum(marginals.pose[:, 6, 6], 0)),
        pose_covariance=pose_covariance + _covariance_by_dvl_position(m, state),
        landmarks=Landmarks(
            position=position,
            covariance=landmark_covariance,
            label=label,
            deviation=deviation,
            views=adjusted.chosen.rays[used].astype(np.int64),
            color=m.tracks.color[used] if m.tracks is not None else np.zeros((0, 3), np.uint8),
        ),
        mounts=state.mounts,
        navigation_errors=state.navigation,
        hull_pose=_hull_pose(state.hull, marginals),
        deviation_field=_deviation_field(state.hull, marginals),
        exposures=m.trajectory.exposures,
    )


def _hull_pose(hull: HullState | None, marginals: native.Covariance) -> HullPose | None:
    """Build the record of the hull's pose. None without a CAD model."""
    if hull is None:
        return None
    return HullPose(
        global_from_hull=hull.global_from_hull,
        covariance=marginals.T_g_M,
        survey_center=hull.survey_center,
    )


def _deviation_field(hull: HullState | None, marginals: native.Covariance) -> DeviationField | None:
    """Build the record of the deviation field with its sigmas. None without a field."""
    if hull is None or hull.grid is None:
        return None
    sigma = np.sqrt(np.maximum(marginals.deviation, 0))
    return DeviationField(
        origin=hull.grid.origin,
        step=hull.grid.step,
        value=hull.field.reshape(hull.grid.shape),
        sigma=sigma.reshape(hull.grid.shape),
    )


def _covariances(
    state: State, position: Array, marginals: native.Covariance
) -> tuple[Array, Array]:
    """Compute covariances of poses (n, 6, 6) and landmarks (l, 3, 3), in M with a CAD model.

    Parameters
    ----------
    state
        The solution.
    position
        Landmarks (l, 3) m in g, at which derivatives are taken.
    marginals
        Covariances in g. The seventh unknown of a node is the tray's angle, which no pose has.
    """
    if state.hull is None:
        return marginals.pose[:, :6, :6], marginals.landmark
    # The covariance of the hull's pose turns about the survey's middle (M), as the solve does
    pose, center, hull = state.hull.global_from_hull, state.hull.survey_center, marginals.T_g_M
    nodes = poses_in_hull(
        marginals.pose[:, :6, :6], marginals.pose_T_g_M[:, :6], hull, state.nodes, pose, center
    )
    # Landmarks may be millions, too many for memory at once
    landmarks = empty_array(marginals.landmark.shape, marginals.landmark.dtype)
    for first in range(0, len(landmarks), POINTS):
        some = slice(first, first + POINTS)
        landmarks[some] = points_in_hull(
            marginals.landmark[some],
            marginals.landmark_T_g_M[some],
            hull,
            position[some],
            pose,
            center,
        )
        release_pages(landmarks, marginals.landmark)
    return nodes, landmarks


def _covariance_by_dvl_position(m: Measurements, state: State) -> Array:
    """Compute what an error of the DVL's position adds to the poses' covariance (n, 6, 6).

    Images and ranges locate the camera and the DVL. Where both are shifted on the tray alike, the
    vehicle's positions shift, and no measurement shows it. The solve holds the DVL's position.
    """
    tray = state.nodes @ poses.tray_poses(m.rig.tray_origin, state.tray)
    in_hull = tray if state.hull is None else state.hull.global_from_hull.inverse() @ tray
    rotate = in_hull.rotation.as_matrix()
    out = np.zeros((len(state.nodes), 6, 6))
    out[:, :3, :3] = (
        rotate @ np.diag(m.rig.priors.dvl_position_sigma_m**2) @ rotate.transpose(0, 2, 1)
    )
    return out


def _labels(adjusted: Adjusted, count: int) -> tuple[Ints, Array]:
    """Look up each landmark's label and signed distance, m, to the CAD model, both (count,).

    Without a CAD model they are 0 and NaN.
    """
    if adjusted.state.hull is None or not count:
        return np.zeros(count, np.int64), np.full(count, np.nan)
    return adjusted.result.label.astype(np.int64), adjusted.result.distance
