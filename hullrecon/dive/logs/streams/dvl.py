# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stack the pings of a DVL into a record: metres, NaN for velocities and ranges that are lost."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from hullrecon.dive.logs.dvl_beams import (
    check_beams,
    choose_beams,
    put_ranges_right,
    range_scale_sigma,
)
from hullrecon.dive.logs.lost_values import (
    drop_false_beams,
    drop_lost_velocities,
    drop_ranges_at_limit,
)
from hullrecon.dive.logs.samples import DvlSample, stamps
from hullrecon.dive.logs.two_sensors import refuse_two_sensors, windows
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.records.sensors import DvlPings
from hullrecon.typing import Array

FASTEST_M_S = 15.0  # no vehicle at a hull is faster
FASTEST_MEDIAN_M_S = 4.0  # of a dive: a survey of a hull is ten times slower
FARTHEST_MEDIAN_M = 100.0  # of the DVL's ranges at a hull: the instruments reach 50 to 200 m
# velocities that are needed to tell a rounding, and how exactly they lie on it, of its step
LEAST_ROUNDED, ON_GRID = 20, 1e-3
LEAST_LEVELS = 4  # different values; a simulated vehicle may go at few speeds
COARSEST_SHARE = 0.25  # of the median speed; a rounding by that turns its direction by 7 degrees
METRES_A_SECOND = {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3}


@np.errstate(all="ignore")  # values of any size: what is absurd is left out below
def dvl_pings(
    samples: Sequence[DvlSample],
    beams: Array | None,
    sigma: float,
    notes: list[Finding],
    unit: str = "m/s",
) -> DvlPings:
    """Stack the pings of a DVL, with NaN for velocities and ranges that are lost or absurd.

    Ranges become metres along the beams, whatever they were logged as.

    Parameters
    ----------
    samples : pings in order of time
    beams : (b, 3) directions of dive.toml in `dvl`, for messages without; None: not given
    sigma : standard deviation of a velocity, m/s, where a message has none
    notes : what was assumed or left out is added
    unit : key of METRES_A_SECOND by which the logged velocities and their sigmas are converted

    Raises
    ------
    InputError
        Ranges along beams that nothing describes, values that only another unit explains, or
        pings of two DVLs.
    """
    ranges = _stack_ranges(samples, notes)
    velocity, given = _stack_velocities(samples, ranges, unit, notes)
    directions = choose_beams(samples, beams, ranges.shape[1], notes)
    ranges, scale_sigma = _ranges_along_beams(samples, directions, ranges, notes)
    return DvlPings(
        t_ns=stamps(samples),
        velocity=velocity,
        velocity_sigma=np.where(np.isfinite(given) & (given > 0), given, sigma),
        ranges=ranges,
        beams=directions,
        range_scale_sigma=np.array(scale_sigma),
    )


def _stack_ranges(samples: Sequence[DvlSample], notes: list[Finding]) -> Array:
    """Stack the ranges (n, b) of n pings as logged, NaN for those that are lost.

    b is 0 where all are lost. A ping with another number of beams than most has none. notes: to
    which findings are added.
    """
    counts = Counter(len(s.ranges) for s in samples if len(s.ranges)).most_common(1)
    width = counts[0][0] if counts else 0
    ranges = np.full((len(samples), width), np.nan)
    for row, sample in enumerate(samples):
        if len(sample.ranges) == width:
            ranges[row] = sample.ranges
    ranges[~((ranges > 0) & np.isfinite(ranges))] = np.nan  # no return
    ranges = drop_false_beams(drop_ranges_at_limit(ranges, notes), notes)
    if width and not np.isfinite(ranges).any():
        notes.append(Finding("ranges-all-lost", where="dvl"))
        return ranges[:, :0]
    return ranges


def _stack_velocities(
    samples: Sequence[DvlSample], ranges: Array, unit: str, notes: list[Finding]
) -> tuple[Array, Array]:
    """Stack the velocities (n, 3), m/s, NaN for those that are lost or absurd.

    Parameters are those of `dvl_pings`. ranges (n, b): a ping without any may have lost the bottom.

    Returns
    -------
    tuple
        Velocities, and their sigmas (n,) as the messages give them, m/s.
    """
    # A whole log is refused before single absurd velocities are dropped: it is judged by all.
    scale = METRES_A_SECOND[unit]
    velocity = scale * np.array([s.velocity for s in samples]).reshape(-1, 3)
    velocity[~np.isfinite(velocity).all(axis=1)] = np.nan
    notes += _describe_not_over_ground(samples)
    speed = np.linalg.norm(velocity, axis=1)
    _refuse_fast(speed, unit)
    _refuse_coarse(velocity, speed)
    absurd = speed > FASTEST_M_S
    if absurd.any():
        velocity[absurd] = np.nan
        values = {"count": int(absurd.sum()), "limit_m_s": FASTEST_M_S}
        notes.append(Finding("velocities-absurd", values, "dvl"))
    given = scale * np.array([s.sigma for s in samples])
    velocity, given = drop_lost_velocities(stamps(samples), velocity, given, ranges, notes)
    cut = windows(velocity[np.isfinite(velocity).all(axis=1)])
    refuse_two_sensors("dvl", np.linalg.norm(cut - cut[:, :1], axis=2), "m/s")
    _refuse_flat(velocity)
    return velocity, given


