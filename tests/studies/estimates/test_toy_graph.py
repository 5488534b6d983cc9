# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.adjustment.problem.selection import label_boundary
from hullrecon.studies.estimates.label_boundary import SIGMA_OFF_M, SIGMA_ON_M, mixture_cost
from hullrecon.studies.estimates.toy_graph import PRINTED_M, TOY, LineFactor, solve_line


def test_the_three_poses_lie_where_they_are_printed() -> None:
    position, covariance = solve_line(TOY)
    np.testing.assert_allclose(position, PRINTED_M, atol=1e-9)
    # by hand: a step of variance 1 beside a detour of 2 is known to 2/3
    assert covariance[2, 2] == pytest.approx(0.001 + 2 / 3)


def test_without_the_closure_steps_add_up() -> None:
    position, _ = solve_line(TOY[:3])
    np.testing.assert_allclose(position, [0, 1, 2], atol=1e-9)


def test_a_surer_closure_pulls_more() -> None:
    sure = (*TOY[:3], LineFactor(first=0, second=2, measured_m=1.0, variance_m2=1e-6))
    assert solve_line(sure)[0][2] == pytest.approx(1.0, abs=1e-5)


def test_the_two_labels_cost_the_same_at_the_boundary() -> None:
    boundary = label_boundary(SIGMA_ON_M, SIGMA_OFF_M)
    assert boundary == pytest.approx(0.05595, abs=1e-5)
    on = 0.5 * (boundary / SIGMA_ON_M) ** 2 + np.log(SIGMA_ON_M)
    off = 0.5 * (boundary / SIGMA_OFF_M) ** 2 + np.log(SIGMA_OFF_M)
    assert on == pytest.approx(off)
    assert mixture_cost(np.array([boundary]))[0] == pytest.approx(on)


def test_the_posterior_is_its_product_up_to_a_constant_not_a_factor() -> None:
    """[Ozog2016 eq. 4.6] prints "proportional to": a factor would move the weights of a mixture."""
    at = np.array([0.0, 0.03, 0.2])
    densities = np.exp(-mixture_cost(at))
    posterior = densities / densities.sum()
    gap = np.log(posterior) + mixture_cost(at)
    np.testing.assert_allclose(gap, gap[0])
    ratio = np.log(posterior) / -mixture_cost(at)
    assert np.ptp(ratio) > 0.1
