# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.studies.estimates.joint_predictions import KERNEL, joint_covariance, patch_sigmas
from hullrecon.surface.gaussian import fit
from hullrecon.typing import Array

NOISE_M = 0.012


@pytest.fixture
def at(rng: np.random.Generator) -> Array:
    return 4.0 * rng.uniform(size=(40, 2))


def test_its_diagonal_is_that_of_the_marginal_sigmas(at: Array) -> None:
    regression = fit(KERNEL, at, np.zeros(40), np.full(40, NOISE_M))
    wanted = np.array([[1.0, 1.0], [2.0, 2.2], [3.5, 0.4]])
    covariance = joint_covariance(regression, wanted)
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), regression.sigma(wanted))
    assert np.linalg.eigvalsh(covariance)[0] > 0


def test_it_is_the_conditional_of_the_joint_normal(at: Array) -> None:
    """[Ozog2016 E.2, E.3]: of p(z, z_t), printed p(y, z_t), noise on the returns alone.

    Printed is the noise on the test values too. That is the covariance of the next returns.
    """
    wanted = np.array([[1.0, 1.0], [2.0, 2.2]])
    everywhere = np.vstack([at, wanted])
    joint = KERNEL.covariance(everywhere).toarray()
    joint[:40, :40] += NOISE_M**2 * np.eye(40)
    by_hand = np.linalg.inv(np.linalg.inv(joint)[40:, 40:])
    found = joint_covariance(fit(KERNEL, at, np.zeros(40), np.full(40, NOISE_M)), wanted)
    np.testing.assert_allclose(found, by_hand, rtol=1e-7)
    as_printed = joint + np.diag(np.r_[np.zeros(40), np.full(2, NOISE_M**2)])
    printed = np.linalg.inv(np.linalg.inv(as_printed)[40:, 40:])
    np.testing.assert_allclose(printed - found, NOISE_M**2 * np.eye(2), atol=1e-12)


def test_a_mean_is_as_uncertain_as_its_vertices_have_in_common(rng: np.random.Generator) -> None:
    at = 6.0 * rng.uniform(size=(120, 2))
    regression = fit(KERNEL, at, np.zeros(120), np.full(120, NOISE_M))
    line = np.linspace(2.5, 3.5, 6)
    patch = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    sigmas = patch_sigmas(rng, at, regression, [patch])
    assert sigmas.scatter[0] / sigmas.joint[0] == pytest.approx(1.0, abs=0.15)
    assert sigmas.independent[0] < 0.5 * sigmas.joint[0]
    assert sigmas.common[0] > sigmas.joint[0]
