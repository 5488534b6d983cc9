# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Describe how the CAD model lies, its bow, and how much of it is in each region of dive.toml."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.dive.config.mounts import guess_sigma
from hullrecon.dive.config.schema import Hull
from hullrecon.dive.hull.afloat import find_sunk
from hullrecon.dive.hull.symmetry import find_lying_side
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.geometry.charts.chart import chart_for_hull
from hullrecon.geometry.charts.region import chart_limits, region_cells
from hullrecon.geometry.charts.section_casting import AXES, first_station, hull_axes
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.meshes.units import METRES_PER_UNIT
from hullrecon.geometry.poses import from_mount, up_in
from hullrecon.records.clock import NS
from hullrecon.records.sensors import DvlPings
from hullrecon.typing import Array

FARTHEST_M = 1000.0  # from where a dive begins to the ship that is inspected
SURE = 5.0  # sigmas of hull.pose that count as possible
AFT_SHARE = 0.25  # of the length; no aft perpendicular lies farther from the aft end
# Shares by which a CAD model's length differs from the stated one. Within the first it is to scale:
# papers round to a decimetre, and models lack rails and fenders. Beyond the second it is not, and
# no bulwark or overhang that was left out explains that.
SAME_LENGTH, OTHER_LENGTH = 0.01, 0.05
# A CAD model is turned in plan by more than these degrees, in a rectangle smaller by this factor. A
# ship of seven times her beam, turned by 5 degrees, fills one 1.6 times as large.
LEAST_TURN_DEG, SLIMMER = 5.0, 0.8


def refuse_far_hull(hull: Hull, mesh: Mesh) -> None:
    """Raise InputError where hull.pose puts the whole CAD model far from the dive's beginning.

    Its origin is then not near the ship, as in map coordinates.
    """
    box = np.stack([mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)])
    middle = from_mount(hull.pose).apply(box.mean(axis=0)[None])[0]
    reach_m = 0.5 * float(np.linalg.norm(np.ptp(box, axis=0)))
    far_m = float(np.linalg.norm(middle[:2])) - reach_m
    if far_m > FARTHEST_M:
        raise InputError(
            f"hull.pose puts the CAD model {far_m / 1000:.4g} km from where the dive begins, which "
            "is at x = y = 0",
            where="hull.pose",
            remedy="give the pose of the CAD model's own origin, or export it about an origin "
            "near the ship and give the pose of that",
        )


def check_reach(hull: Hull, mesh: Mesh, dvl: DvlPings) -> list[Finding]:
    """Warn of a CAD model that hull.pose puts where the dive never came.

    The way of the vehicle is at most that of its speed, the fastest where the DVL gave none. The
    CAD model lies within its box, and hull.pose within SURE of its sigmas.
    """
    speed = np.linalg.norm(dvl.velocity, axis=1)
    if not np.isfinite(speed).any():
        return []
    filled = np.where(np.isfinite(speed), speed, np.nanmax(speed))
    way_m = float(filled[:-1] @ (np.diff(dvl.t_ns) / NS))
    seen_m = float(np.nanmax(dvl.ranges, initial=0.0))
    # from where the dive begins, at the height of the CAD model, to its box
    pose, low, high = from_mount(hull.pose), mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    height_m = pose.apply(0.5 * (low + high)[None])[0, 2]
    begin = pose.inverse().apply(np.array([[0.0, 0.0, height_m]]))[0]
    far_m = float(np.linalg.norm(begin - np.clip(begin, low, high)))
    sigma_m = float(guess_sigma(hull.pose, hull.pose_sigma)[:3].max())
    if far_m - SURE * sigma_m <= way_m + seen_m:
        return []
    values = {"far_m": far_m, "way_m": way_m, "seen_m": seen_m, "sigma_m": sigma_m}
    return [Finding("hull-out-of-reach", values, "the CAD model")]


def check_afloat(hull: Hull, mesh: Mesh) -> list[Finding]:
    """Warn of a ship that hull.pose puts wholly under the water."""
    guess = from_mount(hull.pose)
    axes = hull_axes(mesh.vertices, up_in(guess), hull.bow)
    sigma_m = None if hull.pose_sigma is None else np.array(hull.pose_sigma[:3])
    found = find_sunk(mesh, axes, guess, sigma_m)
    return [] if found is None else [replace(found, where="the CAD model")]


def describe_bow(hull: Hull, mesh: Mesh) -> tuple[Finding, list[Finding]]:
    """Name the end that is taken as the bow, and warn where stations do not start near the stern.

    Raises InputError where hull.bow names a direction that is not along the CAD model.
    """
    forward = hull_axes(mesh.vertices, up_in(from_mount(hull.pose)), hull.bow)[0]
    axis = AXES[int(np.argmax(np.abs(forward)))]
    aft_m, bow_m = np.sort(mesh.vertices @ forward)[[0, -1]]
    first_m = first_station(mesh.vertices, forward, hull.aft_perpendicular)
    # `forward` is an axis of M or its opposite: the sum of its parts is the sign
    # Where stations start: on the axis of M, and ahead of the aft end
    zero_m, ahead_m = float(first_m * forward.sum()) + 0.0, float(first_m - aft_m)
    values: dict[str, object] = {"axis": axis, "zero_m": zero_m, "ahead_m": ahead_m}
    at_m = round(float(bow_m * forward.sum()), 1) + 0.0  # no "-0.0"
    bow = Finding("bow", {**values, "bow_m": at_m, "given": hull.bow is not None})
    is_aft = abs(ahead_m) <= AFT_SHARE * (bow_m - aft_m)
    return bow, [] if is_aft else [Finding("stations-off", values)]


