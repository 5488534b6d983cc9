# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Surfaces by other kernels, references and interpolation, on the survey of a cylinder."""

from __future__ import annotations

import numpy as np
import pytest
from steps.surveyed_cylinder import (
    OFF,
    RADIUS,
    EarlierSteps,
    bumped,
    earlier,
    landmarks_around_bilge,
    on_and_off_bump,
    radius,
    read_surface,
)

from hullrecon.errors import StageError
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.studies.surfaces.comparison import SURFACES
from hullrecon.studies.surfaces.regression import (
    RadialKernel,
    WendlandKernel,
    by_triangles,
    interpolate,
    scatter_sigma,
    wendland,
)
from hullrecon.surface.build import SurfacePoints, build_surface
from hullrecon.surface.gaussian import Kernel, NotPositiveDefiniteError, compact, fit
from hullrecon.surface.options import SurfaceOptions

__all__ = ["earlier"]
FORMS = (Kernel, RadialKernel, WendlandKernel)
CORNERS = np.array([[0.0, 0], [1, 0], [0, 1], [1, 1], [0.4, 0.6]])


def test_linear_interpolation_runs_on_the_same_input(earlier: EarlierSteps) -> None:
    surface, facts = read_surface(earlier.run(stage=SURFACES["linear"]))
    assert facts["method"] == "linear"
    assert np.sqrt(np.mean((radius(surface) - RADIUS - OFF) ** 2)) < 0.008


def test_wendlands_kernel_gives_the_same_hull(earlier: EarlierSteps) -> None:
    surface, facts = read_surface(earlier.run(stage=SURFACES["wendland kernel"]))
    assert facts["kernel"] == "wendland"
    assert np.sqrt(np.mean((radius(surface) - RADIUS - OFF) ** 2)) < 0.004


@pytest.mark.parametrize("name", ["offsets from a plane", "heights over a plane"])
def test_bump_is_found_without_the_cad_model_as_reference(earlier: EarlierSteps, name: str) -> None:
    surface, facts = read_surface(bumped(earlier).run(stage=SURFACES[name], outlier_sigmas=3.0))
    top, aside = on_and_off_bump(surface)
    assert facts["reference"] == {"offsets from a plane": "plane"}.get(name, "none")
    assert "circular" not in str(facts["comparison"])
    assert np.median(surface.deviation[top]) == pytest.approx(OFF + 0.08, abs=0.012)
    assert np.median(surface.deviation[aside]) == pytest.approx(OFF, abs=0.006)


def test_a_hull_that_bends_around_is_no_plane(earlier: EarlierSteps) -> None:
    with pytest.raises(StageError, match="bends too far"):
        landmarks_around_bilge(earlier).run(dvl=False, stage=SURFACES["offsets from a plane"])


def test_triangles_follow_a_wall_but_keep_its_noise(rng: np.random.Generator) -> None:
    x, z = rng.uniform(0, 5, 900), rng.uniform(0, 3, 900)
    bump = 0.03 * np.sin(x / 1.5) + 0.02 * np.cos(z)
    points = np.stack([x, 2 + bump + rng.normal(0, 0.008, 900), z], axis=1)
    observed = SurfacePoints(
        point=points,
        noise=np.full(900, 0.008),
        pose_sigma=np.full(900, 0.004),
        gives_support=np.ones(900, bool),
    )
    wall = PlaneChart(np.array([0.0, 2.0, 0.0]), np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]))
    surface, _ = build_surface(observed, wall, SurfaceOptions(), regression=by_triangles)
    x, y, z = surface.vertices.T
    inside = (x > 0) & (x < 5) & (z > 0) & (z < 3)
    error = (y - 2 - 0.03 * np.sin(x / 1.5) - 0.02 * np.cos(z))[inside]
    # measured over seeds: 5.1 to 5.6 mm, where the Gaussian process has 2.0 to 2.6 mm
    assert 0.004 < np.sqrt(np.mean(error**2)) < 0.008


def test_compact_function_at_points_worked_out_by_hand() -> None:
    # r = 1/2: (2 - 1)/3 * 1/2 + 0; r = 1/4: (2 + 0)/3 * 3/4 + 1/(2 pi)
    assert np.allclose(
        compact(np.array([0.0, 0.25, 0.5, 1.0, 2.0])), [1, 0.5 + 1 / (2 * np.pi), 1 / 6, 0, 0]
    )


def test_wendlands_function_at_points_worked_out_by_hand() -> None:
    assert np.allclose(wendland(np.array([0.0, 0.5, 1.0, 3.0])), [1, 3 / 16, 0, 0])


