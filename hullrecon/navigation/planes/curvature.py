# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Estimate how strongly a hull bends, from its CAD model or from the dive [Ozog2016 2.3.4].

The characteristic curvature is the prior of a patch's curvature: the sigma about zero of K in
azimuth, in twist and in elevation (1/m). A patch measures its own curvature too, so the prior
matters little: in the sphere of [Ozog2016 C] the map is the same for radii from 4 to 20 m.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.navigation.planes.patch_fit import patch_axes
from hullrecon.navigation.planes.patches import Patches
from hullrecon.typing import Array

BROAD = np.array([0.5, 0.3, 0.5])  # 1/m, the broad prior: a bilge radius of 2 m
LEAST = 0.02  # 1/m, a radius of 50 m: where a hull is flat, it may still have dents
SAMPLES = 3000  # points of a CAD model
NEAR_M = 1.5  # between the points whose normals are compared
LEAST_NEIGHBOURS = 6
LEAST_ALIGNMENT = 0.7  # cosine between the normals of one surface
CLIPPED = 95  # percentile at which squared curvatures are clipped: edges and knuckles do not count


def curvature_of_patches(patches: Patches) -> Array:
    """Estimate the characteristic curvature (3,) from patches that were fitted with a broad prior.

    It is the root mean square of their curvatures, less their noise, within LEAST and BROAD. With
    too few patches it is BROAD.
    """
    if len(patches) < LEAST_NEIGHBOURS:
        return BROAD
    noise = np.einsum("wii->wi", patches.curvature_covariance)
    square = np.minimum(patches.curvature**2, np.percentile(patches.curvature**2, CLIPPED, axis=0))
    return np.asarray(np.sqrt(np.clip(np.mean(square - noise, axis=0), LEAST**2, BROAD**2)))


def curvature_of_mesh(mesh: Mesh) -> Array:
    """Estimate the characteristic curvature (3,) of a CAD model from how its normals turn.

    The curvature at sampled points is fitted to the normals around, and its root mean square taken.
    It is BROAD where too few points allow a fit.
    """
    points, normals = _sample_mesh(mesh, np.random.default_rng(0))
    near = cKDTree(points).query_ball_point(points, NEAR_M)
    found = [
        k
        for k in (_fit_curvature(points, normals, i, np.array(rows)) for i, rows in enumerate(near))
        if k is not None
    ]
    if len(found) < LEAST_NEIGHBOURS:
        return BROAD
    square = np.array(found) ** 2
    return np.asarray(
        np.sqrt(
            np.clip(
                np.mean(np.minimum(square, np.percentile(square, CLIPPED, axis=0)), 0),
                LEAST**2,
                BROAD**2,
            )
        )
    )


def _fit_curvature(points: Array, normals: Array, row: int, near: Array) -> Array | None:
    """Fit the curvature K (3,) at a point to the normals near it, by least squares.

    None where fewer than LEAST_NEIGHBOURS of them face the same way.

    Parameters
    ----------
    points, normals
        Points (n, 3) of all samples, and the unit normals there.
    row
        Which of them the curvature is fitted at.
    near
        Rows of samples near it, which may lie on other surfaces.
    """
    near = near[normals[near] @ normals[row] > LEAST_ALIGNMENT]
    if len(near) < LEAST_NEIGHBOURS:
        return None
    axes = patch_axes(normals[row])
    a, e = ((points[near] - points[row]) @ axes[:, :2]).T
    turned = normals[near] @ axes
    # the normal of a surface with slopes (p, q) is along (-p, -q, 1), and K x are the slopes at x
    slopes = -turned[:, :2] / turned[:, 2:]
    zero = np.zeros_like(a)
    rows = np.concatenate([np.stack([a, e, zero], axis=1), np.stack([zero, a, e], axis=1)])
    return np.asarray(np.linalg.lstsq(rows, slopes.T.ravel(), rcond=None)[0])


def _sample_mesh(mesh: Mesh, rng: np.random.Generator) -> tuple[Array, Array]:
    """Sample points (SAMPLES, 3) evenly over the faces, with the unit normals there.

    Normals of faces without an area are nil.
    """
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    area = np.linalg.norm(cross, axis=1)
    face = np.searchsorted(np.cumsum(area), area.sum() * rng.random(SAMPLES)).clip(0, len(area) - 1)
    # evenly over a parallelogram, its far half folded back onto the triangle
    u, v = rng.random((2, SAMPLES, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    points = a[face] + u * (b - a)[face] + v * (c - a)[face]
    return np.asarray(points), np.asarray(cross[face] / np.maximum(area[face], 1e-12)[:, None])
