# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull as found, as the record that an artifact holds."""

from __future__ import annotations

import numpy as np

from hullrecon.detection.as_found.hull_as_found import HullAsFound
from hullrecon.detection.as_found.landmarks import SurfaceLandmarks
from hullrecon.detection.as_found.mesh import refine_near
from hullrecon.geometry.meshes.mesh import Mesh, vertex_normals
from hullrecon.geometry.neighbours import nearest
from hullrecon.records.surface import Surface
from hullrecon.typing import Array

SEAM_SIGMA_M = 0.01  # of a height carried over the width of one triangle of the DVL's surface


def as_found_surface(
    found: HullAsFound, measured: SurfaceLandmarks, has_cad_model: bool = True
) -> Surface:
    """Return the hull as found. support: views that saw the vertex where landmarks measured it, 0
    elsewhere (unseen, or seen without texture); sigma: of its position in the hull frame, so with
    what all landmarks around share; deviation: NaN without a CAD model.
    """
    _, row = nearest(measured.foot, found.base.vertices, 1)
    shared = measured.common[row[:, 0]]
    sigma = np.where(
        found.measured, np.hypot(found.sigma, shared), np.hypot(found.sigma, found.hull_sigma)
    )
    support = np.where(found.measured, found.seen.views, 0)
    deviation = found.deviation if has_cad_model else np.full(len(sigma), np.nan)
    return Surface(
        vertices=found.mesh.vertices,
        faces=found.mesh.faces,
        deviation=deviation,
        sigma=sigma,
        support=support,
    )


def surface_on_cad_model(cad_model: Mesh, surface: Surface, edge_m: float) -> Surface:
    """Return the CAD model moved to the DVL's surface: deviations of its vertices carried over,
    where any lies within two edges.
    """
    mesh = refine_near(cad_model, surface.vertices, edge_m, edge_m)
    distance, row = nearest(
        surface.vertices, mesh.vertices, min(4, len(surface.vertices)), 2 * edge_m
    )
    known = np.isfinite(distance[:, 0])
    weight = np.where(np.isfinite(distance), 1 / (distance + 1e-3) ** 2, 0.0)
    weight[known] /= weight[known].sum(axis=1, keepdims=True)
    row = np.where(np.isfinite(distance), row, 0)

    def carry_over(values: Array) -> Array:
        return np.asarray((weight * values[row]).sum(axis=1))

    deviation = carry_over(surface.deviation)
    sigma = np.where(known, np.hypot(carry_over(surface.sigma), SEAM_SIGMA_M), np.nan)
    support = np.where(known, surface.support[row[:, 0]], 0)
    vertices = mesh.vertices + vertex_normals(mesh) * deviation[:, None]
    return Surface(
        vertices=vertices, faces=mesh.faces, deviation=deviation, sigma=sigma, support=support
    )
