# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compute how much of the hull each sensor saw, how well, and where the survey has holes.

The hull is cut into patches of some 0.1 m, and the areas of those that were seen are summed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
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
from hullrecon.geometry.neighbours import is_near, nearest
from hullrecon.geometry.poses import Poses
from hullrecon.records.sensors import SonarPings
from hullrecon.records.solution import HullPose
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.typing import Array, Ints, Mask

Facts = dict[str, Any]
SeenIf = Callable[[HullError], Mask]  # patches that a sensor saw, under an error of the hull pose
CELL_M = 0.1  # side of a cell of the chart, in which holes are found
PATCH_M = 0.12  # edges of the patches on which coverage is summed
PATCHES_REACH_M = 2.0  # the CAD model is cut into patches up to this far from the surveyed surface
# A patch is seen by the DVL if a vertex of its surface, whose edges are 0.1 m, is as near as this
DVL_REACH_M = 0.08
# Radius of the morphological closing of the surveyed area, in cells: bays of its rim up to twice as
# wide count as holes. Inside of it, gaps of any width do.
BRIDGE_CELLS = 6
# Side of the least bay of the rim that counts, in cells: whether one of a single cell's depth is
# closed depends on where the cells begin
BAY_CELLS = 2
MIN_HOLE_M2 = 0.03  # least area of a hole in what the camera saw
SONAR_GRAZING = 0.25 * GRAZING  # cosine of the flattest incidence that gives a sonar return
CUBE_M = 0.5  # patches in one cube are ruled out at once where a fan passes it
# Least area of a hole in what the DVL saw: its returns lie decimetres apart, and its surface ends
# 0.4 m from a return, so that a smaller hole is a notch of the rim
MIN_HOLE_BY_DVL_M2 = 0.16


@dataclass(frozen=True, kw_only=True)
class HullPatches:
    """The base surface as n patches of some 0.1 m, on which seen area is summed."""

    mesh: Mesh  # whose vertices (n, 3) are the middles of the patches
    normal: Array  # (n, 3) outward
    area: Array  # (n,) m2

    @cached_property
    def cubes(self) -> _Cubes:
        """Group the patches by position."""
        return _group_in_cubes(self.mesh.vertices)


@dataclass(frozen=True, kw_only=True)
class _Cubes:
    """Points grouped in cubes, with a sphere around those of each, to rule out many at once."""

    order: Ints  # (n,) rows of the points, cube by cube
    start: Ints  # (k + 1,) where in `order` each cube's begin, and the end
    middle: Array  # (k, 3) m, of the sphere
    radius: Array  # (k,) m, of the sphere

    def rows(self, which: Mask) -> Ints:
        """List the rows of the points in some cubes (k,)."""
        spans = zip(self.start[:-1][which], self.start[1:][which], strict=True)
        return np.concatenate([self.order[:0], *(self.order[a:b] for a, b in spans)])


def _group_in_cubes(points: Array) -> _Cubes:
    """Group points (n, 3) m in cubes with sides of CUBE_M, without empty ones. See `_Cubes`."""
    cube = np.floor(points / CUBE_M).astype(np.int64)
    order = np.lexsort(cube.T)
    cube = cube[order]
    first = np.ones(len(cube), bool)
    first[1:] = (cube[1:] != cube[:-1]).any(axis=1)
    start = np.append(np.flatnonzero(first), len(cube))
    middle = np.add.reduceat(points[order], start[:-1]) / np.diff(start)[:, None]
    away = np.linalg.norm(points[order] - np.repeat(middle, np.diff(start), axis=0), axis=1)
    radius = np.maximum.reduceat(away, start[:-1])
    return _Cubes(order=order, start=start, middle=middle, radius=radius)


@dataclass(frozen=True, kw_only=True)
class SonarSurvey:
    """The pings of an imaging sonar, and its poses at them."""

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
    """Sum the area that each sensor saw and find the holes of the survey, for coverage.json.

    Holes are gaps in what the camera saw, or without a camera in what the DVL saw. A sensor that
    was not carried has None. Regions are left out without a CAD model.

    Parameters
    ----------
    base
        The hull, which is cut into patches near the surveyed surface.
    views, sonar
        Images of the top camera and pings. None where the sensor was not carried.
    track
        The vehicle's path, in the frame of the base. It gives the sigma of a hole's position.
    regions
        Named regions of the CAD model, whose coverage is given one by one.
    """
    # A seventh of the vertices, decimetres apart, marks well enough where to cut the hull finely
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
    report |= {"min_hole_m2": min_hole_m2, "min_bay_m": BAY_CELLS * CELL_M}
    if regions and base.hull_pose is not None:
        report["regions"] = [
            region_facts(region, base, views, sonar, scene, base.hull_pose) for region in regions
        ]
    return report


