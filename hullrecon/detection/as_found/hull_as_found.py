# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull as found: the base surface refined and moved to what was seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.detection.as_found.background import Background
from hullrecon.detection.as_found.fusion import fuse_shapes
from hullrecon.detection.as_found.landmarks import SurfaceLandmarks
from hullrecon.detection.as_found.mesh import affordable_edge, refine_near
from hullrecon.detection.objects.heights import Heights, local_heights
from hullrecon.detection.options import DetectOptions
from hullrecon.detection.views import CameraViews, Visibility, find_visibility_by_cell
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh, vertex_normals
from hullrecon.geometry.meshes.tessellation import facet_sagitta, facet_turn
from hullrecon.geometry.neighbours import nearest
from hullrecon.typing import Array, Ints, Mask

# one vertex a cell is asked who saw it: on bare hull, near structures
COARSE_CELL_M, FINE_CELL_M = 0.06, 0.02
SHADOW_M = 0.15  # a structure's shadow hardly reaches farther


@dataclass(frozen=True, kw_only=True)
class HullAsFound:
    """Vertex by vertex (n): where it is now (mesh) and on the base; normal (n, 3) of the base; hull
    (n,) m, the smooth offset of the hull from the base, and its sigma; height (n,) m above that
    hull, 0 where not measured; sigma (n,) m of the height; measured (n,) bool; agreement (n,) share
    of landmarks that agree; shapes (n,) views whose shapes show it [Ozog2016 Algorithm 5]; seen: by
    which views; at structures sagitta (n,) m, how far the true curve may stand off the CAD model's
    facet there, and turn (n,) rad, by which the facet's neighbours may be turned from it.
    """

    mesh: Mesh
    base: Mesh
    normal: Array
    hull: Array
    hull_sigma: Array
    height: Array
    sigma: Array
    measured: Mask
    agreement: Array
    shapes: Ints
    seen: Visibility
    sagitta: Array
    turn: Array

    @property
    def deviation(self) -> Array:
        """(n,) m from the base, outward positive."""
        return self.hull + self.height

    def deviation_at(self, vertices: Ints) -> Array:
        """Return the same of some vertices (n,)."""
        return np.asarray(self.hull[vertices] + self.height[vertices])


def estimate_hull_as_found(
    base: Mesh,
    measured: SurfaceLandmarks,
    background: Background,
    views: CameraViews,
    options: DetectOptions,
) -> HullAsFound:
    """Refine the base where landmarks are, finely at structures; move it to the landmarks; see what
    saw it.
    """
    hull_at_foot, _ = background.at(measured.foot)
    height = measured.offset - hull_at_foot
    edge = affordable_edge(measured.foot, options.max_edge_m, options.max_vertices)
    mesh = refine_near(base, measured.foot, edge, options.reach_m)
    coarse = _regress(mesh.vertices, vertex_normals(mesh), measured, height, options)
    high = np.abs(coarse.value) >= options.min_offset_m
    old = len(mesh.vertices)
    left = max(options.max_vertices - old, 1)
    fine = min(edge, affordable_edge(mesh.vertices[high], options.max_fine_edge_m, left))
    mesh = refine_near(mesh, mesh.vertices[high], fine, 2 * options.max_fine_edge_m)
    normal = vertex_normals(mesh)
    heights = coarse.append(_regress(mesh.vertices[old:], normal[old:], measured, height, options))
    hull, hull_sigma = background.at(mesh.vertices)
    known = np.isfinite(heights.value)
    moved = mesh.vertices + normal * (hull + np.where(known, heights.value, 0.0))[:, None]
    rays_to = moved if options.fusion == "heights" else mesh.vertices
    fused = fuse_shapes(views, measured.position, height, rays_to, options)
    raised = np.where(known, heights.value, 0.0)
    if options.fusion == "rays":
        taken = fused.count > 0
        moved = np.where(taken[:, None], fused.vertex, mesh.vertices + normal * hull[:, None])
        raised = np.where(taken, np.einsum("ni,ni->n", moved - mesh.vertices, normal) - hull, 0.0)
    shape = Mesh(moved, mesh.faces)
    cell = np.where(_near_structures(mesh, raised, options), FINE_CELL_M, COARSE_CELL_M)
    seen = find_visibility_by_cell(views, moved, vertex_normals(shape), Scene(shape), cell)
    sagitta, turn = _facets_at(base, mesh, np.abs(raised) >= options.min_offset_m)
    sigma = np.where(known, heights.sigma, options.min_offset_m)
    return HullAsFound(
        mesh=shape,
        base=mesh,
        normal=normal,
        hull=hull,
        hull_sigma=hull_sigma,
        height=raised,
        sigma=sigma,
        measured=known,
        agreement=heights.agreement,
        shapes=fused.count,
        seen=seen,
        sagitta=sagitta,
        turn=turn,
    )


def _facets_at(base: Mesh, mesh: Mesh, which: Mask) -> Array:
    """Return sagitta and turn of the base's face under each of those vertices (2, n), 0 elsewhere."""
    out = np.zeros((2, len(mesh.vertices)))
    if which.any():
        face = Scene(base).closest(mesh.vertices[which]).face
        out[:, which] = facet_sagitta(base)[face], facet_turn(base)[face]
    return out


def _near_structures(mesh: Mesh, height: Array, options: DetectOptions) -> Mask:
    """Mark the vertices on structures and where these may hide the hull from a camera."""
    off = np.abs(height) >= options.min_offset_m
    if not off.any():
        return off
    return np.asarray(np.isfinite(nearest(mesh.vertices[off], mesh.vertices, 1, SHADOW_M)[0][:, 0]))


def _regress(
    at: Array, normal: Array, measured: SurfaceLandmarks, height: Array, options: DetectOptions
) -> Heights:
    return local_heights(
        at, normal, measured.foot, height, measured.sigma, options.neighbours, options.reach_m
    )
