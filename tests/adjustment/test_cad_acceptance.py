# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""CAD models registered to a right path: good ones are accepted, others refused with a reason."""

from dataclasses import replace
from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest
from adjustment.simulated_dive import (
    GLOBAL_FROM_HULL,
    TOP_FROM_BOTTOM,
    TRAY_FROM_DVL,
    TRAY_FROM_TOP,
    motion,
    moved,
    records_poses,
    simulate,
)
from adjustment.solved_dives import solved
from dive.hull.shapes import barge

from hullrecon import native
from hullrecon.adjustment import cad_acceptance
from hullrecon.adjustment.bundle_adjustment import adjust
from hullrecon.adjustment.cad_acceptance import accept_round
from hullrecon.adjustment.cad_placement import register
from hullrecon.adjustment.options import PRODUCT, AdjustOptions
from hullrecon.adjustment.partition.plan import whole
from hullrecon.adjustment.problem import weighting
from hullrecon.adjustment.problem.observations import landmark_count
from hullrecon.adjustment.problem.state import State
from hullrecon.adjustment.residual_growth import MAX_GROWTH, residual_growth
from hullrecon.adjustment.results.summary import summarise_adjustment
from hullrecon.adjustment.rounds import Estimate, RoundSolver, Verdict
from hullrecon.errors import StageError
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.solution import Mounts

OPTIONS = AdjustOptions()
SOLVER = RoundSolver(calibrated=None, options=OPTIONS, strategy=PRODUCT, report=lambda _: None)


@lru_cache
def true_path(seed=1, **scene):
    """The dive's measurements on its true path, with the true mounts."""
    dive = simulate(seed=seed, **scene)
    m = dive.measured
    state = State(
        nodes=records_poses(dive.global_from_vehicle),
        tray=dive.tray,
        landmark=np.full((landmark_count(m), 3), np.nan),
        mounts=Mounts(
            tray_from_dvl=records_poses(TRAY_FROM_DVL),
            tray_from_top=records_poses(TRAY_FROM_TOP) if m.tracks is not None else None,
            top_from_bottom=records_poses(TOP_FROM_BOTTOM) if m.tracks is not None else None,
        ),
        navigation=np.zeros(6),
        hull=None,
    )
    return Estimate(
        measured=m, state=state, weights=weighting.initial_weights(m, PRODUCT), max_px=40.0
    )


def model():
    return true_path().measured.cad_model


def stretched(factors):
    """The CAD model with its axes scaled."""
    mesh = model().mesh
    return replace(model(), mesh=Mesh(mesh.vertices * factors, mesh.faces))


def guessed(shift_m, yaw_deg, sigmas=1.0):
    """The CAD model guessed off along the hull and in yaw, with its sigmas multiplied."""
    wrong = model().guess @ records_poses(motion(shift_m, 0, 0, 0, 0, yaw_deg))
    return replace(model(), guess=wrong, guess_sigma=model().guess_sigma * sigmas)


def place(cad_model, estimate=None):
    return register(estimate or true_path(), cad_model, SOLVER)


def off_hull_m(found):
    """How far the survey's centre lies off its true place: along the hull, and across it."""
    registration = found.placement.registration
    laid = moved(registration.global_from_hull.matrix()[0], registration.center) - moved(
        GLOBAL_FROM_HULL, registration.center
    )
    in_hull = GLOBAL_FROM_HULL[:3, :3].T @ laid
    return abs(in_hull[0]), np.linalg.norm(in_hull[1:])


@pytest.mark.parametrize("seed", [1, 2])
def test_a_good_model_is_found_and_never_refused(seed):
    estimate = true_path(seed)
    found = place(estimate.measured.cad_model, estimate)
    assert found.verdict.accepted
    assert found.placement.registration.fitness > 0.9
    assert found.placement.registration.sigmas_off == 1.0
    assert off_hull_m(found)[1] < 0.15
    assert found.estimate.state.hull.grid is not None


def test_a_model_in_other_units_is_refused():
    """Nothing of it lies near the survey; far from the guess its large flat side fits."""
    reason = place(stretched(np.full(3, 1 / 0.3048))).verdict.reason
    assert "times farther from hull.pose" in reason
    assert reason.endswith('where hull.pose says (hull.units = "ft")')


