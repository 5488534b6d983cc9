# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.tessellation import facet_sagitta, facet_turn, tessellation_error
from hullrecon.typing import Array

RADIUS_M = 5.0


def cylinder(sides: int, length_m: float = 2.0, radius_m: float = RADIUS_M) -> Mesh:
    """A cylinder about x as a strip of quads of `sides` facets, each of two triangles, every quad
    with corners of its own.
    """
    angle = 2 * np.pi * np.arange(sides + 1) / sides
    ring = radius_m * np.stack([np.zeros_like(angle), np.cos(angle), np.sin(angle)], axis=1)
    vertices, faces = [], []
    for k in range(sides):
        quad = [ring[k], ring[k + 1], ring[k + 1] + [length_m, 0, 0], ring[k] + [length_m, 0, 0]]
        vertices += quad
        faces += [[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]]
    return Mesh(np.array(vertices), np.array(faces, np.int32))


@pytest.mark.parametrize("sides", [24, 48, 96])
def test_facets_of_cylinder_are_off_by_sagitta(sides: int) -> None:
    exact = RADIUS_M * (1 - np.cos(np.pi / sides))
    np.testing.assert_allclose(facet_sagitta(cylinder(sides)), exact, rtol=0.02)
    np.testing.assert_allclose(facet_turn(cylinder(sides)), 2 * np.pi / sides, rtol=1e-6)
    near = tessellation_error(cylinder(sides), cylinder(sides).vertices)
    assert near.sigma_m == pytest.approx(exact, rel=0.02)
    assert near.length_m == pytest.approx(2 * RADIUS_M * np.sin(np.pi / sides), rel=0.02)


def test_edges_drawn_on_purpose_do_not_count() -> None:
    assert np.allclose(facet_sagitta(cylinder(6)), 0)  # turns of 60 degrees
    assert np.allclose(facet_turn(cylinder(6)), 0)
    assert tessellation_error(cylinder(6), cylinder(6).vertices).sigma_m == 0


def test_a_turn_of_35_degrees_is_a_curve_for_every_user_alike() -> None:
    coarse = cylinder(10)  # turns of 36 degrees
    assert facet_sagitta(coarse).min() > 0
    assert tessellation_error(coarse, coarse.vertices).sigma_m == pytest.approx(
        facet_sagitta(coarse).mean(), rel=1e-6
    )


def test_faces_out_of_reach_say_nothing() -> None:
    fine, coarse = cylinder(96), cylinder(16)
    far = Mesh(
        np.vstack([fine.vertices, coarse.vertices + np.array([100.0, 0, 0])]),
        np.vstack([fine.faces, coarse.faces + len(fine.vertices)]),
    )
    assert tessellation_error(far, fine.vertices) == tessellation_error(fine, fine.vertices)


def test_a_flat_plate_has_no_error() -> None:
    plate = Mesh(
        np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]]),
        np.array([[0, 1, 2], [0, 2, 3]], np.int32),
    )
    assert np.allclose(facet_sagitta(plate), 0)
    assert tessellation_error(plate, plate.vertices).sigma_m == 0


def _on_cylinder(sides: int, count: int = 400) -> tuple[Array, Array]:
    """Smooth normals at points along a line around a cylinder of facets, and the true ones."""
    angle = 2 * np.pi * (np.arange(count) + 0.5) / count
    outward = np.stack([np.zeros(count), np.cos(angle), np.sin(angle)], axis=1)
    scene = Scene(cylinder(sides))
    found = scene.smooth_normals(scene.closest(RADIUS_M * outward + np.array([0.7, 0, 0])))
    return found, outward


def test_smooth_normals_of_facets_are_those_of_the_cylinder() -> None:
    found, true = _on_cylinder(24)  # facets turn by 15 degrees, and are up to 7.5 off
    off = np.degrees(np.arccos(np.einsum("ni,ni->n", found, true).clip(-1, 1)))
    assert off.max() < 0.2
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1)


def test_smooth_normals_stay_the_facets_beside_sharp_edges() -> None:
    found, _ = _on_cylinder(6)  # turns of 60 degrees
    assert len(np.unique(np.round(found, 9), axis=0)) == 6
