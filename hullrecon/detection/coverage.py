# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How much of the hull was seen, how well, and where the survey has holes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hullrecon.detection.as_found.hull_as_found import refine_near
from hullrecon.detection.base_surface import BaseSurface, HullError, area_sigma, hull_position
from hullrecon.detection.views import GRAZING, CameraViews, Visibility, find_visibility
from hullrecon.dive.config.schema import HullRegion
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.region import region_cells
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh, vertex_areas, vertex_normals
from hullrecon.geometry.neighbours import nearest
from hullrecon.geometry.poses import Poses
from hullrecon.records.sensors import SonarPings
from hullrecon.records.solution import HullPose
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.typing import Array, Ints, Mask

Facts = dict[str, Any]
Look = Callable[[HullError], Mask]  # which patches a sensor saw if the hull lies off
CELL_M = 0.1
PATCH_M = 0.12  # edges of the patches on which coverage is summed
PATCHES_REACH_M = 2.0  # from what the survey saw; beyond, the CAD model's own faces are the patches
DVL_REACH_M = 0.08  # from a vertex of the DVL's surface, whose edges are 0.1 m
# gaps of up to twice as many cells at the rim of the surveyed area count as holes; inside it, any
BRIDGE_CELLS = 6
MIN_HOLE_M2 = 0.03
SONAR_GRAZING = 0.25 * GRAZING  # cosine of the steepest incidence from which a sonar hears
# its returns lie decimetres apart, its surface ends 0.4 m from one: less is a notch of the rim
MIN_HOLE_BY_DVL_M2 = 0.16


@dataclass(frozen=True, kw_only=True)
class HullPatches:
    """The base surface in patches of some 0.1 m, on which seen area is summed."""

    mesh: Mesh  # its vertices (n) stand for the patches
    normal: Array  # (n, 3)
    area: Array  # (n,) m2


@dataclass(frozen=True, kw_only=True)
class SonarSurvey:
    """The pings of an imaging sonar and where they were taken."""

    pings: SonarPings
    poses: Poses  # result_from_sonar at each ping
    half_elevation_rad: float  # half of the aperture out of the fan


def summarise_coverage(
    base: BaseSurface,
    views: CameraViews | None,
    sonar: SonarSurvey | None,
    track: VehicleTrack,
    regions: Sequence[HullRegion] = (),
) -> Facts:
    """Sum the hull that each sensor saw and find its holes, for coverage.json.

    Holes are in what the camera saw, without a camera in what the DVL saw. `regions`: of the CAD
    model, whose own coverage is added; none without a CAD model.
    """
    surveyed = base.surveyed.vertices
    patches, scene = (
        hull_patches(refine_near(base.mesh, surveyed[::7], PATCH_M, PATCHES_REACH_M)),
        Scene(base.mesh),
    )
    by_dvl = covered_by_surface(patches, surveyed[base.surveyed.support > 0], DVL_REACH_M)
    report: Facts = {"frame": str(base.frame), "dvl": None, "camera": None, "sonar": None}
    if base.from_dvl:
        report["dvl"] = area_facts(patches, by_dvl)
    seen, min_hole_m2 = by_dvl, MIN_HOLE_BY_DVL_M2
    if views is not None:
        by_camera = find_visibility(views, patches.mesh.vertices, patches.normal, scene)
        report["camera"] = camera_facts(patches, by_camera, views.camera.fx, len(views))
        seen, min_hole_m2 = by_camera.views > 0, MIN_HOLE_M2
    if sonar is not None:
        report["sonar"] = sonar_facts(patches, sonar, scene, base.hull_pose)
    report["holes"] = find_holes(
        patches, seen, base.chart, lambda center: locate_hole(center, base, track), min_hole_m2
    )
    report["min_hole_m2"] = min_hole_m2
    if regions and base.hull_pose is not None:
        report["regions"] = [
            region_facts(region, base, views, sonar, scene, base.hull_pose) for region in regions
        ]
    return report