def test_a_model_on_its_side_is_refused_however_it_fits():
    on_its_side = replace(model(), mesh=Mesh(barge().vertices[:, [0, 2, 1]], barge().faces))
    assert "exported with y up" in place(on_its_side).verdict.reason


@lru_cache
def adjusted_with_wrong_model():
    """Measurements with a model that fits nowhere, how they were adjusted, and what was told."""
    told = []
    measured = replace(simulate().measured, cad_model=stretched(np.array([0.25, 0.3, 0.35])))
    return measured, adjust(measured, OPTIONS, told.append), told


def test_model_that_fits_nowhere_is_refused():
    reason = adjusted_with_wrong_model()[1].verdict.reason
    assert "% of the surveyed points lie within three sigma of it, wherever it is placed" in reason
    assert "the model, its unit, hull.pose, the path, the tray's angles or the" in reason


def test_model_a_fifth_too_large_is_refused_by_sure_guess():
    """A patch of two metres fits it half a metre farther out: the guess speaks against it."""
    sure = stretched(np.full(3, 1.2))
    found = place(replace(sure, guess_sigma=0.1 * sure.guess_sigma))
    assert "times farther from hull.pose than hull.pose_sigma says" in found.verdict.reason


def test_far_guess_with_small_sigma_is_refused():
    assert "it fits only" in place(guessed(5, 15)).verdict.reason


def test_such_a_guess_with_sigmas_to_match_is_found():
    found = place(guessed(5, 15, sigmas=4))
    assert found.verdict.accepted
    assert found.placement.registration.fitness > 0.9
    along, across = off_hull_m(found)
    assert across < 0.6
    # the hull's form says little along itself, the guess's sigma there is 1.2 m
    assert along < 3.5 * 1.2


def test_a_guess_that_is_contradicted_but_not_absurd_is_widened():
    found = place(guessed(2, 8))
    assert found.verdict.accepted
    assert 3.5 < found.placement.registration.sigmas_off < 8
    wide = found.placement.registration.cad_model.guess_sigma
    np.testing.assert_allclose(wide, model().guess_sigma * found.placement.registration.sigmas_off)
    assert found.placement.registration.cad_model.contradicted
    assert not model().contradicted


def test_without_ranges_landmarks_are_laid_onto_the_model():
    estimate = true_path(ranges=False)
    found = place(estimate.measured.cad_model, estimate)
    assert found.verdict.accepted
    assert found.placement.registration.fitness > 0.9


def test_dive_without_ranges_and_camera_cannot_register():
    estimate = true_path(ranges=False, camera=False)
    with pytest.raises(
        StageError, match="nothing measures the hull: there is no DVL range and no image"
    ):
        place(estimate.measured.cad_model, estimate)


# what follows from it


def round_with(hit, on_hull, problem=None, stated_over_found=1.0):
    """stated_over_found: of the sigma of the tray's angle, that of the package over that of the
    round.
    """
    result = SimpleNamespace(
        ray_hit=np.arange(100) < hit, label=(np.arange(100) < on_hull).astype(int)
    )
    rig, weights = (
        SimpleNamespace(priors=SimpleNamespace(tray_sigma_rad=0.01 * stated_over_found)),
        SimpleNamespace(tray=0.01),
    )
    after = SimpleNamespace(measured=SimpleNamespace(rig=rig, returns=None), state=None)
    return SimpleNamespace(
        result=result,
        problem=problem or solved().adjusted.problem,
        plan=solved().adjusted.plan,
        weights=weights,
        after=after,
    )


def test_round_whose_beams_miss_model_is_refused():
    assert (
        accept_round(round_with(hit=75, on_hull=90), SOLVER).reason
        == "25 % of the DVL's beams miss it"
    )


def test_round_with_few_landmarks_on_model_is_refused():
    assert (
        accept_round(round_with(hit=100, on_hull=10), SOLVER).reason
        == "only 10 % of the landmarks lie on its surface"
    )


def _growth(problem: native.Problem) -> dict[str, float]:
    return residual_growth(problem, whole(problem, "small"), native.Options())


def test_round_on_good_model_is_accepted():
    assert accept_round(round_with(hit=100, on_hull=90), SOLVER) == Verdict()
    growth = _growth(solved().adjusted.problem)
    # of a dive without positions from outside
    assert set(growth) == set(MAX_GROWTH) - {"positions"}
    for name, ratio in growth.items():
        assert 0.99 < ratio < MAX_GROWTH[name], name


