# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from drafts import Draft, leaves
from native.test_cores import problem
from native.test_covariance import dense_covariance
from native.test_links import circle

from hullrecon.errors import InputError, StageError
from hullrecon.geometry.poses import Poses, exp
from hullrecon.native import (
    LinkKernel,
    Options,
    PairCovariance,
    covariance,
    evaluate,
    pair_covariance,
    solve,
)

Survey = Callable[..., Draft]


def all_pairs(n: int) -> np.ndarray:
    i, j = np.meshgrid(np.arange(n), np.arange(n))
    return np.random.default_rng(0).permutation(np.c_[i.ravel(), j.ravel()])


def assert_equals_dense(
    p: Draft,
    got: PairCovariance,
    pairs: np.ndarray,
    options: Options = Options(),  # noqa: B008
) -> None:
    dense, columns = dense_covariance(p, options)

    def block(a: str, b: str) -> np.ndarray:
        """Padded to the width of a whole pose."""
        (i, n), (j, m) = columns.get(a, (0, 0)), columns.get(b, (0, 0))
        out = np.zeros((7 if a.startswith("pose") else 6, 7 if b.startswith("pose") else 6))
        out[:n, :m] = dense[i : i + n, j : j + m]
        return out

    scale = np.abs(dense[:100, :100]).max()
    for k, (i, j) in enumerate(pairs):
        a, b = f"pose {i}", f"pose {j}"
        expected = np.block([[block(a, a), block(a, b)], [block(b, a), block(b, b)]])
        np.testing.assert_allclose(got.pose[k], expected, rtol=1e-6, atol=1e-8 * scale)
        mount = np.vstack([block(a, "T_s_ct"), block(b, "T_s_ct")])
        np.testing.assert_allclose(got.pose_T_s_ct[k], mount, rtol=1e-6, atol=1e-8 * scale)
    np.testing.assert_allclose(got.T_s_ct, block("T_s_ct", "T_s_ct"), rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize(
    "case", ["as it is", "everything free, planes", "links, tray held", "both held", "links alone"]
)
@pytest.mark.parametrize("threads", [1, 2])
def test_every_pair_equals_the_dense_inverse(
    case: str, threads: int, make_survey: Survey, shaken: Survey
) -> None:
    p, pairs = problem(case, make_survey, shaken), all_pairs(8)
    options = Options(method="naive", threads=threads)
    assert_equals_dense(p, pair_covariance(p.build(), pairs, options), pairs, options)


def test_pair_covariance_of_long_path_equals_the_dense_inverse() -> None:
    p, _ = circle(60, np.random.default_rng(1), wrong=0)
    pairs = all_pairs(60)[:500]
    got = pair_covariance(p.build(), pairs)
    assert_equals_dense(p, got, pairs)
    back = pair_covariance(p.build(), pairs[::-1], Options(threads=2))
    np.testing.assert_allclose(back.pose[::-1], got.pose, rtol=1e-9, atol=1e-18)


def test_a_pose_on_its_own_has_the_marginal_of_covariance(make_survey: Survey) -> None:
    p = make_survey().build()
    alone = covariance(p)
    got = pair_covariance(p, np.array([[2, 5], [5, 5]], np.int32))
    np.testing.assert_allclose(got.pose[0, :7, :7], alone.pose[2], rtol=1e-8, atol=1e-18)
    np.testing.assert_allclose(got.pose[0, 7:, 7:], alone.pose[5], rtol=1e-8, atol=1e-18)
    np.testing.assert_allclose(got.pose[1], np.tile(alone.pose[5], (2, 2)), rtol=1e-8, atol=1e-18)
    np.testing.assert_allclose(got.T_s_ct, alone.T_s_ct, rtol=1e-8)


def test_no_pairs_give_empty_tables(make_survey: Survey) -> None:
    assert pair_covariance(make_survey().build(), np.zeros((0, 2), np.int32)).pose.shape == (
        0,
        14,
        14,
    )


@pytest.mark.parametrize(
    ("pairs", "words"),
    [
        (np.array([[0, 8]]), "pose 8 of row 0 is not below 8"),
        (np.array([[0, 1], [-1, 2]]), "pose -1 of row 1"),
        (np.array([[0, 2**31 + 1]]), "is not below 8"),
        (np.array([0, 1]), r"must be \(m, 2\)"),
        (np.array([[0.0, 1.0]]), "wrong type"),
    ],
)
def test_pairs_that_cannot_be_meant_are_refused(
    pairs: np.ndarray, words: str, make_survey: Survey
) -> None:
    with pytest.raises(InputError, match=words) as error:
        pair_covariance(make_survey().build(), pairs)
    assert error.value.where == "pairs"


def test_a_path_that_nothing_ties_down_is_named() -> None:
    p, _ = circle(10, np.random.default_rng(1), wrong=0)
    p.priors.pose.node, p.priors.pose.value = np.zeros(0, np.int32), np.zeros((0, 7))
    p.priors.pose.sqrt_information = np.zeros((0, 6, 6))
    with pytest.raises(StageError, match="undetermined"):
        pair_covariance(p.build(), np.array([[0, 1]]))


def test_the_innovation_of_a_true_candidate_is_chi_square() -> None:
    """Over many draws of the noise, r' (J S J' + 1)^-1 r of a link that the graph does not have
    averages its rows.
    """
    found = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        p, truth = circle(30, rng, wrong=0)
        p.unknowns.pose[:, :3], p.unknowns.pose[:, 3:7] = truth.translation, truth.quaternion
        p.links.kernel[:] = LinkKernel.NONE
        candidate = p.links.first == 3
        candidate[:29] = False
        table = leaves(p.links)
        for name, values in table.items():
            setattr(p.links, name, values[~candidate])
        p.priors.pose.value = truth_draw(truth, rng)
        solved = p.build()
        solved = solved.started_from(solve(solved, Options(function_tolerance=1e-12)).unknowns)
        pair = np.array([[3, 18]])
        free = np.r_[0:6, 7:13]  # the tray is held
        joint = pair_covariance(solved, pair).pose[0][np.ix_(free, free)]
        for name, values in table.items():
            setattr(p.links, name, values[candidate])
        p.unknowns.pose = solved.unknowns.pose
        e = evaluate(p.build())
        rows = np.flatnonzero(e.factor == 9)
        J = np.zeros((6, 12))
        for r, row in enumerate(rows):
            for at in range(e.jacobian_start[row], e.jacobian_start[row + 1]):
                node, k = divmod(int(e.jacobian_column[at]), 6)
                J[r, k + (6 if node == 18 else 0)] = e.jacobian_value[at]
        found.append(
            e.residual[rows] @ np.linalg.solve(J @ joint @ J.T + np.eye(6), e.residual[rows])
        )
    assert 5.1 < np.mean(found) < 7.0  # 6, the mean of 60 within 2.2 of its sigma of 0.45


def truth_draw(truth: Poses, rng: np.random.Generator) -> np.ndarray:
    drawn = truth[:1] @ exp(rng.normal(size=(1, 6)) * 1e-3)
    return np.c_[drawn.translation, drawn.quaternion]
