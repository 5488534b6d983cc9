# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The fields of a DiveSpec under flat names, as the command line and notebooks give them."""

from __future__ import annotations

import dataclasses
import math
import typing
import zlib
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, Literal, TypeVar

import msgspec
import numpy as np

from hullrecon.dive.config.schema import Dive
from hullrecon.errors import UsageError
from hullrecon.synthetic.items import Item

Value = TypeVar("Value")


@dataclass(frozen=True, kw_only=True)
class Meta:
    """What is known of a field."""

    description: str
    unit: str = ""  # as it is printed, empty for words, flags, counts and shares
    low: float = -math.inf  # inclusive
    high: float = math.inf
    choices: tuple[str, ...] = ()  # words that it may be, empty for any

    def bounds(self) -> str:
        """Describe the bounds and the unit, empty for words and flags."""
        if math.isinf(self.low):
            return ""
        range_text = (
            f"at least {self.low:g}" if math.isinf(self.high) else f"{self.low:g} to {self.high:g}"
        )
        return f"{range_text} {self.unit}".rstrip()


def describe_field(
    default: Value,
    description: str,
    unit: str = "",
    low: float = -math.inf,
    high: float = math.inf,
    choices: tuple[str, ...] = (),
) -> Value:
    """Declare a dataclass field with its Meta, which makes it an option with limits and help."""
    meta = Meta(description=description, unit=unit, low=low, high=high, choices=choices)
    made: Value = field(default=default, metadata={"meta": meta})
    return made


class Checked:
    """A record whose described fields are held to their bounds and choices."""

    # before a field's name where it stands without its record, as on the command line
    prefix: ClassVar[str] = ""

    def __post_init__(self) -> None:
        """Raise UsageError for the first value out of bounds or none of the choices."""
        for f in fields(self):  # type: ignore[arg-type]
            meta, value = f.metadata.get("meta"), getattr(self, f.name)
            if meta is None or value is None:
                continue
            name = self.prefix + f.name
            if isinstance(value, int | float) and not meta.low <= value <= meta.high:
                raise UsageError(f"{name} is {value}", remedy=f"choose {meta.bounds()}")
            if meta.choices and value not in meta.choices:
                raise UsageError(
                    f"{name} is {value!r}", remedy=f"choose one of {', '.join(meta.choices)}"
                )


@dataclass(frozen=True, kw_only=True)
class Ship(Checked):
    """The hull of the CAD model: an analytic form, or a mesh scaled to length_m."""

    hull: str = describe_field(
        "form", "`form` for an analytic ship, or the path of a mesh, which is scaled to --length-m"
    )
    length_m: float = describe_field(50.0, "Length of the ship", "m", 5, 500)
    beam_m: float = describe_field(9.0, "Beam of the analytic ship", "m", 0.5, 100)
    depth_m: float = describe_field(5.5, "Keel to deck of the analytic ship", "m", 0.5, 60)
    draught_m: float = describe_field(3.8, "Keel to water surface", "m", 0.2, 40)
    bilge_radius_m: float = describe_field(
        1.3, "Bilge radius of the analytic ship amidships", "m", 0.01, 20
    )
    entrance: float = describe_field(
        0.35, "Share of the length over which bow and stern each narrow", "", 0.05, 0.5
    )


@dataclass(frozen=True, kw_only=True)
class Survey(Checked):
    """The legs, which run along the hull, back and forth, from the top down."""

    along_m: float | None = describe_field(
        None,
        "Middle of the legs, from the stern; where the bow begins to narrow if absent",
        "m",
        0,
        500,
    )
    top_m: float = describe_field(1.2, "Depth of the first leg's steel below the water", "m", 0, 40)
    legs: int = describe_field(5, "Number of legs", "", 1, 200)
    leg_length_m: float = describe_field(6.5, "Length of a leg", "m", 0.5, 500)
    leg_spacing_m: float = describe_field(0.6, "Girth from leg to leg", "m", 0.1, 3)
    standoff_m: float = describe_field(1.15, "Distance of the sensors from the steel", "m", 0.5, 3)
    speed_m_per_s: float = describe_field(0.3, "Speed along a leg", "m/s", 0.02, 2)


