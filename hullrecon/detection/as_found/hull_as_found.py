# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The hull as found: the base surface, refined and moved to the landmarks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hullrecon.detection.as_found.landmarks import Background, SurfaceLandmarks
from hullrecon.detection.as_found.shapes import count_shapes
from hullrecon.detection.objects.heights import Heights, local_heights
from hullrecon.detection.options import MIN_OFFSET_M, DetectOptions
from hullrecon.detection.views import CameraViews, Visibility, find_visibility_by_cell
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh, vertex_normals
from hullrecon.geometry.meshes.refinement import refine
from hullrecon.geometry.meshes.tessellation import facet_sagitta, facet_turn
from hullrecon.geometry.neighbours import is_near, nearest
from hullrecon.records.surface import Surface
from hullrecon.typing import Array, Ints, Mask

# Sides of cells in which visibility is found for one vertex: on bare hull, and near structures
COARSE_CELL_M, FINE_CELL_M = 0.06, 0.02
REACH_M = 0.08  # landmarks within this distance of a vertex determine its height
NEIGHBOURS = 20  # nearest landmarks from which the height of a vertex is estimated
FINE_EDGE_M = 0.012  # longest edge of the mesh at structures
SHADOW_M = 0.15  # a structure occludes hull up to this distance from it
SEAM_SIGMA_M = 0.01  # sigma of a height interpolated across a triangle of the DVL's surface


@dataclass(frozen=True, kw_only=True)
class HullAsFound:
    """The hull as found, given at the n vertices of the refined base."""

    mesh: Mesh  # with the vertices where they were found
    base: Mesh  # with the vertices on the base
    normal: Array  # (n, 3) of the base
    hull: Array  # (n,) m, smooth offset of the hull from the base
    hull_sigma: Array  # (n,) m
    height: Array  # (n,) m above that hull, 0 where not measured
    sigma: Array  # (n,) m of the height
    measured: Mask  # (n,) whether landmarks determine the height
    agreement: Array  # (n,) share of landmarks that agree with the height
    # (n,) number of views in which an alpha shape of the features off the hull lies on the ray to
    # the vertex [Ozog2016 Algorithm 5]
    shapes: Ints
    seen: Visibility  # how the views saw the vertices
    # (n,) m: how far a curved hull may stand off the CAD model's flat facet. 0 off structures
    sagitta: Array
    turn: Array  # (n,) rad: largest angle between the facet and its neighbours. 0 off structures

    @property
    def deviation(self) -> Array:
        """Deviation (n,) m from the base, outward positive."""
        return self.hull + self.height

    def deviation_at(self, vertices: Ints) -> Array:
        """Compute the deviations (k,) m of some vertices (k,)."""
        return np.asarray(self.hull[vertices] + self.height[vertices])


@dataclass(frozen=True, kw_only=True)
class Unfused:
    """The refined base with its regressed heights, before the views' shapes are fused into it."""

    mesh: Mesh  # with n vertices
    normal: Array  # (n, 3) outward
    hull: Array  # (n,) m, smooth offset of the hull from the base
    height: Array  # (n,) m above that hull by regression, 0 where no landmark is near
    features: Array  # (l, 3) m, landmarks
    feature_height: Array  # (l,) m, of the landmarks above the hull


# Returns the moved vertices (n, 3), their heights (n,) m above the hull, and the number of views
# (n,) whose shapes show each
Fusion = Callable[[Unfused, CameraViews, DetectOptions], tuple[Array, Array, Ints]]


def fuse_heights(
    given: Unfused, views: CameraViews, options: DetectOptions
) -> tuple[Array, Array, Ints]:
    """Move each vertex along its normal by its regressed height, and count the shapes there.

    The default `Fusion`: shapes of the views only count, and do not move a vertex.
    """
    moved = given.mesh.vertices + given.normal * (given.hull + given.height)[:, None]
    shapes = count_shapes(views, given.features, given.feature_height, moved, options)
    return moved, given.height, shapes


def estimate_hull_as_found(
    base: Mesh,
    measured: SurfaceLandmarks,
    background: Background,
    views: CameraViews,
    options: DetectOptions,
    fusion: Fusion = fuse_heights,
) -> HullAsFound:
    """Refine the base at landmarks and structures, and move it to the landmarks.

    Vertices without landmarks near by stay on the hull without structures, and are marked as not
    measured.

    Parameters
    ----------
    base
        The CAD model, or the surveyed surface without one.
    measured
        Landmarks near the base, from whose offsets heights are regressed.
    background
        Offset of the hull without structures from the base, above which heights are counted.
    views
        Images of the top camera, whose shapes show structures and which see the vertices or not.
    options
        The section [detect] of dive.toml: sizes of the mesh, and the radius of clusters.
    fusion
        How regressed heights and the views' shapes become vertices.
    """
    # Heights over the hull without structures, on a mesh that is fine at landmarks and structures.
    hull_at_foot, _ = background.at(measured.foot)
    height = measured.offset - hull_at_foot
    mesh, normal, heights = _mesh_with_heights(base, measured, height, options)

    # Move the vertices to their heights, and count the views whose shapes show them.
    hull, hull_sigma = background.at(mesh.vertices)
    known = np.isfinite(heights.value)
    moved, raised, shapes = fusion(
        Unfused(
            mesh=mesh,
            normal=normal,
            hull=hull,
            height=np.where(known, heights.value, 0.0),
            features=measured.position,
            feature_height=height,
        ),
        views,
        options,
    )

    # Visibility of the moved mesh, and how far its facets may be off a curved hull.
    shape = Mesh(moved, mesh.faces)
    cell = np.where(_near_structures(mesh, raised), FINE_CELL_M, COARSE_CELL_M)
    seen = find_visibility_by_cell(views, moved, vertex_normals(shape), Scene(shape), cell)
    sagitta, turn = _facets_at(base, mesh, np.abs(raised) >= MIN_OFFSET_M)
    # a hull without landmarks near by is taken to rise by less than a structure
    sigma = np.where(known, heights.sigma, MIN_OFFSET_M)
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
        shapes=shapes,
        seen=seen,
        sagitta=sagitta,
        turn=turn,
    )


