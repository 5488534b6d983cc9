# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compute how much of the hull each sensor saw, how well, and where the survey has holes.

The hull is cut into patches of some 0.1 m, and the areas of those that were seen are summed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from hullrecon.detection.as_found.hull_as_found import refine_near
from hullrecon.detection.base_surface import BaseSurface, HullError, area_sigma
from hullrecon.detection.coverage_holes import (
    BAY_CELLS,
    CELL_M,
    MIN_HOLE_M2,
    find_holes,
    locate_hole,
)
from hullrecon.detection.hull_patches import PATCH_M, Facts, HullPatches, hull_patches
from hullrecon.detection.sonar_visibility import SonarSurvey, visible_to_sonar
from hullrecon.detection.views import CameraViews, Visibility, find_visibility
from hullrecon.dive.config.schema import HullRegion
from hullrecon.geometry.charts.region import region_cells
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.neighbours import is_near
from hullrecon.records.solution import HullPose
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.typing import Array, Mask

SeenIf = Callable[[HullError], Mask]  # patches that a sensor saw, under an error of the hull pose
PATCHES_REACH_M = 2.0  # the CAD model is cut into patches up to this far from the surveyed surface
# A patch is seen by the DVL if a vertex of its surface, whose edges are 0.1 m, is as near as this
DVL_REACH_M = 0.08
# Least area of a hole in what the DVL saw: its returns lie decimetres apart, and its surface ends
# 0.4 m from a return, so that a smaller hole is a notch of the rim
MIN_HOLE_BY_DVL_M2 = 0.16


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
        """Sum the area, m2, that the sonar saw if the hull's pose were off by an error."""
        return _area(
            hull, visible_to_sonar(hull, replace(sonar, poses=off.poses(sonar.poses)), scene)
        )

    return {**facts, "area_sigma_m2": area_sigma(area_if, hull_pose)}


def area_facts(hull: HullPatches, seen: Mask) -> Facts:
    """Sum the area of the patches that were seen."""
    return {"area_m2": _area(hull, seen)}


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
