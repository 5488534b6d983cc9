# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A problem in parts takes the steps of the whole, whatever the parts are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from native.test_cores import problem as of_case

from benchmarks.problems import make
from benchmarks.survey import Size
from hullrecon.adjustment.partition.sub_problem import SubProblems
from hullrecon.errors import InputError, StageError
from hullrecon.native import Options, RangeTable, SparseRows, SurfaceTable, covariance, solve
from hullrecon.native.parts import Part, PartsResult, covariance_parts, solve_parts

FREE = ("T_ct_cb", "T_s_d", "navigation", "intrinsics_top", "intrinsics_bottom")


def place(split: SubProblems, found: PartsResult, name: str) -> np.ndarray:
    """Unknowns of the parts, where they stand in the whole."""
    rows = {"pose": split.poses, "landmark": split.landmarks, "deviation": split.nodes}[name]
    out = np.full_like(getattr(split.problem.unknowns, name), np.nan)
    for part, at in zip(found.parts, rows, strict=True):
        out[at] = getattr(part.unknowns, name)
    return out


def expect_the_same(problem, owner, options: Options) -> PartsResult:
    whole = solve(problem, options)
    split = SubProblems(problem, owner)
    found = solve_parts(list(split.parts()), options)
    record, one = found.iterations, whole.iterations
    assert len(record.cost) == len(one.cost)
    # Behind the colon of the message stands a change of cost, which is rounding in parts
    assert found.message.split(":")[0] == whole.message.split(":")[0]
    assert found.converged == whole.converged
    np.testing.assert_array_equal(record.accepted, one.accepted)
    np.testing.assert_allclose(record.cost, one.cost, rtol=1e-10)
    for name in ("on_surface", "label_changes", "rays_missed"):
        np.testing.assert_array_equal(getattr(record, name), getattr(one, name), err_msg=name)
    for name in ("pose", "landmark", "deviation"):
        got = place(split, found, name)
        np.testing.assert_allclose(got, getattr(whole.unknowns, name), rtol=0, atol=1e-9)
    for name in ("T_g_M", "T_s_ct", "T_s_d", "navigation"):
        for part in found.parts:
            np.testing.assert_allclose(
                getattr(part.unknowns, name), getattr(whole.unknowns, name), rtol=0, atol=1e-9
            )
    return found


@pytest.fixture(scope="module")
def side():
    """Four legs along a ship's side, and the stripe along it of each pose."""
    problem = make(Size(poses=160, imaged=150, landmarks=1200, stereo=True, legs=4))
    along = problem.unknowns.pose[:, :2] @ [np.cos(0.7), np.sin(0.7)]
    return problem, np.argsort(np.argsort(along)) * 8 // len(along)


