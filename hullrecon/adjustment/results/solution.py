# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the adjustment leaves: the Solution record, the solver's record as arrays, and a summary in words and figures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon import native
from hullrecon.adjustment.bundle_adjustment import Adjusted
from hullrecon.adjustment.hull_pose import estimate
from hullrecon.adjustment.hull_pose.observability import find_weak_directions
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.problem import intrinsics, iteration_history, weighting
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.state import State, seven
from hullrecon.adjustment.results import residual_statistics
from hullrecon.adjustment.results.covariance import hull_axes, points_in_hull, poses_in_hull
from hullrecon.geometry import poses
from hullrecon.records.solution import DeviationField, HullPose, Landmarks, Mounts, Solution
from hullrecon.typing import Array, Ints

NAVIGATION = ("dvl_scale", "heading_drift_rad_s", "roll_bias_rad", "pitch_bias_rad", "depth_bias_m", "tray_play_rad")


@dataclass(frozen=True)
class Outcome:
    """solution; iterations: arrays for iterations.npz, and when each was done (s); summary: for adjust.json; warnings:
    sentences for the report."""

    solution: Solution
    iterations: dict[str, NDArray[Any]]
    iterations_s: Array
    summary: dict[str, Any]
    warnings: list[str]


def summarise_adjustment(m: Measurements, adjusted: Adjusted, options: AdjustOptions) -> Outcome:
    """m: as measured, its rig as calibrated."""
    settings = native.Options(method=options.method, sigma_on=options.sigma_on, sigma_off=options.sigma_off)
    marginals = _marginals(m, adjusted, options, settings)
    solution = _solution(m, adjusted, marginals)
    weak = [] if adjusted.state.T_g_M is None else find_weak_directions(hull_axes(marginals.T_g_M, adjusted.state.T_g_M))
    before, after = (residual_statistics.by_factor(native.evaluate(p, settings)) for p in (adjusted.start, adjusted.problem))
    seen_with = intrinsics.summarise_intrinsics(m.rig, adjusted.rig, marginals, options)
    warnings = [str(w["sentence"]) for w in weak] + _warnings(adjusted, solution) + intrinsics.intrinsics_warnings(seen_with)
    record, times = iteration_history.columns(adjusted.rounds), iteration_history.seconds(adjusted.rounds)
    summary = _summary(m, adjusted, options, weak, before, after) | ({"intrinsics": seen_with} if seen_with else {})
    return Outcome(solution, record, times, summary, warnings)


def _marginals(m: Measurements, adjusted: Adjusted, options: AdjustOptions, settings: native.Options) -> native.Covariance:
    """Covariances at the solution. As published: the solve's own. Else what the measurements leave open with the hull held
    where and as it was found, and the covariance of that place by the CAD model's error: in the solve a field and many beams
    with white noise are surer of the place than so few cells of the CAD model's error allow (docs/adr/0011)."""
    free = native.covariance(_place_free(adjusted.problem), settings)
    if m.cad_model is None or adjusted.state.T_g_M is None or options.as_published:
        return free
    known = native.covariance(adjusted.problem.hold("T_g_M", "deviation"), settings)
    ground = adjusted.ground or _ground(m, adjusted)
    return replace(
        known,
        deviation=free.deviation,
        T_g_M=estimate.hull_pose_covariance(ground, adjusted.state.T_g_M),
        pose_T_g_M=np.zeros_like(free.pose_T_g_M),
        landmark_T_g_M=np.zeros_like(free.landmark_T_g_M),
    )


def _ground(m: Measurements, adjusted: Adjusted) -> estimate.HullPoseEvidence:
    """What a single solve was laid on, looked at afterwards."""
    assert m.cad_model is not None
    assert adjusted.state.T_g_M is not None
    points = estimate.collect_hull_points(m, adjusted.state, adjusted.chosen, adjusted.result.label)
    return estimate.fit_hull_pose(points, adjusted.state.T_g_M, m.cad_model, adjusted.center)[0]


