# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""`adjust` on the simulated dive, against truth. Bounds are some twice what this dive gives (0.9 to
1.4 mm, landmarks 0.4 to 0.8 mm; as published 2.6 mm); dead reckoning alone is 12 mm off after
alignment.
"""

from dataclasses import replace

import numpy as np
import pytest
from adjustment.simulated_dive import (
    BOX_M,
    NAVIGATION,
    NAVIGATION_SIGMA,
    PIXEL_NOISE_PX,
    aligning,
    hull_chart,
    moved,
    simulate,
    true_deviation,
)
from adjustment.simulated_dive import GLOBAL_FROM_HULL as TRUTH
from adjustment.solved_dives import solved

from hullrecon.adjustment import rounds
from hullrecon.adjustment.bundle_adjustment import adjust
from hullrecon.adjustment.options import AdjustOptions, Strategy
from hullrecon.adjustment.problem import weighting
from hullrecon.adjustment.results.summary import summarise_adjustment

SCALE, DRIFT, ROLL, PITCH, DEPTH, BACKLASH = range(6)
# scene and options, then bounds after alignment: RMSE of positions and of turns, median of
# landmarks
CASES = {
    "stereo with CAD": ({}, 2e-3, 1.5e-3, 1.0e-3),
    "mono with CAD": ({"stereo": False}, 3e-3, 1.5e-3, 2.0e-3),
    "stereo without CAD": ({"cad": False}, 2e-3, 1.5e-3, 1.0e-3),
    "mono without CAD": ({"cad": False, "stereo": False}, 3e-3, 1.5e-3, 2.0e-3),
    "stereo with CAD, every landmark on it": ({"method": "geva"}, 2e-3, 1.5e-3, 1.0e-3),
    "stereo with CAD, no landmark on it": ({"method": "naive"}, 2e-3, 1.5e-3, 1.0e-3),
    "labels by an outer loop": ({"labels": "outer"}, 2e-3, 1.5e-3, 1.0e-3),
    "a single round": ({"rounds": 1}, 2e-3, 1.5e-3, 1.0e-3),
    "as published": ({"as_published": True}, 5e-3, 5e-3, 1.5e-3),
    "no ranges": ({"ranges": False}, 2e-3, 1.5e-3, 1.0e-3),
}
WITH_CAD = [name for name, (chosen, *_) in CASES.items() if chosen.get("cad", True)]


def of(case):
    return solved(**CASES[case][0])


@pytest.mark.parametrize("case", CASES)
def test_the_path_and_the_landmarks_come_out_to_millimetres(case):
    _, position_m, turn_rad, landmark_m = CASES[case]
    found = of(case)
    assert found.adjusted.result.converged
    assert np.sqrt(np.mean(np.sum(found.position_errors_m() ** 2, 1))) < position_m
    assert np.sqrt(np.mean(found.turn_errors_rad() ** 2)) < turn_rad
    assert np.median(found.landmark_errors_m()) < landmark_m
    assert len(found.outcome.solution.landmarks) > 300


def test_the_scale_of_one_camera_is_solved_to_its_minimum(monkeypatch):
    """Damping that holds a mode which all measurements share stopped 2.5e-4 short of it here, and
    5e-3 on a dive of 1,400 images, where its sigma was 5e-4.
    """
    measured = simulate(stereo=False, cad=False, ranges=False, landmarks=4000, per_leg=60).measured
    options = AdjustOptions(max_iterations=200)
    found = adjust(measured, options, lambda line: None)
    monkeypatch.setattr(rounds, "FUNCTION_TOLERANCE", 1e-12)
    monkeypatch.setattr(rounds, "COARSE_TOLERANCE", 1e-11)
    at_minimum = adjust(measured, options, lambda line: None)
    assert found.state.navigation[SCALE] == pytest.approx(
        at_minimum.state.navigation[SCALE], abs=2e-5
    )


def test_path_without_camera_beats_dead_reckoning():
    found = solved(camera=False)
    reckoned, truth = (
        found.dive.measured.trajectory.translation,
        found.dive.global_from_vehicle[:, :3, 3],
    )
    before = np.sqrt(np.mean(np.sum((moved(aligning(reckoned, truth), reckoned) - truth) ** 2, 1)))
    assert np.sqrt(np.mean(np.sum(found.position_errors_m() ** 2, 1))) < 0.7 * before
    assert len(found.outcome.solution.landmarks) == 0
    assert found.adjusted.state.mounts.tray_from_top is None


def test_last_round_drops_observations_beyond_outlier_limit(monkeypatch):
    dive = simulate(cad=False)
    top, rng = dive.measured.tracks.top.copy(), np.random.default_rng(8)
    wrong = np.flatnonzero(np.isfinite(top[:, 0]) & (rng.random(len(top)) < 0.03))
    top[wrong, 0] += 6 * PIXEL_NOISE_PX  # below the 2 px to which the rounds before it reach
    tracks = replace(dive.measured.tracks, top=top)
    monkeypatch.setattr(weighting, "MIN_SIGMA_PX", 0.1)
    measured = replace(dive.measured, tracks=tracks)
    chosen = adjust(measured, AdjustOptions(), lambda line: None).chosen
    assert chosen.top[wrong].mean() < 0.2
    assert chosen.top[np.isfinite(top[:, 0])].mean() > 0.94


def test_an_observation_is_left_out_by_its_own_sigma():
    dive = simulate(cad=False)
    tracks, rng = dive.measured.tracks, np.random.default_rng(8)
    weak, seen = tracks.landmark % 2 == 0, np.isfinite(tracks.top[:, 0])
    top = tracks.top + np.where(weak, 4 * PIXEL_NOISE_PX, 0.0)[:, None] * rng.standard_normal(
        tracks.top.shape
    )
    bottom = tracks.bottom + np.where(weak, 4 * PIXEL_NOISE_PX, 0.0)[:, None] * rng.standard_normal(
        tracks.bottom.shape
    )
    off = seen & (rng.random(len(top)) < 0.03)
    top[off, 0] += 8 * PIXEL_NOISE_PX  # two sigmas of a weak feature, eight of a strong one
    tracks = replace(tracks, top=top, bottom=bottom, response=np.where(weak, 0.02, 0.08))
    chosen = adjust(
        replace(dive.measured, tracks=tracks), AdjustOptions(), lambda line: None
    ).chosen
    assert chosen.top[off & ~weak].mean() < 0.2
    assert chosen.top[off & weak].mean() > 0.9


@pytest.mark.parametrize("case", [c for c in WITH_CAD if c != "as published"])
def test_the_hull_lies_within_three_of_its_sigmas(case):
    found = of(case)
    error, covariance = found.hull_error(), found.outcome.solution.hull_pose.covariance
    assert np.all(np.abs(error) < 3 * np.sqrt(np.diag(covariance)))
    # 99 % of chi-square with six degrees of freedom
    assert error @ np.linalg.solve(covariance, error) < 16.8


@pytest.mark.parametrize("case", ["stereo with CAD", "mono with CAD"])
def test_vehicle_in_hull_frame_is_within_three_sigmas(case):
    found = of(case)
    sigma = np.sqrt(np.einsum("nii->ni", found.outcome.solution.pose_covariance))
    assert np.all(np.abs(found.pose_errors_in_hull()) < 3 * sigma)


@pytest.mark.parametrize(
    "case",
    ["stereo with CAD", "mono with CAD", "labels by an outer loop", "no ranges", "as published"],
)
def test_landmarks_are_told_on_the_hull_from_off_it(case):
    found = of(case)
    label = found.outcome.solution.landmarks.label
    assert (~found.on_hull_truth).sum() > 20
    assert np.mean(label[found.on_hull_truth] == 1) > 0.98
    assert np.mean(label[~found.on_hull_truth] == 0) > 0.95


def test_the_distance_of_the_boxs_face_is_its_height():
    found = of("stereo with CAD")
    x, _, z = moved(np.linalg.inv(TRUTH), found.landmark_truth[~found.on_hull_truth]).T
    expected = BOX_M[4] + true_deviation(x, z)
    np.testing.assert_allclose(
        found.outcome.solution.landmarks.deviation[~found.on_hull_truth], expected, atol=0.015
    )


def test_a_model_onto_which_nothing_is_laid_is_left_out():
    measured = replace(simulate(cad=True).measured, returns=None)
    found = adjust(measured, AdjustOptions(), lambda _: None, Strategy(method="naive"))
    assert (
        found.verdict.reason
        == "the method naive puts no landmark on it, and there is no range of a DVL"
    )
    assert summarise_adjustment(measured, found, AdjustOptions()).solution.hull_pose is None


def test_naive_draws_no_landmark_to_the_hull_and_geva_draws_all():
    assert not of("stereo with CAD, no landmark on it").outcome.solution.landmarks.label.any()
    assert of("stereo with CAD, every landmark on it").outcome.solution.landmarks.label.all()


@pytest.mark.parametrize("case", [c for c in CASES if c != "as published"])
def test_errors_of_dvl_heading_and_servo_are_found(case):
    navigation = of(case).outcome.solution.navigation_errors
    assert navigation[SCALE] == pytest.approx(NAVIGATION[SCALE], abs=5e-3)  # prior sigma 10e-3
    assert navigation[DRIFT] == pytest.approx(NAVIGATION[DRIFT], abs=4e-4)  # prior sigma 1e-3
    # prior sigma 14e-3
    assert navigation[BACKLASH] == pytest.approx(NAVIGATION[BACKLASH], abs=5e-4)


@pytest.mark.parametrize("case", [c for c in CASES if c != "as published"])
def test_biases_that_nothing_resolves_stay_within_their_priors(case):
    navigation = of(case).outcome.solution.navigation_errors
    unresolved = [ROLL, PITCH, DEPTH]
    assert np.all(np.abs(navigation - NAVIGATION)[unresolved] < 3 * NAVIGATION_SIGMA[unresolved])


def test_as_published_has_no_systematic_errors_and_no_field():
    state = of("as published").adjusted.state
    assert not state.navigation.any()
    assert state.hull.grid is None
    np.testing.assert_array_equal(
        state.mounts.tray_from_dvl.matrix(), simulate().measured.rig.tray_from_dvl.matrix()
    )


def test_the_tray_angles_are_freed_of_their_backlash():
    found = of("stereo with CAD")
    logged = found.dive.measured.trajectory.tray - found.dive.tray
    assert np.median(np.abs(logged)) > 5e-3
    assert np.median(np.abs(found.outcome.solution.tray - found.dive.tray)) < 1e-3


@pytest.mark.parametrize("case", ["stereo with CAD", "mono with CAD", "a single round"])
def test_the_field_follows_the_bump_that_the_cad_model_lacks(case):
    found = of(case)
    state, solution = found.adjusted.state, found.outcome.solution
    on = solution.landmarks.label == 1
    at = hull_chart().to_chart(state.hull.to_hull(solution.landmarks.position[on]))[:, :2]
    field = state.hull.grid.value(state.hull.field, at)
    x, _, z = moved(np.linalg.inv(TRUTH), found.landmark_truth[on]).T
    truth = true_deviation(x, z)
    assert np.corrcoef(field, truth)[0, 1] > 0.85
    assert np.std(field - truth) < 0.5 * np.std(truth)


def test_the_pixel_sigma_is_that_of_the_noise():
    assert of("stereo with CAD").outcome.summary["sigmas"]["pixel_px"] == pytest.approx(
        PIXEL_NOISE_PX, rel=0.15
    )


def test_two_runs_give_the_same_bytes_whatever_the_threads():
    once = of("stereo with CAD")
    assert once.options.threads == 2
    again = adjust(once.dive.measured, AdjustOptions(threads=1), lambda _: None)
    once = once.adjusted
    for name, values in vars(once.result.unknowns).items():
        assert values.tobytes() == getattr(again.result.unknowns, name).tobytes(), name
    assert (
        once.state.hull.global_from_hull.translation.tobytes()
        == again.state.hull.global_from_hull.translation.tobytes()
    )
    assert once.state.landmark.tobytes() == again.state.landmark.tobytes()
    assert once.result.label.tobytes() == again.result.label.tobytes()


def test_each_round_is_told_in_a_line_with_its_landmarks():
    told = []
    adjust(simulate().measured, AdjustOptions(rounds=2), told.append)
    # a round without the CAD model, its registration, a round and the last one with it
    assert len(told) == 4
    assert "points to the CAD model" in told[1]
    assert [line.split(":")[0] for line in (told[0], *told[2:])] == [
        "round 1",
        "round 2",
        "round 3",
    ]
    assert "0 on the hull" in told[0]
