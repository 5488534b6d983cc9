# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The results of the adjustment: its Solution, the solver's record and adjust.json."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass

import numpy as np

from hullrecon import native
from hullrecon.adjustment.bundle_adjustment import Adjusted
from hullrecon.adjustment.hull_pose.observability import find_weak_directions
from hullrecon.adjustment.hull_pose.registration import rms_m
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.partition import join
from hullrecon.adjustment.problem import intrinsics, iteration_history, lens, weighting
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.problem.observations import landmark_count, read_tracks
from hullrecon.adjustment.problem.state import HullState, State
from hullrecon.adjustment.results.adjustment_warnings import (
    explained_as_well,
    solve_warnings,
    stereo_sentence,
    unexpected_errors,
)
from hullrecon.adjustment.results.covariance import hull_axes
from hullrecon.adjustment.results.legs import LegTies, tie_legs
from hullrecon.adjustment.results.solution import build_solution, marginal_covariances
from hullrecon.adjustment.suspects import Trial
from hullrecon.estimation.position_tables import fit_of_positions
from hullrecon.findings.adjustment import SUSPECTS
from hullrecon.geometry.poses import pose_vector
from hullrecon.geometry.robust import robust_sigma_of_blocks
from hullrecon.memory import empty_array, release_pages
from hullrecon.records.solution import Solution
from hullrecon.typing import Array, Arrays, Ints

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
    stereo = stereo_sentence(m, adjusted, marginals)
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
            *solve_warnings(adjusted, solution),
            *([] if untied is None else [untied]),
            *([] if disagreement is None else [disagreement]),
            *intrinsics.intrinsics_warnings(refined),
            *lens.lens_warnings(lenses),
            *([] if stereo is None else [stereo]),
            *unexpected_errors(m, adjusted, marginals),
            *explained_as_well(adjusted.verdict.suspects),
        ],
    )


def _covariance_in_hull(marginals: native.Covariance, hull: HullState) -> tuple[Array, Array]:
    """Compute the covariance (6, 6) of the hull's pose in M's axes, with the ship's axes (3, 3)."""
    return hull_axes(marginals.T_g_M, hull.global_from_hull), hull.cad_model.chart.ship_axes


def _suspects(trials: Sequence[Trial]) -> dict[str, object]:
    """Tabulate the trials of suspects for adjust.json, each with a description in words."""
    if not trials:
        return {}
    return {
        "suspects": [
            asdict(trial) | {"words": SUSPECTS[trial.suspect](trial.found)} for trial in trials
        ]
    }


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
    vector = pose_vector(found.global_from_hull).tolist()
    form = {} if compared is None else {"form": asdict(compared) | {"log_odds": compared.log_odds}}
    return {
        "registration": {"fitness": found.fitness, "rms_m": rms_m(found), "T_g_M": vector, **form}
    }


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


def residual_figures(of_parts: Iterable[Mapping[str, Array]]) -> dict[str, dict[str, float]]:
    """Compute figures of each factor's whitened residuals: count, RMS, robust sigma, outliers.

    of_parts: residuals (m,) of each part of the problem, by factor. Those of all parts do not fit
    into memory, so they are kept in files. Factors without residuals are left out.
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
    """Compute the figures of one factor's whitened residuals, kept in blocks (m,)."""

    def blocks() -> Iterator[Array]:
        """Read the blocks one by one, and give each one's memory back."""
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
