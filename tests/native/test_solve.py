# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import dataclasses
import signal
import subprocess
import sys
from collections.abc import Callable
from types import FrameType
from typing import Any

import numpy as np
import pytest
from drafts import Draft, change, clear, evaluate, leaves, solve

from hullrecon import native
from hullrecon.errors import InputError, StageError, UsageError
from hullrecon.native import Options

TIGHT = Options(function_tolerance=1e-14, parameter_tolerance=1e-14)
Survey = Callable[..., Draft]


def with_prior(problem: Draft, sigma: float) -> Draft:
    problem.priors.pose.node, problem.priors.pose.value = (
        np.zeros(1, np.int32),
        problem.unknowns.pose[:1, :7].copy(),
    )
    problem.priors.pose.sqrt_information = np.eye(6)[None] / sigma
    return problem


def test_the_toy_graph_of_the_source_gives_thirds(empty: Callable[[int], Draft]) -> None:
    p = with_prior(empty(3), 0.001)
    p.odometry.first, p.odometry.second = (
        np.array([0, 1, 0], np.int32),
        np.array([1, 2, 2], np.int32),
    )
    p.odometry.measured = np.tile([1.0, 0, 0, 0, 0, 0, 1], (3, 1))
    p.odometry.sqrt_information = np.tile(np.eye(6), (3, 1, 1))
    p.odometry.by_navigation, p.odometry.by_mount, p.odometry.by_tray = (
        np.zeros((3, 6, 2)),
        np.zeros((3, 6, 3)),
        np.zeros((3, 6)),
    )
    p.odometry.tray = np.zeros(3)
    got = solve(p, TIGHT).unknowns.pose
    np.testing.assert_allclose(got[:, 0], [0, 2 / 3, 4 / 3], atol=1e-9)
    np.testing.assert_allclose(got[:, 1:6], 0, atol=1e-9)


@pytest.mark.parametrize("method", ["naive", "geva", "maxmix"])
def test_a_shaken_stereo_survey_comes_home(
    method: str, make_survey: Survey, shaken: Survey
) -> None:
    truth = make_survey()
    got = solve(shaken(make_survey()), dataclasses.replace(TIGHT, method=method))
    assert got.converged
    for name in ("pose", "landmark", "T_g_M", "T_s_ct"):
        np.testing.assert_allclose(
            getattr(got.unknowns, name), getattr(truth.unknowns, name), atol=1e-9
        )


def test_one_camera_of_either_kind_comes_home_too(make_survey: Survey, shaken: Survey) -> None:
    truth, p = make_survey(), shaken(make_survey(), 0.01, 0.002)
    rows = len(p.stereo.node)
    p.mono.node, p.mono.landmark = np.tile(p.stereo.node, 2), np.tile(p.stereo.landmark, 2)
    p.mono.camera = np.repeat([0, 1], rows).astype(np.int32)
    p.mono.pixel = np.vstack([p.stereo.pixel[:, :2], p.stereo.pixel[:, 2:]])
    clear(p, "stereo")
    got = solve(p, TIGHT)
    np.testing.assert_allclose(got.unknowns.landmark, truth.unknowns.landmark, atol=1e-7)


def test_one_thread_repeats_its_bytes_and_two_agree_to_rounding(
    make_survey: Survey, shaken: Survey
) -> None:
    runs = [
        solve(shaken(make_survey(pixel_noise=0.5)), Options(threads=threads))
        for threads in (1, 1, 2)
    ]
    first, second, two = (run.unknowns.landmark for run in runs)
    assert first.tobytes() == second.tobytes()
    np.testing.assert_allclose(two, first, atol=1e-8)


def test_the_input_is_not_written_to(make_survey: Survey, shaken: Survey) -> None:
    p = shaken(make_survey())
    before = {path: np.copy(value) for path, value in leaves(p).items()}
    solve(p)
    for path, value in leaves(p).items():
        np.testing.assert_array_equal(value, before[path])


