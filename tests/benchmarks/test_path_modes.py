# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The benchmark of what limits a path's shape: its sigmas are those of the solver, its modes slow
shapes and no motions.
"""

from __future__ import annotations

import numpy as np
import pytest
from adjustment.simulated_dive import simulate

from benchmarks import path_modes
from benchmarks.path_modes import Mode
from hullrecon import native
from hullrecon.adjustment.bundle_adjustment import adjust
from hullrecon.adjustment.options import AdjustOptions

ALONG = np.linspace(-3.0, 5.0, 40)
POSITIONS = np.stack([ALONG, 0.02 * ALONG**2, 1.0 + 0.3 * np.sin(ALONG)], axis=1)


@pytest.fixture(scope="module")
def solved() -> native.Problem:
    """The tiny dive's problem at its solution, without a CAD model."""
    measured = simulate(cad=False).measured
    adjusted = adjust(measured, AdjustOptions(), lambda _sentence: None)
    return adjusted.problem.started_from(adjusted.result.unknowns)


def one_pose(count: int, pose: int, axis: int) -> Mode:
    """Return the mode whose component is one coordinate of one pose."""
    displacement = np.zeros((count, 3))
    displacement[pose, axis] = count
    return Mode(name="one pose", displacement=displacement)


def test_the_sigma_of_one_coordinate_is_the_solver_s(solved: native.Problem) -> None:
    count = len(solved.unknowns.pose)
    modes = [
        one_pose(count, pose, axis) for pose in (1, count // 2, count - 1) for axis in range(3)
    ]
    marginal = native.covariance(solved).pose
    expected = [
        np.sqrt(marginal[pose, axis, axis])
        for pose in (1, count // 2, count - 1)
        for axis in range(3)
    ]
    known = path_modes.how_well_known(solved, native.Options(), modes)
    np.testing.assert_allclose([one.sigma for one in known], expected, rtol=1e-4)


def test_the_factors_shares_are_the_whole_information(solved: native.Problem) -> None:
    for known in path_modes.how_well_known(
        solved, native.Options(), path_modes.modes_of(solved.unknowns.pose[:, :3])
    ):
        assert sum(known.share.values()) == pytest.approx(1.0, abs=0.01)


def test_the_modes_are_a_scale_and_bends_of_rms_one() -> None:
    modes = path_modes.modes_of(POSITIONS)
    assert [mode.name for mode in modes] == [
        "scale",
        "bend across",
        "double bend across",
        "bend off the hull",
        "double bend off the hull",
    ]
    for mode in modes:
        assert (mode.displacement**2).sum(axis=1).mean() == pytest.approx(1.0)


def test_long_path_shows_in_the_scale_and_a_bend_as_bend() -> None:
    scale, *bends = path_modes.modes_of(POSITIONS)
    gap = POSITIONS - POSITIONS.mean(axis=0)
    assert path_modes.component(scale, 0.01 * gap) == pytest.approx(
        0.01 * np.sqrt((gap**2).sum(axis=1).mean())
    )
    for bend in bends:
        for other in bends:
            expected = 0.003 if bend is other else 0.0
            assert path_modes.component(other, 0.003 * bend.displacement) == pytest.approx(
                expected, abs=1e-9
            )
        assert bend.displacement.mean(axis=0) == pytest.approx(0, abs=1e-12)