@pytest.mark.parametrize("parts", [1, 2, 8])
def test_parts_of_a_side_take_the_steps_of_the_whole(side, parts):
    problem, stripe = side
    found = expect_the_same(problem, stripe * parts // 8, Options(threads=2))
    assert found.iterations.accepted.sum() > 4


@pytest.mark.parametrize("held", [(), FREE])
def test_parts_with_a_deviation_field_take_the_steps_of_the_whole(make_survey, held):
    draft = make_survey(poses=12, landmarks=80, pixel_noise=0.5)
    nodes, rng = 6, np.random.default_rng(3)
    draft.unknowns.deviation = np.zeros(nodes)
    for table in (draft.ranges, draft.surface):
        rows = len(table.measured if table is draft.ranges else table.weight)
        table.field.index = rng.integers(0, nodes, (rows, 4)).astype(np.int32)
        table.field.weight = np.full((rows, 4), 0.25)
    draft.priors.deviation = SparseRows(
        start=np.arange(nodes + 1, dtype=np.int32),
        index=np.arange(nodes, dtype=np.int32),
        value=np.full(nodes, 50.0),
    )
    draft.unknowns.pose[:, :3] += 0.01 * rng.normal(size=(12, 3))
    owner = np.repeat(np.arange(3), 4)
    expect_the_same(replace(draft.build(), constant=held), owner, Options())


@pytest.mark.parametrize("case", ["everything free, positions", "planes, tray held"])
def test_parts_of_any_tables_take_the_steps_of_the_whole(case, make_survey, shaken):
    survey = of_case(case, make_survey, shaken).build()
    owner = np.arange(len(survey.unknowns.pose)) * 3 // len(survey.unknowns.pose)
    expect_the_same(survey, owner, Options(max_iterations=8))


def test_the_order_of_parts_changes_nothing_that_matters(side):
    problem, stripe = side
    one = SubProblems(problem, stripe)
    other = SubProblems(problem, np.random.default_rng(4).permutation(8)[stripe])
    first, second = (solve_parts(list(split.parts()), Options()) for split in (one, other))
    assert len(first.iterations.cost) == len(second.iterations.cost)
    np.testing.assert_allclose(
        place(one, first, "pose"), place(other, second, "pose"), rtol=0, atol=1e-9
    )


def test_parts_repeat_their_bytes_on_any_number_of_threads(side):
    problem, stripe = side
    parts = list(SubProblems(problem, stripe // 2).parts())
    one, two = (
        solve_parts(parts, Options(threads=threads, max_iterations=4)) for threads in (1, 3)
    )
    np.testing.assert_array_equal(one.iterations.cost, two.iterations.cost)
    for here, there in zip(one.parts, two.parts, strict=True):
        assert here.unknowns.pose.tobytes() == there.unknowns.pose.tobytes()
        assert here.unknowns.landmark.tobytes() == there.unknowns.landmark.tobytes()


def test_parts_in_files_have_the_bytes_of_parts_in_memory(side, tmp_path):
    problem, stripe = side
    parts, options = SubProblems(problem, stripe // 2), Options(max_iterations=4)
    here, there = (solve_parts(parts.parts(), options, folder) for folder in (None, tmp_path))
    np.testing.assert_array_equal(here.iterations.cost, there.iterations.cost)
    for one, other in zip(here.parts, there.parts, strict=True):
        assert one.unknowns.pose.tobytes() == other.unknowns.pose.tobytes()
        assert one.unknowns.landmark.tobytes() == other.unknowns.landmark.tobytes()
        assert one.label.tobytes() == other.label.tobytes()
    found, inverse = (covariance_parts(parts.parts(), options, at) for at in (None, tmp_path))
    for one, other in zip(found, inverse, strict=True):
        assert one.landmark.tobytes() == other.landmark.tobytes()
        assert one.pose.tobytes() == other.pose.tobytes()
    assert not list(tmp_path.iterdir())


def test_a_folder_for_parts_that_is_not_there_is_named(side, tmp_path):
    parts = SubProblems(side[0], side[1] // 4).parts()
    with pytest.raises(FileNotFoundError, match="missing"):
        solve_parts(parts, Options(), tmp_path / "missing")


@pytest.mark.parametrize("parts", [1, 8])
def test_marginals_of_parts_are_those_of_the_whole(side, parts):
    problem, stripe = side
    # The side is so plain that the prior alone tells its place along the hull. Half a metre of that
    # beside tenths of a millimetre leaves eight digits to either way of inverting.
    guess = problem.priors.T_g_M
    near = replace(guess, sqrt_information=50 * guess.sqrt_information)
    problem = replace(problem, priors=replace(problem.priors, T_g_M=near))
    problem = problem.started_from(solve(problem).unknowns)
    whole, split = covariance(problem), SubProblems(problem, stripe * parts // 8)
    found = covariance_parts(list(split.parts()))
    hull = sigmas(whole.T_g_M)
    for part, poses, landmarks in zip(found, split.poses, split.landmarks, strict=True):
        for name, rows in (("pose", poses), ("landmark", landmarks)):
            want, cross = getattr(whole, name)[rows], getattr(whole, f"{name}_T_g_M")[rows]
            expect_close(getattr(part, name), want, sigmas(want), sigmas(want))
            expect_close(getattr(part, f"{name}_T_g_M"), cross, sigmas(want), hull)
        expect_close(part.T_g_M, whole.T_g_M, hull, hull)
        expect_close(part.T_s_ct, whole.T_s_ct, sigmas(whole.T_s_ct), sigmas(whole.T_s_ct))
    for kind, leverage in whole.leverage_by_factor.items():
        np.testing.assert_allclose(
            sum(part.leverage_by_factor[kind] for part in found), leverage, rtol=1e-8, atol=1e-8
        )


def sigmas(covariance):
    return np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))


def expect_close(got, want, first, second):
    """Equal to 1e-9 as correlations."""
    assert (np.abs(got - want) <= 1e-9 * first[..., :, None] * second[..., None, :]).all()


def test_what_no_part_determines_is_refused(side):
    problem, stripe = side
    free = replace(problem, priors=replace(problem.priors, T_g_M=None), ranges=RangeTable())
    free = replace(free, surface=SurfaceTable())
    with pytest.raises(StageError, match="undetermined"):
        covariance_parts(list(SubProblems(free, stripe // 4).parts()))


@pytest.mark.parametrize(
    "shared", [np.array([[99999, 0]]), np.array([[0, -1]]), np.array([[0, 0], [0, 1]])]
)
def test_blocks_that_cannot_be_shared_are_refused(side, shared):
    part = Part(problem=side[0], shared_poses=shared.astype(np.int32))
    with pytest.raises(InputError, match="part"):
        solve_parts([part], Options())


def test_a_number_that_no_part_has_is_refused(side):
    part = Part(problem=side[0], shared_poses=np.array([[3, 1]], np.int32))
    with pytest.raises(InputError, match="no part has shared block 0"):
        solve_parts([part], Options())


def test_marginals_repeat_their_bytes_on_any_number_of_threads(side):
    problem, stripe = side
    parts = list(SubProblems(problem, stripe // 2).parts())
    one, three = (
        [covariance(problem, options), *covariance_parts(parts, options)]
        for options in (Options(threads=1), Options(threads=3))
    )
    for here, there in zip(one, three, strict=True):
        for name in ("pose", "pose_T_g_M", "landmark", "landmark_T_g_M", "T_g_M", "navigation"):
            assert getattr(here, name).tobytes() == getattr(there, name).tobytes(), name
        assert here.leverage_by_factor == there.leverage_by_factor
