# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What holds at every point of a chart, of a hull or of a plane."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hullrecon.geometry.charts.chart import (
    Chart,
    chart_for_hull,
    chart_for_points,
    chart_from_arrays,
)
from hullrecon.geometry.charts.viewing_side import flips
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import exp

QUICK = settings(max_examples=30, deadline=None, derandomize=True)
SEEDS = st.integers(0, 10**6)


@pytest.fixture(scope="session")
def chart(steel: Mesh) -> Chart:
    return chart_for_hull(steel)


def plane(seed: int) -> Chart:
    """A chart of points scattered about a plane that lies anyhow in g, seen from the origin."""
    rng = np.random.default_rng(seed)
    flat = rng.normal(size=(60, 3)) * [5.0, 2.0, 0.01] + [0.0, 0.0, 4.0]
    return chart_for_points(
        exp(np.r_[np.zeros(3), rng.normal(size=3)][None]).apply(flat), np.zeros(3)
    )


def on_hull(seed: int, n: int = 20) -> np.ndarray:
    return np.random.default_rng(seed).uniform([0.3, -4.4], [19.7, 4.4], (n, 2))


def directions(
    chart: Chart, at: np.ndarray, step_m: float = 0.05
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Along, girth (n, 3) by differences, and the normal."""
    along, girth = (
        chart.from_chart(at + step)[0] - chart.from_chart(at - step)[0]
        for step in 0.5 * step_m * np.eye(2)
    )
    return along / step_m, girth / step_m, chart.from_chart(at)[1]


@QUICK
@given(SEEDS)
def test_the_points_of_a_hulls_chart_lie_on_the_hull(chart: Chart, steel: Mesh, seed: int) -> None:
    points, normals = chart.from_chart(on_hull(seed))
    near = Scene(steel).closest(points)
    np.testing.assert_allclose(near.distance, 0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-12)
    assert (np.einsum("ni,ni->n", normals, near.normal) > 0.99).all()


@QUICK
@given(SEEDS)
def test_every_chart_is_left_handed_about_the_outward_normal(chart: Chart, seed: int) -> None:
    for made, at in (
        (chart, on_hull(seed)),
        (plane(seed), np.random.default_rng(seed).normal(size=(5, 2))),
    ):
        along, girth, normal = directions(made, at)
        assert (np.einsum("ni,ni->n", np.cross(along, girth), normal) < -0.9).all()


@QUICK
@given(SEEDS, st.floats(-0.4, 0.4))
def test_along_the_normal_only_the_offset_grows(chart: Chart, seed: int, offset: float) -> None:
    at = np.random.default_rng(seed).normal(size=(7, 2))
    flat = plane(seed)
    points, normals = flat.from_chart(at)
    np.testing.assert_allclose(
        flat.to_chart(points + offset * normals), np.c_[at, np.full(7, offset)], atol=1e-9
    )
    points, normals = chart.from_chart(on_hull(seed))
    np.testing.assert_allclose(chart.to_chart(points + offset * normals)[:, 2], offset, atol=1e-3)


@QUICK
@given(SEEDS)
def test_a_hull_read_back_answers_as_it_did(chart: Chart, seed: int) -> None:
    for made, at in ((chart, on_hull(seed)), (plane(seed), on_hull(seed))):
        again = chart_from_arrays(made.to_arrays())
        for old, new in zip(made.from_chart(at), again.from_chart(at), strict=True):
            np.testing.assert_array_equal(new, old)
        points = made.from_chart(at)[0] * 1.01
        np.testing.assert_array_equal(again.to_chart(points), made.to_chart(points))


@QUICK
@given(SEEDS)
def test_a_plane_faces_the_sensors_and_its_axes_are_square(seed: int) -> None:
    chart = plane(seed)
    assert chart.to_chart(np.zeros((1, 3)))[0, 2] > 3.5
    along, girth, normal = (axis[0] for axis in directions(chart, np.zeros((1, 2))))
    axes = np.stack([along, girth, normal])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-9)


def test_unknown_places_on_a_plane_have_no_normal() -> None:
    _, normals = plane(1).from_chart(np.array([[0.0, 0.0], [np.nan, 1.0], [1.0, np.nan]]))
    assert np.isnan(normals).all(axis=1).tolist() == [False, True, True]


@pytest.mark.parametrize(("side", "expected"), [(1.0, (True, False)), (-1.0, (False, True))])
def test_a_real_hull_is_turned_as_its_side_asks(
    chart: Chart, side: float, expected: tuple[bool, bool]
) -> None:
    at = np.random.default_rng(2).uniform([1.0, 0.5], [19.0, 4.2], (50, 2)) * [1.0, side]
    assert flips(chart, at) == expected


@QUICK
@given(SEEDS)
def test_chart_as_drawn_shows_hull_from_outside(chart: Chart, seed: int) -> None:
    side = 1.0 if seed % 2 else -1.0
    at = np.abs(on_hull(seed)) * [1.0, side]
    at[:, 1] += side * (np.abs(at[:, 1]) < 0.1) * 0.1
    at[:, 1] = np.clip(at[:, 1], -4.4, 4.4)
    left, down = flips(chart, at)
    along, girth, normal = directions(chart, at)
    right, upward = (-1 if left else 1) * along, (-1 if down else 1) * girth
    # to a viewer outside, right x up points at the viewer
    assert (np.einsum("ni,ni->n", np.cross(right, upward), normal) > 0.9).all()
    assert (upward @ chart.ship_axes[2] > 0).all()