def locate_hole(center: Array, base: BaseSurface, track: VehicleTrack) -> Facts:
    """Compute the position of a hole's middle (3,), as members of coverage.json.

    Nothing was measured in a hole. So its covariance is that of the nearest pose of the path, with
    the sigma of a cell of the chart added. Its normal points to that pose. center: m, in the frame
    of the base.
    """
    near = int(np.argmin(np.linalg.norm(track.poses.translation - center, axis=1)))
    toward = track.poses.translation[near] - center
    normal = toward / max(float(np.linalg.norm(toward)), 1e-9)
    covariance = track.covariance[near : near + 1, :3, :3]
    return hull_position(center, normal, covariance, 0.0, CELL_M / np.sqrt(12), base).members(base)


def region_facts(
    region: HullRegion,
    base: BaseSurface,
    views: CameraViews | None,
    sonar: SonarSurvey | None,
    scene: Scene,
    hull_pose: HullPose,
) -> Facts:
    """Compute which share of a region of the CAD model each sensor saw, with sigmas.

    The region is fixed to the ship. So how much of the survey lies within it depends on the hull
    pose, from which the sigmas follow. A sensor that was not carried has None.

    Parameters
    ----------
    region
        Its name, and its limits along and in girth.
    base, scene
        The hull, and its mesh, which may occlude parts of itself.
    views, sonar
        Images of the top camera and pings. None where the sensor was not carried.
    hull_pose
        Its covariance says how far the survey may have been elsewhere on the hull.
    """
    cells = region_cells(base.chart, base.mesh, region.along, region.girth)
    patches = HullPatches(
        mesh=Mesh(cells.middle, np.zeros((0, 3), np.int32)), normal=cells.normal, area=cells.area
    )
    surveyed = base.surveyed.vertices[base.surveyed.support > 0]
    seen: dict[str, SeenIf | None] = {"camera": None, "dvl": None, "sonar": None}
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
        # Vertices are moved to the nearest point of the CAD model: an error along its normal does
        # not change what was seen
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


def _share(region: HullPatches, look: SeenIf, hull_pose: HullPose) -> Facts:
    """Compute the seen area of a region and its share of the whole, with sigmas.

    look: which patches a sensor saw, given an error of the hull pose.
    """
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
    """Take the vertices of a mesh as patches, with their shares of its area."""
    return HullPatches(mesh=mesh, normal=vertex_normals(mesh), area=vertex_areas(mesh))


def camera_facts(hull: HullPatches, seen: Visibility, focal_px: float, images: int) -> Facts:
    """Compute how much the camera saw and how well, for coverage.json.

    These are the area seen, that seen at least twice, and percentiles, weighted by area, of ground
    sample distance, incidence (both of a patch's nearest view) and number of views. Percentiles are
    None where nothing was seen.

    Parameters
    ----------
    hull
        Area of each patch.
    seen
        Number of views of each patch, and its nearest one.
    focal_px
        Focal length of the camera, by which distance becomes ground sample distance.
    images
        Number of images, as it is reported.
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
    """Tell which patches (n,) lie within `reach_m` of a vertex (k, 3) of the DVL's surface."""
    return is_near(vertices, hull.mesh.vertices, reach_m)


