# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find readings that are written as numbers but stand for lost ones.

Drivers write a lost velocity as zero, as the last one or as what a filter makes of that, with or
without a covariance beyond all measurement, a lost range as the largest that the instrument could
have, a lost attitude as the default of its message.
"""

from __future__ import annotations

import numpy as np

from hullrecon.findings.finding import Finding
from hullrecon.records.clock import NS, format_time
from hullrecon.typing import Array, Ints, Mask

# Water Linked calls velocities of this figure of merit and more invalid
WORST_SIGMA_M_S = 0.4
# from one ping to the next; no vehicle stops within less, whatever the time between them
SUDDEN_M_S, SUDDEN_M_S2 = 0.02, 0.25
NOTHING_M_S = 1e-6  # velocities below are zero; no DVL tells a tenth of a millimetre per second
LEAST_NOISE = 3.0  # times its step: a sensor as noisy does not measure exactly zero on three axes
LEAST_PINGS = 20  # to tell a sensor's noise, and that its values are not constant
THIRD_DIFFERENCE = 20**0.5  # of white noise: its standard deviation over the noise's
LONG_RUN = 3.0  # times as many equal velocities as usual
LONGEST_HOLD_S = 1.0
MOST_UNHEARD = 0.5  # of the velocities may be lost because no beam has a range
UNFILLED, SUDDEN_TURN_RAD = (0.0, 0.0, 0.0, 1.0), 0.1  # ROS 2's default orientation
LEAST_LIMITED = 5  # ranges that are exactly the largest one
LEAST_BEAMS = 3  # of a ping that shows whether one is unlike the others
MOST_ALIKE = 0.9  # of the pings, with one range in all beams
STANDS_STILL = 0.2  # of what the hull in the other beams comes and goes
CLOSE_TO_LIMIT = 0.9  # of the largest range: one that was measured has others as long


@np.errstate(all="ignore")  # velocities of any size
def drop_lost_velocities(
    t_ns: Ints, velocity: Array, sigma: Array, ranges: Array, notes: list[Finding]
) -> tuple[Array, Array]:
    """Replace velocities by NaN that stand for a lost bottom lock.

    Parameters
    ----------
    t_ns : (n,) in order
    velocity : (n, 3) m/s, NaN where lost
    sigma : (n,) m/s, NaN where not given
    ranges : (n, b) m, NaN where lost. A beam that tracks the bottom has a range
    notes : what was left out is added

    Returns
    -------
    velocity, and sigma: NaN where all are so large that they say nothing
    """
    known = np.isfinite(velocity).all(axis=1)
    huge = known & (sigma >= WORST_SIGMA_M_S)
    if known.any() and huge[known].all():
        values = {"least_m_s": float(sigma[known].min()), "limit_m_s": WORST_SIGMA_M_S}
        notes.append(Finding("velocity-sigmas-useless", values, "dvl"))
        sigma, huge = np.full(len(sigma), np.nan), np.zeros(len(sigma), bool)
    zeros, repeats = _false_readings(t_ns, np.where(huge[:, None], np.nan, velocity))
    rest = known & ~(huge | zeros | repeats)
    unheard = rest & ~np.isfinite(ranges).any(axis=1)
    if unheard.sum() > MOST_UNHEARD * rest.sum():  # of an instrument that gives few ranges
        unheard[:] = False
    lost = huge | zeros | repeats | unheard
    if lost.any():
        first, last = np.flatnonzero(lost)[[0, -1]]
        marks: dict[str, object] = {
            "huge": int(huge.sum()),
            "zero": int(zeros.sum()),
            "repeated": int(repeats.sum()),
            "unheard": int(unheard.sum()),
            "limit_m_s": WORST_SIGMA_M_S,
            "start": format_time(int(t_ns[first])),
            "seconds": float(t_ns[last] - t_ns[first]) / NS,
        }
        notes.append(Finding("velocities-marked-lost", marks, "dvl"))
    return np.where(lost[:, None], np.nan, velocity), sigma


def _false_readings(t_ns: Ints, velocity: Array) -> tuple[Mask, Mask]:
    """Find velocities (n,) that stand for lost ones: false zeros, and repeats of the last one.

    Zeros are false where they begin or end as no vehicle stops or starts, or where a sensor whose
    noise is well beyond the smallest velocity that it tells from zero gives several. Such a sensor
    does not give the same velocity for seconds either, apart from a driver that writes each ping
    several times.
    """
    zeros, repeats = np.zeros(len(velocity), bool), np.zeros(len(velocity), bool)
    known = np.flatnonzero(np.isfinite(velocity).all(axis=1))
    if len(known) < 2:
        return zeros, repeats
    # a zero that was turned or moved by a lever arm is not exactly zero any more
    velocity = np.where(np.abs(velocity) < NOTHING_M_S, 0.0, velocity)
    measured, t_s = velocity[known], (t_ns[known] - t_ns[0]) / NS
    step = np.linalg.norm(np.diff(measured, axis=0), axis=1)
    sudden = step > SUDDEN_M_S + SUDDEN_M_S2 * np.diff(t_s)
    starts = np.flatnonzero(np.r_[True, step > 0])
    ends = np.r_[starts[1:], len(known)]
    is_zero = (measured[starts] == 0).all(axis=1)
    usual = LONG_RUN * float(np.median(ends - starts))
    noisy = _is_noisy(measured[starts][~is_zero])
    for start, end, zero in zip(starts, ends, is_zero, strict=True):
        borders = sudden[[row for row in (start - 1, end - 1) if 0 <= row < len(sudden)]]
        if zero:
            zeros[known[start:end]] = len(starts) > 1 and (
                borders.any() or (noisy and end - start > 1)
            )
        elif noisy and end - start > usual and t_s[end - 1] - t_s[start] > LONGEST_HOLD_S:
            repeats[known[start + 1 : end]] = True
    return zeros, repeats


def _is_noisy(velocity: Array) -> bool:
    """Tell whether velocities (n, 3) have noise well above their smallest value."""
    if len(velocity) < LEAST_PINGS:
        return False
    noise = 1.4826 * np.median(np.abs(np.diff(velocity, 3, axis=0)), axis=0) / THIRD_DIFFERENCE
    smallest = np.abs(velocity[velocity != 0]).min()
    return bool(noise.min() > LEAST_NOISE * smallest)


def is_false_attitude(quaternion: Array) -> Mask:
    """Find attitudes (n,) of exactly (0, 0, 0, 1) amid others: a message that was not filled in.

    quaternion: (n, 4) x, y, z, w. One that turns there gently from its neighbours is believed, and
    so are most of them.
    """
    default = (np.abs(quaternion) == UNFILLED).all(axis=1)
    others = np.flatnonzero(~default & np.isfinite(quaternion).all(axis=1))
    if not 0 < default.sum() < len(others):
        return np.zeros(len(quaternion), bool)
    rows = np.arange(len(quaternion))
    after = np.searchsorted(others, rows).clip(0, len(others) - 1)
    before = (np.searchsorted(others, rows) - 1).clip(0)
    # of the turn from the default to a unit quaternion, w is the cosine of half of it
    turned = np.cos(SUDDEN_TURN_RAD / 2) > np.abs(quaternion[:, 3])
    return np.asarray(default & (turned[others[after]] | turned[others[before]]))


def is_held(t_ns: Ints, quaternion: Array, rates: Array, acceleration: Array) -> Mask:
    """Find readings (n,) that repeat the one before to the last digit for more than a second.

    An IMU that turns has no two equal ones: it or its driver stood still. One that is at rest in a
    simulator has no rates, and a driver that writes each reading several times repeats all alike.
    """
    reading = np.hstack([quaternion, rates, acceleration])
    moved = np.r_[True, (np.diff(reading, axis=0) != 0).any(axis=1)]
    starts = np.flatnonzero(moved)
    ends = np.r_[starts[1:], len(reading)]
    count = ends - starts
    long = (t_ns[ends - 1] - t_ns[starts]) / NS > LONGEST_HOLD_S
    long &= count > LONG_RUN * np.median(count)
    return np.asarray(np.repeat(long, count) & ~moved & (rates != 0).any(axis=1))


def drop_ranges_of_one_beam(ranges: Array, notes: list[Finding]) -> Array:
    """Replace ranges (n, b) by NaN that are none of the beams they stand for.

    A driver without ranges writes the altitude into all beams. A beam that hears its own pulse, or
    a part of the vehicle, stays where it is while the hull in the others comes and goes.
    """
    whole = np.isfinite(ranges).all(axis=1)
    if ranges.shape[1] < LEAST_BEAMS or whole.sum() < LEAST_PINGS:
        return ranges
    known = ranges[whole]
    if (np.ptp(known, axis=1) == 0).mean() > MOST_ALIKE and len(np.unique(known)) > LEAST_PINGS:
        notes.append(Finding("ranges-alike", {"count": int(whole.sum())}, "dvl"))
        return np.full_like(ranges, np.nan)
    out = ranges.copy()
    low, middle, high = np.percentile(known, [5, 50, 95], axis=0)
    for beam in range(ranges.shape[1]):
        others = np.delete(known, beam, axis=1)
        spread = float(np.median(np.ptp(np.percentile(others, [5, 95], axis=0), axis=0)))
        own = float(high[beam] - low[beam])
        is_near = middle[beam] < np.median(others, axis=0).min() - spread
        if is_near and own < STANDS_STILL * spread:
            values = {"beam": beam + 1, "low_m": float(low[beam]), "high_m": float(high[beam])}
            notes.append(Finding("beam-stands-still", {**values, "others_m": spread}, "dvl"))
            out[:, beam] = np.nan
    return out


def drop_ranges_at_limit(ranges: Array, notes: list[Finding]) -> Array:
    """Replace ranges (n, b) by NaN that are exactly the largest of all and far from the others."""
    known = ranges[np.isfinite(ranges)]
    if not known.size:
        return ranges
    limit = known.max()
    at_limit = ranges == limit
    others = np.unique(known[known < limit])
    if at_limit.sum() < LEAST_LIMITED or len(others) < LEAST_PINGS:
        return ranges
    if others[-1] > CLOSE_TO_LIMIT * limit:
        return ranges
    values = {"count": int(at_limit.sum()), "limit_m": float(limit), "next_m": float(others[-1])}
    notes.append(Finding("ranges-at-limit", values, "dvl"))
    return np.where(at_limit, np.nan, ranges)