def locate_hole(center: Array, base: BaseSurface, track: VehicleTrack) -> Facts:
    """Locate the middle (3,) of a hole, as members of coverage.json.

    Nothing was measured in a hole. Its place is known as well as the nearest pose of the path, and
    no better than a cell of the chart.
    """
    near = int(np.argmin(np.linalg.norm(track.poses.translation - center, axis=1)))
    toward = track.poses.translation[near] - center
    normal = toward / max(float(np.linalg.norm(toward)), 1e-9)
    covariance = track.covariance[near : near + 1, :3, :3]
    return hull_position(center, normal, covariance, 0.0, CELL_M / np.sqrt(12), base).as_json(base)


def region_facts(
    region: HullRegion,
    base: BaseSurface,
    views: CameraViews | None,
    sonar: SonarSurvey | None,
    scene: Scene,
    hull_pose: HullPose,
) -> Facts:
    """Sum how much of a region of the CAD model each sensor saw, with sigmas.

    None stands for a sensor that was not carried. The region's limits are on the ship: how much of
    the survey lies within them depends on the hull pose.
    """
    cells = region_cells(base.chart, base.mesh, region.along, region.girth)
    patches = HullPatches(
        mesh=Mesh(cells.middle, np.zeros((0, 3), np.int32)), normal=cells.normal, area=cells.area
    )
    surveyed = base.surveyed.vertices[base.surveyed.support > 0]
    seen: dict[str, Look | None] = {"camera": None, "dvl": None, "sonar": None}
    if views is not None:
        seen["camera"] = lambda off: (
            find_visibility(
                replace(views, result_from_camera=off.poses(views.result_from_camera)),
                cells.middle,
                cells.normal,
                scene,
            ).views
            > 0
        )
    if base.from_dvl:
        # Laid on the CAD model: a hull that lies off along its normal was seen as well as before
        seen["dvl"] = lambda off: covered_by_surface(
            patches, scene.closest(off.points(surveyed)).foot, DVL_REACH_M
        )
    if sonar is not None:
        seen["sonar"] = lambda off: visible_to_sonar(
            patches, replace(sonar, poses=off.poses(sonar.poses)), scene
        )
    shares = {
        name: None if look is None else _share(patches, look, hull_pose)
        for name, look in seen.items()
    }
    whole = round(float(cells.area.sum()), 4)
    return {
        "name": region.name,
        "along": region.along,
        "girth": region.girth,
        "area_m2": whole,
        **shares,
    }


def _share(region: HullPatches, look: Look, hull_pose: HullPose) -> Facts:
    """Sum the area of a region that was seen and its share of the whole, with sigmas."""
    whole = float(region.area.sum())
    area = _area(region, look(HullError(hull_pose=hull_pose, error=np.zeros(6))))
    sigma = area_sigma(lambda off: _area(region, look(off)), hull_pose)
    share, share_sigma = (round(value / whole, 4) if whole else 0.0 for value in (area, sigma))
    return {
        "area_m2": area,
        "area_sigma_m2": sigma,
        "share": min(share, 1.0),
        "share_sigma": share_sigma,
    }


def hull_patches(mesh: Mesh) -> HullPatches:
    return HullPatches(mesh=mesh, normal=vertex_normals(mesh), area=vertex_areas(mesh))


def camera_facts(hull: HullPatches, seen: Visibility, focal_px: float, images: int) -> Facts:
    """Sum area, ground sample distance and incidence at each patch's best view.

    Percentiles are of the area seen.
    """
    which = seen.views > 0
    gsd = seen.distance[which] / focal_px
    incidence = np.degrees(np.arccos(np.clip(seen.cosine[which], -1, 1)))
    return {
        "images": images,
        "area_m2": _area(hull, which),
        "area_twice_m2": _area(hull, seen.views > 1),
        "gsd_m": _percentiles(gsd, hull.area[which]),
        "incidence_deg": _percentiles(incidence, hull.area[which]),
        "views": _percentiles(seen.views[which].astype(np.float64), hull.area[which]),
    }


def covered_by_surface(hull: HullPatches, vertices: Array, reach_m: float) -> Mask:
    """Mark the patches that the DVL's surface with those vertices covers."""
    if not len(vertices):
        return np.zeros(len(hull.area), bool)
    return np.asarray(np.isfinite(nearest(vertices, hull.mesh.vertices, 1, reach_m)[0][:, 0]))