def visible_to_sonar(hull: HullPatches, sonar: SonarSurvey, scene: Scene) -> Mask:
    """Tell which patches (n,) lie in the fan of a ping, face the sonar, and are not occluded.

    The sonar's z axis points along the middle of the fan, x out of its plane (docs/conventions.md).
    Patches seen by an earlier ping, and those that a coarse test rules out, are not tested again.
    """
    pings, result_from_sonar = sonar.pings, sonar.poses
    bearing = np.arctan2(pings.directions[:, 1], pings.directions[:, 2])  # in the fan's plane
    out_of_plane = result_from_sonar.rotation.as_matrix()[:, :, 0]
    seen = np.zeros(len(hull.area), bool)
    for ping in range(len(result_from_sonar)):
        center = result_from_sonar.translation[ping]
        rows = hull.cubes.rows(_meets_fan(hull.cubes, center, out_of_plane[ping], sonar))
        rows = rows[~seen[rows]]
        rows = rows[_near_fan(hull, rows, center, out_of_plane[ping], sonar)]
        # In the fan: by range, elevation out of its plane, and bearing
        local = result_from_sonar[ping].inverse().apply(hull.mesh.vertices[rows])
        distance = np.maximum(np.linalg.norm(local, axis=1), 1e-9)
        at = np.arctan2(local[:, 1], local[:, 2])
        fits = (distance >= pings.range_m[0]) & (
            np.abs(np.arcsin(local[:, 0] / distance)) <= sonar.half_elevation_rad
        )
        rows = rows[fits & (at >= bearing.min()) & (at <= bearing.max())]
        # Facing the sonar, with nothing in between
        ray = hull.mesh.vertices[rows] - center
        length = np.maximum(np.linalg.norm(ray, axis=1), 1e-9)
        clear = -np.einsum("ni,ni->n", ray, hull.normal[rows]) / length > SONAR_GRAZING
        clear &= scene.cast(center, ray / length[:, None]) > length - 0.02
        seen[rows[clear]] = True
    return seen


def _meets_fan(cubes: _Cubes, center: Array, out_of_plane: Array, sonar: SonarSurvey) -> Mask:
    """Mark the cubes (k,) whose sphere may reach into the sonar's fan.

    Patches in the others need no test.
    """
    # A sphere is in range if its nearest point is. Its part out of the plane is compared with the
    # aperture at its farthest point, where the fan is widest.
    ray = cubes.middle - center
    farthest = np.linalg.norm(ray, axis=1) + cubes.radius
    return np.asarray(
        (farthest - 2 * cubes.radius <= sonar.pings.range_m[-1])
        & (np.abs(ray @ out_of_plane) - cubes.radius <= _elevation_sine(sonar) * farthest)
    )


def _near_fan(
    hull: HullPatches, rows: Ints, center: Array, out_of_plane: Array, sonar: SonarSurvey
) -> Mask:
    """Tell which of some patches may be in a ping's fan: a fast first test.

    Tested are the farthest range, elevation (to rounding) and incidence, without computing angles.
    So a patch that passes may still be too near, or beside the fan.

    Parameters
    ----------
    hull
        Middles and normals of all patches.
    rows
        The patches that are tested.
    center, out_of_plane
        Position (3,) m of the sonar, and its x axis (3,), across the fan's plane.
    sonar
        Gives range and aperture.
    """
    ray = hull.mesh.vertices[rows] - center
    distance = np.linalg.norm(ray, axis=1)
    facing = -np.einsum("ni,ni->n", ray, hull.normal[rows])
    return np.asarray(
        (distance <= sonar.pings.range_m[-1])
        & (np.abs(ray @ out_of_plane) <= _elevation_sine(sonar) * distance)
        & (facing > (SONAR_GRAZING - 1e-9) * distance)
    )


def _elevation_sine(sonar: SonarSurvey) -> float:
    """Compute the sine of half the aperture out of the fan, rounded up."""
    return float(np.sin(min(sonar.half_elevation_rad, np.pi / 2)) + 1e-9)


def sonar_facts(
    hull: HullPatches, sonar: SonarSurvey, scene: Scene, hull_pose: HullPose | None
) -> Facts:
    """Count the pings and sum the area that they saw, for coverage.json.

    With a CAD model the area has a sigma: a fan meets the hull at a grazing angle, so that the area
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
    """Sum the area of the patches that were seen."""
    return {"area_m2": _area(hull, seen)}


def find_holes(
    hull: HullPatches,
    seen: Mask,
    chart: Chart,
    locate: Callable[[Array], Facts],
    min_hole_m2: float = MIN_HOLE_M2,
) -> list[Facts]:
    """Find unseen parts of the chart inside the surveyed area, the largest first.

    The surveyed area is the seen cells, with bays of its rim up to 2 BRIDGE_CELLS wide and all gaps
    inside of it. Cells of the chart without hull are no holes. Cells without a patch are: without a
    CAD model the hull has patches only where something was seen. Holes smaller than `min_hole_m2`
    are left out, and bays into which no square of BAY_CELLS fits. None is found where nothing was
    seen.

    Parameters
    ----------
    hull
        Position and area of each patch.
    seen
        (n,) which patches were seen.
    chart
        Chart of the hull, in whose cells holes are found.
    locate
        Computes members of coverage.json, an address among them, from the center (3,) of a hole.
    min_hole_m2
        Least area of a hole that is returned.
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
    rim = ndimage.binary_dilation(~surveyed)
    bay = np.ones((BAY_CELLS, BAY_CELLS), bool)
    holes = (label == k for k in range(1, count + 1))  # one mask of the chart at a time
    found = [
        _hole_facts(cells, hole, chart, locate)
        for hole in holes
        if not (hole & rim).any() or ndimage.binary_opening(hole, bay).any()
    ]
    large = [hole for hole in found if hole["area_m2"] >= min_hole_m2]
    return sorted(large, key=lambda hole: (-hole["area_m2"], hole["address"]))


