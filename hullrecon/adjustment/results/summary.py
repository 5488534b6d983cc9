# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The results of the adjustment: its Solution, the solver's record, adjust.json and warnings."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from hullrecon import native
from hullrecon.adjustment.bundle_adjustment import Adjusted
from hullrecon.adjustment.cad_placement import Placement
from hullrecon.adjustment.hull_pose.observability import find_weak_directions
from hullrecon.adjustment.hull_pose.other_headings import describe_turn, turn_from_guess
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.partition import join
from hullrecon.adjustment.problem import intrinsics, iteration_history, lens, weighting
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.observations import landmark_count, read_tracks
from hullrecon.adjustment.problem.state import HullState, State
from hullrecon.adjustment.problem.triangulation import camera_poses
from hullrecon.adjustment.results.covariance import hull_axes
from hullrecon.adjustment.results.legs import LegTies, tie_legs
from hullrecon.adjustment.results.solution import build_solution, marginal_covariances
from hullrecon.adjustment.results.unexpected_errors import (
    MountFit,
    length_warning,
    mount_warnings,
    navigation_warnings,
    scale_warning,
)
from hullrecon.adjustment.stereo_calibration import stereo_warning
from hullrecon.adjustment.suspects import Trial, best_explanations
from hullrecon.estimation.position_tables import fit_of_positions
from hullrecon.findings.adjustment import SUSPECTS
from hullrecon.findings.finding import Finding
from hullrecon.geometry.poses import pose_vector
from hullrecon.geometry.robust import robust_sigma_of_blocks
from hullrecon.memory import empty_array, release_pages
from hullrecon.records.solution import Solution
from hullrecon.typing import Array, Arrays, Ints

MOST_LANDMARKS = 2000  # landmarks whose distance from the cameras is measured
# Sigma of the CAD model's scale beyond which the report says that the survey cannot tell it
TRUSTED_SCALE = 0.1
# Names in adjust.json of the errors of navigation, in the order of RigPriors.navigation_sigma
NAVIGATION = (
    "dvl_scale",
    "heading_drift_rad_s",
    "roll_bias_rad",
    "pitch_bias_rad",
    "depth_bias_m",
    "tray_backlash_rad",
)


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """All that the step adjust writes, except for its COLMAP model."""

    solution: Solution
    iterations: Arrays  # columns of iterations.npz
    iterations_s: Array  # when each of its rows was done, seconds since the adjustment began
    summary: dict[str, object]  # adjust.json
    warnings: list[str]  # sentences for the report


def summarise_adjustment(m: Measurements, adjusted: Adjusted, options: AdjustOptions) -> Outcome:
    """Compute solution, figures and warnings of the adjusted dive.

    Parameters
    ----------
    m
        Measurements, with the rig as calibrated.
    adjusted
        The solution.
    options
        The section [adjust] of dive.toml.
    """
    settings = adjusted.settings
    marginals = marginal_covariances(m, adjusted)
    solution = build_solution(m, adjusted, marginals)
    hull = adjusted.state.hull
    ties = _ties(m, adjusted)
    weak = [] if hull is None else find_weak_directions(*_covariance_in_hull(marginals, hull))
    fit = fit_of_positions(adjusted.problem, m.positions, marginals.world, settings)
    disagreement = None if fit is None else fit.disagreement()
    refined = intrinsics.summarise_intrinsics(m.rig, adjusted.rig, marginals, options)
    lenses = lens.summarise_lenses(m.rig, adjusted.lenses, marginals)
    stereo = _stereo_sentence(m, adjusted, marginals)
    summary = {
        **_figures(m, adjusted),
        "parts": adjusted.plan.facts(),
        "navigation_sigma": _navigation_sigma(marginals),
        "weak_directions": weak,
        "residuals_before": residual_figures(join.residuals(adjusted.start, None, settings)),
        "residuals_after": residual_figures(
            join.residuals(adjusted.problem, adjusted.plan, settings)
        ),
        **_registration(adjusted),
        "cad_model_refused": adjusted.verdict.reason,
        "legs": [] if ties is None else ties.table(m.trajectory.t_ns),
        **_suspects(adjusted.verdict.suspects),
        **({"intrinsics": refined} if refined else {}),
        **({"lenses": lenses} if lenses else {}),
        **(
            {"stereo_contradiction": asdict(adjusted.verdict.stereo) | {"sentence": stereo}}
            if adjusted.verdict.stereo is not None
            else {}
        ),
        **({"positions": fit.facts()} if fit is not None else {}),
    }
    untied = None if ties is None else ties.describe_untied(m.trajectory.t_ns)
    return Outcome(
        solution=solution,
        iterations=iteration_history.columns(adjusted.rounds),
        iterations_s=iteration_history.seconds(adjusted.rounds),
        summary=summary,
        warnings=[
            *(str(w["sentence"]) for w in weak),
            *_warnings(adjusted, solution),
            *([] if untied is None else [untied]),
            *([] if disagreement is None else [disagreement]),
            *intrinsics.intrinsics_warnings(refined),
            *lens.lens_warnings(lenses),
            *([] if stereo is None else [stereo]),
            *_unexpected_errors(m, adjusted, marginals),
            *explained_as_well(adjusted.verdict.suspects),
        ],
    )