@dataclass(frozen=True, kw_only=True)
class Cameras(Checked):
    """The cameras, and how often they fire: `views` sets the frame rate."""

    carried: Literal["stereo", "mono", "none"] = describe_field(
        "stereo", "Cameras carried", choices=("stereo", "mono", "none")
    )
    image_width: int = describe_field(640, "Width of an image", "px", 160, 4096)
    image_height: int = describe_field(512, "Height of an image", "px", 120, 4096)
    views: float = describe_field(
        7.0, "Images that see a point of the steel during one leg", "", 1, 60
    )
    jpeg_quality: int = describe_field(88, "Quality of the JPEG files", "", 1, 100)
    lens_error_px: float = describe_field(
        0.0, "Smooth error of the lenses that the calibration lacks, rms", "px", 0, 5
    )
    readout_s: float = describe_field(
        0.0, "Time from an image's first row to its last, exposed in turn", "s", 0, 0.15
    )
    camera_offset_s: float = describe_field(
        0.0, "Time by which the stamps of the images are late", "s", -1, 1
    )
    pair_offset_s: float = describe_field(
        0.0, "Time by which the bottom camera fires after the top one, unstamped", "s", -0.2, 0.2
    )


@dataclass(frozen=True, kw_only=True)
class SensorErrors(Checked):
    """The errors of the instruments; dive.toml gives no smaller sigma."""

    heading_drift_deg_per_hour: float = describe_field(
        1.0, "Drift of the IMU's heading, beside its random walk", "deg/h", -3600, 3600
    )
    dvl_scale_error: float = describe_field(
        0.003, "Share by which the DVL's velocities are too long, 0.003 for 0.3 %", "", -0.1, 0.1
    )
    backlash_deg: float = describe_field(
        0.5, "Backlash of the tray's servo, half the dead band", "deg", 0, 5
    )
    servo_sigma_deg: float = describe_field(
        0.05, "White noise of the servos' encoders, one sigma", "deg", 0, 5
    )


@dataclass(frozen=True, kw_only=True)
class DeviationField(Checked):
    """How the steel leaves the CAD model: offsets along the outward normal."""

    prefix: ClassVar[str] = "deviation_"

    mean_m: float = describe_field(
        -0.008, "Mean offset of the steel from the CAD model, outward positive", "m", -0.5, 0.5
    )
    sigma_m: float = describe_field(0.012, "Sigma of the smooth field of offsets", "m", 0, 0.2)
    length_m: float = describe_field(
        2.5, "Correlation length of that field along the hull", "m", 0.3, 50
    )


@dataclass(frozen=True, kw_only=True)
class InitialHullPose(Checked):
    """The error of the hull pose in dive.toml."""

    prefix: ClassVar[str] = "guess_"

    along_m: float = describe_field(
        0.4, "Error of the initial hull pose along the hull", "m", -100, 100
    )
    across_m: float = describe_field(
        0.2, "Error of the initial hull pose across the hull", "m", -100, 100
    )
    turn_deg: float = describe_field(
        2.0, "Error of the initial hull pose in heading", "deg", -180, 180
    )


@dataclass(frozen=True, kw_only=True)
class Items(Checked):
    """Items added to the hull: numbers of each kind at random places, or those of `placed`."""

    structures: int = describe_field(
        6, "Objects that stand out of the hull or are cut into it", "", 0, 200
    )
    marks: int = describe_field(3, "Painted marks, which are no objects", "", 0, 200)
    barnacles: int = describe_field(1, "Patches of barnacles, which are no objects", "", 0, 200)
    added: int = describe_field(
        0, "Structures that came since a first dive of this hull, beside those", "", 0, 200
    )
    removed: int = describe_field(
        0, "Structures that went since a first dive of this hull, of those", "", 0, 200
    )
    grown_m: float = describe_field(
        0.0, "Height that one structure gained since a first dive of this hull", "m", -0.1, 0.3
    )
    placed: tuple[Item, ...] | None = None


@dataclass(frozen=True, kw_only=True)
class Paint(Checked):
    """Where the paint is hard for images."""

    prefix: ClassVar[str] = "paint_"

    bare_share: float = describe_field(
        0.0,
        "Share of the legs, from their end towards the stern, whose paint is bare: "
        "images show nothing there",
        "",
        0,
        1,
    )
    repeats_m: float | None = describe_field(
        None,
        "Length along the hull after which its colours come again; never if absent",
        "m",
        0.5,
        500,
    )


@dataclass(frozen=True, kw_only=True)
class Positions(Checked):
    """Positions by USBL in a local frame, whose north and place are drawn from the seed."""

    prefix: ClassVar[str] = "position_"

    every_s: float | None = describe_field(
        None,
        "Time between positions of the vehicle by USBL; none are measured if absent",
        "s",
        0.1,
        3600,
    )
    sigma_m: float = describe_field(
        0.5, "White noise of such a position, north and east, one sigma", "m", 0, 100
    )
    outlier_share: float = describe_field(
        0.0, "Share of such positions that are off by metres or tens of metres", "", 0, 1
    )