def _place_free(problem: native.Problem) -> native.Problem:
    """The last round holds T_g_M where its profile put it; what is unknown about it is still unknown."""
    return problem.free("T_g_M") if len(problem.cad_mesh.vertices) else problem


def _solution(m: Measurements, adjusted: Adjusted, marginals: native.Covariance) -> Solution:
    state, chosen = adjusted.state, adjusted.chosen
    used = chosen.landmarks
    position = state.landmark[used]
    pose_covariance, landmark_covariance = _covariances(state, adjusted.center, position, marginals)
    pose_covariance = pose_covariance + _lever_arm(m, state)
    label, deviation = _labels(adjusted, len(used))
    return Solution(
        t_ns=m.trajectory.t_ns,
        image=m.trajectory.image,
        global_from_vehicle=state.nodes,
        tray=state.tray,
        tray_sigma=np.sqrt(np.maximum(marginals.pose[:, 6, 6], 0)),
        pose_covariance=pose_covariance,
        landmarks=Landmarks(
            position=position,
            covariance=landmark_covariance,
            label=label,
            deviation=deviation,
            views=_views(m, adjusted)[used],
            color=m.tracks.color[used] if m.tracks is not None else np.zeros((0, 3), np.uint8),
        ),
        mounts=Mounts(tray_from_dvl=state.T_s_d, tray_from_camera=state.T_s_ct, top_from_bottom=state.T_ct_cb),
        navigation_errors=state.navigation,
        hull_pose=_hull_pose(adjusted, marginals),
        deviation_field=_deviation_field(state, marginals),
    )


def _hull_pose(adjusted: Adjusted, marginals: native.Covariance) -> HullPose | None:
    if adjusted.state.T_g_M is None:
        return None
    return HullPose(global_from_hull=adjusted.state.T_g_M, covariance=marginals.T_g_M, survey_center=adjusted.center)


def _deviation_field(state: State, marginals: native.Covariance) -> DeviationField | None:
    if state.grid is None:
        return None
    sigma = np.sqrt(np.maximum(marginals.deviation, 0))
    return DeviationField(
        origin=state.grid.origin,
        step=state.grid.step,
        value=state.field.reshape(state.grid.shape),
        sigma=sigma.reshape(state.grid.shape),
    )


def _covariances(state: State, center: Array, position: Array, marginals: native.Covariance) -> tuple[Array, Array]:
    """Of the poses (n, 6, 6) and the landmarks (L, 3, 3), in M when there is a CAD model."""
    if state.T_g_M is None:
        return marginals.pose[:, :6, :6], marginals.landmark
    hull = marginals.T_g_M
    nodes = poses_in_hull(marginals.pose[:, :6, :6], marginals.pose_T_g_M[:, :6], hull, state.nodes, state.T_g_M, center)
    landmarks = points_in_hull(marginals.landmark, marginals.landmark_T_g_M, hull, position, state.T_g_M, center)
    return nodes, landmarks


def _lever_arm(m: Measurements, state: State) -> Array:
    """What the held position of the DVL on the tray adds to the poses' covariance (n, 6, 6): images and ranges see the camera
    and the DVL; a shift of both on the tray moves the vehicle alone, and nothing measures it."""
    tray = state.nodes @ poses.tray_poses(m.rig.tray_origin, state.tray)
    in_hull = tray if state.T_g_M is None else state.T_g_M.inverse() @ tray
    rotate = in_hull.rotation.as_matrix()
    out = np.zeros((len(state.nodes), 6, 6))
    out[:, :3, :3] = rotate @ np.diag(m.rig.dvl_position_sigma**2) @ rotate.transpose(0, 2, 1)
    return out


