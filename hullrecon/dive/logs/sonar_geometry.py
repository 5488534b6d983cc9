# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find the common geometry of an imaging sonar's pings: beam directions and ranges."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hullrecon.dive.logs.dvl_beams import unit
from hullrecon.dive.logs.messages.sonar import in_fan
from hullrecon.dive.logs.samples import SonarSample
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.typing import Array

# share of the range by which windows of one setting differ at most, as the temperature changes
SAME_REACH = 0.01
# difference of unit vectors, half a degree; the fans of two modes differ by tens of degrees
SAME_FAN = 0.01
OFF_PLANE = 0.5  # largest x of the unit vectors of a fan's beams
FARTHEST_M = 200.0  # no imaging sonar sees a hull from farther away
MEANING = (
    "the azimuth of each beam in degrees from the middle of the fan, growing from port to starboard"
)


def pings_of_one_window(
    samples: Sequence[SonarSample], notes: list[Finding]
) -> tuple[list[SonarSample], Array]:
    """Select the pings of the most common window and fan, with their ranges (ranges,) m.

    A window is a number of beams and samples and a span of ranges. Windows whose ends differ by
    SAME_REACH at most are one, as the speed of sound that a sonar reckons with changes with the
    temperature. A fan is the directions of all beams. Pings of other windows and fans are dropped,
    so that the rest fits into one array. `notes` gets findings of how many. Both results are empty
    without pings. The ranges are those of most pings.
    """
    if not samples:
        return [], np.zeros(0)
    reach = np.array([s.range_m[-1] for s in samples])
    shapes = Counter(s.image.shape for s in samples)
    agreed = max((_widest_agreement(samples, reach, shape) for shape in shapes), key=len)
    best = _select_common_fan(samples, agreed)
    windows = Counter(round(float(reach[i]), 6) for i in best)
    common = windows.most_common(1)[0][0]
    kept = [samples[i] for i in best]
    first = next(s for s in kept if round(float(s.range_m[-1]), 6) == common)
    if len(agreed) < len(samples):
        values: dict[str, object] = {
            "others": len(samples) - len(agreed),
            "count": len(samples),
            "beams": first.image.shape[0],
            "range_m": float(first.range_m[-1]),
        }
        notes.append(Finding("sonar-other-windows", values, "sonar"))
    elsewhere = len(agreed) - len(best)
    if elsewhere:
        values = {"others": elsewhere, "count": len(agreed)}
        notes.append(Finding("sonar-other-fans", values, "sonar"))
    others = len(kept) - windows[common]
    if others:
        differ_mm = 1e3 * float(np.abs(reach[best] - first.range_m[-1]).max())
        values = {"others": others, "count": len(kept), "differ_mm": differ_mm}
        notes.append(Finding("sonar-other-ranges", values, "sonar"))
    return kept, first.range_m


def _widest_agreement(
    samples: Sequence[SonarSample], reach: Array, shape: tuple[int, ...]
) -> list[int]:
    """Find the rows of the largest group of pings of one shape whose windows agree.

    For each ping, those are counted whose last range lies within half of SAME_REACH of its own. The
    group is around the ping with most.

    Parameters
    ----------
    samples : all pings
    reach : (n,) last range of each, m
    shape : (beams, ranges) of the images that are looked at
    """
    rows = np.array([i for i, s in enumerate(samples) if s.image.shape == shape])
    value = np.sort(reach[rows])
    margin = SAME_REACH / 2 * np.abs(reach[rows])
    count = np.searchsorted(value, reach[rows] + margin, "right") - np.searchsorted(
        value, reach[rows] - margin
    )
    middle = int(np.argmax(count))
    start = float(samples[rows[middle]].range_m[0])
    limit = float(margin[middle])
    near = [
        i
        for i in rows
        if abs(reach[i] - reach[rows[middle]]) <= limit
        and abs(samples[i].range_m[0] - start) <= limit
    ]
    return [int(i) for i in near]


def _select_common_fan(samples: Sequence[SonarSample], rows: Sequence[int]) -> list[int]:
    """Select the rows whose beams point as in the most common fan.

    Pings without beam directions count as one fan. Pings of one fan mostly share one array, so
    arrays are compared once for each object instead of once for each ping.
    """
    fans: dict[int, Array | None] = {id(samples[i].directions): samples[i].directions for i in rows}
    key = {number: b"" if fan is None else fan.tobytes() for number, fan in fans.items()}
    count = Counter(key[id(samples[i].directions)] for i in rows)
    common = next(fans[number] for number in key if key[number] == count.most_common(1)[0][0])
    same = {number for number, fan in fans.items() if _is_one_fan(fan, common)}
    return [i for i in rows if id(samples[i].directions) in same]


