# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The warnings of the adjustment: convergence, CAD model, stereo rig, sensors and mounts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hullrecon import native
from hullrecon.adjustment.bundle_adjustment import Adjusted
from hullrecon.adjustment.cad_placement import Placement
from hullrecon.adjustment.hull_pose.other_headings import describe_turn, turn_from_guess
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.state import State
from hullrecon.adjustment.problem.triangulation import camera_poses
from hullrecon.adjustment.results.unexpected_errors import (
    MountFit,
    length_warning,
    mount_warnings,
    navigation_warnings,
    scale_warning,
)
from hullrecon.adjustment.results.untold_lengths import only_dvl_tells_lengths
from hullrecon.adjustment.stereo_calibration import DVL_SCALE, stereo_warning
from hullrecon.adjustment.suspects import Trial, best_explanations
from hullrecon.findings.finding import Finding
from hullrecon.records.solution import Solution

MOST_LANDMARKS = 2000  # landmarks whose distance from the cameras is measured
# Sigma of the CAD model's scale beyond which the report says that the survey cannot tell it
TRUSTED_SCALE = 0.1
MANY_MISSED = 0.05  # share of the DVL's beams that miss the CAD model, beyond which it is told


def solve_warnings(adjusted: Adjusted, solution: Solution) -> list[str]:
    """Warn of a CAD model that was refused or hardly fits, and of a solve that did not converge."""
    found = _placement_warnings(adjusted, solution)
    if not adjusted.result.converged:
        found.append(
            f"The adjustment stopped before it converged ({adjusted.result.message}): raise "
            "adjust.max_iterations."
        )
    missed = float(np.mean(~adjusted.result.ray_hit)) if len(adjusted.result.ray_hit) else 0.0
    if missed > MANY_MISSED:
        found.append(f"{100 * missed:.0f} % of the DVL's beams miss the CAD model.")
    if (
        len(solution.landmarks)
        and solution.landmarks.label.mean() < 0.5
        and adjusted.state.hull is not None
    ):
        found.append("Fewer than half of the landmarks lie on the CAD model's surface.")
    return found


def _placement_warnings(adjusted: Adjusted, solution: Solution) -> list[str]:
    """Warn where the CAD model was refused, or where its pose or shape contradicts the package.

    Empty without a CAD model.
    """
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
    if adjusted.placement.tray_offset is not None:  # explains the distance from hull.pose as well
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


def unexpected_errors(
    m: Measurements, adjusted: Adjusted, marginals: native.Covariance
) -> list[str]:
    """Warn of errors of sensors and mounts beyond what dive.toml allows, and of untold lengths."""
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
    if not lengths and only_dvl_tells_lengths(adjusted):
        per_cent = 100 * float(m.rig.priors.navigation_sigma[DVL_SCALE])
        lengths = [Finding("lengths-untold", {"per_cent": per_cent}).sentence]
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


def stereo_sentence(
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
