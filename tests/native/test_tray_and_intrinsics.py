# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Unknowns that few dives free: the tray's backlash, the cameras' intrinsics and baseline, the
DVL's mount, biases.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from drafts import Draft, clear, covariance, evaluate, solve
from native.test_cores import free
from scipy.spatial.transform import Rotation

from hullrecon.native import FACTORS, Options

Survey = Callable[..., Draft]
TIGHT = Options(
    method="naive", function_tolerance=1e-14, parameter_tolerance=1e-14, max_iterations=200
)


def with_free(p: Draft, *names: str) -> Draft:
    free(*names)(p)
    return p


def at_known_poses(p: Draft, weight: float) -> None:
    """Puts a prior of this square root of information on every pose, about where it is."""
    prior, n = p.priors.pose, len(p.unknowns.pose)
    prior.node, prior.value = np.arange(n), p.unknowns.pose[:, :7].copy()
    prior.sqrt_information = np.tile(np.eye(6) * weight, (n, 1, 1))


@pytest.mark.parametrize("backlash", [-0.02, 0.005, 0.03])
def test_the_backlash_is_that_of_angles_measured_on_both_sides(
    backlash: float, make_survey: Survey
) -> None:
    p = with_free(make_survey(), "navigation")
    p.priors.navigation_sigma = np.full(6, 10.0)
    p.tray.measured = p.tray.measured + backlash * p.tray.direction
    got = solve(p, TIGHT)
    assert got.unknowns.navigation[5] == pytest.approx(backlash, abs=1e-6)
    np.testing.assert_allclose(got.unknowns.pose[:, 7], p.unknowns.pose[:, 7], atol=1e-6)


def test_backlash_at_rest_stays_at_its_prior(make_survey: Survey) -> None:
    p = with_free(make_survey(), "navigation")
    p.tray.direction = np.zeros_like(p.tray.direction)
    got = solve(p, TIGHT)
    assert got.unknowns.navigation[5] == pytest.approx(0, abs=1e-12)
    assert covariance(p, TIGHT).navigation[5, 5] == pytest.approx(
        p.priors.navigation_sigma[5] ** 2, rel=1e-9
    )


def test_images_separate_tray_angle_from_backlash(
    make_survey: Survey,
) -> None:
    p = with_free(make_survey(), "navigation")
    p.tray.direction = np.ones_like(p.tray.direction)
    with_images = covariance(p, TIGHT).navigation[5, 5]
    clear(p, "stereo", "surface")
    p.unknowns.landmark = p.unknowns.landmark[:0]
    assert covariance(p, TIGHT).navigation[5, 5] > with_images


@pytest.mark.parametrize("bias", [2, 3, 4])
def test_bias_of_roll_pitch_or_depth_is_found(bias: int, make_survey: Survey) -> None:
    p = with_free(make_survey(), "navigation")
    p.priors.navigation_sigma = np.full(6, 1.0)
    at_known_poses(p, 1e4)
    measured = p.attitude.measured.copy()
    measured[:, {4: 0, 2: 1, 3: 2}[bias]] += 0.01
    p.attitude.measured = measured
    assert solve(p, TIGHT).unknowns.navigation[bias] == pytest.approx(0.01, rel=1e-2)


@pytest.mark.parametrize(
    ("block", "moved"),
    [
        ("intrinsics_top", [3.0, -2, 1, 1, 0, 0, 0, 0, 0]),
        ("intrinsics_bottom", [-3.0, 2, -1, 1, 0, 0, 0, 0, 0]),
        ("T_ct_cb", [0.001, -0.002, 0.001]),
    ],
)
@pytest.mark.parametrize("core", ["schur", "ceres"])
def test_a_camera_that_is_off_its_calibration_comes_home(
    core: str, block: str, moved: list[float], make_survey: Survey
) -> None:
    truth = make_survey(poses=12, landmarks=200)
    p = with_free(make_survey(poses=12, landmarks=200), block)
    p.priors.intrinsics_sigma = np.r_[50.0, 50, 50, 50, 1, 1, 1, 1, 1]
    p.priors.T_ct_cb.sqrt_information = np.eye(6)
    at_known_poses(p, 1e4)
    p.priors.T_s_ct.sqrt_information = np.eye(6) * 1e4
    start = getattr(p.unknowns, block).copy()
    start[: len(moved)] += moved
    setattr(p.unknowns, block, start)
    result = solve(
        p, Options(method="naive", core=core, function_tolerance=1e-12, max_iterations=100)
    )
    got = getattr(result.unknowns, block)
    before = np.abs(start - getattr(truth.unknowns, block)).max()
    assert np.abs(got - getattr(truth.unknowns, block)).max() < 0.02 * before


def test_intrinsics_with_few_images_stay_at_their_prior(make_survey: Survey) -> None:
    p = with_free(make_survey(pixel_noise=0.5), "intrinsics_top", "intrinsics_bottom")
    for sigma in (1.0, 1e-3, 1e-6):
        p.priors.intrinsics_sigma = np.full(9, sigma)
        spread = np.sqrt(np.diagonal(covariance(p, TIGHT).intrinsics_top))
        assert (spread <= sigma * (1 + 1e-9)).all()
    np.testing.assert_allclose(spread, 1e-6, rtol=1e-3)
    got = solve(p, TIGHT).unknowns
    np.testing.assert_allclose(got.intrinsics_top, p.unknowns.intrinsics_top, atol=1e-5)


def test_bottom_images_say_nothing_of_the_top_cameras_intrinsics(make_survey: Survey) -> None:
    p = with_free(make_survey(), "intrinsics_top", "intrinsics_bottom", "T_ct_cb")
    p.mono.node, p.mono.landmark, p.mono.pixel = (
        p.stereo.node,
        p.stereo.landmark,
        p.stereo.pixel[:, 2:],
    )
    p.mono.camera = np.ones(len(p.mono.node), np.int32)
    clear(p, "stereo")
    e = evaluate(p, Options(method="geva"))
    start, width = e.columns["intrinsics_top"]
    touching = (
        (e.jacobian_column >= start) & (e.jacobian_column < start + width) & (e.jacobian_value != 0)
    )
    rows = np.searchsorted(e.jacobian_start, np.flatnonzero(touching), side="right") - 1
    assert set(e.factor[rows]) == {FACTORS.index("prior")}
    expected = np.diag(p.priors.intrinsics_sigma**2)
    np.testing.assert_allclose(
        covariance(p, Options(method="geva")).intrinsics_top, expected, atol=1e-12
    )


def test_dvl_mount_is_found_from_odometry(
    make_survey: Survey,
) -> None:
    p = with_free(make_survey(), "T_s_d")
    clear(p, "ranges")
    tilt = np.array([0.01, -0.02, 0.015])
    true = Rotation.from_quat(p.unknowns.T_s_d[3:]) * Rotation.from_rotvec(tilt)
    seen = np.einsum("kij,j->ki", p.odometry.by_mount, tilt)
    z = p.odometry.measured.copy()
    z[:, :3] -= seen[:, :3]
    z[:, 3:] = (Rotation.from_quat(z[:, 3:]) * Rotation.from_rotvec(-seen[:, 3:])).as_quat()
    p.odometry.measured = z
    p.priors.T_s_d.sqrt_information = np.eye(6)
    at_known_poses(p, 1e5)
    got = solve(p, TIGHT).unknowns.T_s_d
    assert (true.inv() * Rotation.from_quat(got[3:])).magnitude() < 1e-3 * np.linalg.norm(
        tilt
    ) + 1e-4