def visible_to_sonar(hull: HullPatches, sonar: SonarSurvey, scene: Scene) -> Mask:
    """Mark the patches inside any ping's fan that face the sonar unhidden.

    z of the sonar looks along the middle of the fan, x out of its plane (docs/conventions.md).
    """
    pings, result_from_sonar = sonar.pings, sonar.poses
    bearing = np.arctan2(pings.directions[:, 1], pings.directions[:, 2])  # in the fan's plane
    columns = np.ascontiguousarray(hull.mesh.vertices.T), np.ascontiguousarray(hull.normal.T)
    out_of_plane = result_from_sonar.rotation.as_matrix()[:, :, 0]
    seen = np.zeros(len(hull.area), bool)
    for ping in range(len(result_from_sonar)):
        center = result_from_sonar.translation[ping]
        rows = np.flatnonzero(_near_fan(*columns, center, out_of_plane[ping], sonar) & ~seen)
        # in the fan: by range, elevation out of its plane, and bearing
        local = result_from_sonar[ping].inverse().apply(hull.mesh.vertices[rows])
        distance = np.maximum(np.linalg.norm(local, axis=1), 1e-9)
        at = np.arctan2(local[:, 1], local[:, 2])
        fits = (distance >= pings.range_m[0]) & (
            np.abs(np.arcsin(local[:, 0] / distance)) <= sonar.half_elevation_rad
        )
        rows = rows[fits & (at >= bearing.min()) & (at <= bearing.max())]
        # facing the sonar, with nothing in between
        ray = hull.mesh.vertices[rows] - center
        length = np.maximum(np.linalg.norm(ray, axis=1), 1e-9)
        clear = -np.einsum("ni,ni->n", ray, hull.normal[rows]) / length > SONAR_GRAZING
        clear &= scene.cast(center, ray / length[:, None]) > length - 0.02
        seen[rows[clear]] = True
    return seen


def _near_fan(
    points: Array, normals: Array, center: Array, out_of_plane: Array, sonar: SonarSurvey
) -> Mask:
    """Mark the points (3, n) that face the sonar within reach and, but for rounding, in its fan.

    Nearly all are ruled out here, coordinate by coordinate and without angles.
    """
    ray = points - center[:, None]
    distance = np.sqrt(np.square(ray).sum(axis=0))
    elevation = np.sin(min(sonar.half_elevation_rad, np.pi / 2))
    return np.asarray(
        (distance <= sonar.pings.range_m[-1])
        & (np.abs(out_of_plane @ ray) <= (elevation + 1e-9) * distance)
        & (-(ray * normals).sum(axis=0) > (SONAR_GRAZING - 1e-9) * distance)
    )


def sonar_facts(
    hull: HullPatches, sonar: SonarSurvey, scene: Scene, hull_pose: HullPose | None
) -> Facts:
    """Count pings and sum the area that they saw.

    With a CAD model the area has a sigma: a fan meets the hull at a grazing angle, so the area
    depends on the hull pose.
    """
    facts = {"pings": len(sonar.poses), **area_facts(hull, visible_to_sonar(hull, sonar, scene))}
    if hull_pose is None:
        return facts

    def area_if(off: HullError) -> float:
        return _area(
            hull, visible_to_sonar(hull, replace(sonar, poses=off.poses(sonar.poses)), scene)
        )

    return {**facts, "area_sigma_m2": area_sigma(area_if, hull_pose)}


def area_facts(hull: HullPatches, seen: Mask) -> Facts:
    return {"area_m2": _area(hull, seen)}