@dataclass(frozen=True, kw_only=True)
class DiveSpec(Checked):
    """A dive to simulate.

    Every random draw comes from `seed`, those of the hull itself from `hull_seed`.
    """

    name: str = describe_field("simulated", "Name of the dive")
    seed: int = describe_field(1, "Number from which every random draw comes", "", 0)
    hull_seed: int | None = describe_field(
        None,
        "Number from which steel, paint and objects are drawn, for a second dive of one hull; "
        "the seed if absent",
        "",
        0,
    )
    sonar: bool = describe_field(True, "Carry an imaging sonar")
    visibility_m: float = describe_field(6.0, "How far one sees in this water", "m", 1, 50)
    form: Literal["mcap", "plain"] = describe_field(
        "mcap", "How the logs are written", choices=("mcap", "plain")
    )
    ship: Ship = Ship()
    survey: Survey = Survey()
    cameras: Cameras = Cameras()
    errors: SensorErrors = SensorErrors()
    deviation: DeviationField = DeviationField()
    guess: InitialHullPose = InitialHullPose()
    items: Items = Items()
    paint: Paint = Paint()
    positions: Positions = Positions()

    def __post_init__(self) -> None:
        """Raise UsageError also for a name that no dive.toml may have."""
        super().__post_init__()
        try:
            msgspec.convert({"name": self.name}, Dive)
        except msgspec.ValidationError:
            remedy = (
                "choose up to 100 ASCII letters, digits, dots, hyphens and underscores, "
                "neither a dot nor a hyphen first"
            )
            raise UsageError(f"name is {self.name!r}", remedy=remedy) from None

    def random(self, purpose: str) -> np.random.Generator:
        """Make the random generator of a purpose, so that draws for one do not change another's."""
        return np.random.default_rng([self.seed, zlib.crc32(purpose.encode())])

    def hull_random(self, purpose: str) -> np.random.Generator:
        """Make the random generator of a purpose that belongs to the hull, not to the dive."""
        seed = self.seed if self.hull_seed is None else self.hull_seed
        return np.random.default_rng([seed, zlib.crc32(purpose.encode())])


RENAMED = {("cameras", "carried"): "cameras"}


@dataclass(frozen=True, kw_only=True)
class Option:
    """One option of a simulated dive."""

    name: str  # flat, in snake case
    part: str  # field of DiveSpec that holds its record, empty for DiveSpec's own
    field: str  # of that record
    kind: type  # of its value where one is given
    default: bool | int | float | str | None
    meta: Meta


def options() -> tuple[Option, ...]:
    """List the fields of DiveSpec and of its records that have a Meta, in their order."""
    spec = DiveSpec()
    records: dict[str, Checked] = {"": spec}
    records |= {f.name: getattr(spec, f.name) for f in fields(spec) if "meta" not in f.metadata}
    return tuple(
        Option(
            name=RENAMED.get((part, f.name), record.prefix + f.name),
            part=part,
            field=f.name,
            kind=_kind(record, f.name),
            default=getattr(record, f.name),
            meta=f.metadata["meta"],
        )
        for part, record in records.items()
        for f in fields(record)  # type: ignore[arg-type]
        if "meta" in f.metadata
    )


def with_options(spec: DiveSpec, **values: Any) -> DiveSpec:
    """Change options of a spec by flat name.

    Raises UsageError for an unknown name, and for a value out of bounds.
    """
    known = {option.name: option for option in options()}
    changes: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        if name not in known:
            raise UsageError(f"unknown option {name}", remedy="see `hullrecon simulate --help`")
        changes.setdefault(known[name].part, {})[known[name].field] = value
    own = changes.pop("", {})
    parts = {
        part: dataclasses.replace(getattr(spec, part), **changed)
        for part, changed in changes.items()
    }
    return dataclasses.replace(spec, **own, **parts)


def spec_from(**values: Any) -> DiveSpec:
    """Describe a dive by some options, with the defaults of all others."""
    return with_options(DiveSpec(), **values)


def _kind(record: object, field: str) -> type:
    """Find the type of a field's values, such as int for `int | None`."""
    default = getattr(record, field)
    if default is not None:
        return type(default)
    kinds: tuple[type, ...] = typing.get_args(typing.get_type_hints(type(record))[field])
    return next(kind for kind in kinds if kind is not type(None))
