# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.adjustment.facets import facets_near
from hullrecon.geometry.meshes.mesh import Mesh


def cylinder(radius, width, length=4.0):
    """A quarter of a cylinder along x in facets of that width round it."""
    angle = np.arange(0, np.pi / 2, width / radius)
    x = np.linspace(0, length, 5)
    a, b = np.meshgrid(angle, x, indexing="ij")
    vertices = np.stack([b, radius * np.cos(a), radius * np.sin(a)], -1).reshape(-1, 3)
    n = np.arange(a.size).reshape(a.shape)
    p, q, r, s = n[:-1, :-1].ravel(), n[1:, :-1].ravel(), n[1:, 1:].ravel(), n[:-1, 1:].ravel()
    return Mesh(vertices, np.vstack([np.stack([p, q, r], 1), np.stack([p, r, s], 1)]).astype(np.int32))


def test_a_cylinder_s_facets_have_the_sagitta_of_their_chord():
    mesh = cylinder(5.0, 0.5)
    found = facets_near(mesh, mesh.vertices)
    assert found.sigma == pytest.approx(0.5**2 / (8 * 5.0), rel=0.1)
    assert found.length == pytest.approx(0.5, rel=0.1)


def test_finer_facets_err_less():
    coarse, fine = (facets_near(cylinder(5.0, w), cylinder(5.0, w).vertices) for w in (0.5, 0.1))
    assert fine.sigma < 0.06 * coarse.sigma


def test_a_plane_has_no_facet_error():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    mesh = Mesh(vertices, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    assert facets_near(mesh, vertices).sigma == pytest.approx(0.0, abs=1e-9)


def test_a_right_angle_is_meant():
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 1.0]])
    mesh = Mesh(vertices, np.array([[0, 1, 2], [1, 0, 3]], np.int32))
    assert facets_near(mesh, vertices).sigma == 0.0


def test_only_faces_near_the_points_count():
    mesh = cylinder(5.0, 0.5)
    with_far_block = Mesh(np.vstack([mesh.vertices, cylinder(1.0, 0.5).vertices + 100]), mesh.faces)
    assert facets_near(with_far_block, mesh.vertices).sigma == facets_near(mesh, mesh.vertices).sigma
