# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A deviation is parted into what the hull's pose leaves open and what it does not."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.detection.deviation import split_deviation
from hullrecon.estimation.landmark_variance import pose_jacobian
from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.refinement import refine
from hullrecon.geometry.meshes.topology import find_edges
from hullrecon.geometry.poses import exp, from_rpy
from hullrecon.records.solution import HullPose
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.typing import Array

CHART = PlaneChart(np.array([0.0, 2.0, 0.0]), np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]))
SIGMA = np.array([0.1, 0.02, 0.3, 0.004, 0.001, 0.003])  # of T_g_M: the wall's normal is y
POSE = HullPose(
    global_from_hull=from_rpy([[5.0, 6, 7]], [[0.0, 0, 0]]),
    covariance=np.diag(SIGMA**2),
    survey_center=np.array([2.0, 2, 1]),
)


@pytest.fixture
def fine(wall: Mesh) -> Mesh:
    return refine(wall, 0.1)[0]


def _split(
    wall: Mesh, fine: Mesh, deviation: Array, bare: Array | None = None, own: float = 0.002
) -> DeviationSplit:
    n = len(fine.vertices)
    by_pose = pose_jacobian(fine.vertices, np.tile([0.0, 1, 0], (n, 1)), POSE)
    place = np.einsum("ni,ij,nj->n", by_pose, POSE.covariance, by_pose)
    surface = Surface(
        vertices=fine.vertices,
        faces=fine.faces,
        deviation=deviation,
        sigma=np.sqrt(place + own**2),
        support=np.ones(n, np.int64),
    )
    split = split_deviation(
        surface, np.full(n, own), np.ones(n, bool) if bare is None else bare, wall, CHART, POSE
    )
    assert split is not None
    return split


def test_a_level_is_offset_a_slope_is_tilt_and_the_rest_is_form(wall: Mesh, fine: Mesh) -> None:
    x, _, z = fine.vertices.T
    wave = 0.005 * np.cos(2 * np.pi * (x - 2)) * np.cos(2 * np.pi * (z - 1))
    split = _split(wall, fine, -0.012 + 0.003 * (x - 2) - 0.001 * (z - 1) + wave)
    assert float(split.offset) == pytest.approx(-0.012, abs=3e-4)
    np.testing.assert_allclose(split.tilt, [0.003, -0.001], atol=3e-4)
    np.testing.assert_allclose(split.form, wave, atol=8e-4)


def test_offset_has_sigma_of_hull_pose_and_form_has_not(wall: Mesh, fine: Mesh) -> None:
    split = _split(wall, fine, np.zeros(len(fine.vertices)))
    assert float(split.offset_sigma) == pytest.approx(0.02, rel=0.01)
    np.testing.assert_allclose(split.tilt_sigma, [0.003, 0.004], rtol=0.01)
    np.testing.assert_allclose(split.form_sigma, 0.002, rtol=1e-3)


def test_no_error_of_the_hulls_pose_shows_in_the_form(wall: Mesh, fine: Mesh) -> None:
    """The wall itself, placed by a wrong pose: its deviation is all offset and tilt, within three
    sigmas of none.
    """
    for seed in range(5):
        error = np.random.default_rng(seed).normal(0, SIGMA)
        error[3:] *= 0.3  # so that the motion is small
        motion = exp(np.r_[np.zeros(3), error[3:]][None])
        moved = (
            motion.inverse().apply(fine.vertices - POSE.survey_center)
            + POSE.survey_center
            - error[:3]
        )
        split = _split(wall, fine, moved[:, 1] - 2)
        np.testing.assert_allclose(split.form, 0, atol=3e-4)
        assert abs(float(split.offset)) < 3 * float(split.offset_sigma)
        assert (np.abs(split.tilt) < 3 * split.tilt_sigma).all()


def test_a_structure_is_form_and_moves_no_offset(wall: Mesh, fine: Mesh) -> None:
    x, _, z = fine.vertices.T
    on = np.hypot(x - 1, z - 1) < 0.4
    for bare in (~on, None):
        split = _split(wall, fine, np.where(on, 0.11, 0.01), bare)
        assert float(split.offset) == pytest.approx(0.01, abs=0.002)
        np.testing.assert_allclose(split.form[on], 0.1, atol=0.002)


def test_unseen_hull_has_no_form_and_little_has_no_split(wall: Mesh, fine: Mesh) -> None:
    n = len(fine.vertices)
    surface = Surface(
        vertices=fine.vertices,
        faces=fine.faces,
        deviation=np.zeros(n),
        sigma=np.full(n, 0.02),
        support=(fine.vertices[:, 0] < 2).astype(np.int64),
    )
    split = split_deviation(surface, None, np.ones(n, bool), wall, CHART, POSE)
    assert split is not None
    np.testing.assert_array_equal(np.isfinite(split.form), surface.support > 0)
    assert split_deviation(surface, None, np.zeros(n, bool), wall, CHART, POSE) is None


def test_sigma_of_form_does_not_jump_between_facets_of_a_curved_hull() -> None:
    """The hull's position enters the form's sigma by how the hull is curved, without steps where
    the CAD model has edges.
    """
    angle = np.linspace(-0.6, 0.6, 13)
    facets = _cylinder_side(angle)
    fine = refine(facets, 0.06)[0]
    n = len(fine.vertices)
    scene = Scene(facets)
    by_pose = pose_jacobian(fine.vertices, scene.smooth_normals(scene.closest(fine.vertices)), POSE)
    place = np.einsum("ni,ij,nj->n", by_pose, POSE.covariance, by_pose)
    surface = Surface(
        vertices=fine.vertices,
        faces=fine.faces,
        deviation=np.zeros(n),
        sigma=np.sqrt(place + 0.002**2),
        support=np.ones(n, np.int64),
    )
    split = split_deviation(surface, np.full(n, 0.002), np.ones(n, bool), facets, CHART, POSE)
    assert split is not None
    a, b = split.form_sigma[find_edges(fine.faces).vertices].T
    assert split.form_sigma.max() > 0.004
    assert np.abs(a - b).max() < 0.2 * split.form_sigma.max()


def _cylinder_side(angle: Array, radius_m: float = 5.2) -> Mesh:
    """Facets about the vertical line through (2, 2 - radius): the hull's outside looks along y."""
    ends = [
        np.stack(
            [2 + radius_m * np.sin(angle), 2 - radius_m * (1 - np.cos(angle)), 0 * angle + z], 1
        )
        for z in (0.0, 2.0)
    ]
    k, n = np.arange(len(angle) - 1), len(angle)
    faces = np.vstack([np.stack([k, n + k, n + k + 1], 1), np.stack([k, n + k + 1, k + 1], 1)])
    return Mesh(np.vstack(ends), faces.astype(np.int32))
