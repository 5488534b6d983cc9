# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find and measure objects on the hull: regions of the as-found mesh that are certain."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from hullrecon.detection.as_found.hull_as_found import HullAsFound
from hullrecon.detection.as_found.landmarks import SurfaceLandmarks
from hullrecon.detection.base_surface import MIDDLE_SHARE, BaseSurface, hull_position, rounded
from hullrecon.detection.objects.footprint import (
    find_open_edge,
    hidden_extent,
    measure_size,
    outline,
)
from hullrecon.detection.objects.regions import (
    TOP_M2,
    Region,
    find_regions,
    height_sigma,
    p_value,
    roughness,
    unresolved_relief,
)
from hullrecon.detection.options import DetectOptions
from hullrecon.detection.views import CameraViews, rows_in_image, visible_rows
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import vertex_areas
from hullrecon.geometry.neighbours import Around, nearest
from hullrecon.geometry.robust import weighted_quantile
from hullrecon.records.deliverables import RejectedRegion, ReportedObject
from hullrecon.typing import Array, Ints, Mask

MIN_AGREEMENT = 0.6  # least share of an object's landmarks that stand off the hull as it does
IMAGES = 6  # most images that are named with an object
# A landmark whose foot is farther from every vertex lies where the hull was not meshed
NEAR_M = 0.02


@dataclass(frozen=True, kw_only=True)
class _RegionEvidence:
    """A region, and how certain it is."""

    region: Region
    center: int  # vertex in the middle of its top
    seen: Ints  # views that show it, the best first
    p_value: float  # probability that bare hull reaches its height somewhere
    sigma: float  # m, of its height


@dataclass(frozen=True, kw_only=True)
class _Landmarks:
    """The landmarks of a dive, indexed by their feet on the base."""

    measured: SurfaceLandmarks
    around: Around  # index of the feet
    vertices: Around  # index of the vertices of the base

    def at(self, found: HullAsFound, vertices: Ints) -> tuple[Ints, Ints]:
        """Find the landmarks that belong to some vertices, and the vertex of each.

        A landmark belongs to the vertex nearest to its foot. So landmarks on the hull beside a
        structure's edge are not counted with the structure.
        """
        where = found.base.vertices[vertices]
        near, candidates = self.around.ball(where, NEAR_M), self.vertices.ball(where, 2 * NEAR_M)
        distance, row = nearest(
            found.base.vertices[candidates], self.measured.foot[near], 1, NEAR_M
        )
        known = np.isfinite(distance[:, 0])
        near, vertex = near[known], candidates[row[known, 0]]
        on = np.isin(vertex, vertices)
        return near[on], vertex[on]

    def on_region(
        self, found: HullAsFound, region: Region, vertices: Ints
    ) -> tuple[Mask, Array, Array]:
        """Find the n landmarks that belong to vertices of a region.

        Returns
        -------
        stands
            (n,) whether each landmark stands off the hull as the region does.
        over
            (n,) m, its height above the as-found surface.
        own
            (n,) m, its own sigma.
        """
        rows, vertex = self.at(found, vertices)
        stands = self.rise_like(found, region, rows, vertex)
        return (
            stands,
            self.measured.offset[rows] - found.deviation_at(vertex),
            self.measured.sigma[rows],
        )

    def rise_like(self, found: HullAsFound, region: Region, rows: Ints, vertex: Ints) -> Mask:
        """Tell which landmarks (n,) rise at least half as much as the region at their vertices."""
        above = region.rise_of(self.measured.foot[rows], self.measured.offset[rows])
        return np.asarray(above > 0.5 * np.abs(region.rise(found, vertex)))

    def covariances(self, found: HullAsFound, region: Region) -> Array:
        """Collect the covariances (n, 3, 3) of landmarks that stand off as the region does."""
        rows, vertex = self.at(found, region.core)
        return self.measured.covariance[rows[self.rise_like(found, region, rows, vertex)]]

    def nearest_covariance(self, point: Array) -> Array:
        """Return the covariance (1, 3, 3) of the landmark nearest to a point (3,)."""
        row = int(np.argmin(np.linalg.norm(self.measured.foot - point, axis=1)))
        return self.measured.covariance[row : row + 1]


