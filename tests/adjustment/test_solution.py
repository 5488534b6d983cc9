# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the adjustment leaves: shapes, frames, covariances, the summary and its warnings."""

import json
from dataclasses import replace

import numpy as np
import pytest
from adjustment.simulated_dive import TRAY_ORIGIN_M, matrix, simulate
from adjustment.solved_dives import solved
from scipy.spatial.transform import Rotation

from hullrecon import native
from hullrecon.adjustment.hull_pose.shape_comparison import ShapeComparison
from hullrecon.adjustment.results.solution import marginal_covariances
from hullrecon.adjustment.results.summary import summarise_adjustment
from hullrecon.records.serialisation import to_arrays

SCENES = {
    "stereo": {},
    "mono": {"stereo": False},
    "no CAD": {"cad": False},
    "no camera": {"camera": False},
    "as published": {"as_published": True},
}
KEYS = {
    "method",
    "converged",
    "message",
    "iterations",
    "rounds",
    "landmarks",
    "on_hull",
    "rays_missed",
    "observations",
    "observations_left_out",
    "sigmas",
    "navigation",
    "navigation_sigma",
    "mounts",
    "weak_directions",
    "residuals_before",
    "residuals_after",
    "cad_model_refused",
    "legs",
    "parts",
}


def with_form(adjusted, form):
    return replace(adjusted, placement=replace(adjusted.placement, shape=form))


@pytest.fixture(params=SCENES, ids=list(SCENES))
def found(request):
    return solved(**SCENES[request.param])


def test_shapes_go_with_nodes_landmarks_and_the_field(found):
    s, n = found.outcome.solution, len(found.dive.tray)
    count = len(found.adjusted.chosen.landmarks)
    assert (len(s.global_from_vehicle), s.tray.shape, s.tray_sigma.shape) == (n, (n,), (n,))
    assert s.pose_covariance.shape == (n, 6, 6)
    assert (s.landmarks.position.shape, s.landmarks.covariance.shape) == ((count, 3), (count, 3, 3))
    assert (
        s.landmarks.label.shape
        == s.landmarks.deviation.shape
        == s.landmarks.views.shape
        == (count,)
    )
    assert s.landmarks.color.shape == (count, 3)
    if s.deviation_field is not None:
        assert s.deviation_field.value.shape == s.deviation_field.sigma.shape
    np.testing.assert_array_equal(s.t_ns, found.dive.measured.trajectory.t_ns)
    np.testing.assert_array_equal(s.image, found.dive.measured.trajectory.image)


def test_covariances_are_symmetric_and_positive_definite(found):
    s = found.outcome.solution
    for covariance in (s.pose_covariance, s.landmarks.covariance):
        np.testing.assert_allclose(covariance, covariance.transpose(0, 2, 1), rtol=1e-6, atol=1e-15)
        assert (np.linalg.eigvalsh(covariance) > 0).all()
    assert (s.tray_sigma > 0).all()
    if found.dive.measured.cad_model is not None:
        assert (np.linalg.eigvalsh(s.hull_pose.covariance) > 0).all()


def test_what_there_is_not_is_none():
    bare = solved(cad=False).outcome.solution
    assert bare.hull_pose is None
    assert np.isnan(bare.landmarks.deviation).all()
    assert not bare.landmarks.label.any()
    assert bare.deviation_field is None
    assert solved(stereo=False).outcome.solution.mounts.top_from_bottom is None
    blind = solved(camera=False).outcome.solution
    assert blind.mounts.tray_from_top is None
    assert np.isfinite(blind.mounts.tray_from_dvl.matrix()).all()


def test_with_cameras_and_a_cad_model_every_field_is_finite():
    s = solved().outcome.solution
    for name, array in to_arrays(s).items():
        assert np.isfinite(array.astype(float)).all(), name


def test_landmarks_count_the_images_that_saw_them():
    found = solved()
    tracks, chosen = found.dive.measured.tracks, found.adjusted.chosen
    expected = [
        int(chosen.top[tracks.landmark == k].sum() + chosen.bottom[tracks.landmark == k].sum())
        for k in chosen.landmarks[:40]
    ]
    assert found.outcome.solution.landmarks.views[:40].tolist() == expected
    assert (found.outcome.solution.landmarks.views >= 2).all()


def test_poses_in_hull_share_sigma_of_hull_pose():
    """The lever from the survey's centre to the vehicle carries the hull's turn into the vehicle's
    place.
    """
    found = solved()
    s = found.outcome.solution
    turn = Rotation.from_quat(s.hull_pose.global_from_hull.quaternion[0]).as_matrix().T
    hull = np.linalg.eigvalsh(turn @ s.hull_pose.covariance[:3, :3] @ turn.T)[-1]
    pose = np.linalg.eigvalsh(s.pose_covariance[:, :3, :3])[:, -1]
    assert (pose > 0.8 * hull).all()
    along = np.sqrt(s.pose_covariance[:, 0, 0])
    # the along-hull place is the weak one
    assert (along > np.sqrt(s.pose_covariance[:, 1, 1])).all()


