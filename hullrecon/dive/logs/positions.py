# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Convert position fixes (USBL, GNSS) to metres north and east, and drop unusable ones."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from hullrecon.dive.logs.samples import PositionSample, stamps
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.geometry.geodesy import north_east
from hullrecon.records.clock import seconds_to_nearest
from hullrecon.records.sensors import PositionFixes, PressureSamples
from hullrecon.typing import Array, Mask

# Depth at which a satellite's signal is lost: centimetres of sea water end it, the rest is for
# waves and the error of the sensor
DEEPEST_RECEPTION_M = 1.0
FARTHEST_DEG = (90.0, 360.0)  # the largest latitude and longitude; some count longitude to 360
FARTHEST_RAD = (np.pi / 2, np.pi)
MOST_DDMM = (9000.0, 18000.0)  # as degrees and minutes in one number, ddmm.mmm
NEAR_DEPTH_S = 10.0  # between a fix and the depth that tells whether the antenna was under water
# words in the name of a topic whose fixes are of a locator under water
ACOUSTIC_WORDS = frozenset({"usbl", "ssbl", "sbl", "lbl", "ugps", "acoustic", "underwater"})


def is_acoustic(source: str | None, topic: str) -> bool:
    """Tell whether positions are acoustic: by dive.toml, else by the words of the topic's name."""
    if source is not None:
        return source == "acoustic"
    return bool(ACOUSTIC_WORDS & set(re.split(r"[^a-z]+", topic.lower())))


@np.errstate(all="ignore")
def position_fixes(
    samples: Sequence[PositionSample],
    sigma_m: float,
    frame: str,
    pressure: PressureSamples | None,
    notes: list[Finding],
) -> PositionFixes | None:
    """Convert fixes to metres north and east of the first one. None where no fix is usable.

    Dropped are readings without a fix, those of another kind (geographic or local) than the first
    fix, and satellite fixes of a vehicle under water.

    Parameters
    ----------
    samples : positions in order of time
    sigma_m : standard deviation along either horizontal axis, where a message has none
    frame : "enu" or "ned", the meaning of x and y where fixes are in a local frame
    pressure : depths, which tell when a satellite antenna was under water
    notes : a finding for each reason is added, with how many were dropped

    Raises
    ------
    InputError
        Latitudes and longitudes that are no degrees.
    """
    _refuse_other_units([s for s in samples if s.geographic])
    fixed = [s for s in samples if _is_position(s)]
    if len(fixed) < len(samples):
        values = {"lacking": len(samples) - len(fixed), "count": len(samples)}
        notes.append(Finding("positions-without-fix", values, "position"))
    # geographic and local coordinates cannot be mixed: those of the first fix's kind are used
    of_one_kind = [s for s in fixed if s.geographic == fixed[0].geographic]
    if len(of_one_kind) < len(fixed):
        values = {"others": len(fixed) - len(of_one_kind), "count": len(fixed)}
        notes.append(Finding("positions-other-form", values, "position"))
    under_water = _under_water(of_one_kind, pressure)
    if under_water.any():
        count = {"drowned": int(under_water.sum()), "count": len(under_water)}
        limit = {"deepest_m": DEEPEST_RECEPTION_M}
        notes.append(Finding("positions-under-water", {**count, **limit}, "position"))
    kept = [s for s, is_wet in zip(of_one_kind, under_water, strict=True) if not is_wet]
    if not kept:
        return None
    given = np.array([s.sigma_m for s in kept])
    place = np.array([s.place for s in kept])
    return PositionFixes(
        t_ns=stamps(kept),
        north_east=_in_metres(place, kept[0].geographic, frame),
        # with x and y, or latitude and longitude, in the other order: loggers exchange them
        exchanged=_in_metres(place[:, [1, 0]], kept[0].geographic, frame),
        sigma=np.where(np.isfinite(given) & (given > 0), given, sigma_m),
    )


def _refuse_other_units(samples: Sequence[PositionSample]) -> None:
    """Raise InputError where most latitudes and longitudes are in another unit than degrees.

    Radians, degrees and minutes in one number, and 1e-7 degrees are recognised by their size.
    """
    place = np.abs(np.array([s.place[:2] for s in samples], float).reshape(-1, 2))
    place = place[np.isfinite(place).all(axis=1) & place.any(axis=1)]
    if not len(place):
        return
    latitude, longitude = np.median(place, axis=0)
    if (place <= FARTHEST_RAD).all():
        unit = "radians (in degrees the ship would lie in the open Gulf of Guinea)"
    elif (place <= FARTHEST_DEG).all(axis=1).mean() >= 0.5:
        return
    elif (place <= MOST_DDMM).all() and (place % 100 < 60).all():
        unit = "degrees and minutes (ddmm.mmm, as NMEA has them)"
    else:
        unit = "1e-7 degrees, as MAVLink counts"
    raise InputError(
        f"half of the latitudes are {latitude:.7g} and more, of the longitudes {longitude:.7g}: "
        f"are they {unit}?",
        where="position",
        remedy="log them in degrees, or leave topics.position (or position.csv) away",
    )


def _is_position(sample: PositionSample) -> bool:
    """Tell whether a sample holds a fix.

    False where values are missing or beyond any latitude and longitude. False, too, for zero
    latitude and longitude, which receivers send before they have a fix.
    """
    first, second = sample.place[:2]
    if not np.isfinite([first, second]).all():
        return False
    return not sample.geographic or (
        abs(first) <= FARTHEST_DEG[0]
        and abs(second) <= FARTHEST_DEG[1]
        and (first, second) != (0.0, 0.0)
    )


def _under_water(samples: Sequence[PositionSample], pressure: PressureSamples | None) -> Mask:
    """Find the satellite fixes (n,) of a vehicle under water, where its antenna receives nothing.

    It is judged by the depth interpolated at the fix. Fixes without one within NEAR_DEPTH_S are not
    marked.
    """
    t_ns = stamps(samples)
    by_satellite = np.array([s.by_satellite for s in samples], bool)
    if pressure is None or not len(pressure.t_ns) or not len(samples):
        return np.zeros(len(samples), bool)
    depth = np.interp(t_ns, pressure.t_ns, pressure.depth)
    known = seconds_to_nearest(pressure.t_ns, t_ns) <= NEAR_DEPTH_S
    return np.asarray(by_satellite & known & (depth > DEEPEST_RECEPTION_M))


def _in_metres(place: Array, geographic: bool, frame: str) -> Array:
    """Convert positions (n, 3) to metres north and east (n, 2) of the first.

    Parameters
    ----------
    place : latitude and longitude in degrees where geographic, else x and y in m; the third column
        is not used
    geographic : whether they are latitude and longitude
    frame : "enu" (x is east) or "ned" (x is north), of a local frame
    """
    if geographic:
        return north_east(place[:, 0], place[:, 1])
    shift = place[:, :2] - place[0, :2]
    return shift[:, ::-1].copy() if frame == "enu" else shift
