# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a simulated dive is: everything that `write_package` needs, as one frozen struct."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Literal

import numpy as np

Kind = Literal["cylinder", "dome", "box", "lump", "recess", "barnacles", "digits", "stripe", "ring"]
STRUCTURES: tuple[Kind, ...] = ("cylinder", "dome", "box", "lump", "recess")
MARKS: tuple[Kind, ...] = ("digits", "stripe", "ring")


@dataclass(frozen=True)
class Item:
    """Something added to the CAD model at chart coordinates `along`, `girth` (m): a structure, a painted mark (no height) or a
    patch of barnacles. height in m, negative for a recess; size: full extent along and across (m); turn in the chart, rad."""

    kind: Kind
    along_m: float
    girth_m: float
    height_m: float
    size_m: tuple[float, float]
    turn_rad: float = 0.0

    def reach_m(self) -> float:
        return 0.5 * float(np.hypot(*self.size_m))


@dataclass(frozen=True)
class DiveSpec:
    """A dive to simulate. Lengths in metres, angles in degrees, times in seconds; every draw comes from `seed`.

    hull: "form" (an analytic ship of length x beam x depth with that bilge radius; the bow and the stern take `entrance` of the
    length each) or the path of a mesh, scaled to length_m. The dive starts `top_m` below the water and steps down the girth.
    views: images that see a point of the steel during one leg; it sets the frame rate. items: None plants `structures` and
    `marks` and `barnacles` at random places. guess_*: how far the first guess of the hull's pose is off. form: how the logs
    are written. heading_drift_deg_per_hour, dvl_scale_error: what the instruments truly do, dive.toml tells no smaller sigma;
    backlash_deg: half the dead band of the tray's servo; servo_sigma_deg: white noise of the encoders."""

    name: str = "simulated"
    seed: int = 1
    hull: str = "form"
    length_m: float = 50.0
    beam_m: float = 9.0
    depth_m: float = 5.5
    draught_m: float = 3.8
    bilge_radius_m: float = 1.3
    entrance: float = 0.35
    along_m: float | None = None  # the middle of the legs, from the stern; absent: where the entrance begins
    top_m: float = 1.2
    legs: int = 5
    leg_length_m: float = 6.5
    leg_spacing_m: float = 0.6
    standoff_m: float = 1.15
    speed: float = 0.3
    cameras: Literal["stereo", "mono", "none"] = "stereo"
    image_width: int = 640
    image_height: int = 512
    views: float = 7.0
    jpeg_quality: int = 88
    sonar: bool = True
    visibility_m: float = 6.0
    heading_drift_deg_per_hour: float = 1.0
    dvl_scale_error: float = 0.003
    backlash_deg: float = 0.5
    servo_sigma_deg: float = 0.05
    deviation_mean_m: float = -0.008
    deviation_sigma_m: float = 0.012
    deviation_length_m: float = 2.5
    guess_along_m: float = 0.4
    guess_across_m: float = 0.2
    guess_turn_deg: float = 2.0
    structures: int = 6
    marks: int = 3
    barnacles: int = 1
    items: tuple[Item, ...] | None = None
    form: Literal["mcap", "plain"] = "mcap"

    def random(self, purpose: str) -> np.random.Generator:
        """A stream of its own for each purpose, so that one more draw here changes nothing there."""
        return np.random.default_rng([self.seed, zlib.crc32(purpose.encode())])