def find_objects(
    found: HullAsFound,
    measured: SurfaceLandmarks,
    views: CameraViews,
    base: BaseSurface,
    options: DetectOptions,
) -> tuple[list[ReportedObject], list[RejectedRegion]]:
    """Find the regions that stand off the hull, and split them into objects and uncertain ones.

    Both lists begin with the highest, and may be empty. An uncertain region is returned with the
    reason why it is not reported as an object.

    Parameters
    ----------
    found
        The hull as found, on whose mesh regions are looked for.
    measured
        Landmarks near the base. Those on a region must support it, and give its position's sigma.
    views
        Images of the top camera, of which enough must show a region.
    base
        The hull without structures, which gives positions and addresses.
    options
        The section [detect] of dive.toml, with the limits of what is reported.
    """
    area = vertex_areas(found.base)
    rough = roughness(found)
    scene, around = Scene(found.mesh), Around(found.base.vertices)
    landmarks = _Landmarks(measured=measured, around=Around(measured.foot), vertices=around)
    objects, rejected = [], []
    for region in find_regions(found, options):
        evidence = _collect_evidence(
            found, region, area, rough, landmarks, _seen_by(found, region, views, scene)
        )
        reason = _rejection_reason(
            found, evidence, area, _supporting_landmarks(found, region, landmarks), options
        )
        if reason:
            rejected.append(_unreported(found, evidence, area, base, landmarks, reason))
        else:
            objects.append(_object(found, evidence, area, around, views, base, landmarks))
    return objects, rejected


def _unreported(
    found: HullAsFound,
    evidence: _RegionEvidence,
    area: Array,
    base: BaseSurface,
    landmarks: _Landmarks,
    reason: str,
) -> RejectedRegion:
    """Describe a region that is not reported as an object, with its position and the reason.

    Without a landmark that stands off as it does, its position has the covariance of the nearest.

    area: of the vertices of the base (n,) m2. reason: why it is not reported.
    """
    region, center = evidence.region, found.mesh.vertices[evidence.center]
    covariances = landmarks.covariances(found, region)
    if not len(covariances):
        covariances = landmarks.nearest_covariance(center)
    middle_sigma = MIDDLE_SHARE * float(np.sqrt(area[region.footprint].sum()))
    position = hull_position(
        center, found.normal[evidence.center], covariances, evidence.sigma, middle_sigma, base
    )
    return RejectedRegion(
        center=rounded(center),
        height=round(region.height, 5),
        height_sigma=round(evidence.sigma, 5),
        reason=reason,
        **position.members(base),
    )


def _collect_evidence(
    found: HullAsFound, region: Region, area: Array, rough: float, landmarks: _Landmarks, seen: Ints
) -> _RegionEvidence:
    """Compute a region's p-value and the sigma of its height.

    The p-value takes the number of positions of a top's size on the measured hull into account, as
    each of them may be high by chance.

    Parameters
    ----------
    found, region
        The hull as found, and the region.
    area
        (n,) m2 of the vertices of the base.
    rough
        Roughness of the hull, m.
    landmarks
        Those on the region's top show relief that smoothing removed.
    seen
        Views that show the region, the best first.
    """
    sigma = height_sigma(found, region)
    places = float(area[found.measured].sum() / TOP_M2)
    by_bare_hull = p_value(region.height, sigma, rough, places)
    # The sigma of the height has four parts: that of the fit, the roughness of the hull, the
    # bluntness, by which a peak may be higher than was measured, and the relief between landmarks
    # that smoothing has removed.
    stands, over, own = landmarks.on_region(found, region, _top_rows(found, region))
    unresolved = unresolved_relief(over[stands], own[stands])
    sigma = float(np.sqrt(sigma**2 + rough**2 + region.bluntness**2 + unresolved**2))
    return _RegionEvidence(
        region=region,
        center=_center(found, region, area),
        seen=seen,
        p_value=by_bare_hull,
        sigma=sigma,
    )


