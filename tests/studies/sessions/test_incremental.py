# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A session solved pose by pose."""

from __future__ import annotations

import numpy as np

from hullrecon.studies.sessions.incremental import SquareRoot, smooth
from tests.studies.sessions.conftest import Solved


def test_pose_by_pose_ends_where_the_batch_does(solved: Solved) -> None:
    session, _, batch = solved
    going = smooth(session)
    np.testing.assert_allclose(going.state.poses.translation, batch.poses.translation, atol=0.01)
    assert np.median(going.touched / going.columns) < 0.8


def test_rows_that_come_one_by_one_make_the_root_of_all() -> None:
    rng = np.random.default_rng(0)
    rows, residual = rng.normal(size=(9, 4)), rng.normal(size=9)
    rows[:3, 2:] = 0.0  # of the first two columns alone
    root = SquareRoot()
    assert root.add(rows[:3, :2], residual[:3], 2) == 2
    assert root.add(rows[3:], residual[3:], 4) == 4
    np.testing.assert_allclose(root.root.T @ root.root, rows.T @ rows, atol=1e-12)
    expected = np.linalg.lstsq(rows, -residual, rcond=None)[0]
    np.testing.assert_allclose(root.step(), expected, atol=1e-12)