def test_the_hulls_form_is_no_witness_of_the_path():
    """Held, the field would vouch for the path that made it. Its level is the hull pose's."""
    found = solved()
    problem, settings = found.adjusted.problem.hold("T_g_M"), found.adjusted.settings
    ours = marginal_covariances(found.dive.measured, found.adjusted)
    held, loose = (
        np.einsum("nii->n", native.covariance(p, settings).landmark)
        for p in (problem.hold("deviation"), problem)
    )
    of_ours = np.einsum("nii->n", ours.landmark)
    assert (of_ours > held * (1 - 1e-6)).all()
    assert (of_ours < loose * (1 + 1e-6)).all()
    assert 0 < np.median(of_ours - held) < 0.8 * np.median(loose - held)


def test_the_dvls_held_position_widens_the_vehicles_place_alone():
    """One centimetre in each axis of the tray, turned into M."""
    found = solved()
    rig = found.dive.measured.rig
    held = replace(
        found.dive.measured, rig=rig.with_priors(dvl_position_sigma_m=np.array([0.03, 0.0, 0.0]))
    )
    none = replace(found.dive.measured, rig=rig.with_priors(dvl_position_sigma_m=np.zeros(3)))
    with_lever, without = (
        summarise_adjustment(m, found.adjusted, found.options).solution for m in (held, none)
    )
    added = with_lever.pose_covariance - without.pose_covariance
    np.testing.assert_allclose(added[:, 3:], 0.0, atol=1e-12)
    tray = matrix(
        np.tile(TRAY_ORIGIN_M, (len(added), 1)),
        Rotation.from_euler("y", found.outcome.solution.tray[:, None]),
    )
    hull_from_tray = (
        found.adjusted.state.hull.global_from_hull.inverse().matrix()
        @ with_lever.global_from_vehicle.matrix()
        @ tray
    )
    x = hull_from_tray[:, :3, 0]
    np.testing.assert_allclose(
        added[:, :3, :3], 0.03**2 * x[:, :, None] * x[:, None, :], atol=1e-10
    )
    np.testing.assert_array_equal(with_lever.landmarks.covariance, without.landmarks.covariance)


def test_the_summary_holds_its_keys_and_is_json(found):
    summary = found.outcome.summary
    assert set(summary) == KEYS | (
        {"registration"} if found.dive.measured.cad_model is not None else set()
    )
    json.dumps(summary, allow_nan=False)
    assert summary["landmarks"] == len(found.outcome.solution.landmarks)
    assert summary["on_hull"] == int((found.outcome.solution.landmarks.label == 1).sum())
    assert set(summary["navigation"]) == {
        "dvl_scale",
        "heading_drift_rad_s",
        "roll_bias_rad",
        "pitch_bias_rad",
        "depth_bias_m",
        "tray_backlash_rad",
    }


def test_depth_bias_keeps_prior_where_hull_height_is_unknown(
    found,
):
    sigma, prior = (
        found.outcome.summary["navigation_sigma"],
        found.dive.measured.rig.priors.navigation_sigma,
    )
    if found.options.as_published:  # holds them
        assert sigma == {}
        return
    assert 0.9 * prior[4] < sigma["depth_bias_m"] <= prior[4] * (1 + 1e-9)


def test_observations_are_counted_used_and_left_out():
    found = solved()
    tracks = found.dive.measured.tracks
    seen = np.isfinite(tracks.top[:, 0]).sum() + np.isfinite(tracks.bottom[:, 0]).sum()
    assert (
        found.outcome.summary["observations"] + found.outcome.summary["observations_left_out"]
        == seen
    )


@pytest.mark.parametrize("factor", ["odometry", "stereo", "mono", "range", "attitude", "tray"])
def test_residuals_are_near_one_sigma_after_the_adjustment(factor):
    after = solved().outcome.summary["residuals_after"][factor]
    assert 0.3 < after["robust_sigma"] < 1.5
    # some beams meet the box, which no CAD model shows
    assert after["share_beyond_3"] < (0.06 if factor == "range" else 0.02)


def test_images_fit_worse_before_the_adjustment_than_after():
    summary = solved().outcome.summary
    assert (
        summary["residuals_before"]["stereo"]["rms"]
        > 2 * summary["residuals_after"]["stereo"]["rms"]
    )


