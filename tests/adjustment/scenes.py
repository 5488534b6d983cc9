# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A ship's side to lay points onto."""

import numpy as np

from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry import poses
from hullrecon.geometry.meshes.mesh import Mesh


class SideChart:
    """Along and height of a hull's port side; enough for correlation."""

    def to_chart(self, points):
        return np.c_[points[:, 0], points[:, 2], np.zeros(len(points))]


def side(fullness):
    """A port side y(x, z), 30 m long: `fullness` 0 is a cylinder, 1 curves strongly towards both ends."""
    x, z = np.meshgrid(np.linspace(-15, 15, 121), np.linspace(0, 5, 41), indexing="ij")
    y = 4.0 * (1 - fullness * 0.6 * (x / 15) ** 4) * np.sqrt(np.clip(1 - ((5.5 - z) / 6) ** 4, 0.01, None))
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.vstack([np.stack([a, c, b], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)])
    return Mesh(np.stack([x, y, z], -1).reshape(-1, 3), faces.astype(np.int32))


def survey(mesh, rng, span=(2.0, 11.0)):
    v = mesh.vertices
    inside = (v[:, 0] > span[0]) & (v[:, 0] < span[1]) & (v[:, 2] > 0.8) & (v[:, 2] < 4.2)
    return v[inside] + 0.01 * rng.standard_normal((inside.sum(), 3))


def cad_model(mesh, truth, error):
    guess = truth @ poses.exp(error)
    sigma = np.r_[1.0, 0.3, 0.3, np.radians([1, 1, 5])]
    return CadModel(mesh, SideChart(), guess, sigma, 0.02, (3.0, 1.5))


TRUTH = poses.from_rpy([10.0, 30.0, 3.0], np.radians([-179.0, 0.5, -95.0]))
ERROR = np.r_[0.5, 0.2, -0.1, np.radians([0.5, -0.5, 2.5])]