@dataclass(frozen=True, kw_only=True)
class _ChartCells:
    """Square cells of the chart, CELL_M wide: arrays (a, g) by along and girth."""

    low: Ints  # (2,) number of the first cell along and in girth
    seen: Mask  # (a, g) whether a patch in the cell was seen
    unseen: Array  # (a, g) m2 of the cell's unseen patches, or of the cell where there is no patch
    on_hull: Mask  # (a, g) whether the chart has hull there


def _chart_cells(hull: HullPatches, seen: Mask, chart: Chart) -> _ChartCells:
    """Sort patches into cells of the chart, which reach BRIDGE_CELLS beyond the seen patches.

    Patches off the chart, or beyond these cells, are left out. A cell without a patch of its own is
    seen if the nearest patch is.
    """
    at = chart.to_chart(hull.mesh.vertices)[:, :2]
    known = np.asarray(np.isfinite(at).all(axis=1))
    low = np.floor(at[known & seen].min(axis=0) / CELL_M).astype(np.int64) - BRIDGE_CELLS
    size = np.floor(at[known & seen].max(axis=0) / CELL_M).astype(np.int64) + BRIDGE_CELLS + 1 - low
    cell = np.floor(np.where(known[:, None], at, 0.0) / CELL_M).astype(np.int64) - low
    known &= ((cell >= 0) & (cell < size)).all(axis=1)
    is_seen, has_patch, unseen = (
        np.zeros(tuple(size), bool),
        np.zeros(tuple(size), bool),
        np.zeros(tuple(size)),
    )
    is_seen[tuple(cell[known & seen].T)] = True
    has_patch[tuple(cell[known].T)] = True
    np.add.at(unseen, tuple(cell[known & ~seen].T), hull.area[known & ~seen])
    middle = (np.argwhere(np.ones_like(is_seen)) + low + 0.5) * CELL_M
    # Patches are hardly smaller than cells, so a cell may hold none. It is as its nearest patch is
    distance, row = nearest(at[known], middle, 1, 0.75 * PATCH_M)
    near = np.isfinite(distance[:, 0]) & ~has_patch.ravel()
    is_seen.ravel()[near] = seen[known][row[near, 0]]
    on_hull = np.asarray(np.isfinite(chart.from_chart(middle)[0]).all(axis=1)).reshape(
        is_seen.shape
    )
    return _ChartCells(
        low=low,
        seen=is_seen,
        unseen=np.where(has_patch | is_seen, unseen, CELL_M**2),
        on_hull=on_hull,
    )


def _hole_facts(
    cells: _ChartCells, hole: Mask, chart: Chart, locate: Callable[[Array], Facts]
) -> Facts:
    """Measure a hole: centre, address and area, for coverage.json.

    The centre is the cell of the hole nearest to the mean of its cells, as the mean itself may lie
    outside. The area counts unseen patches in the seen cells around the hole too. hole (a, g): its
    cells.
    """
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
    """Sum the area of some patches, m2."""
    return round(float(hull.area[which].sum()), 4)


def _percentiles(values: Array, area: Array) -> Facts | None:
    """Compute the 5, 50 and 95 % percentiles of values weighted by area. None without a value."""
    if not len(values):
        return None
    order = np.argsort(values)
    share = np.cumsum(area[order]) / area.sum()
    return {
        f"p{p:02d}": float(f"{values[order][np.searchsorted(share, p / 100)]:.5g}")
        for p in (5, 50, 95)
    }
