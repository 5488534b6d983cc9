# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One patch through the ends of beams: its plane and curvature, how sure they are, and what is no
patch.
"""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.navigation.planes.patch_fit import fit_patch, height_over_plane, patch_axes

BROAD = np.array([0.5, 0.5, 0.5])
SIGMA_M = 0.01


def surface(
    rng: np.random.Generator, curvature: np.ndarray, n: int = 60, noise_m: float = SIGMA_M
) -> tuple[np.ndarray, np.ndarray]:
    """Points of a surface one metre ahead (+x) in the axes of a patch there, and rays that run
    along x.
    """
    axes = patch_axes(np.array([-1.0, 0, 0]))
    at = rng.uniform(-0.7, 0.7, (n, 2))
    local = np.column_stack(
        [at, height_over_plane(curvature, at) + noise_m * rng.standard_normal(n)]
    )
    return local @ axes.T + [1.0, 0, 0], np.tile([1.0, 0, 0], (n, 1))


def test_axes_are_right_handed_and_the_first_is_level() -> None:
    for normal in np.random.default_rng(0).normal(size=(20, 3)):
        axes = patch_axes(normal / np.linalg.norm(normal))
        np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)
        assert np.linalg.det(axes) > 0
        if np.linalg.norm(np.cross([0, 0, 1], axes[:, 2])) >= 0.3:
            assert abs(axes[2, 0]) < 1e-12


def test_under_a_flat_bottom_the_axes_are_those_of_the_vehicle() -> None:
    axes = patch_axes(np.array([0.0, 0, 1]))
    np.testing.assert_allclose(np.abs(axes[1, 0]), 1, atol=1e-12)


def test_plane_and_curvature_are_found_without_noise() -> None:
    curvature = np.array([0.03, -0.05, -0.3])
    fit = fit_patch(*surface(np.random.default_rng(1), curvature, noise_m=0.0), 0.001, BROAD)
    assert fit is not None
    # told at the middle of the points
    np.testing.assert_allclose(fit.curvature, curvature, atol=0.02)
    off = fit.center - [1.0, 0, 0]
    local = off @ patch_axes(np.array([-1.0, 0, 0]))
    assert local[2] == pytest.approx(height_over_plane(curvature, local[None])[0], abs=1e-4)


def test_the_normal_looks_at_the_vehicle() -> None:
    points, rays = surface(np.random.default_rng(2), np.zeros(3))
    fit = fit_patch(points, rays, SIGMA_M, BROAD)
    assert fit is not None
    assert fit.axes[0, 2] < -0.99


def test_the_sigmas_are_those_of_many_draws() -> None:
    rng = np.random.default_rng(3)
    curvature = np.array([0.02, 0.0, -0.1])
    at = rng.uniform(-0.7, 0.7, (50, 2))
    axes = patch_axes(np.array([-1.0, 0, 0]))
    slopes, ks, fits = [], [], []
    for _ in range(150):
        local = np.column_stack(
            [at, height_over_plane(curvature, at) + SIGMA_M * rng.standard_normal(50)]
        )
        fit = fit_patch(local @ axes.T + [1.0, 0, 0], np.tile([1.0, 0, 0], (50, 1)), SIGMA_M, BROAD)
        assert fit is not None
        n = axes.T @ fit.axes[:, 2]
        slopes.append(-n[:2] / n[2])
        ks.append(fit.curvature)
        fits.append(fit)
    by = np.mean([f.by_curvature for f in fits], axis=0)
    k = np.mean([f.curvature_covariance for f in fits], axis=0)
    whole = np.mean([f.plane_covariance for f in fits], axis=0) + by @ k @ by.T
    np.testing.assert_allclose(np.std(ks, axis=0), np.sqrt(np.diag(k)), rtol=0.25)
    np.testing.assert_allclose(np.std(slopes, axis=0), np.sqrt(np.diag(whole)[1:]), rtol=0.3)


def test_wild_returns_are_dropped() -> None:
    points, rays = surface(np.random.default_rng(4), np.zeros(3))
    points[[3, 20, 41]] += [0.4, 0, 0]
    fit = fit_patch(points, rays, SIGMA_M, BROAD)
    assert fit is not None
    assert not fit.kept[[3, 20, 41]].any()
    assert fit.center[0] == pytest.approx(1.0, abs=0.005)


def test_a_range_is_moved_onto_the_plane() -> None:
    curvature = np.array([0.0, 0.0, -0.4])
    points, rays = surface(np.random.default_rng(5), curvature, noise_m=0.0)
    fit = fit_patch(points, rays, 0.001, BROAD)
    assert fit is not None
    onto = points + fit.to_plane[:, None] * rays
    np.testing.assert_allclose((onto - fit.center) @ fit.axes[:, 2], 0, atol=2e-3)


@pytest.mark.parametrize("broken", ["few", "line", "step", "noise"])
def test_what_is_no_smooth_patch_is_left_out(broken: str) -> None:
    rng = np.random.default_rng(6)
    points, rays = surface(rng, np.zeros(3))
    if broken == "few":
        points, rays = points[:11], rays[:11]
    elif broken == "line":
        points[:, 2] = 0.01 * rng.standard_normal(len(points))
    elif broken == "step":
        points[:, 0] += np.where(points[:, 1] > 0, 0.3, 0.0)
    else:
        points[:, 0] += 0.1 * rng.standard_normal(len(points))
    assert fit_patch(points, rays, SIGMA_M, BROAD) is None