def _labels(adjusted: Adjusted, count: int) -> tuple[Ints, Array]:
    """Label and signed distance to the CAD model of each landmark; without a CAD model all are label 0 of unknown deviation."""
    if adjusted.state.T_g_M is None or not count:
        return np.zeros(count, np.int64), np.full(count, np.nan)
    return adjusted.result.label.astype(np.int64), adjusted.result.distance


def _views(m: Measurements, adjusted: Adjusted) -> Ints:
    """Images that saw each landmark and were used (L,)."""
    if m.tracks is None:
        return np.zeros(0, np.int64)
    seen = adjusted.chosen.top.astype(np.int64) + adjusted.chosen.bottom
    return np.bincount(m.tracks.landmark, seen, minlength=len(m.tracks.color)).astype(np.int64)


def _summary(
    m: Measurements, adjusted: Adjusted, options: AdjustOptions, weak: list[dict[str, object]], before: Any, after: Any
) -> dict[str, Any]:
    state, result = adjusted.state, adjusted.result
    depth = weighting.depth_sigma(m, adjusted.weights)
    summary: dict[str, Any] = {
        "method": options.method,
        "as_published": options.as_published,
        "converged": result.converged,
        "message": result.message,
        "iterations": len(result.iterations.cost) - 1,
        "rounds": iteration_history.summarise_rounds(adjusted.rounds),
        "landmarks": len(adjusted.chosen.landmarks),
        "on_hull": int((result.label == 1).sum()),
        "rays_missed": int((~result.ray_hit).sum()),
        "observations": int(adjusted.chosen.top.sum() + adjusted.chosen.bottom.sum()),
        "observations_left_out": _left_out(m, adjusted),
        "sigmas": {
            "pixel_px": adjusted.weights.pixel,
            "tray_rad": adjusted.weights.tray,
            "depth_m": depth if np.isfinite(depth) else None,
            "range_m": adjusted.weights.range_sigma,
        },
        "navigation": dict(zip(NAVIGATION, state.navigation.tolist(), strict=True)),
        "mounts": _mounts(state),
        "weak_directions": weak,
        "residuals_before": before,
        "residuals_after": after,
    }
    if adjusted.registration is not None:
        summary["registration"] = {
            "fitness": adjusted.registration.fitness,
            "rms_m": float(np.sqrt(np.mean(adjusted.registration.residual**2))),
            "T_g_M": pose_vector(adjusted.registration.global_from_hull).tolist(),
        }
    return summary


def _mounts(state: State) -> dict[str, list[float]]:
    present = {"T_s_ct": state.T_s_ct, "T_ct_cb": state.T_ct_cb, "T_s_d": state.T_s_d, "T_g_M": state.T_g_M}
    return {name: pose_vector(pose).tolist() for name, pose in present.items() if pose is not None}


def _left_out(m: Measurements, adjusted: Adjusted) -> int:
    if m.tracks is None:
        return 0
    seen = np.isfinite(m.tracks.top[:, 0]).sum() + np.isfinite(m.tracks.bottom[:, 0]).sum()
    return int(seen - adjusted.chosen.top.sum() - adjusted.chosen.bottom.sum())


def _warnings(adjusted: Adjusted, solution: Solution) -> list[str]:
    """What an inspector should know before trusting the result."""
    found = []
    if not adjusted.result.converged:
        found.append(f"The adjustment stopped before it converged ({adjusted.result.message}): raise adjust.max_iterations.")
    missed = float(np.mean(~adjusted.result.ray_hit)) if len(adjusted.result.ray_hit) else 0.0
    if missed > 0.05:
        found.append(
            f"{100 * missed:.0f} % of the DVL's beams miss the CAD model: it may be incomplete, or the first guess wrong."
        )
    if len(solution.landmarks) and solution.landmarks.label.mean() < 0.5 and adjusted.state.T_g_M is not None:
        found.append(
            "Fewer than half of the landmarks lie on the CAD model's surface: the CAD model or its first guess may be wrong."
        )
    return found
