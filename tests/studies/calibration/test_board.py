# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A camera calibrated by views of a board."""

from __future__ import annotations

import numpy as np

from hullrecon.studies.calibration.board import CAMERA, calibrate, views


def test_exact_corners_give_the_camera_back() -> None:
    found = calibrate(views(np.random.default_rng(0)))
    truth = [CAMERA.fx, CAMERA.fy, CAMERA.cx, CAMERA.cy, CAMERA.k1, CAMERA.k2]
    np.testing.assert_allclose(found.intrinsics[:6], truth, rtol=1e-3)


def test_sigmas_are_those_of_the_scatter() -> None:
    exact, rng = views(np.random.default_rng(0)), np.random.default_rng(1)
    draws = [calibrate([v + 0.5 * rng.standard_normal(v.shape) for v in exact]) for _ in range(25)]
    scatter = np.std([d.intrinsics[:4] for d in draws], axis=0)
    claimed = np.median([d.sigma[:4] for d in draws], axis=0)
    np.testing.assert_allclose(scatter, claimed, rtol=0.35)