def _is_one_fan(directions: Array | None, other: Array | None) -> bool:
    """Tell whether two fans of directions (beams, 3) point the same ways, within SAME_FAN.

    Where one fan is not known, neither may be.
    """
    if directions is None or other is None:
        return directions is other
    # vectors of length 0, of beams that were never filled in, are like themselves only
    return np.array_equal(directions, other) or bool(
        np.abs(unit(directions) - unit(other)).max() < SAME_FAN
    )


def image_in_ranges(sample: SonarSample, range_m: Array) -> NDArray[np.generic]:
    """Resample a ping's image (beams, ranges) to other ranges, m, by the nearest sample.

    With it pings of slightly different windows fit into one array. 0 beyond its own ranges.
    The image is returned unchanged where its own ranges do not grow.
    """
    own = sample.range_m
    if np.array_equal(own, range_m) or len(own) < 2 or not (np.diff(own) > 0).all():
        return sample.image
    number = np.arange(len(own))
    half = 0.5 * np.diff(own)[[0, -1]]
    # a sample reaches half a step beyond its middle, at either end too
    limits = np.concatenate([[own[0] - half[0]], own, [own[-1] + half[1]]])
    nearest = (
        np.interp(range_m, limits, np.concatenate([[0], number, [number[-1]]]), left=-1, right=-1)
        .round()
        .astype(int)
    )
    return np.where(nearest >= 0, sample.image[:, nearest], 0).astype(sample.image.dtype)


def evenly_spaced(range_m: Array) -> Array:
    """Return ranges (n,) m as they are if they are evenly spaced, else n that are, over their span.

    Raises InputError for ranges that do not grow, or beyond those of any sonar at a hull.
    """
    steps, farthest = np.diff(range_m), float(range_m.max())
    if not (steps > 0).all() or farthest > FARTHEST_M:
        raise InputError(
            f"the sonar's ranges reach {farthest:.4g} m: are they in centimetres or millimetres?"
            if farthest > FARTHEST_M
            else "the sonar's ranges do not grow from sample to sample",
            where="sonar",
            remedy="log them in metres, growing, or leave topics.sonar away",
        )
    if not len(steps):
        return range_m
    even = np.linspace(range_m[0], range_m[-1], len(range_m))
    return even if np.abs(range_m - even).max() > 0.25 * float(steps.mean()) else range_m


def choose_directions(
    sample: SonarSample, azimuth_deg: Array | None, notes: list[Finding]
) -> Array:
    """Choose the directions (beams, 3) in `sonar` of a ping's beams: its own, else dive.toml's.

    Its own are taken only where they are a fan. Raises InputError where neither says, or where
    azimuth_deg (beams,) of dive.toml describes another number of beams, or does not grow. notes: a
    finding is added where azimuth_deg is given but not used.
    """
    beams = len(sample.image)
    if sample.directions is not None and _is_fan(sample.directions):
        if azimuth_deg is not None:
            notes.append(Finding("sonar-azimuths-unused", where="sonar"))
        return sample.directions
    if azimuth_deg is None:
        raise ask_for_azimuths(beams, sample.directions is not None)
    if len(azimuth_deg) != beams or not (np.diff(azimuth_deg) > 0).all():
        raise InputError(
            f"sonar.beam_azimuth_deg has {len(azimuth_deg)} angles for {beams} beams, or they do "
            "not grow",
            where="sonar.beam_azimuth_deg",
            remedy=f"give {MEANING}",
        )
    return in_fan(np.radians(azimuth_deg))


@np.errstate(all="ignore")  # vectors of any values
def _is_fan(directions: Array) -> bool:
    """Tell whether directions (beams, 3) lie side by side in a plane near y and z.

    Azimuths in degrees that were taken as radians point all around.
    """
    x, y, z = unit(directions).T
    bearing = np.arctan2(y, z)
    steps = np.diff(bearing)
    return bool(
        (np.abs(x) < OFF_PLANE).all()
        and (np.abs(bearing) <= np.pi / 2).all()
        and ((steps >= 0).all() or (steps <= 0).all())
    )


def ask_for_azimuths(beams: int, are_logged: bool = False) -> InputError:
    """Make the error that asks for the azimuths of the sonar's beams.

    are_logged: the log has directions, which are none.
    """
    what = f"nothing says where the sonar's {beams} beams point"
    if are_logged:
        what = (
            f"the directions of the sonar's {beams} beams in the log are no fan around z, from one "
            "side to the other: azimuths in degrees in place of radians, other axes, or not filled "
            "in?"
        )
    return InputError(
        what,
        where="sonar.beam_azimuth_deg",
        remedy=f"give {MEANING}, from the manufacturer; lenses do not space beams evenly",
    )
