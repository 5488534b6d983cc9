# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""State and measurements to a native problem and back."""

from dataclasses import replace
from operator import attrgetter

import numpy as np
import pytest
from adjustment.simulated_dive import (
    GLOBAL_FROM_HULL,
    NAVIGATION,
    SEMI_AXES_M,
    TRAY_FROM_DVL,
    TRAY_NOISE_RAD,
    TRAY_ORIGIN_M,
    cad_hull,
    matrix,
    moved,
    records_poses,
    simulate,
)
from adjustment.solved_dives import solved
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hullrecon import native
from hullrecon.adjustment.options import PRODUCT
from hullrecon.adjustment.problem import selection, weighting
from hullrecon.adjustment.problem.assembly import (
    assemble,
    share_weight_by_cell,
    state_from_unknowns,
)
from hullrecon.adjustment.problem.deviation_field import grid_over
from hullrecon.adjustment.problem.observations import landmark_count
from hullrecon.adjustment.problem.state import HullState, State
from hullrecon.geometry.poses import Poses
from hullrecon.records.solution import Mounts

CENTER = np.array([0.1, 2.4, 0.2])
SEEN_BY = ("stereo", "mono", "none")


def some_poses(rng, n=1):
    return Poses(Rotation.random(n, rng=rng).as_quat(), rng.normal(0, 5, (n, 3)))


def with_mounts(state, **mounts):
    return replace(state, mounts=replace(state.mounts, **mounts))


def some_state(rng, measured, stereo, cad, camera):
    """Any state that fits the measurements in its shapes."""
    n, count = len(measured.trajectory.t_ns), landmark_count(measured)
    return State(
        nodes=some_poses(rng, n),
        tray=rng.normal(0, 1, n),
        landmark=rng.normal(0, 5, (count, 3)),
        mounts=Mounts(
            tray_from_dvl=some_poses(rng),
            tray_from_top=some_poses(rng) if camera else None,
            top_from_bottom=some_poses(rng) if camera and stereo else None,
        ),
        navigation=rng.normal(0, 1, 6),
        hull=some_hull(rng, measured.cad_model) if cad else None,
    )


def some_hull(rng, cad_model):
    grid = grid_over(rng.uniform(0, 4, (20, 2)), (3.0, 1.5))
    return HullState(
        cad_model=cad_model,
        global_from_hull=some_poses(rng),
        survey_center=CENTER,
        grid=grid,
        field=rng.normal(0, 0.02, grid.size),
    )


def chosen_from(rng, measured):
    """Some landmarks, observations and returns."""
    count = landmark_count(measured)
    rows = 0 if measured.tracks is None else len(measured.tracks.node)
    returns = 0 if measured.returns is None else len(measured.returns.node)
    top, bottom = (rng.random(rows) < 0.7 for _ in range(2))
    landmarks = np.flatnonzero(rng.random(count) < 0.6)
    rays = np.zeros(count, np.int32)
    if rows:
        rays += np.bincount(measured.tracks.landmark, top + 1 * bottom, count).astype(np.int32)
    return selection.Selection(top, bottom, rng.random(returns) < 0.8, landmarks, rays)


def true_state(dive):
    """The truth as a state, its field on a grid of zeros."""
    m = dive.measured
    start = solved().adjusted.state
    hull = replace(
        start.hull,
        global_from_hull=records_poses(GLOBAL_FROM_HULL),
        survey_center=CENTER,
        field=0 * start.hull.field,
    )
    return replace(
        start,
        nodes=records_poses(dive.global_from_vehicle),
        tray=dive.tray,
        landmark=dive.landmark,
        navigation=NAVIGATION,
        hull=hull if m.cad_model is not None else None,
    )


def problem_at(dive, state, **held):
    chosen = selection.select_measurements(dive.measured, state, 40.0)
    weights = weighting.initial_weights(dive.measured, PRODUCT)
    return (
        assemble(
            dive.measured, state, weights, chosen, held.pop("systematic_errors", True), **held
        ),
        chosen,
        weights,
    )


def assert_same_motion(a, b):
    """T_a_b equal, whichever sign their quaternions have."""
    if a is None or b is None:
        assert a is b
        return
    np.testing.assert_allclose(a.matrix(), b.matrix(), atol=1e-12)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(seed=st.integers(0, 2**32 - 1), seen_by=st.sampled_from(SEEN_BY), cad=st.booleans())
