# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Displacements of the lenses as unknowns: derivatives, covariances, both cores, what is found."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from drafts import Draft, covariance, evaluate, solve
from native.test_covariance import assert_equal, dense_covariance
from native.test_tray_and_intrinsics import at_known_poses, with_free

from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.native import LENS_MODES, Options

Survey = Callable[..., Draft]
SIZE = np.tile([640.0, 480.0], (2, 1))
IMAGE = CameraModel(640, 480, 1.0, 1.0, 0.0, 0.0)
OPTIONS = Options(method="naive", function_tolerance=1e-13, max_iterations=200)


def lenses(p: Draft, sigma_px: float = 1.0) -> None:
    """Frees the lenses, which start off zero and off their prior."""
    rng = np.random.default_rng(4)
    p.unknowns.lens_top, p.unknowns.lens_bottom = 0.1 * rng.normal(size=(2, 2 * LENS_MODES))
    p.lenses.image_size = SIZE
    p.lenses.sigma_px = np.full((2, 2 * LENS_MODES), sigma_px)
    p.lenses.expected_px = 0.01 * rng.normal(size=(2, 2 * LENS_MODES))


def with_lenses(p: Draft, sigma_px: float = 1.0) -> Draft:
    """Free lenses, and some pairs that are seen by one camera alone."""
    lenses(p, sigma_px)
    few = slice(0, 40)
    p.mono.node = np.tile(p.stereo.node[few], 2)
    p.mono.landmark = np.tile(p.stereo.landmark[few], 2)
    p.mono.camera = np.repeat(np.array([0, 1], np.int32), 40)
    p.mono.pixel = np.vstack([p.stereo.pixel[few, :2], p.stereo.pixel[few, 2:]])
    for name in ("node", "landmark", "pixel"):
        setattr(p.stereo, name, getattr(p.stereo, name)[40:])
    return p


def test_derivatives_by_the_lenses_are_those_of_the_residuals(make_survey: Survey) -> None:
    p = with_lenses(make_survey())
    e = evaluate(p)
    dense = np.zeros((len(e.residual), e.width))
    row = np.repeat(np.arange(len(e.residual)), np.diff(e.jacobian_start))
    dense[row, e.jacobian_column] = e.jacobian_value
    for name in ("lens_top", "lens_bottom"):
        start, width = e.columns[name]
        assert width == 2 * LENS_MODES
        for k in range(width):
            moved = getattr(p.unknowns, name).copy()
            moved[k] += 1.0
            before = getattr(p.unknowns, name)
            setattr(p.unknowns, name, moved)
            found = evaluate(p).residual - e.residual  # they are linear in the numbers
            setattr(p.unknowns, name, before)
            np.testing.assert_allclose(found, dense[:, start + k], atol=1e-9)


def test_covariances_with_lenses_are_those_of_the_dense_inverse(make_survey: Survey) -> None:
    p = with_lenses(make_survey(pixel_noise=0.5), sigma_px=0.3)
    dense, columns = dense_covariance(p, OPTIONS)
    got = covariance(p, OPTIONS)
    for name, found in [
        ("pose 3", got.pose[3]),
        ("landmark 7", got.landmark[7]),
        ("lens_top", got.lens_top),
        ("lens_bottom", got.lens_bottom),
    ]:
        start, width = columns[name]
        assert_equal(found, dense[start : start + width, start : start + width])


@pytest.mark.parametrize("also", [(), ("T_ct_cb", "intrinsics_top", "intrinsics_bottom")])
def test_both_cores_find_the_same_lenses(also: tuple[str, ...], make_survey: Survey) -> None:
    p = with_free(with_lenses(make_survey(poses=8, landmarks=150, pixel_noise=0.3)), *also)
    if also:
        p.priors.intrinsics_sigma = np.r_[1.0, 1, 1, 1, 0.01, 0.01, 0.01, 0.01, 0.01]
        p.priors.T_ct_cb.sqrt_information = np.eye(6) / 0.01
    ours, theirs = (
        solve(
            p, Options(method="naive", core=core, function_tolerance=1e-14, max_iterations=100)
        ).unknowns
        for core in ("schur", "ceres")
    )
    for name in ("lens_top", "lens_bottom", "pose", "landmark"):
        np.testing.assert_allclose(getattr(ours, name), getattr(theirs, name), atol=1e-5)


def test_a_displacement_of_one_lens_is_found_and_the_others_are_held(make_survey: Survey) -> None:
    from hullrecon.adjustment.problem.lens import displacement

    p = make_survey(poses=24, landmarks=400)
    truth = 0.2 * np.random.default_rng(2).normal(size=2 * LENS_MODES)
    top = p.stereo.pixel[:, :2].copy()
    for _ in range(20):  # the pixel p with p + displacement(p) where the calibration has it
        top = p.stereo.pixel[:, :2] - displacement(top, IMAGE, truth)
    p.stereo.pixel = np.hstack([top, p.stereo.pixel[:, 2:]])
    at_known_poses(p, 1e5)
    p.priors.T_s_ct.sqrt_information = np.eye(6) * 1e5
    p.lenses.image_size = SIZE
    p.lenses.sigma_px = np.full((2, 2 * LENS_MODES), 10.0)
    p.lenses.expected_px = np.zeros((2, 2 * LENS_MODES))
    p.constant = (*p.constant, "lens_bottom")
    found = solve(p, OPTIONS).unknowns
    np.testing.assert_allclose(found.lens_top, truth, atol=0.01)
    assert not found.lens_bottom.any()
    assert not covariance(p, OPTIONS).lens_bottom.any()


def test_lenses_without_a_prior_are_refused(make_survey: Survey) -> None:
    p = with_lenses(make_survey())
    p.lenses.sigma_px = np.zeros((2, 2 * LENS_MODES))
    with pytest.raises(InputError, match="positive"):
        evaluate(p)
