# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.geometry.neighbours import nearest
from hullrecon.surface.build import supported_lattice


def test_every_vertex_is_near_a_return() -> None:
    at = np.array([[0.0, 0.0], [3.0, 1.0]])
    mesh = supported_lattice(at, 0.1, 0.5)
    assert nearest(at, mesh.vertices[:, :2], 1)[0].max() <= 0.5
    area = len(mesh.faces) * 0.005
    assert 0.6 * 2 * np.pi * 0.25 < area < 2 * np.pi * 0.25


def test_every_vertex_belongs_to_a_face_and_faces_look_one_way() -> None:
    mesh = supported_lattice(np.array([[0.03, -0.02]]), 0.1, 0.4)
    a, b, c = mesh.vertices[mesh.faces].transpose(1, 0, 2)
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()
    assert np.array_equal(np.unique(mesh.faces), np.arange(len(mesh.vertices)))


def test_a_reach_below_the_spacing_gives_no_surface() -> None:
    assert len(supported_lattice(np.array([[0.05, 0.05]]), 0.1, 0.02).faces) == 0