def _mesh_with_heights(
    base: Mesh, measured: SurfaceLandmarks, height: Array, options: DetectOptions
) -> tuple[Mesh, Array, Heights]:
    """Refine the base at landmarks, and more at structures, and regress heights at its vertices.

    Structures are where heights are above MIN_OFFSET_M. height: (l,) m of the landmarks above the
    hull. Returns the mesh with n vertices, its normals (n, 3) and its heights (n).
    """
    edge = affordable_edge(measured.foot, options.max_edge_m, options.max_vertices)
    mesh = refine_near(base, measured.foot, edge, REACH_M)
    coarse = _regress(mesh.vertices, vertex_normals(mesh), measured, height)
    high = np.abs(coarse.value) >= MIN_OFFSET_M
    old = len(mesh.vertices)
    left = max(options.max_vertices - old, 1)
    fine = min(edge, affordable_edge(mesh.vertices[high], FINE_EDGE_M, left))
    mesh = refine_near(mesh, mesh.vertices[high], fine, 2 * FINE_EDGE_M)
    normal = vertex_normals(mesh)
    # vertices of the coarse mesh keep their heights
    fresh = _regress(mesh.vertices[old:], normal[old:], measured, height)
    return mesh, normal, coarse.followed_by(fresh)


def _facets_at(base: Mesh, mesh: Mesh, which: Mask) -> Array:
    """Look up sagitta and turn (2, n) of the base's facets under some vertices. 0 elsewhere.

    They bound how far a curved hull may lie off a CAD model of flat facets without a structure.
    which (n,): the vertices of the refined mesh.
    """
    out = np.zeros((2, len(mesh.vertices)))
    if which.any():
        face = Scene(base).closest(mesh.vertices[which]).face
        out[:, which] = facet_sagitta(base)[face], facet_turn(base)[face]
    return out


def _near_structures(mesh: Mesh, height: Array) -> Mask:
    """Tell which vertices (n,) are on structures, or so near that these may occlude them."""
    return is_near(mesh.vertices[np.abs(height) >= MIN_OFFSET_M], mesh.vertices, SHADOW_M)


def _regress(at: Array, normal: Array, measured: SurfaceLandmarks, height: Array) -> Heights:
    """Regress heights at points (n, 3) with normals (n, 3) from the landmarks' heights."""
    return local_heights(at, normal, measured.foot, height, measured.sigma, NEIGHBOURS, REACH_M)


def refine_near(mesh: Mesh, points: Array, edge_m: float, reach_m: float) -> Mesh:
    """Split edges of a mesh that are longer than `edge_m` within `reach_m` of points (n, 3).

    Farther off, the allowed edge grows with the distance. So only the surveyed part of a ship is
    meshed finely. Old vertices keep their rows. Without points the mesh is returned as it is.
    """
    # One point in each cell is enough. Its rounding is made up for by `cell` in the reach.
    cell = 0.5 * max(edge_m, reach_m)
    thinned: Array = np.unique(np.round(points / cell), axis=0) * cell

    def allowed_edge(middle: Array) -> Array:
        """Compute the longest edge (e,) m allowed at the edges' middles (e, 3) m."""
        distance, _ = nearest(thinned, middle, 1)
        return np.asarray(edge_m + np.maximum(0.0, distance[:, 0] - reach_m - cell))

    return refine(mesh, allowed_edge, spared_m=edge_m)[0] if len(points) else mesh


def affordable_edge(points: Array, edge_m: float, max_vertices: int) -> float:
    """Compute the edge, at least `edge_m`, with which a mesh has about `max_vertices` at most.

    The area is estimated from points (n, 3) that cover it. A mesh has one vertex for each 0.43
    edge^2 of it.
    """
    cell_m = 0.2
    area_m2 = len(np.unique(np.floor(points / cell_m).astype(np.int64), axis=0)) * cell_m**2
    return float(max(edge_m, np.sqrt(area_m2 / (0.43 * max_vertices))))


def as_found_surface(
    found: HullAsFound, measured: SurfaceLandmarks, has_cad_model: bool = True
) -> Surface:
    """Make the record of the hull as found.

    Its support is the number of views that saw a vertex where landmarks measured it, and 0 where
    no view saw it, or where it has no texture. Its sigma is of the position in the frame of the
    results, with the part that neighbouring landmarks have in common. Without a CAD model the
    deviation is NaN.
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
    """Move the CAD model to the surface from the DVL, by interpolation of its deviations.

    It is the hull as found where no image gave landmarks. edge_m: longest edge of the result near
    that surface. Vertices farther than two edges from it are not moved, and have no support.
    """
    mesh = refine_near(cad_model, surface.vertices, edge_m, edge_m)
    distance, row = nearest(
        surface.vertices, mesh.vertices, min(4, len(surface.vertices)), 2 * edge_m
    )
    # Weights of the nearest vertices of the surface by the inverse square of their distance
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
