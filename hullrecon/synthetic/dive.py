# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A whole simulated dive, before it is written down."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.meshes import Mesh
from hullrecon.synthetic.sensors import instruments, sonar
from hullrecon.synthetic.sensors.rendering import Scene, lens, photograph
from hullrecon.synthetic.spec import DiveSpec, Item
from hullrecon.synthetic.vehicle.motion import Motion
from hullrecon.synthetic.vehicle.rig import LAMP_IN_TOP, SONAR_ORIGIN, TRAY_ORIGIN, Rig, true_rig
from hullrecon.synthetic.vehicle.simulate_path import leg_corners, simulate_path
from hullrecon.synthetic.world.as_built import AsBuilt, build
from hullrecon.synthetic.world.hull_patch import HullPatch, cut_hull_patch
from hullrecon.synthetic.world.hull_shapes import hull_shape
from hullrecon.synthetic.world.item_placement import place_items
from hullrecon.synthetic.world.plate_atlas import PlateAtlas
from hullrecon.synthetic.world.ray_casting import Rays
from hullrecon.synthetic.world.texture import Atlas, paint_atlas

Array = NDArray[np.float64]
Window = tuple[float, float]
BELOW_M, BEYOND_M = 3.0, 2.6  # skin kept around the legs, for the sonar
ATLAS_TEXELS = 24e6  # up to there the texture is one image: painting it takes 0.5 GB


@dataclass(frozen=True)
class Dive:
    """The world and the vehicle's way through it. seen_along, seen_girth: the window of the chart that the cameras see.
    frame_s (n,): when the cameras fire (and, without cameras, when truth is written)."""

    spec: DiveSpec
    cad_model: Mesh
    patch: HullPatch
    items: tuple[Item, ...]
    built: AsBuilt
    hull: Rays
    rig: Rig
    motion: Motion
    seen_along: Window
    seen_girth: Window
    frame_s: Array


def simulate_dive(spec: DiveSpec) -> Dive:
    """Hull, items, path and rig of a dive; the sensors are asked afterwards."""
    cad_model = hull_shape(spec)
    middle = spec.along_m if spec.along_m is not None else (1 - spec.entrance) * spec.length_m
    half = 0.5 * spec.leg_length_m
    surface_z = spec.draught_m - spec.top_m
    depth = (spec.legs - 1) * spec.leg_spacing_m
    top_z = min(float(cad_model.vertices[:, 2].max()), surface_z + 2.0) - 1e-3
    patch = cut_hull_patch(cad_model, (middle - half - BEYOND_M, middle + half + BEYOND_M), surface_z, top_z, depth + BELOW_M)
    corners = leg_corners(spec, middle, 0.0)
    items = place_items(spec, (middle - half + 0.1, middle + half - 0.1), (-depth - 0.1, 0.1))
    motion = simulate_path(spec, patch, corners)
    built = build(spec, patch, items)
    frame_s = instruments.ticks(motion, _frame_rate(spec), spec.random("frames"), 0.45)
    seen_along, seen_girth = (middle - half - 0.9, middle + half + 0.9), (-depth - 0.9, 0.9)
    hull = Rays(built.mesh)
    return Dive(spec, cad_model, patch, items, built, hull, true_rig(spec), motion, seen_along, seen_girth, frame_s)


def photographs(dive: Dive) -> Iterator[tuple[NDArray[np.uint8], NDArray[np.uint8] | None]]:
    """RGB images of the top and the bottom camera, frame by frame."""
    spec, rig = dive.spec, dive.rig
    scene, random = _scene(dive), spec.random("camera")
    top = lens(rig.camera_top)
    bottom = lens(rig.camera_bottom) if rig.camera_bottom is not None else None
    T_M_ct = dive.motion.in_hull(dive.motion.on_tray(dive.frame_s, rig.T_s_ct, TRAY_ORIGIN))
    T_M_cb = dive.motion.in_hull(dive.motion.on_tray(dive.frame_s, rig.T_s_ct @ rig.T_ct_cb, TRAY_ORIGIN))
    for k in range(len(dive.frame_s)):
        lamp = T_M_ct[k].apply(LAMP_IN_TOP[None])[0]
        first = photograph(scene, top, T_M_ct[k], lamp, random)
        yield first, None if bottom is None else photograph(scene, bottom, T_M_cb[k], lamp, random)


def pings(dive: Dive) -> tuple[Array, Iterator[NDArray[np.uint8]]]:
    """Times of the sonar's pings, and their images (beams, ranges)."""
    random = dive.spec.random("sonar")
    t = instruments.ticks(dive.motion, 2.0, random, 0.3)
    at = dive.motion.on_tray(t, dive.rig.T_u_o, SONAR_ORIGIN, dive.motion.sonar_tray)
    T_M_o, fan = dive.motion.in_hull(at), sonar.fan()
    return t, (sonar.ping(T_M_o[k], dive.hull, dive.built, fan, random) for k in range(len(t)))


def _scene(dive: Dive) -> Scene:
    spec = dive.spec
    texel = max(0.001, 0.75 * spec.standoff_m / dive.rig.camera_top.fx)
    texels = np.ptp(dive.seen_along) * np.ptp(dive.seen_girth) / texel**2
    atlas: Atlas | PlateAtlas = (
        paint_atlas(spec, dive.items, dive.seen_along, dive.seen_girth, texel)
        if texels <= ATLAS_TEXELS
        else PlateAtlas(spec, dive.items, texel)
    )
    return Scene(dive.built, dive.hull, dive.patch, atlas, 2.0 / spec.visibility_m)


def _frame_rate(spec: DiveSpec) -> float:
    """Frames a second that show a point of the steel about `views` times in one leg."""
    footprint = spec.standoff_m * spec.image_width / (1.03 * spec.image_width)
    return spec.views * spec.speed / footprint