def _rejection_reason(
    found: HullAsFound,
    evidence: _RegionEvidence,
    area: Array,
    supporting: tuple[int, float],
    options: DetectOptions,
) -> str:
    """Give the first reason why a region is not reported as an object. Empty if it is reported.

    Parameters
    ----------
    found, evidence
        The hull as found, and the region with what is known of it.
    area
        (n,) m2 of the vertices of the base.
    supporting
        Number of landmarks on the region's core that stand off as it does, and their share.
    options
        The limits of height, area, landmarks, images and p-value.
    """
    region, seen, (on, agree) = evidence.region, len(evidence.seen), supporting
    # An image shows the region if it saw it and its features make an alpha shape there
    images = min(seen, _views_with_shape(found, region, area))
    core = float(area[region.core].sum())
    facets = _height_of_facets(found, region)  # m, which a bare curved hull may seem to have
    checks = (
        (abs(region.height) < options.min_height_m + facets, _too_low(region.height, facets)),
        (core < options.min_area_m2, f"only {1e4 * core:.0f} cm2 above half its height"),
        (on < options.min_landmarks, f"only {on} landmark{'' if on == 1 else 's'}"),
        (agree < MIN_AGREEMENT, f"only {100 * agree:.0f} % of its landmarks agree"),
        (images < options.min_views, f"only {images} images show it"),
        (
            evidence.p_value > options.max_p_value,
            f"bare hull does so with probability {evidence.p_value:.2g}",
        ),
    )
    return next((reason for failed, reason in checks if failed), "")


def _too_low(height: float, facets: float) -> str:
    """Say how high a region is that is too low for an object, and what facets may explain of it.

    height, facets: m.
    """
    said = f"only {abs(height):.3f} m off the hull around it"
    if facets < 0.0005:  # in the sentence it would be 0.000 m
        return said
    return f"{said}, of which the CAD model's flat facets may account for {facets:.3f} m"


def _height_of_facets(found: HullAsFound, region: Region) -> float:
    """Compute how high a curved hull without a structure may seem over flat facets, m, at most.

    A region must be higher than that to be reported. The curved hull is off a facet by at most the
    sagitta. Heights are counted from a plane through the ring around the region. Where facets meet
    at an angle, the curved hull is off such a plane by at most half of the angle times the distance
    to the ring.
    """
    vertices = found.base.vertices
    reach = np.linalg.norm(vertices[region.ring] - vertices[region.core].mean(axis=0), axis=1).max()
    return float(
        np.median(np.minimum(found.sagitta[region.core], 0.5 * found.turn[region.core] * reach))
    )


def _views_with_shape(found: HullAsFound, region: Region, area: Array) -> int:
    """Count the views whose alpha shapes of features show the region (`as_found/shapes.py`).

    They must show at least TOP_M2 of its core, the area that its height comes from too. It is the
    largest number k so that vertices of TOP_M2 are each shown by k views or more.
    """
    order = region.core[np.argsort(-found.shapes[region.core], kind="stable")]
    enough = np.flatnonzero(np.cumsum(area[order]) >= TOP_M2)
    return int(found.shapes[order[enough[0]]]) if len(enough) else 0


def _supporting_landmarks(
    found: HullAsFound, region: Region, landmarks: _Landmarks
) -> tuple[int, float]:
    """Count the landmarks on a region's core that stand off as it does, and their share of all."""
    stands, _, _ = landmarks.on_region(found, region, region.core)
    return int(stands.sum()), float(stands.mean()) if len(stands) else 0.0


def _center(found: HullAsFound, region: Region, area: Array) -> int:
    """Find the vertex nearest to the middle of a region's top. area: (n,) m2 of the vertices."""
    top = _top_rows(found, region)
    middle = np.average(found.base.vertices[top], axis=0, weights=np.maximum(area[top], 1e-12))
    return int(top[np.argmin(np.linalg.norm(found.base.vertices[top] - middle, axis=1))])


