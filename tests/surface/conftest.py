# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.charts.plane_chart import PlaneChart


@pytest.fixture
def wall() -> PlaneChart:
    """A vertical wall at y = 2: along is x, girth is z, the outward normal is y."""
    return PlaneChart(np.array([0.0, 2.0, 0.0]), np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]))


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(11)