def test_landmarks_on_a_structure_are_off_and_keep_their_height(
    make_survey: Survey,
) -> None:
    p = make_survey()
    raised = np.flatnonzero(np.bincount(p.stereo.landmark, minlength=60) >= 3)[:8]
    higher = make_survey()
    higher.unknowns.landmark[raised] += [0, 0, -0.15]  # z is down in g, the plate looks up
    moved = _project_again(higher)
    moved.surface.weight[:] = 1.0
    by_method = {
        m: solve(moved, dataclasses.replace(TIGHT, method=m)) for m in ("naive", "geva", "maxmix")
    }
    assert set(np.flatnonzero(by_method["maxmix"].label == 0)) == set(raised)
    assert by_method["geva"].label.all()
    assert not by_method["naive"].label.any()
    height = {m: r.distance[raised].mean() for m, r in by_method.items()}
    assert height["maxmix"] == pytest.approx(height["naive"], rel=0.02)
    # squashed onto the hull as in [Ozog2016 Fig. 4.10, 4.11]
    assert height["geva"] < 0.9 * height["maxmix"]


def _project_again(p: Draft) -> Draft:
    """Pixels of the landmarks where they are now: measured plus what the residual says."""
    e = evaluate(p, Options(method="naive"))
    stereo = e.factor == 4
    p.stereo.pixel = p.stereo.pixel + e.residual[stereo].reshape(-1, 4) * p.sigma_px
    return p


def test_the_record_adds_up_and_counts(make_survey: Survey, shaken: Survey) -> None:
    record = solve(shaken(make_survey(pixel_noise=0.3))).iterations
    total = np.sum(list(record.cost_by_factor.values()), axis=0)
    np.testing.assert_allclose(total[record.accepted], record.cost[record.accepted], rtol=1e-9)
    assert (np.diff(record.cost[record.accepted]) <= 0).all()
    np.testing.assert_allclose(record.cost_change[1], record.cost[0] - record.cost[1], rtol=1e-9)
    assert record.on_surface[-1] == 60
    assert (record.rays_missed == 0).all()
    assert (
        len(
            {
                len(getattr(record, f.name))
                for f in dataclasses.fields(record)
                if f.name != "cost_by_factor"
            }
        )
        == 1
    )


def test_held_labels_stay_though_the_landmarks_move(make_survey: Survey) -> None:
    p = make_survey()
    p.unknowns.landmark[:5, 2] -= 0.1
    held = solve(p, dataclasses.replace(TIGHT, labels_in_solve=False))
    free = solve(p, TIGHT)
    assert (held.label[:5] == 0).all()
    assert (held.iterations.label_changes == 0).all()
    assert free.label.all()


def test_held_blocks_do_not_move_and_the_others_do(make_survey: Survey, shaken: Survey) -> None:
    p = shaken(make_survey())
    p.constant = (*p.constant, "T_g_M", "T_s_ct", "tray")
    got = solve(p).unknowns
    for name in ("T_g_M", "T_s_ct", "T_ct_cb", "navigation", "intrinsics_top"):
        np.testing.assert_array_equal(getattr(got, name), getattr(p.unknowns, name))
    np.testing.assert_array_equal(got.pose[:, 7], p.unknowns.pose[:, 7])
    assert (got.pose[:, :3] != p.unknowns.pose[:, :3]).all()


def test_a_beam_that_misses_the_hull_is_switched_off_and_counted(make_survey: Survey) -> None:
    p = make_survey()
    p.ranges.beam[3] = [0, 0, -1.0]
    got = solve(p, TIGHT)
    assert got.ray_hit.sum() == len(got.ray_hit) - 1
    assert not got.ray_hit[3]
    assert (got.iterations.rays_missed == 1).all()
    np.testing.assert_allclose(got.unknowns.pose, p.unknowns.pose, atol=1e-9)


