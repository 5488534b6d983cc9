# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A ship's side to lay points onto."""

from dataclasses import replace

import numpy as np

from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry import poses
from hullrecon.geometry.meshes.mesh import Mesh


class SideChart:
    """Along and height of a hull's port side; enough for correlation."""

    ship_axes = np.eye(3)

    def to_chart(self, points):
        return np.c_[points[:, 0], points[:, 2], np.zeros(len(points))]


def side(fullness):
    """A port side y(x, z), 30 m long: `fullness` 0 is a cylinder, 1 curves strongly towards both
    ends.
    """
    x, z = np.meshgrid(np.linspace(-15, 15, 121), np.linspace(0, 5, 41), indexing="ij")
    y = (
        4.0
        * (1 - fullness * 0.6 * (x / 15) ** 4)
        * np.sqrt(np.clip(1 - ((5.5 - z) / 6) ** 4, 0.01, None))
    )
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    faces = np.vstack(
        [np.stack([a, c, b], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)]
    )
    return Mesh(np.stack([x, y, z], -1).reshape(-1, 3), faces.astype(np.int32))


def survey(mesh, rng, span=(2.0, 11.0)):
    v = mesh.vertices
    inside = (v[:, 0] > span[0]) & (v[:, 0] < span[1]) & (v[:, 2] > 0.8) & (v[:, 2] < 4.2)
    return v[inside] + 0.01 * rng.standard_normal((inside.sum(), 3))


def cad_model(mesh, truth, error):
    guess = truth @ poses.exp(error)
    sigma = np.r_[1.0, 0.3, 0.3, np.radians([1, 1, 5])]
    return CadModel(mesh, SideChart(), guess, sigma, 0.02, (3.0, 1.5))


def lying(model):
    """Return a CAD model with z up as its file would have it with y up and the ship along z, and
    that turn (3, 3).
    """
    turn = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])
    chart = SideChart()
    chart.to_chart, chart.ship_axes = (lambda points: SideChart().to_chart(points @ turn)), turn.T
    in_hull = np.r_[turn @ model.guess_sigma[:3], turn @ model.guess_sigma[3:]]
    guess = model.guess @ poses.from_matrix(
        np.block([[turn.T, np.zeros((3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]])
    )
    return replace(
        model,
        mesh=Mesh(model.mesh.vertices @ turn.T, model.mesh.faces),
        chart=chart,
        guess=guess,
        guess_sigma=in_hull,
    ), turn


TRUTH = poses.from_rpy([10.0, 30.0, 3.0], np.radians([-179.0, 0.5, -95.0]))
ERROR = np.r_[0.5, 0.2, -0.1, np.radians([0.5, -0.5, 2.5])]
