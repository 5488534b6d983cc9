# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.detection.facets import facet_sagitta
from hullrecon.geometry.meshes.mesh import Mesh


def _cylinder(radius: float, sides: int, split: bool = False) -> Mesh:
    angle = np.linspace(0, 2 * np.pi, sides, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1) * radius
    vertices = np.vstack([np.column_stack([np.full(sides, x), ring]) for x in (0.0, 5.0)])
    a = np.arange(sides)
    b = (a + 1) % sides
    faces = np.concatenate([np.stack([a, b, b + sides], 1), np.stack([a, b + sides, a + sides], 1)]).astype(np.int32)
    if split:  # as an STL has it: every face with corners of its own
        vertices, faces = vertices[faces].reshape(-1, 3), np.arange(faces.size, dtype=np.int32).reshape(-1, 3)
    return Mesh(vertices, faces)


@pytest.mark.parametrize("split", [False, True])
def test_the_sagitta_of_a_cylinders_facets_is_that_of_its_arc(split: bool) -> None:
    exact = 2.0 * (1 - np.cos(np.pi / 24))
    assert np.allclose(facet_sagitta(_cylinder(2.0, 24, split)), exact, rtol=0.02)


def test_twice_as_many_facets_leave_a_quarter() -> None:
    few, many = (facet_sagitta(_cylinder(2.0, sides)).max() for sides in (24, 48))
    assert few / many == pytest.approx(4, rel=0.02)


def test_a_plane_and_a_sharp_edge_have_none(wall) -> None:
    assert np.allclose(facet_sagitta(wall), 0, atol=1e-7)
    assert np.allclose(facet_sagitta(_cylinder(2.0, 6)), 0, atol=1e-7)  # edges of 60 degrees
