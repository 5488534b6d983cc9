# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What `hullrecon simulate` offers: its options as data, and the function behind it. No click here."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hullrecon.errors import UsageError
from hullrecon.synthetic.spec import DiveSpec

if TYPE_CHECKING:
    from hullrecon.synthetic.sensors.recorder import Track


@dataclass(frozen=True)
class Option:
    """One option of the command line: `--name`, its type, default, help, and the words it may be (empty: anything)."""

    name: str
    field: str
    type: type
    default: Any
    help: str
    choices: tuple[str, ...] = ()


def _option(field: str, help: str, choices: tuple[str, ...] = ()) -> Option:
    default = next(f.default for f in fields(DiveSpec) if f.name == field)
    kind = float if default is None else type(default)
    return Option(field.replace("_", "-"), field, kind, default, help, choices)


OPTIONS = (
    _option("seed", "Every random draw comes from it"),
    _option("name", "Name of the dive"),
    _option("legs", "Legs along the hull, from the top down"),
    _option("leg_length_m", "Length of a leg, metres"),
    _option("leg_spacing_m", "Girth from leg to leg, metres"),
    _option("standoff_m", "Distance of the sensors from the steel, metres"),
    _option("speed", "Speed along a leg, metres a second"),
    _option("hull", "`form` for an analytic ship, or the path of a mesh, which is scaled to --length-m"),
    _option("length_m", "Length of the ship, metres"),
    _option("beam_m", "Beam of the analytic ship, metres"),
    _option("depth_m", "Keel to deck of the analytic ship, metres"),
    _option("draught_m", "Keel to water surface, metres"),
    _option("bilge_radius_m", "Bilge radius of the analytic ship amidships, metres"),
    _option("entrance", "Share of the length over which bow and stern each narrow"),
    _option("along_m", "Middle of the legs, metres from the stern; absent: where the bow begins to narrow"),
    _option("top_m", "Depth of the first leg's steel below the water, metres"),
    _option("cameras", "Cameras carried", ("stereo", "mono", "none")),
    _option("image_width", "Pixels"),
    _option("image_height", "Pixels"),
    _option("views", "Images that see a point of the steel during one leg"),
    _option("jpeg_quality", "1 to 100"),
    _option("sonar", "Carry an imaging sonar"),
    _option("visibility_m", "How far one sees in this water, metres"),
    _option("heading_drift_deg_per_hour", "Drift of the IMU's heading, degrees an hour; its walk comes on top"),
    _option("dvl_scale_error", "Share by which the DVL's velocities are too long"),
    _option("backlash_deg", "Backlash of the tray's servo, half the dead band, degrees"),
    _option("servo_sigma_deg", "White noise of the servos' encoders, one sigma, degrees"),
    _option("deviation_mean_m", "Mean offset of the steel from its CAD model, outward positive, metres"),
    _option("deviation_sigma_m", "Sigma of the offset's smooth field, metres"),
    _option("deviation_length_m", "Correlation length of that field along the hull, metres"),
    _option("guess_along_m", "Error of the first guess of the hull's pose along the hull, metres"),
    _option("guess_across_m", "The same across, metres"),
    _option("guess_turn_deg", "The same in heading, degrees"),
    _option("structures", "Objects that stand out of the hull or are cut into it"),
    _option("marks", "Painted marks, which are no objects"),
    _option("barnacles", "Rough patches, which are no objects"),
    _option("form", "How the logs are written", ("mcap", "plain")),
)
BOUNDS: dict[str, tuple[float, float]] = {
    "legs": (1, 200),
    "leg_length_m": (0.5, 500),
    "leg_spacing_m": (0.1, 3),
    "standoff_m": (0.5, 3),
    "speed": (0.02, 2),
    "length_m": (5, 500),
    "entrance": (0.05, 0.5),
    "image_width": (160, 4096),
    "image_height": (120, 4096),
    "views": (1, 60),
    "jpeg_quality": (1, 100),
    "visibility_m": (1, 50),
    "heading_drift_deg_per_hour": (-3600, 3600),
    "dvl_scale_error": (-0.1, 0.1),
    "backlash_deg": (0, 5),
    "servo_sigma_deg": (0, 5),
    "deviation_sigma_m": (0, 0.2),
    "deviation_length_m": (0.3, 50),
    "structures": (0, 200),
    "marks": (0, 200),
    "barnacles": (0, 200),
}


def simulate(folder: Path, track: Track | None = None, **options: Any) -> dict[str, Any]:
    """Write a dive package and return counts for the terminal. options: by field name of DiveSpec; track: shows the images
    as they are written.

    Raises UsageError for an option out of bounds or unknown, StorageError when the folder cannot be written."""
    from hullrecon.synthetic.output.package import write_package

    known = {option.field for option in OPTIONS}
    for name, value in options.items():
        if name not in known:
            raise UsageError(f"unknown option {name}", remedy="see `hullrecon simulate --help`")
        low, high = BOUNDS.get(name, (float("-inf"), float("inf")))
        if isinstance(value, (int, float)) and not low <= value <= high:
            raise UsageError(f"{name} is {value}", remedy=f"choose from {low:g} to {high:g}")
    spec = DiveSpec(**options)
    dive = write_package(folder, spec) if track is None else write_package(folder, spec, track)
    return {
        "package": str(folder),
        "seconds": round(float(dive.motion.t_s[-1]), 1),
        "frames": len(dive.frame_s),
        "objects": sum(item.height_m != 0 and item.kind != "barnacles" for item in dive.items),
    }
