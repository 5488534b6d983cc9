# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find lost readings that were written as numbers.

Drivers write a lost velocity as zero, as the last one or as what a filter makes of that. Some
mark it by a covariance that no measurement has. They write a lost range as the largest that the
instrument could have, and a lost attitude as the default of its message.
"""

from __future__ import annotations

import numpy as np

from hullrecon.findings.finding import Finding
from hullrecon.geometry.robust import NORMAL_MAD
from hullrecon.records.clock import NS, format_time
from hullrecon.typing import Array, Ints, Mask

# Water Linked calls velocities of this figure of merit and more invalid
WORST_SIGMA_M_S = 0.4
# Change of velocity from one ping to the next that is no vehicle's: by noise and by acceleration
# over the time between the two
SUDDEN_M_S, SUDDEN_M_S2 = 0.02, 0.25
NOTHING_M_S = 1e-6  # velocities below are zero: no DVL resolves 0.1 mm/s
# Noise over the smallest velocity that the sensor writes. One as noisy does not measure exactly
# zero on three axes
LEAST_NOISE = 3.0
LEAST_PINGS = 20  # to tell a sensor's noise, and that its values are not constant
THIRD_DIFFERENCE = 20**0.5  # standard deviation of third differences of white noise, over its own
LONG_RUN = 3.0  # times as many equal readings in a row as usual
LONGEST_HOLD_S = 1.0  # that a reading may be repeated as measured
MOST_UNHEARD = 0.5  # of the velocities may be lost because no beam has a range
# ROS 2's default orientation, and the angle to it from which a neighbour shows it to be false
UNFILLED, SUDDEN_TURN_RAD = (0.0, 0.0, 0.0, 1.0), 0.1
LEAST_LIMITED = 5  # ranges that are exactly the largest one
LEAST_BEAMS = 3  # of a ping that shows whether one is unlike the others
MOST_ALIKE = 0.9  # of the pings, with one range in all beams
STANDS_STILL = 0.2  # of the spread of the other beams' ranges; a beam that varies less stands still
CLOSE_TO_LIMIT = 0.9  # of the largest range; where that was measured, others are nearly as long


@np.errstate(all="ignore")  # velocities of any size
def drop_lost_velocities(
    t_ns: Ints, velocity: Array, sigma: Array, ranges: Array, notes: list[Finding]
) -> tuple[Array, Array]:
    """Replace velocities by NaN that mark a lost bottom lock.

    These are velocities with a sigma of WORST_SIGMA_M_S or more, false zeros, repeats of the last
    velocity, and those of pings in which no beam has a range. Where every sigma is that large, the
    sigmas are dropped in place of the velocities. Where most pings have no range, ranges are not
    required.

    Parameters
    ----------
    t_ns : (n,) stamps in order
    velocity : (n, 3) m/s, NaN where lost
    sigma : (n,) m/s, NaN where not given
    ranges : (n, b) m, NaN where lost. A beam that tracks the bottom has a range
    notes : a finding of how many velocities were lost for each reason is added

    Returns
    -------
    velocity (n, 3) and sigma (n,), with NaN for what was dropped
    """
    known = np.isfinite(velocity).all(axis=1)
    huge = known & (sigma >= WORST_SIGMA_M_S)
    if known.any() and huge[known].all():
        values = {"least_m_s": float(sigma[known].min()), "limit_m_s": WORST_SIGMA_M_S}
        notes.append(Finding("velocity-sigmas-useless", values, "dvl"))
        sigma, huge = np.full(len(sigma), np.nan), np.zeros(len(sigma), bool)
    zeros, repeats = _false_readings(t_ns, np.where(huge[:, None], np.nan, velocity))
    remaining = known & ~(huge | zeros | repeats)
    unheard = remaining & ~np.isfinite(ranges).any(axis=1)
    if unheard.sum() > MOST_UNHEARD * remaining.sum():  # of an instrument that gives few ranges
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
    """Find velocities that mark lost ones: false zeros, and repeats of the last one.

    Runs of equal velocities are looked at one by one. Zeros are false where the velocity jumps at
    the start or the end of their run as no vehicle starts or stops. Several zeros in a row are also
    false where the sensor is noisy (`_is_noisy`). A noisy sensor does not repeat any other velocity
    for more than LONGEST_HOLD_S either, unless its driver writes each ping several times. The first
    velocity of such a run was measured and is kept.

    velocity: (n, 3) m/s, NaN where lost.

    Returns
    -------
    masks (n,) of the false zeros and of the repeats
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
    # a run is a stretch of equal velocities, from its row in `starts` to before that in `ends`
    starts = np.flatnonzero(np.r_[True, step > 0])
    ends = np.r_[starts[1:], len(known)]
    is_zero = (measured[starts] == 0).all(axis=1)
    longest_usual = LONG_RUN * float(np.median(ends - starts))
    noisy = _is_noisy(measured[starts][~is_zero])
    for start, end, zero in zip(starts, ends, is_zero, strict=True):
        borders = sudden[[row for row in (start - 1, end - 1) if 0 <= row < len(sudden)]]
        if zero:
            zeros[known[start:end]] = len(starts) > 1 and (
                borders.any() or (noisy and end - start > 1)
            )
        elif noisy and end - start > longest_usual and t_s[end - 1] - t_s[start] > LONGEST_HOLD_S:
            repeats[known[start + 1 : end]] = True
    return zeros, repeats


