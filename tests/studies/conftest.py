# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The wall of the evaluation's tests, here as the dive that studies are made of."""

import numpy as np
import pytest
from detection.conftest import scenery, views_at
from evaluation.conftest import block_points, deliver, package, returns, rig, solution, wall_points

__all__ = [
    "block_points",
    "deliver",
    "package",
    "returns",
    "rig",
    "scenery",
    "solution",
    "views_at",
    "wall_points",
]


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(11)