def test_the_field_takes_up_a_hull_that_is_off_its_cad_model(make_survey: Survey) -> None:
    p = make_survey()
    p.constant = ("T_g_M", *(name for name in p.constant if name != "deviation"))
    p.unknowns.deviation = np.zeros(3)
    rows = len(p.surface.landmark)
    p.surface.field.index = np.tile(np.array([0, 1, 1, 2], np.int32), (rows, 1))
    p.surface.field.weight = np.tile([0.5, 0.25, 0.25, 0.0], (rows, 1))
    p.priors.deviation.start, p.priors.deviation.index = (
        np.arange(4, dtype=np.int32),
        np.arange(3, dtype=np.int32),
    )
    p.priors.deviation.value = np.full(3, 1 / 0.5)
    clear(p, "ranges")
    p.cad_mesh.vertices = p.cad_mesh.vertices - [0, 0, 0.03]
    got = solve(p, TIGHT).unknowns
    # 0.03 along z, less along the bumps' normals
    assert got.deviation[:2] == pytest.approx([0.028, 0.028], abs=0.002)
    assert got.deviation[2] == 0
    np.testing.assert_allclose(got.landmark, p.unknowns.landmark, atol=1e-3)


def test_landmark_behind_its_camera_spoils_nothing_else(
    make_survey: Survey, shaken: Survey
) -> None:
    p, truth = shaken(make_survey()), make_survey()
    p.unknowns.landmark[7] = p.unknowns.pose[0, :3] - [0, 0, 3.0]
    got = solve(p, dataclasses.replace(TIGHT, method="naive"))
    others = np.arange(60) != 7
    np.testing.assert_allclose(
        got.unknowns.landmark[others], truth.unknowns.landmark[others], atol=1e-6
    )


def test_the_backlash_of_the_tray_is_found(make_survey: Survey) -> None:
    p = make_survey()
    p.tray.measured = p.tray.measured + 0.01 * p.tray.direction
    p.constant = tuple(name for name in p.constant if name != "navigation")
    assert solve(p, TIGHT).unknowns.navigation[5] == pytest.approx(0.01, rel=0.02)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("unknowns.pose", np.zeros((0, 8))),
        ("unknowns.pose", np.zeros((8, 7))),
        ("unknowns.pose", np.full((8, 8), np.nan)),
        ("unknowns.landmark", np.zeros((60, 2))),
        ("unknowns.T_g_M", np.zeros(7)),
        ("unknowns.navigation", np.zeros(5)),
        ("stereo.node", np.full(222, 8, np.int32)),
        ("stereo.landmark", np.full(222, -1, np.int32)),
        ("stereo.pixel", np.full((222, 4), np.inf)),
        ("stereo.node", np.zeros(222)),
        ("attitude.sigma", np.zeros((8, 3))),
        ("tray.sigma", np.ones(7)),
        ("odometry.second", np.arange(7, dtype=np.int32)),
        ("odometry.sqrt_information", np.zeros((7, 6))),
        ("ranges.beam", np.zeros((32, 3))),
        ("ranges.sigma", -np.ones(32)),
        ("surface.weight", -np.ones(60)),
        ("surface.field.index", np.zeros((60, 4), np.int32)),
        ("cad_mesh.faces", np.array([[0, 1, 9999]], np.int32)),
        ("cad_mesh.faces", np.zeros((0, 3), np.int32)),
        ("cad_mesh.vertices", np.full((625, 3), np.nan)),
        ("priors.T_g_M.value", None),
        ("priors.T_g_M.sqrt_information", np.eye(5)),
        ("priors.deviation.start", np.array([0, 1], np.int32)),
        ("constant", ("everything",)),
        ("sigma_px", 0.0),
        ("unknowns.intrinsics_top", np.zeros(9)),
        ("priors.navigation_sigma", np.zeros(6)),
    ],
)
def test_a_table_that_cannot_be_is_refused_by_name(
    field: str, value: Any, make_survey: Survey
) -> None:
    p = make_survey()
    change(p, field, value)
    with pytest.raises(InputError) as caught:
        solve(p)
    assert caught.value.where.startswith(field.removesuffix(".value"))


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("method", "magic"),
        ("sigma_on", 0.0),
        ("sigma_off", 0.01),
        ("huber_stereo", 0.0),
        ("huber_mono", -1.0),
        ("huber_range", np.nan),
        ("max_iterations", -1),
        ("function_tolerance", np.nan),
        ("initial_radius", np.inf),
        ("threads", 0),
        ("threads", "two"),
    ],
)
def test_an_option_that_cannot_be_meant_is_refused_by_name(
    option: str, value: Any, make_survey: Survey
) -> None:
    with pytest.raises(UsageError) as caught:
        solve(make_survey(), dataclasses.replace(Options(), **{option: value}))
    assert caught.value.where == option