def _is_noisy(velocity: Array) -> bool:
    """Tell whether velocities (n, 3) have noise well above their smallest value.

    Such a sensor does not measure exactly zero by chance, nor the same velocity twice. Noise is
    taken from third differences, in which the motion of a vehicle hardly shows. False for fewer
    than LEAST_PINGS velocities.
    """
    if len(velocity) < LEAST_PINGS:
        return False
    noise = NORMAL_MAD * np.median(np.abs(np.diff(velocity, 3, axis=0)), axis=0) / THIRD_DIFFERENCE
    smallest = np.abs(velocity[velocity != 0]).min()
    return bool(noise.min() > LEAST_NOISE * smallest)


def is_false_attitude(quaternion: Array) -> Mask:
    """Find attitudes (n,) of exactly (0, 0, 0, 1) amid others: a message that was not filled in.

    quaternion: (n, 4) x, y, z, w. The vehicle may also have had just that attitude. It is therefore
    not marked where the attitudes before and after it are close to it. None is marked where most
    attitudes have this value, as for a vehicle at rest.
    """
    default = (np.abs(quaternion) == UNFILLED).all(axis=1)
    others = np.flatnonzero(~default & np.isfinite(quaternion).all(axis=1))
    if not 0 < default.sum() < len(others):
        return np.zeros(len(quaternion), bool)
    rows = np.arange(len(quaternion))
    after = np.searchsorted(others, rows).clip(0, len(others) - 1)
    before = (np.searchsorted(others, rows) - 1).clip(0)
    # w of a unit quaternion is the cosine of half its angle from the default
    turned = np.cos(SUDDEN_TURN_RAD / 2) > np.abs(quaternion[:, 3])
    return np.asarray(default & (turned[others[after]] | turned[others[before]]))


def is_held(t_ns: Ints, quaternion: Array, rates: Array, acceleration: Array) -> Mask:
    """Find readings (n,) that repeat the one before to the last digit for more than a second.

    An IMU on a vehicle that turns has no two equal readings: the IMU or its driver has hung up. The
    first reading of such a run is kept. A run counts if it is longer than a second and longer than
    LONG_RUN times the usual one: some drivers write every reading several times. Runs with rates of
    exactly zero are a simulated vehicle at rest, and are kept.

    Parameters
    ----------
    t_ns : (n,) stamps in order
    quaternion : (n, 4) orientation
    rates, acceleration : (n, 3) as logged
    """
    reading = np.hstack([quaternion, rates, acceleration])
    moved = np.r_[True, (np.diff(reading, axis=0) != 0).any(axis=1)]
    starts = np.flatnonzero(moved)
    ends = np.r_[starts[1:], len(reading)]
    count = ends - starts
    long = (t_ns[ends - 1] - t_ns[starts]) / NS > LONGEST_HOLD_S
    long &= count > LONG_RUN * np.median(count)
    return np.asarray(np.repeat(long, count) & ~moved & (rates != 0).any(axis=1))


def drop_false_beams(ranges: Array, notes: list[Finding]) -> Array:
    """Replace ranges (n, b), m, by NaN that were not measured along the beam they are listed for.

    A driver without ranges writes the altitude into all beams: then all ranges are dropped. A beam
    that hears its own pulse, or a part of the vehicle, stays at one short range while the hull in
    the others comes and goes: then that beam is dropped. Ranges of fewer than LEAST_BEAMS beams or
    LEAST_PINGS pings are returned unchanged. notes: what was dropped is added.
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
        # how far the ranges of a usual other beam vary, m
        spread = float(np.median(np.ptp(np.percentile(others, [5, 95], axis=0), axis=0)))
        own = float(high[beam] - low[beam])
        is_near = middle[beam] < np.median(others, axis=0).min() - spread
        if is_near and own < STANDS_STILL * spread:
            values = {"beam": beam + 1, "low_m": float(low[beam]), "high_m": float(high[beam])}
            notes.append(Finding("beam-stands-still", {**values, "others_m": spread}, "dvl"))
            out[:, beam] = np.nan
    return out


def drop_ranges_at_limit(ranges: Array, notes: list[Finding]) -> Array:
    """Replace ranges (n, b), m, by NaN that are exactly the largest of all and far from the others.

    Such a range is what an instrument writes where no echo came back. Ranges are returned unchanged
    where others come close to the largest, as it may then have been measured, and where there are
    too few to tell. notes: how many were dropped is added.
    """
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


def describe_lost(name: str, good: Mask) -> list[Finding]:
    """Report how many readings of a stream are not finite. good (n,): those that are."""
    lost = int(np.count_nonzero(~good))
    values = {"lost": lost, "count": len(good)}
    return [Finding("readings-not-finite", values, name)] if lost else []
