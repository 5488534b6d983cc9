# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import math

import numpy as np
import pytest

from hullrecon.evaluation.trajectory import rms, rms_length


def test_a_root_mean_square_by_hand() -> None:
    assert rms(np.array([3.0, 4.0])) == pytest.approx(math.sqrt(12.5))
    assert rms_length(np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 5.0]])) == pytest.approx(5)


def test_nothing_has_no_root_mean_square() -> None:
    assert math.isnan(rms(np.zeros(0)))
    assert math.isnan(rms_length(np.zeros((0, 3))))