def _covariance_in_hull(marginals: native.Covariance, hull: HullState) -> tuple[Array, Array]:
    """Compute the covariance (6, 6) of the hull's pose in M's axes, with the ship's axes (3, 3)."""
    return hull_axes(marginals.T_g_M, hull.global_from_hull), hull.cad_model.chart.ship_axes


def _stereo_sentence(
    m: Measurements, adjusted: Adjusted, marginals: native.Covariance
) -> str | None:
    """Write the warning of a stereo calibration that the dive contradicts.

    None without a contradiction, where it is too small to matter, or without a second camera.
    """
    if (
        adjusted.verdict.stereo is None
        or adjusted.state.mounts.top_from_bottom is None
        or m.rig.top_from_bottom is None
    ):
        return None
    return stereo_warning(
        adjusted.verdict.stereo,
        m.rig.top_from_bottom,
        adjusted.state.mounts.top_from_bottom,
        marginals.T_ct_cb,
    )


def _unexpected_errors(
    m: Measurements, adjusted: Adjusted, marginals: native.Covariance
) -> list[str]:
    """Warn of each sensor error and each mount that was found beyond what dive.toml allows."""
    allowed, state = m.rig.priors.navigation_sigma, adjusted.state
    by_lengths = adjusted.verdict.stereo is not None and not adjusted.verdict.stereo.by_images
    # Where lengths disagree, another warning mentions the DVL's scale
    if by_lengths or adjusted.verdict.length_conflict is not None:
        allowed = np.r_[np.inf, allowed[1:]]
    lengths = (
        []
        if adjusted.verdict.length_conflict is None
        else [length_warning(adjusted.verdict.length_conflict, marginals.navigation)]
    )
    mounts = {
        "dvl.mount": MountFit(
            m.rig.tray_from_dvl,
            m.rig.priors.tray_from_dvl,
            state.mounts.tray_from_dvl,
            marginals.T_s_d,
        ),
        "camera.top.mount": MountFit(
            m.rig.tray_from_top,
            m.rig.priors.tray_from_top,
            state.mounts.tray_from_top,
            marginals.T_s_ct,
        ),
    }
    return [
        *lengths,
        *navigation_warnings(state.navigation, allowed, marginals.navigation),
        *scale_warning(state.navigation, allowed, marginals.navigation),
        *mount_warnings(mounts, _camera_distance(m, state)),
    ]