@pytest.mark.parametrize("form", FORMS)
def test_the_sparse_matrix_equals_the_function_at_every_pair(
    form: type[Kernel], rng: np.random.Generator
) -> None:
    kernel = form((3.0, 0.7), 0.2)
    a, b = rng.uniform(0, 4, (40, 2)), rng.uniform(0, 4, (25, 2))
    gap = ((a[:, None] - b[None]) / [3.0, 0.7]).reshape(-1, 2)
    dense = 0.04 * kernel.correlation(gap).reshape(40, 25)
    sparse = kernel.matrix(a, b)
    assert np.allclose(sparse.toarray(), dense, atol=1e-15)
    assert sparse.nnz < a.shape[0] * b.shape[0]


@pytest.mark.parametrize("form", FORMS)
def test_the_covariance_ends_at_the_length(form: type[Kernel]) -> None:
    kernel = form((2.0, 1.0), 1.0)
    beyond = kernel.matrix(np.zeros((1, 2)), np.array([[2.01, 0.0], [0.0, 1.01], [1.9, 0.0]]))
    assert beyond.toarray()[0, :2].tolist() == [0, 0]
    assert beyond.toarray()[0, 2] > 0


@pytest.mark.parametrize("form", [Kernel, WendlandKernel])
def test_product_and_wendland_are_covariances(form: type[Kernel], rng: np.random.Generator) -> None:
    at = rng.uniform(0, 3, (120, 2))
    assert np.linalg.eigvalsh(form((1.5, 1.0), 1.0).matrix(at, at).toarray())[0] > -1e-12


@pytest.mark.parametrize("side", [19, 24])
def test_radial_kernel_that_is_no_covariance_is_refused(side: int) -> None:
    at = 0.2 * np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(
        -1, 2
    ).astype(float)
    with pytest.raises(NotPositiveDefiniteError, match="radial"):
        fit(RadialKernel((1.0, 1.0), 0.1), at, np.zeros(len(at)), np.full(len(at), 0.5))


def test_radial_kernel_that_is_a_covariance_works() -> None:
    at = np.array([[0.0, 0], [0.5, 0], [5, 5]])
    result = fit(RadialKernel((1.0, 1.0), 0.1), at, np.array([0.1, 0.1, 0]), np.full(3, 0.01))
    assert result.mean(at)[0] == pytest.approx(0.1, abs=0.01)


def test_radius_of_the_kernel_needs_the_transpose_that_is_not_printed() -> None:
    """[Ozog2016 3.2.2.2] prints (x - x') Omega (x - x') of columns: no product has these sizes."""
    length, x, other = np.array([3.0, 15.0]), np.array([[1.0], [2.0]]), np.array([[0.4], [5.0]])
    gap, omega = x - other, np.diag(length**-2)
    radius = np.sqrt(gap.T @ omega @ gap)
    kernel = RadialKernel((3.0, 15.0), 0.2)
    np.testing.assert_allclose(kernel.matrix(x.T, other.T).toarray(), 0.04 * compact(radius))
    with pytest.raises(ValueError, match="mismatch"):
        _ = gap @ omega @ gap


def test_training_by_the_second_coordinate_as_printed_makes_no_surface() -> None:
    """[Ozog2016 3.2.2.2] prints training pairs (x_i, y_i), where y_i is a part of x_i."""
    at, depth = CORNERS, np.array([0.02, 0.03, -0.01, 0.0, 0.05])
    kernel, noise = Kernel((1.0, 1.0), 0.1), np.full(5, 1e-4)
    np.testing.assert_allclose(fit(kernel, at, depth, noise).mean(at), depth, atol=1e-6)
    printed = fit(kernel, at, at[:, 1], noise).mean(at)
    assert np.abs(printed - depth).max() > 0.5


def test_a_plane_is_reproduced_inside() -> None:
    values = 2 + 3 * CORNERS[:, 0] - CORNERS[:, 1]
    wanted = np.array([[0.2, 0.3], [0.9, 0.95]])
    assert np.allclose(interpolate(CORNERS, values, wanted), 2 + 3 * wanted[:, 0] - wanted[:, 1])


def test_outside_the_nearest_value_holds() -> None:
    assert interpolate(CORNERS, np.arange(5.0), np.array([[5.0, 0.1]])).tolist() == [1.0]


def test_returns_on_one_line_still_give_a_value() -> None:
    line = np.array([[0.0, 0], [1, 0], [2, 0], [3, 0], [4, 0]])
    assert interpolate(line, np.arange(5.0), np.array([[2.2, 0.3]])).tolist() == [2.0]


def test_the_scatter_is_that_of_the_noise(rng: np.random.Generator) -> None:
    at = rng.uniform(0, 5, (2000, 2))
    values = 0.02 * at[:, 0] + rng.normal(0, 0.01, 2000)
    assert abs(scatter_sigma(at, values) / 0.01 - 1) < 0.1
    assert scatter_sigma(at[:1], values[:1]) == 0.0
