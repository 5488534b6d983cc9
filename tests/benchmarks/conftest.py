# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The small problems, with a pair and with one camera, made once."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from benchmarks.problems import SIZES, Truth, simulate
from hullrecon.geometry.poses import Poses
from hullrecon.native import Problem


@pytest.fixture(scope="session", params=["small", "small_mono"])
def size_name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="session")
def small(size_name: str) -> tuple[Problem, Truth]:
    return simulate(SIZES[size_name])


def seven(pose: Poses) -> np.ndarray:
    return np.r_[pose.translation[0], pose.quaternion[0]]


@pytest.fixture(scope="session")
def at_truth(small: tuple[Problem, Truth]) -> Problem:
    """The problem started from its truth."""
    problem, truth = small
    unknowns = dataclasses.replace(
        problem.unknowns,
        pose=np.c_[truth.nodes.translation, truth.nodes.quaternion, truth.tray],
        landmark=truth.landmark,
        T_g_M=seven(truth.global_from_hull),
        T_s_ct=seven(truth.tray_from_top),
    )
    return problem.started_from(unknowns)