def check_upright(hull: Hull, mesh: Mesh) -> list[Finding]:
    """Warn of a CAD model that hull.pose lays on its side."""
    guess = from_mount(hull.pose)
    axes = hull_axes(mesh.vertices, up_in(guess), hull.bow)
    found = find_lying_side(mesh, axes, guess)
    return [] if found is None else [replace(found, where="the CAD model")]


def check_length(hull: Hull, mesh: Mesh) -> list[Finding]:
    """Hold the CAD model's length against hull.length_overall, which tells its scale and unit.

    Nothing is found where the two agree, or where none is stated. A few per cent are a warning.
    Raises InputError where the CAD model is not to scale, with the unit in which it would be, or
    where it is, and lies turned.
    """
    stated_m = hull.length_overall
    if stated_m is None:
        return []
    axes = hull_axes(mesh.vertices, up_in(from_mount(hull.pose)), hull.bow)
    length_m = float(np.ptp(mesh.vertices @ axes[0]))
    turn_deg, turned_m = _turn_in_plan(mesh, axes)
    if abs(turn_deg) > LEAST_TURN_DEG and not _is_apart(turned_m, stated_m, OTHER_LENGTH):
        raise InputError(
            f"the CAD model {hull.mesh} lies turned by {turn_deg:+.0f} degrees about its vertical: "
            f"it is {turned_m:.1f} m long in that direction, and its axes are none of the ship's",
            where="hull.mesh",
            remedy=f"export it turned by {-turn_deg:+.0f} degrees, its length along an axis",
        )
    if _is_apart(length_m, stated_m, OTHER_LENGTH):
        in_file = length_m / METRES_PER_UNIT[hull.units]
        fitting = [
            f'set hull.units = "{unit}"'
            for unit, metres in METRES_PER_UNIT.items()
            if not _is_apart(in_file * metres, stated_m, OTHER_LENGTH)
        ]
        raise InputError(
            f"the CAD model {hull.mesh} is {length_m:.1f} m long, {length_m / stated_m:.3g} times "
            f"the {stated_m:g} m of hull.length_overall",
            where="hull.mesh",
            remedy=" or ".join(fitting)
            or "export it to scale, or correct hull.length_overall: it is no length between "
            "perpendiculars, and of a model of a part it is the length of that part",
        )
    if _is_apart(length_m, stated_m, SAME_LENGTH):
        values = {"length_m": length_m, "stated_m": stated_m}
        return [Finding("hull-length-differs", values, "the CAD model")]
    return []


def _turn_in_plan(mesh: Mesh, axes: Array) -> tuple[float, float]:
    """Find the direction in plan in which a mesh is slim, by the smallest rectangle around it.

    axes (3, 3): rows forward, port, up in M.

    Returns
    -------
    tuple
        Its angle from forward towards port, deg, and the mesh's length in it, m.
    """
    plan = mesh.vertices @ axes[:2].T
    degrees = np.arange(-45.0, 45.5, 0.5)
    along = np.stack([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    across = np.stack([-along[1], along[0]])
    length, width = (np.ptp(plan @ directions, axis=0) for directions in (along, across))
    area = length * width
    best = int(np.argmin(area))
    if area[best] > SLIMMER * area[degrees == 0.0][0]:
        best = int(np.flatnonzero(degrees == 0.0)[0])
    return float(degrees[best]), float(length[best])


def _is_apart(one_m: float, other_m: float, share: float) -> bool:
    """Tell whether two lengths differ by more than a share, whichever is the longer."""
    return bool(abs(np.log(one_m / other_m)) > np.log1p(share))


def describe_regions(hull: Hull | None, mesh: Mesh | None) -> tuple[list[Finding], list[Finding]]:
    """Measure the area of each region of dive.toml, and warn of those that hold no hull.

    Both lists are empty without regions or CAD model. Where the CAD model has no chart (coordinates
    along the ship and around her sections), one warning says that no region was measured.
    """
    regions = () if hull is None else hull.region or ()
    if not regions or hull is None or mesh is None:
        return [], []
    try:
        chart = chart_for_hull(mesh, up_in(from_mount(hull.pose)), hull.bow, hull.aft_perpendicular)
    except InputError as error:
        return [], [Finding("regions-uncounted", {"count": len(regions), "why": error.what})]
    along_m, girth_m = ((low + 0.0, high + 0.0) for low, high in chart_limits(chart, mesh).round(1))
    limits = {"along_m": list(map(float, along_m)), "girth_m": list(map(float, girth_m))}
    areas, empty = [], []
    for region in regions:
        area_m2 = float(region_cells(chart, mesh, region.along, region.girth).area.sum())
        if area_m2:
            areas.append(Finding("region-area", {"region": region.name, "area_m2": area_m2}))
        else:
            empty.append(Finding("region-empty", {"region": region.name, **limits}))
    return areas, empty
