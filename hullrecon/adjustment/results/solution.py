# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The Solution record of an adjusted dive: unknowns and covariances in the results' frame."""

from __future__ import annotations

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
from hullrecon.memory import return_free_memory
from hullrecon.records.solution import DeviationField, HullPose, Landmarks, Solution
from hullrecon.typing import Array, Ints

POINTS = 1 << 16  # whose covariances are turned at a time: they take some 700 bytes each


def marginal_covariances(m: Measurements, adjusted: Adjusted) -> native.Covariance:
    """Compute the covariances at the solution.

    Poses and landmarks: what the measurements leave open with the hull's pose held and its form
    free. The hull's pose: what the CAD model's error leaves open. In the solve itself, a field and
    many beams with white noise are surer of that pose than so few cells of the CAD model's error
    allow (docs/adr/0011). A part of the field that moves the hull as a whole is that error, and is
    counted there. Sensors' errors: those of a solve in which the hull is free, as its height and a
    bias of the depth cannot be told apart.

    Without a deviation field, covariances are the solve's own.
    """
    return_free_memory()  # of the last solve
    hull = adjusted.state.hull
    if hull is None:
        return join.covariance(adjusted.problem, adjusted.plan, adjusted.settings)
    # The last round holds the hull where its profile put it; here it is free again.
    has_field = adjusted.strategy.deviation_field
    free = join.covariance(
        adjusted.problem.free("T_g_M"),
        adjusted.plan,
        adjusted.settings,
        of_landmarks=not has_field,
    )
    if not has_field:
        return free
    evidence = adjusted.placement.evidence if adjusted.placement is not None else None
    evidence = evidence or _evidence_afterwards(m, adjusted, hull)
    held = _placed(adjusted.problem, evidence, hull)
    placed = join.covariance(held, adjusted.plan, adjusted.settings)
    return replace(
        placed,
        navigation=free.navigation,
        deviation=free.deviation,
        T_g_M=estimate.hull_pose_covariance(evidence, hull.global_from_hull),
    )


def _placed(
    problem: native.Problem, evidence: estimate.HullPoseEvidence, hull: HullState
) -> native.Problem:
    """Hold the hull's pose, and what of the field the fit of that pose takes for a motion."""
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


def _evidence_afterwards(
    m: Measurements, adjusted: Adjusted, hull: HullState
) -> estimate.HullPoseEvidence:
    """Collect the evidence of the hull's pose from a single solve, which did not hold it."""
    points = estimate.collect_hull_points(m, adjusted.state, adjusted.chosen, adjusted.result.label)
    return estimate.fit_hull_pose(
        points, hull.global_from_hull, hull.cad_model, hull.survey_center
    )[0]


def build_solution(m: Measurements, adjusted: Adjusted, marginals: native.Covariance) -> Solution:
    """Build the record of the adjusted dive. m: its rig as calibrated."""
    state, used = adjusted.state, adjusted.chosen.landmarks
    position = state.landmark[used]
    pose_covariance, landmark_covariance = _covariances(state, position, marginals)
    label, deviation = _labels(adjusted, len(used))
    return Solution(
        t_ns=m.trajectory.t_ns,
        image=m.trajectory.image,
        global_from_vehicle=state.nodes,
        tray=state.tray,
        tray_sigma=np.sqrt(np.maximum(marginals.pose[:, 6, 6], 0)),
        pose_covariance=pose_covariance + _lever_arm(m, state),
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
    if hull is None:
        return None
    return HullPose(
        global_from_hull=hull.global_from_hull,
        covariance=marginals.T_g_M,
        survey_center=hull.survey_center,
    )


def _deviation_field(hull: HullState | None, marginals: native.Covariance) -> DeviationField | None:
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
    """Compute covariances of poses (n, 6, 6) and landmarks (L, 3, 3), in M with a CAD model."""
    if state.hull is None:
        return marginals.pose[:, :6, :6], marginals.landmark
    pose, center, hull = state.hull.global_from_hull, state.hull.survey_center, marginals.T_g_M
    nodes = poses_in_hull(
        marginals.pose[:, :6, :6], marginals.pose_T_g_M[:, :6], hull, state.nodes, pose, center
    )
    landmarks = np.empty_like(marginals.landmark)
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
    return nodes, landmarks


def _lever_arm(m: Measurements, state: State) -> Array:
    """Compute what the held position of the DVL adds to the poses' covariance (n, 6, 6).

    Images and ranges see camera and DVL. A shift of both on the tray moves the vehicle alone, and
    nothing measures it.
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
    """Look up label and signed distance to the CAD model of each landmark.

    Label 0 and NaN without a CAD model.
    """
    if adjusted.state.hull is None or not count:
        return np.zeros(count, np.int64), np.full(count, np.nan)
    return adjusted.result.label.astype(np.int64), adjusted.result.distance