def find_holes(
    hull: HullPatches,
    seen: Mask,
    chart: Chart,
    locate: Callable[[Array], Facts],
    min_hole_m2: float = MIN_HOLE_M2,
) -> list[Facts]:
    """Find unseen parts of the chart inside the surveyed area, the largest first.

    Without a CAD model there is no patch where there was nothing to see; such parts are holes as
    well. What lies off the hull is none. `locate`: from a hole's center (3,) to members of
    coverage.json, its address among them.
    """
    from scipy import ndimage

    if not seen.any():
        return []
    cells = _chart_cells(hull, seen, chart)
    disc = (
        np.hypot(*np.mgrid[-BRIDGE_CELLS : BRIDGE_CELLS + 1, -BRIDGE_CELLS : BRIDGE_CELLS + 1])
        <= BRIDGE_CELLS
    )
    surveyed = ndimage.binary_fill_holes(ndimage.binary_closing(cells.seen, disc))
    label, count = ndimage.label(surveyed & ~cells.seen & cells.on_hull)
    found = [_hole_facts(cells, label == k, chart, locate) for k in range(1, count + 1)]
    large = [hole for hole in found if hole["area_m2"] >= min_hole_m2]
    return sorted(large, key=lambda hole: (-hole["area_m2"], hole["address"]))


@dataclass(frozen=True, kw_only=True)
class _ChartCells:
    """Squares of the chart, CELL_M wide, (a, g)."""

    low: Ints  # (2,) number of the first
    seen: Mask  # some patch in it was seen
    unseen: Array  # m2 of its patches that were not seen, of the square where there is no patch
    on_hull: Mask  # there is hull


def _chart_cells(hull: HullPatches, seen: Mask, chart: Chart) -> _ChartCells:
    """Put the patches of hull into cells of the chart, a margin around what was seen."""
    at = chart.to_chart(hull.mesh.vertices)[:, :2]
    known = np.asarray(np.isfinite(at).all(axis=1))
    low = np.floor(at[known & seen].min(axis=0) / CELL_M).astype(np.int64) - BRIDGE_CELLS
    size = np.floor(at[known & seen].max(axis=0) / CELL_M).astype(np.int64) + BRIDGE_CELLS + 1 - low
    cell = np.floor(np.where(known[:, None], at, 0.0) / CELL_M).astype(np.int64) - low
    known &= ((cell >= 0) & (cell < size)).all(axis=1)
    image, held, unseen = (
        np.zeros(tuple(size), bool),
        np.zeros(tuple(size), bool),
        np.zeros(tuple(size)),
    )
    image[tuple(cell[known & seen].T)] = True
    held[tuple(cell[known].T)] = True
    np.add.at(unseen, tuple(cell[known & ~seen].T), hull.area[known & ~seen])
    middle = (np.argwhere(np.ones_like(image)) + low + 0.5) * CELL_M
    # Patches are hardly smaller than cells: a cell that happens to hold none is as the nearest one
    distance, row = nearest(at[known], middle, 1, 0.75 * PATCH_M)
    near = np.isfinite(distance[:, 0]) & ~held.ravel()
    image.ravel()[near] = seen[known][row[near, 0]]
    on_hull = np.asarray(np.isfinite(chart.from_chart(middle)[0]).all(axis=1)).reshape(image.shape)
    return _ChartCells(
        low=low, seen=image, unseen=np.where(held | image, unseen, CELL_M**2), on_hull=on_hull
    )


def _hole_facts(
    cells: _ChartCells, hole: Mask, chart: Chart, locate: Callable[[Array], Facts]
) -> Facts:
    """Measure a hole (a, g) of cells, with what its rim cells left unseen."""
    from scipy import ndimage

    which = np.argwhere(hole)
    inner = which[np.argmin(np.linalg.norm(which - which.mean(axis=0), axis=1))]
    center = chart.from_chart(((inner + cells.low + 0.5) * CELL_M)[None])[0][0]
    around = ndimage.binary_dilation(hole, np.ones((3, 3), bool)) & (hole | cells.seen)
    return {
        **locate(center),
        "center": [round(float(v), 3) for v in center],
        "area_m2": round(float(cells.unseen[around].sum()), 4),
    }


def _area(hull: HullPatches, which: Mask) -> float:
    return round(float(hull.area[which].sum()), 4)


def _percentiles(values: Array, area: Array) -> Facts | None:
    """Compute 5, 50 and 95 % percentiles by area. None without a value."""
    if not len(values):
        return None
    order = np.argsort(values)
    share = np.cumsum(area[order]) / area.sum()
    return {
        f"p{p:02d}": float(f"{values[order][np.searchsorted(share, p / 100)]:.5g}")
        for p in (5, 50, 95)
    }
