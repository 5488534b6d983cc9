# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.robust import robust_sigma

NORMAL = np.random.default_rng(1).normal(5.0, 0.2, 20_000)


def test_of_normal_values_it_is_their_sigma() -> None:
    assert robust_sigma(NORMAL) == pytest.approx(0.2, rel=0.03)


def test_a_few_wild_values_hardly_move_it() -> None:
    wild = np.where(np.arange(len(NORMAL)) % 10 == 0, 1e6, NORMAL)
    assert robust_sigma(wild) == pytest.approx(0.2, rel=0.2)


def test_about_a_middle_that_is_known_a_common_offset_counts() -> None:
    assert robust_sigma(np.array([3.0, 3.0, 3.0])) == 0.0
    assert robust_sigma(np.array([3.0, -3.0, 3.0]), about=0.0) == pytest.approx(3 * 1.4826)


def test_of_nothing_it_is_unknown() -> None:
    assert np.isnan(robust_sigma(np.zeros(0)))