def test_iterations_have_a_row_each_over_all_rounds():
    found = solved()
    rounds = found.outcome.iterations["round"]
    # two for the path, one with the CAD model laid under it, the last
    assert set(rounds) == {1, 2, 3, 4}
    assert len(found.outcome.iterations_s) == len(rounds)
    assert (np.diff(found.outcome.iterations_s) >= 0).all()
    assert {len(v) for v in found.outcome.iterations.values()} == {len(rounds)}


def test_the_weak_place_along_the_hull_is_warned_of():
    outcome = solved().outcome
    worst = outcome.summary["weak_directions"][0]
    assert worst["kind"] == "position"
    assert abs(worst["direction"][0]) > 0.9
    assert any("along the hull" in warning for warning in outcome.warnings)
    assert solved(cad=False).outcome.warnings == []


def test_a_solve_that_did_not_converge_is_warned_of():
    found = solved(max_iterations=1, rounds=1)
    assert not found.outcome.summary["converged"]
    assert any("adjust.max_iterations" in warning for warning in found.outcome.warnings)
    raised = solved().outcome
    assert raised.summary["converged"]
    assert not any("adjust.max_iterations" in warning for warning in raised.warnings)


def test_landmarks_mostly_off_the_hull_are_warned_of():
    found = solved()
    off = replace(found.adjusted.result, label=np.zeros_like(found.adjusted.result.label))
    outcome = summarise_adjustment(
        found.dive.measured, replace(found.adjusted, result=off), found.options
    )
    assert any("Fewer than half" in warning for warning in outcome.warnings)


def test_beams_that_miss_the_cad_model_are_warned_of():
    found = solved()
    missed = np.arange(len(found.adjusted.result.ray_hit)) % 5 > 0
    result = replace(found.adjusted.result, ray_hit=missed)
    outcome = summarise_adjustment(
        found.dive.measured, replace(found.adjusted, result=result), found.options
    )
    expected = f"{100 * np.mean(~missed):.0f} % of the DVL's beams miss"
    assert any(warning.startswith(expected) for warning in outcome.warnings)


def test_as_published_the_hulls_covariance_is_the_solves_own():
    found = solved(as_published=True)
    np.testing.assert_allclose(
        found.outcome.solution.hull_pose.covariance,
        native.covariance(found.adjusted.problem, found.adjusted.settings).T_g_M,
        rtol=1e-9,
    )


def test_the_last_problem_stands_at_the_solution():
    adjusted = solved().adjusted
    for name in ("pose", "landmark", "deviation"):
        np.testing.assert_array_equal(
            getattr(adjusted.problem.unknowns, name), getattr(adjusted.result.unknowns, name)
        )
    assert (
        simulate().measured.trajectory.translation.tobytes()
        == adjusted.start.unknowns.pose[:, :3].tobytes()
    )


def test_a_stated_length_tells_the_scale_of_a_plain_patch():
    found = solved()
    plain = ShapeComparison(patterns=20, deviation=0.8, plane=1.0, scale_sigma=(0.5, 0.5, 0.5))
    placed = with_form(found.adjusted, plain).placement
    lies = placed.registration
    stated = replace(lies, cad_model=replace(lies.cad_model, has_stated_length=True))
    outcome = summarise_adjustment(
        found.dive.measured,
        replace(found.adjusted, placement=replace(placed, registration=stated)),
        found.options,
    )
    (said,) = (line for line in outcome.warnings if "too plain to tell" in line)
    assert "scale" not in said


@pytest.mark.parametrize(
    ("form", "said"),
    [
        (
            ShapeComparison(patterns=20, deviation=0.8, plane=90.0, scale_sigma=(0.35, 0.1, 0.2)),
            "proportions and scale to 35 %",
        ),
        (
            ShapeComparison(patterns=20, deviation=0.8, plane=90.0, scale_sigma=(0.02, 0.01, 0.03)),
            None,
        ),
        (
            ShapeComparison(patterns=20, deviation=0.8, plane=1.0, scale_sigma=(0.5, 0.5, 0.5)),
            "too plain to tell",
        ),
        (
            ShapeComparison(
                patterns=40, deviation=3.0, plane=900.0, scale_sigma=(0.02, 0.01, 0.03)
            ),
            "by 1.7 times hull.deviation_sigma",
        ),
    ],
)
def test_what_the_form_of_the_hull_leaves_open_is_said(form, said):
    found = solved()
    outcome = summarise_adjustment(
        found.dive.measured, with_form(found.adjusted, form), found.options
    )
    about_form = [
        line
        for line in outcome.warnings
        if "proportions" in line or "plain" in line or "deviation_sigma" in line
    ]
    assert [said in line for line in about_form] == ([True] if said else [])