def _ranges_along_beams(
    samples: Sequence[DvlSample], directions: Array, ranges: Array, notes: list[Finding]
) -> tuple[Array, float]:
    """Convert ranges (n, b), as logged, to metres along the beams, and find their scale's sigma.

    They may have been logged as distances along the DVL's axis, or in another unit. `ranges` is
    changed in place.

    directions: (b, 3) of the beams in `dvl`.
    """
    along_axis = np.array([s.along_axis for s in samples], bool)
    along_beams = ranges[along_axis] / directions[:, 2]
    ranges[along_axis] = np.where(np.isfinite(along_beams) & (along_beams > 0), along_beams, np.nan)
    altitude = np.array([s.altitude for s in samples])
    ranges, mended = put_ranges_right(directions, ranges, altitude)
    _refuse_far(ranges)
    notes += mended + check_beams(directions, ranges, altitude)
    by_hand = any(s.by_hand for s in samples)
    scale_sigma, unconfirmed = range_scale_sigma(directions, ranges, altitude, by_hand)
    notes += unconfirmed
    return ranges, scale_sigma


def _describe_not_over_ground(samples: Sequence[DvlSample]) -> list[Finding]:
    """Report the velocities that a DVL measured relative to something else than the ground."""
    code, count = "velocities-not-over-ground", len(samples)
    others = Counter(s.not_over_ground for s in samples if s.not_over_ground)
    return [
        Finding(code, {"lost": lost, "count": count, "what": what}, "dvl")
        for what, lost in sorted(others.items())
    ]


def _refuse_far(ranges: Array) -> None:
    """Raise InputError for ranges (n, b), m, that only another unit explains."""
    known = ranges[np.isfinite(ranges)]
    median = float(np.median(known)) if len(known) else 0.0
    if median > FARTHEST_MEDIAN_M:
        raise InputError(
            f"half of the DVL's ranges are {median:.4g} m or more, as none along a hull is: are "
            "they in centimetres or millimetres?",
            where="dvl",
            remedy="log them in metres, or leave the ranges away",
        )


def _refuse_coarse(velocity: Array, speed: Array) -> None:
    """Raise InputError for velocities (n, 3), m/s, rounded so that they lose their direction.

    They are where all are multiples of one step, and the step is more than COARSEST_SHARE of the
    median speed. Too few velocities, or different values, are accepted.

    Parameters
    ----------
    velocity : (n, 3) m/s, NaN where lost
    speed : (n,) their lengths
    """
    levels = np.unique(np.abs(velocity[np.isfinite(velocity)]))
    moving = speed[speed > 0]
    if len(moving) < LEAST_ROUNDED or len(levels) < LEAST_LEVELS:
        return
    step = float(np.diff(levels).min())
    rounded = np.abs(levels / step - np.round(levels / step)).max() < ON_GRID
    median = float(np.median(moving))
    if rounded and step > COARSEST_SHARE * median:
        raise InputError(
            f"its velocities are rounded to {step:.3g} m/s, half of them are {median:.3g} m/s or "
            "less",
            where="dvl",
            remedy="log or write them with more digits",
        )


def _refuse_flat(velocity: Array) -> None:
    """Raise InputError for a velocity (n, 3) of which one axis is exactly zero in all pings.

    The two others take many values, so that it is no vehicle at rest: a driver left the axis out.
    """
    known = velocity[np.isfinite(velocity).all(axis=1)]
    flat = (known == 0).all(axis=0)
    levels = [len(np.unique(values)) for values in known.T[~flat]]
    if flat.sum() != 1 or min(levels) < LEAST_ROUNDED:
        return
    raise InputError(
        f"its velocity along {'xyz'[int(np.argmax(flat))]} is exactly 0 in all {len(known)} pings: "
        "its driver leaves that axis out",
        where="dvl",
        remedy="log the velocity along all three axes",
    )


def _refuse_fast(speed: Array, unit: str) -> None:
    """Raise InputError for a speed (n,), m/s, that only another unit explains.

    unit: of METRES_A_SECOND, by which they were converted. The error names the units that fit.
    """
    known = speed[np.isfinite(speed)]
    median = float(np.median(known)) if len(known) > 2 else 0.0
    if median <= FASTEST_MEDIAN_M_S:
        return
    logged = median / METRES_A_SECOND[unit]
    others = [
        f'"{other}" ({logged * METRES_A_SECOND[other]:.2g} m/s)'
        for other in METRES_A_SECOND
        if logged * METRES_A_SECOND[other] <= FASTEST_MEDIAN_M_S
    ]
    raise InputError(
        f"half of the DVL's velocities are {median:.3g} m/s or more, as no vehicle at a hull moves",
        where="dvl.velocity_unit",
        remedy=f"give their unit: {' or '.join(others)}" if others else "see what the topic holds",
    )
