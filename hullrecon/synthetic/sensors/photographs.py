# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The images of a dive's cameras, frame by frame."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hullrecon.synthetic.dive import Dive
from hullrecon.synthetic.sensors.rendering import Scene, lens, photograph
from hullrecon.synthetic.vehicle.rig import LAMP_IN_TOP, TRAY_ORIGIN
from hullrecon.synthetic.world.plate_atlas import PlateAtlas, paint_atlas
from hullrecon.synthetic.world.texture import Albedo, Atlas, PaintedHull
from hullrecon.typing import Pixels

ATLAS_TEXELS = 24e6  # up to there the texture is one image: painting it takes 0.5 GB


def photographs(dive: Dive) -> Iterator[tuple[Pixels, Pixels | None]]:
    """Yield the RGB images (h, w, 3) of the top and the bottom camera; None where no bottom camera
    is carried.
    """
    rig, motion, random = dive.rig, dive.motion, dive.spec.random("camera")
    paint, absorption = _paint(dive), 2.0 / dive.spec.visibility_m
    top = lens(rig.camera_top)
    bottom = lens(rig.camera_bottom) if rig.camera_bottom is not None else None
    hull_from_top = motion.in_hull(motion.on_tray(dive.frame_s, rig.tray_from_top, TRAY_ORIGIN))
    hull_from_bottom = motion.in_hull(
        motion.on_tray(dive.frame_s, rig.tray_from_top @ rig.top_from_bottom, TRAY_ORIGIN)
    )
    for k in range(len(dive.frame_s)):
        scene = Scene(dive.hull.near(hull_from_top.translation[k, 0]), paint, absorption)
        lamp = hull_from_top[k].apply(LAMP_IN_TOP[None])[0]
        first = photograph(scene, top, hull_from_top[k], lamp, random)
        yield (
            first,
            None
            if bottom is None
            else photograph(scene, bottom, hull_from_bottom[k], lamp, random),
        )


def _paint(dive: Dive) -> Albedo:
    """Return the colours of the hull, changed where the spec says so."""
    paint, survey = dive.spec.paint, dive.spec.survey
    if paint.bare_share == 0 and paint.repeats_m is None:
        return _atlas(dive)
    bare_to_m = float(np.mean(dive.seen_along)) + (paint.bare_share - 0.5) * survey.leg_length_m
    return PaintedHull(
        albedo=_atlas(dive),
        start_m=dive.seen_along[0],
        bare_to_m=bare_to_m if paint.bare_share else None,
        repeats_m=paint.repeats_m,
    )


def _atlas(dive: Dive) -> Atlas | PlateAtlas:
    spec = dive.spec
    texel_m = max(0.001, 0.75 * spec.survey.standoff_m / dive.rig.camera_top.fx)
    texels = np.ptp(dive.seen_along) * np.ptp(dive.seen_girth) / texel_m**2
    if texels <= ATLAS_TEXELS:
        return paint_atlas(spec, dive.items, dive.seen_along, dive.seen_girth, texel_m)
    return PlateAtlas(spec, dive.items, texel_m)