def test_a_state_comes_back_as_it_went_in(seed, seen_by, cad):
    rng = np.random.default_rng(seed)
    stereo, camera = seen_by == "stereo", seen_by != "none"
    measured = simulate(stereo=stereo, cad=cad, camera=camera, per_leg=3, landmarks=60).measured
    state = some_state(rng, measured, stereo, cad, camera)
    chosen = chosen_from(rng, measured)
    weights = weighting.initial_weights(measured, PRODUCT)
    problem = assemble(measured, state, weights, chosen, systematic_errors=True)
    back = state_from_unknowns(state, problem.unknowns, chosen)
    for name in ("nodes", "mounts.tray_from_top", "mounts.top_from_bottom", "mounts.tray_from_dvl"):
        assert_same_motion(attrgetter(name)(back), attrgetter(name)(state))
    for name in ("tray", "navigation"):
        np.testing.assert_array_equal(getattr(back, name), getattr(state, name))
    np.testing.assert_array_equal(back.landmark[chosen.landmarks], state.landmark[chosen.landmarks])
    out = np.setdiff1d(np.arange(len(state.landmark)), chosen.landmarks)
    assert np.isnan(back.landmark[out]).all()
    if state.hull is None:
        assert back.hull is None
        return
    assert_same_motion(back.hull.global_from_hull, state.hull.global_from_hull)
    np.testing.assert_array_equal(back.hull.field, state.hull.field)
    assert back.hull.grid is state.hull.grid


@pytest.mark.parametrize("factor", ["odometry", "attitude", "tray"])
def test_truth_leaves_residuals_of_one_sigma(factor):
    dive = simulate()
    state = with_mounts(true_state(dive), tray_from_dvl=records_poses(TRAY_FROM_DVL))
    chosen = selection.select_measurements(dive.measured, state, 40.0)
    weights = replace(weighting.initial_weights(dive.measured, PRODUCT), tray=TRAY_NOISE_RAD)
    found = native.evaluate(assemble(dive.measured, state, weights, chosen, systematic_errors=True))
    rows = found.residual[found.factor == native.FACTORS.index(factor)]
    assert np.sqrt(np.mean(rows**2)) == pytest.approx(1.0, abs=0.25)


def test_problem_hull_frame_is_at_survey_centre():
    dive = simulate()
    problem, _, _ = problem_at(dive, true_state(dive))
    hull = Poses(problem.unknowns.T_g_M[None, 3:], problem.unknowns.T_g_M[None, :3])
    expected = moved(GLOBAL_FROM_HULL, cad_hull().vertices)
    np.testing.assert_allclose(hull.apply(problem.cad_mesh.vertices), expected, atol=1e-9)


def test_every_observation_chosen_stands_in_one_table_once():
    dive = simulate()
    problem, chosen, _ = problem_at(dive, true_state(dive))
    tracks = dive.measured.tracks
    known = np.isin(tracks.landmark, chosen.landmarks)
    assert len(problem.stereo.node) == (known & chosen.top & chosen.bottom).sum()
    assert len(problem.mono.node) == (known & (chosen.top ^ chosen.bottom)).sum()
    assert set(np.unique(problem.mono.camera)) == {0, 1}
    seen = np.flatnonzero(known & chosen.top & chosen.bottom)
    np.testing.assert_array_equal(chosen.landmarks[problem.stereo.landmark], tracks.landmark[seen])
    np.testing.assert_array_equal(
        problem.stereo.pixel, np.hstack([tracks.top[seen], tracks.bottom[seen]])
    )
    assert np.isfinite(problem.mono.pixel).all()


def test_mono_rig_has_no_stereo_rows():
    dive = simulate(stereo=False)
    state = with_mounts(true_state(dive), top_from_bottom=None)
    problem, _, _ = problem_at(dive, state)
    assert len(problem.stereo.node) == 0
    assert not problem.mono.camera.any()
    assert "T_ct_cb" in problem.constant


