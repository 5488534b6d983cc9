# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A whole simulated dive: the hull, the rig and the path, before any sensor is simulated."""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.errors import UsageError
from hullrecon.findings.logs import count_noun
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.synthetic.built_hull import BuiltHull, place_items
from hullrecon.synthetic.hull_patch import HullSkin
from hullrecon.synthetic.hull_shapes import hull_shape
from hullrecon.synthetic.items import Item
from hullrecon.synthetic.options import DiveSpec, Survey
from hullrecon.synthetic.vehicle import Motion, TrueRig, leg_corners, simulate_path, ticks, true_rig
from hullrecon.typing import Array

Window = tuple[float, float]
BELOW_M, BEYOND_M = 3.0, 2.6  # hull built below and beyond the legs, which the sonar sees
BESIDE_M = 0.1  # largest distance of items' centres above the first leg or below the last one
SEEN_M = 0.9  # how far the cameras see beyond the legs


@dataclass(frozen=True, kw_only=True)
class Dive:
    """The world and the vehicle's path through it."""

    spec: DiveSpec
    cad_model: Mesh
    items: tuple[Item, ...]
    hull: BuiltHull
    rig: TrueRig
    motion: Motion
    seen_along: Window  # of the chart, that the cameras see
    seen_girth: Window
    frame_s: Array  # (n,) when the cameras fire and truth is written


def simulate_dive(spec: DiveSpec) -> Dive:
    """Build the hull, the items, the path and the rig of a dive.

    Raises UsageError where the hull is too small for it.
    """
    ship, survey = spec.ship, spec.survey
    cad_model = hull_shape(ship)
    # Of the survey's window along the hull. By default where the parallel midbody ends forward
    middle = survey.along_m if survey.along_m is not None else (1 - ship.entrance) * ship.length_m
    half = 0.5 * survey.leg_length_m
    # Height of the first leg above the keel, and how far down in girth the last one is
    surface_z = ship.draught_m - survey.top_m
    depth = (survey.legs - 1) * survey.leg_spacing_m
    if surface_z <= 0:
        remedy = f"choose less than {ship.draught_m:g} m, which the keel lies below the water"
        raise UsageError(f"top_m is {survey.top_m:g}", remedy=remedy)
    top_z = min(float(cad_model.vertices[:, 2].max()), surface_z + 2.0) - 1e-3
    span = (middle - half - BEYOND_M, middle + half + BEYOND_M)
    skin = HullSkin(cad_model, span, zero_z_m=surface_z, top_z_m=top_z, down_m=depth + BELOW_M)
    _refuse_legs_beyond(skin, survey)
    items = place_items(
        spec, (middle - half + 0.1, middle + half - 0.1), (-depth - BESIDE_M, BESIDE_M)
    )
    motion = simulate_path(spec, skin, leg_corners(survey, middle, 0.0))
    return Dive(
        spec=spec,
        cad_model=cad_model,
        items=items,
        hull=BuiltHull(spec, skin, items),
        rig=true_rig(spec),
        motion=motion,
        seen_along=(middle - half - SEEN_M, middle + half + SEEN_M),
        seen_girth=(-depth - SEEN_M, SEEN_M),
        frame_s=ticks(motion, _frame_rate(spec), spec.random("frames"), first_s=0.45),
    )


def _refuse_legs_beyond(skin: HullSkin, survey: Survey) -> None:
    """Raise UsageError if the hull has no skin where legs, or items beside them, would be.

    The vehicle would follow the edge of the hull.
    """
    low, high = float(skin.girth_m[0]), float(skin.girth_m[-1])
    if high < BESIDE_M:
        raise UsageError(
            "the hull ends below the first leg",
            remedy="choose a larger --top-m, or less --draught-m",
        )
    fit = max(0, int((-low - BESIDE_M) / survey.leg_spacing_m) + 1)
    if fit < survey.legs:
        remedy = (
            "choose fewer --legs, less --leg-spacing-m, or another place by --along-m and --top-m"
        )
        raise UsageError(
            f"the hull has skin for {count_noun(fit, 'leg')} there, not for {survey.legs}",
            remedy=remedy,
        )


def _frame_rate(spec: DiveSpec) -> float:
    """Choose the frames per second at which a leg shows each point of the steel `views` times."""
    # Width of an image on the steel. The focal length is 1.03 widths (`true_rig`)
    footprint = (
        spec.survey.standoff_m * spec.cameras.image_width / (1.03 * spec.cameras.image_width)
    )
    return spec.cameras.views * spec.survey.speed_m_per_s / footprint