def test_start_that_cannot_be_evaluated_is_an_error(make_survey: Survey) -> None:
    p = make_survey()
    p.unknowns.pose[3, 3:7] = [0, np.sqrt(0.5), 0, np.sqrt(0.5)]  # bow straight up: no roll
    with pytest.raises(StageError, match="solver failed"):
        solve(p)
    with pytest.raises(StageError, match="attitude 3"):
        evaluate(p)


def test_nothing_is_printed(make_survey: Survey, capfd: pytest.CaptureFixture[str]) -> None:
    p = make_survey()
    p.unknowns.pose[3, 3:7] = [0, np.sqrt(0.5), 0, np.sqrt(0.5)]
    with pytest.raises(StageError):
        solve(p)
    solve(make_survey())
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("core", ["schur", "ceres"])
def test_ctrl_c_stops_between_iterations(core: str, make_survey: Survey, shaken: Survey) -> None:
    """A timer's signals reach Python only where the solve looks for them: the frame of `solve` sees
    one before the native call at most and one after it, so a fourth can only have come between two
    iterations.
    """
    p = shaken(make_survey(poses=30, landmarks=800, pixel_noise=0.5))
    in_solve = 0

    def count(_: int, frame: FrameType | None) -> None:
        nonlocal in_solve
        in_solve += frame is not None and frame.f_code is native.solve.__code__
        if in_solve == 4:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.raise_signal(signal.SIGINT)

    options = Options(
        core=core,
        function_tolerance=0.0,
        gradient_tolerance=0.0,
        parameter_tolerance=0.0,
        max_iterations=100000,
    )
    before = signal.signal(signal.SIGALRM, count)
    try:
        signal.setitimer(signal.ITIMER_REAL, 1e-4, 1e-4)
        with pytest.raises(KeyboardInterrupt):
            solve(p, options)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert in_solve == 4


def test_importing_the_interface_does_not_load_the_solver() -> None:
    code = "import sys, hullrecon.native; print('hullrecon._native' in sys.modules)"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "False"


AFTER_A_FORK = """
import os
import numpy as np
from hullrecon.native import AttitudeTable, Options, PosePriors, Priors, Problem, Unknowns, solve

held = ("T_g_M", "T_s_ct", "T_ct_cb", "T_s_d", "navigation", "deviation", "tray")
held += ("intrinsics_top", "intrinsics_bottom")
pose = np.tile([0.0, 0, 0, 0, 0, 0, 1, 0], (40, 1))
node = np.arange(40, dtype=np.int32)
attitude = AttitudeTable(node=node, measured=np.ones((40, 3)), sigma=np.ones((40, 3)))
prior = PosePriors(node=node, value=pose[:, :7], sqrt_information=np.tile(np.eye(6), (40, 1, 1)))
unknowns, priors = Unknowns(pose=pose), Priors(pose=prior)
p = Problem(unknowns=unknowns, constant=held, attitude=attitude, priors=priors)
before = solve(p, Options(threads=2)).unknowns.pose
if (child := os.fork()) == 0:
    os._exit(0 if np.array_equal(solve(p, Options(threads=2)).unknowns.pose, before) else 1)
raise SystemExit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


def test_a_process_forked_after_a_solve_solves_as_well() -> None:
    forked = subprocess.run(
        [sys.executable, "-c", AFTER_A_FORK], capture_output=True, text=True, timeout=120
    )
    assert forked.returncode == 0, forked.stderr