@pytest.mark.parametrize(
    ("scene", "options", "held"),
    [
        ({}, {}, {"T_ct_cb"}),
        ({}, {"hold_hull_pose": True}, {"T_ct_cb", "T_g_M"}),
        ({}, {"systematic_errors": False}, {"T_ct_cb", "T_s_d", "navigation"}),
        ({"cad": False}, {}, {"T_ct_cb", "T_g_M", "deviation"}),
        ({"camera": False}, {}, {"T_ct_cb", "T_s_ct"}),
    ],
)
def test_what_is_calibrated_absent_or_asked_to_stay_is_held(scene, options, held):
    dive = simulate(**scene)
    problem, _, _ = problem_at(dive, true_state(dive), **options)
    assert set(problem.constant) == held | {"intrinsics_top", "intrinsics_bottom"}


def ellipsoid_hits(origin, direction):
    """Where rays in M first meet the CAD model's ellipsoid, (n, 3); NaN where they pass it."""
    o, d = origin / SEMI_AXES_M, direction / SEMI_AXES_M
    a, b, c = (d * d).sum(1), (o * d).sum(1), (o * o).sum(1) - 1
    inside = b * b - a * c
    length = (-b - np.sqrt(np.where(inside > 0.01, inside, np.nan))) / a
    return origin + length[:, None] * direction


def test_the_beams_meet_the_field_where_they_meet_the_cad_model():
    """Their four weights at the nodes give back the chart's coordinates of the beam's first point
    on the ellipsoid.
    """
    dive = simulate()
    state = with_mounts(true_state(dive), tray_from_dvl=records_poses(TRAY_FROM_DVL))
    problem, chosen, _ = problem_at(dive, state)
    returns = dive.measured.returns
    assert chosen.returns.all()
    assert len(problem.ranges.measured) == len(returns.node)
    ping = dive.global_from_vehicle[returns.node] @ matrix(
        returns.translation, Rotation.from_quat(returns.quaternion)
    )
    angle = (dive.tray[returns.node] + returns.tray_offset)[:, None]
    tray = matrix(np.tile(TRAY_ORIGIN_M, (len(angle), 1)), Rotation.from_euler("y", angle))
    hull_from_dvl = np.linalg.inv(GLOBAL_FROM_HULL) @ ping @ tray @ TRAY_FROM_DVL
    hits = ellipsoid_hits(
        hull_from_dvl[:, :3, 3], np.einsum("nij,nj->ni", hull_from_dvl[:, :3, :3], returns.beam)
    )
    row, column = np.divmod(problem.ranges.field.index, state.hull.grid.shape[1])
    node = state.hull.grid.origin + np.stack([row, column], -1) * state.hull.grid.step
    found = np.einsum("nk,nkc->nc", problem.ranges.field.weight, node)
    met = np.isfinite(hits[:, 0])
    assert met.mean() > 0.9
    np.testing.assert_allclose(
        found[met], dive.measured.cad_model.chart.to_chart(hits[met])[:, :2], atol=0.01
    )


def test_missing_beam_takes_field_at_measured_end():
    dive = simulate()
    turned = dive.measured.returns.beam * [1, 1, -1]  # away from the hull
    measured = replace(dive.measured, returns=replace(dive.measured.returns, beam=turned))
    state = true_state(dive)
    chosen, weights = (
        selection.select_measurements(measured, state, 40.0),
        weighting.initial_weights(measured, PRODUCT),
    )
    problem = assemble(measured, state, weights, chosen, systematic_errors=True)
    np.testing.assert_allclose(problem.ranges.field.weight.sum(1), 1.0)
    assert (problem.ranges.field.index < state.hull.grid.size).all()


def test_without_a_field_ranges_and_landmarks_have_no_nodes():
    dive = simulate()
    state = true_state(dive)
    problem, _, _ = problem_at(
        dive, replace(state, hull=replace(state.hull, grid=None, field=np.zeros(0)))
    )
    assert problem.ranges.field.index.shape == problem.surface.field.index.shape == (0, 4)
    assert len(problem.unknowns.deviation) == 0