def _seen_by(found: HullAsFound, region: Region, views: CameraViews, scene: Scene) -> Ints:
    """List the views that saw more than half of a region's top, the best first. May be empty.

    The best view has the top nearest to the middle of its image.
    """
    top = _top_rows(found, region)
    middle = views.result_from_camera.inverse().apply(found.mesh.vertices[top].mean(axis=0)[None])
    # How far off the optical axis each view shows the top's middle, as a tangent
    offset = np.hypot(middle[:, 0], middle[:, 1]) / np.maximum(middle[:, 2], 1e-6)
    near = np.linalg.norm(middle, axis=1) < views.farthest_m + 0.5
    share = np.zeros(len(views))
    for view in np.flatnonzero(near).tolist():
        rows = rows_in_image(views, view, found.mesh.vertices, top)
        clear, _, _ = visible_rows(
            views.result_from_camera.translation[view],
            rows,
            found.mesh.vertices,
            found.normal,
            scene,
        )
        share[view] = len(clear) / len(top)
    seen = np.flatnonzero(share > 0.5)
    return seen[np.argsort(offset[seen], kind="stable")]


def _top_rows(found: HullAsFound, region: Region) -> Ints:
    """Select the vertices of a region's top: those of the core above four fifths of its height."""
    top = region.core[region.rise(found, region.core) >= 0.8 * abs(region.height)]
    return top if len(top) else region.core


def _object(
    found: HullAsFound,
    evidence: _RegionEvidence,
    area: Array,
    around: Around,
    views: CameraViews,
    base: BaseSurface,
    landmarks: _Landmarks,
) -> ReportedObject:
    """Measure the object of a certain region: position, size, height and their sigmas.

    area: of the vertices of the base (n,) m2. around: index of these vertices.
    """
    region = evidence.region
    footprint, core = region.footprint, region.core
    normal = np.average(found.normal[core], axis=0, weights=np.maximum(area[core], 1e-12))
    normal /= np.linalg.norm(normal)
    # The deviation of the top is a quantile, so that no single vertex decides it
    deviation = region.sign * weighted_quantile(
        region.sign * found.deviation_at(core), area[core], 0.98
    )
    open_edge = find_open_edge(found, region, area, around)
    size = measure_size(found, region, open_edge, area, evidence.sigma, normal, base.chart)
    # The middle is uncertain by where the edge is drawn, and by half of what may lie beyond an open
    # edge
    middle_sigma = np.hypot(
        MIDDLE_SHARE * max(size.extent),
        0.5 * hidden_extent(found, region, open_edge, normal, base.chart).max(),
    )
    center = _top(found, region, evidence.center)
    position = hull_position(
        center,
        normal,
        landmarks.covariances(found, region),
        evidence.sigma,
        float(middle_sigma),
        base,
    )
    return ReportedObject(
        center=rounded(center),
        normal=rounded(normal),
        height=round(region.height, 5),
        height_sigma=round(evidence.sigma, 5),
        deviation=round(deviation, 5) if base.cad_model is not None else None,
        deviation_sigma=round(float(position.sigma[2]), 5) if base.cad_model is not None else None,
        **asdict(size),
        open_edge=round(open_edge.share, 3),
        views=len(evidence.seen),
        p_value=float(f"{evidence.p_value:.3g}"),
        images=tuple(views.name[view] for view in evidence.seen[:IMAGES]),
        outline=tuple(rounded(point) for point in outline(found.mesh, footprint)),
        **position.members(base),
    )


def _top(found: HullAsFound, region: Region, center: int) -> Array:
    """Compute the point (3,) at the region's height above the vertex `center` of the base."""
    foot = found.base.vertices[center]
    return np.asarray(
        foot + found.normal[center] * (region.hull.offset(foot[None])[0] + region.height)
    )