def _camera_distance(m: Measurements, state: State) -> float:
    """Compute the median distance, m, of landmarks from the nearest pose of the top camera.

    NaN without landmarks.
    """
    from scipy.spatial import cKDTree

    known = state.landmark[np.isfinite(state.landmark).all(axis=1)]
    if not len(known):
        return float("nan")
    few = known[:: max(1, len(known) // MOST_LANDMARKS)]
    cameras = camera_poses(m.rig, state)[0].translation
    return float(np.median(cKDTree(cameras).query(few)[0]))


def _suspects(trials: Sequence[Trial]) -> dict[str, object]:
    """Tabulate the trials of suspects for adjust.json, each with a description in words."""
    if not trials:
        return {}
    return {
        "suspects": [
            asdict(trial) | {"words": SUSPECTS[trial.suspect](trial.found)} for trial in trials
        ]
    }


def explained_as_well(trials: Sequence[Trial]) -> list[str]:
    """Warn where an error that cannot be corrected explains as much as the best explanation.

    Empty where all of the best explanations are errors that the adjustment corrects.
    """
    best = best_explanations(trials)
    others = [[trial.suspect, trial.found] for trial in best if not trial.corrects]
    if not others:
        return []
    corrected = any(trial.corrects for trial in best)
    code = "explained-as-well" if corrected else "explained-better"
    return [Finding(code, {"explanations": others}).sentence]


def _ties(m: Measurements, adjusted: Adjusted) -> LegTies | None:
    """Count the landmarks that legs share. None without images."""
    if m.tracks is None:
        return None
    return tie_legs(adjusted.state.nodes.translation, _observed(m, adjusted))


def _observed(m: Measurements, adjusted: Adjusted) -> Iterator[tuple[Ints, Ints]]:
    """Read the observations that entered in blocks: node and landmark of each, both (k,)."""
    chosen = adjusted.chosen
    is_chosen = np.zeros(landmark_count(m), bool)
    is_chosen[chosen.landmarks] = True
    for block in read_tracks(m.tracks, is_chosen):
        rows = chosen.top[block.rows] | chosen.bottom[block.rows]
        yield block.tracks.node[rows], block.tracks.landmark[rows]


def _figures(m: Measurements, adjusted: Adjusted) -> dict[str, object]:
    """Collect the figures of the solve for adjust.json: rounds, counts, sigmas, sensor errors."""
    state, result = adjusted.state, adjusted.result
    depth = weighting.depth_sigma(m, adjusted.weights)
    return {
        "method": adjusted.strategy.method,
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
    }


def _navigation_sigma(marginals: native.Covariance) -> dict[str, float]:
    """Collect the sigma of each navigation error that was not held."""
    sigma = np.sqrt(np.maximum(np.diag(marginals.navigation), 0))
    return {name: float(value) for name, value in zip(NAVIGATION, sigma, strict=True) if value > 0}


def _registration(adjusted: Adjusted) -> dict[str, object]:
    """Collect how well the CAD model was registered, and its shape compared, for adjust.json.

    Empty without a CAD model.
    """
    placement = adjusted.placement
    if placement is None:
        return {}
    found, compared = placement.registration, placement.shape
    rms_m = float(np.sqrt(np.mean(found.residual**2)))
    vector = pose_vector(found.global_from_hull).tolist()
    form = {} if compared is None else {"form": asdict(compared) | {"log_odds": compared.log_odds}}
    return {"registration": {"fitness": found.fitness, "rms_m": rms_m, "T_g_M": vector, **form}}


def _mounts(state: State) -> dict[str, list[float]]:
    """Collect the estimated mounts and hull pose, by name, as [x, y, z, qx, qy, qz, qw]."""
    hull = None if state.hull is None else state.hull.global_from_hull
    present = {
        "T_s_ct": state.mounts.tray_from_top,
        "T_ct_cb": state.mounts.top_from_bottom,
        "T_s_d": state.mounts.tray_from_dvl,
        "T_g_M": hull,
    }
    return {name: pose_vector(pose).tolist() for name, pose in present.items() if pose is not None}


def _left_out(m: Measurements, adjusted: Adjusted) -> int:
    """Count the observations, of both cameras, that did not enter the last round."""
    if m.tracks is None:
        return 0
    seen = sum(
        np.isfinite(block.tracks.top[:, 0]).sum() + np.isfinite(block.tracks.bottom[:, 0]).sum()
        for block in read_tracks(m.tracks)
    )
    return int(seen - adjusted.chosen.top.sum() - adjusted.chosen.bottom.sum())


def _placement_warnings(adjusted: Adjusted, solution: Solution) -> list[str]:
    """Warn where the CAD model was refused, or where its pose or shape contradicts the package."""
    if not adjusted.verdict.accepted:
        sources = "images and navigation" if len(solution.landmarks) else "navigation"
        return [
            f"The CAD model was left out: {adjusted.verdict.reason}. What is delivered comes from "
            f"{sources} alone, in frame g: positions are relative to where the dive began."
        ]
    if adjusted.placement is None:
        return []
    found = adjusted.placement.registration
    sentences = [*_shape_warnings(adjusted.placement), *_segment_warnings(adjusted.placement)]
    if found.sigmas_off <= 1:
        return sentences
    if adjusted.placement.tray_offset is not None:
        off_deg = np.degrees(adjusted.placement.tray_offset)
        sentences.append(
            f"The tray's angles may be off by {off_deg:+.0f} degrees: put right by that, the CAD "
            "model fits where hull.pose has it, and as they are it does not."
        )
    turn = turn_from_guess(found)
    if turn is not None:
        return [
            *sentences,
            f"The CAD model fits far from hull.pose: {describe_turn(turn)}. The sigmas of that "
            "pose were widened as much.",
        ]
    return [
        *sentences,
        f"The hull lies {found.sigmas_off:.1f} times farther from hull.pose than hull.pose_sigma "
        "says; the sigmas of that pose were widened as much. Where the hull's form does not tell, "
        "positions are no better than that.",
    ]


def _segment_warnings(placement: Placement) -> list[str]:
    """Warn of segments of the path that the CAD model alone ties together."""
    segments = placement.segments
    if segments is None:
        return []
    return [
        f"Outages cut the path into {len(segments)} segments, known to {segments.loosest_m:.2f} m "
        "from one to the next (one sigma, the worst axis) before they were registered to the CAD "
        "model. Where the hull's form does not tell, what one shows lies no better to what "
        "another shows than that."
    ]


def _shape_warnings(placement: Placement) -> list[str]:
    """Warn where an accepted CAD model deviates, or where the surveyed shape cannot confirm it."""
    shape = placement.shape
    if shape is None:
        return []
    if shape.needs_wider_sigma:
        return [
            f"The hull leaves its CAD model by {np.sqrt(shape.deviation):.1f} times "
            "hull.deviation_sigma over metres; that sigma was widened as much. If that is not "
            "known of the hull, the CAD model may be another ship's: the sigmas of position reach "
            "to where hull.pose has it."
        ]
    is_plain, sigma = not shape.fits_better_than_plane, max(shape.scale_sigma, default=np.inf)
    if placement.registration.cad_model.has_stated_length:
        return [Finding("cad-model-untold").sentence] if is_plain else []
    if is_plain or sigma > TRUSTED_SCALE:
        values = {"per_cent": None if is_plain else 100 * sigma}
        return [Finding("cad-scale-untold", values).sentence]
    return []


def _warnings(adjusted: Adjusted, solution: Solution) -> list[str]:
    """Warn of a CAD model that was refused or hardly fits, and of a solve that did not converge."""
    found = _placement_warnings(adjusted, solution)
    if not adjusted.result.converged:
        found.append(
            f"The adjustment stopped before it converged ({adjusted.result.message}): raise "
            "adjust.max_iterations."
        )
    missed = float(np.mean(~adjusted.result.ray_hit)) if len(adjusted.result.ray_hit) else 0.0
    if missed > 0.05:
        found.append(f"{100 * missed:.0f} % of the DVL's beams miss the CAD model.")
    if (
        len(solution.landmarks)
        and solution.landmarks.label.mean() < 0.5
        and adjusted.state.hull is not None
    ):
        found.append("Fewer than half of the landmarks lie on the CAD model's surface.")
    return found


def residual_figures(of_parts: Iterable[Mapping[str, Array]]) -> dict[str, dict[str, float]]:
    """Compute figures of each factor's whitened residuals: count, RMS, robust sigma, outliers.

    Factors without residuals are left out. Residuals of all parts do not fit into memory.
    """
    kept: dict[str, list[Array]] = {name: [] for name in native.FACTORS}
    for of_part in of_parts:
        for name, values in of_part.items():
            if len(values):
                kept[name].append(empty_array(values.shape, values.dtype))
                kept[name][-1][:] = values
                release_pages(kept[name][-1])
    return {name: _figures_of(values) for name, values in kept.items() if values}


def _figures_of(kept: Sequence[Array]) -> dict[str, float]:
    def blocks() -> Iterator[Array]:
        for values in kept:
            yield values
            release_pages(values)

    count = sum(len(values) for values in kept)
    return {
        "count": float(count),
        "rms": float(np.sqrt(sum(np.sum(values**2) for values in blocks()) / count)),
        "robust_sigma": robust_sigma_of_blocks(blocks),
        "share_beyond_3": sum(np.count_nonzero(np.abs(values) > 3) for values in blocks()) / count,
    }