def with_poor_levels(seed):
    """A right model, and tray, roll and pitch read to 0.6 degrees with nothing else that tells
    them: without the model each follows its own reading, with it their residuals are some three
    times as large.
    """
    rng, problem, sigma = np.random.default_rng(seed), solved(camera=False).adjusted.problem, 0.01
    tray, attitude, count = problem.tray, problem.attitude, len(problem.tray.node)
    levels = np.c_[np.zeros(count), sigma * rng.standard_normal((count, 2))]
    poor = replace(
        problem,
        tray=replace(
            tray,
            measured=tray.measured + sigma * rng.standard_normal(count),
            sigma=np.full(count, sigma),
        ),
        attitude=replace(
            attitude,
            measured=attitude.measured + levels,
            sigma=attitude.sigma * [1, 0, 0] + [0, sigma, sigma],
        ),
        odometry=replace(
            problem.odometry, sqrt_information=problem.odometry.sqrt_information / 100
        ),
    )
    return poor.started_from(native.solve(poor).unknowns)


@pytest.mark.parametrize("seed", [1, 2])
def test_residuals_of_freed_unknowns_may_grow(seed):
    tied = with_poor_levels(seed)
    growth = _growth(tied)
    assert growth["odometry"] < MAX_GROWTH["odometry"]
    assert growth["attitude"] < MAX_GROWTH["attitude"]
    squares = native.evaluate(tied).cost_by_factor
    # no more than their four readings a node
    assert 2 * (squares["attitude"] + squares["tray"]) < 4 * len(tied.tray.node)


@pytest.mark.parametrize(("stated_over_found", "believed"), [(10.0, True), (0.1, False)])
def test_attitude_may_grow_within_stated_sigmas(stated_over_found, believed, monkeypatch):
    """With one camera the sigma of the tray that a round finds follows the noise, and a right model
    is no worse than stated.
    """
    monkeypatch.setattr(
        cad_acceptance,
        "residual_growth",
        lambda *_: {"images": 1.0, "odometry": 1.0, "attitude": 1.3},
    )
    reason = accept_round(round_with(100, 90, stated_over_found=stated_over_found), SOLVER).reason
    assert reason == (None if believed else "with it, the residuals grow: attitude by 30 %")


def test_growth_of_undetermined_problem_is_taken_as_is(monkeypatch):
    def refuse(problem, settings, **more):
        raise StageError("nothing determines it")

    problem = with_poor_levels(1)
    monkeypatch.setattr(native, "covariance", refuse)
    assert _growth(problem)["attitude"] > 2


def test_round_bent_by_shifted_model_is_refused():
    """The model held 30 cm along the hull and 3 degrees off: landmarks and beams pull the path."""
    problem = solved().adjusted.problem
    wrong = records_poses(GLOBAL_FROM_HULL @ motion(0.3, 0, 0, 0, 3, 6))
    astray = replace(problem.unknowns, T_g_M=np.r_[wrong.translation[0], wrong.quaternion[0]])
    bent = problem.started_from(astray).hold("T_g_M", "deviation")
    bent = bent.started_from(
        native.solve(bent, native.Options(method="geva", max_iterations=15)).unknowns
    )
    growth = _growth(bent)
    assert any(growth[name] > limit for name, limit in MAX_GROWTH.items())
    assert "with it, the residuals grow: " in accept_round(round_with(100, 90, bent), SOLVER).reason


def test_refused_model_leaves_path_without_it():
    measured, refused, told = adjusted_with_wrong_model()
    without = solved(cad=False).adjusted
    assert refused.state.hull is None
    np.testing.assert_allclose(
        refused.state.nodes.translation, without.state.nodes.translation, atol=1e-9
    )
    assert any(line.startswith("the CAD model is left out: only ") for line in told)
    outcome = summarise_adjustment(measured, refused, OPTIONS)
    assert outcome.summary["cad_model_refused"] == refused.verdict.reason
    (said,) = [warning for warning in outcome.warnings if "The CAD model was left out" in warning]
    assert "What is delivered comes from images and navigation alone" in said
    blind = solved(camera=False, cad=False)
    outcome = summarise_adjustment(
        blind.dive.measured, replace(blind.adjusted, verdict=refused.verdict), OPTIONS
    )
    (said,) = [warning for warning in outcome.warnings if "The CAD model was left out" in warning]
    assert "What is delivered comes from navigation alone" in said