def test_weights_go_into_the_tables_of_their_measurements():
    dive = simulate()
    state = true_state(dive)
    chosen = selection.select_measurements(dive.measured, state, 40.0)
    first = weighting.initial_weights(dive.measured, PRODUCT)
    surface = np.linspace(0.1, 1.0, len(state.landmark))
    weights = replace(first, pixel=0.7, depth=0.5, tray=0.003, range_sigma=0.02, surface=surface)
    problem = assemble(dive.measured, state, weights, chosen, systematic_errors=True)
    assert problem.sigma_px == 0.7
    np.testing.assert_allclose(problem.attitude.sigma, dive.measured.attitude.sigma * [0.5, 1, 1])
    assert set(problem.tray.sigma) == {0.003}
    assert set(problem.ranges.sigma) == {0.02}
    np.testing.assert_array_equal(problem.surface.weight, surface[chosen.landmarks])


def test_odometry_enters_whitened_by_its_covariance():
    dive = simulate()
    problem, _, _ = problem_at(dive, true_state(dive))
    white = (
        problem.odometry.sqrt_information
        @ dive.measured.odometry.covariance
        @ problem.odometry.sqrt_information.transpose(0, 2, 1)
    )
    np.testing.assert_allclose(white, np.tile(np.eye(6), (len(white), 1, 1)), atol=1e-9)


def test_image_odometry_between_linked_nodes_is_dropped():
    dive = simulate()
    odometry, tracks = dive.measured.odometry, dive.measured.tracks
    m = len(odometry)
    # nothing was seen there
    blind = np.isin(tracks.node, [odometry.first[4], odometry.second[4]])[:, None]
    seen = replace(
        tracks,
        top=np.where(blind, np.nan, tracks.top),
        bottom=np.where(blind, np.nan, tracks.bottom),
    )
    by_images = np.arange(m) != 2
    measured = replace(
        dive.measured, tracks=seen, odometry=replace(odometry, from_images=by_images)
    )
    state = true_state(dive)
    chosen = selection.select_measurements(measured, state, 40.0)
    problem = assemble(
        measured,
        state,
        weighting.initial_weights(measured, PRODUCT),
        chosen,
        systematic_errors=True,
    )
    used = (chosen.top | chosen.bottom) & np.isin(seen.landmark, chosen.landmarks)
    common = [
        len(
            np.intersect1d(
                seen.landmark[used & (seen.node == i)], seen.landmark[used & (seen.node == j)]
            )
        )
        for i, j in zip(odometry.first, odometry.second, strict=True)
    ]
    kept = ~by_images | (np.array(common) < 12)
    assert {2, 4} <= set(np.flatnonzero(kept).tolist())
    assert kept.sum() < m / 2
    np.testing.assert_array_equal(problem.odometry.first, odometry.first[kept])
    np.testing.assert_array_equal(problem.odometry.second, odometry.second[kept])


@pytest.mark.parametrize("levelled", [True, False])
def test_the_first_pose_fixes_what_no_sensor_measures(levelled):
    """With roll, pitch and depth measured, x, y and heading alone; else all six."""
    dive = simulate()
    attitude = dive.measured.attitude
    if not levelled:
        attitude = replace(
            attitude,
            node=attitude.node[:0],
            depth=attitude.depth[:0],
            roll=attitude.roll[:0],
            pitch=attitude.pitch[:0],
            sigma=attitude.sigma[:0],
            nodes_per_reading=attitude.nodes_per_reading[:0],
        )
    measured = replace(dive.measured, attitude=attitude)
    problem, _, _ = problem_at(replace(dive, measured=measured), true_state(dive))
    to_global = Rotation.from_quat(measured.trajectory.quaternion[0]).as_matrix()
    # by steps in g
    rows = problem.priors.pose.sqrt_information[0] @ np.kron(np.eye(2), to_global.T)
    sigma = 1 / np.linalg.norm(rows, axis=0)
    assert (sigma < 1e-3).tolist() == (
        [True, True, False, False, False, True] if levelled else [True] * 6
    )


def test_landmarks_of_one_cell_share_one_observations_weight():
    dive = simulate()
    state = true_state(dive)
    landmarks = np.arange(0, len(state.landmark), 2)
    weight = share_weight_by_cell(state.hull, state.landmark, landmarks, (0.5, 0.5))
    assert set(weight[1::2]) == {1.0}
    cells = dive.measured.cad_model.chart.to_chart(state.hull.to_hull(state.landmark[landmarks]))[
        :, :2
    ]
    occupied = len(np.unique(np.floor(cells / 0.5), axis=0))
    assert weight[landmarks].sum() == pytest.approx(occupied)
