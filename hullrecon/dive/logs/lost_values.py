# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find velocities and ranges of a DVL that are written as numbers but stand for lost ones.

Drivers write a lost velocity as zero, with or without a covariance beyond all measurement, and a
lost range as the largest that the instrument could have.
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
LEAST_NOISE = 3.0  # times its step: a sensor as noisy does not measure exactly zero on three axes
LEAST_PINGS = 20  # to tell a sensor's noise, and that its values are not constant
THIRD_DIFFERENCE = 20**0.5  # of white noise: its standard deviation over the noise's
LEAST_LIMITED = 5  # ranges that are exactly the largest one
CLOSE_TO_LIMIT = 0.9  # of the largest range: one that was measured has others as long


@np.errstate(all="ignore")  # velocities of any size
def drop_lost_velocities(
    t_ns: Ints, velocity: Array, sigma: Array, notes: list[Finding]
) -> tuple[Array, Array]:
    """Replace velocities by NaN that stand for a lost bottom lock.

    Parameters
    ----------
    t_ns : (n,) in order
    velocity : (n, 3) m/s, NaN where lost
    sigma : (n,) m/s, NaN where not given
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
    lost = huge | _false_zeros(t_ns, np.where(huge[:, None], np.nan, velocity))
    if lost.any():
        first, last = np.flatnonzero(lost)[[0, -1]]
        marks: dict[str, object] = {
            "huge": int(huge.sum()),
            "zero": int((lost & ~huge).sum()),
            "limit_m_s": WORST_SIGMA_M_S,
            "start": format_time(int(t_ns[first])),
            "seconds": float(t_ns[last] - t_ns[first]) / NS,
        }
        notes.append(Finding("velocities-marked-lost", marks, "dvl"))
    return np.where(lost[:, None], np.nan, velocity), sigma


def _false_zeros(t_ns: Ints, velocity: Array) -> Mask:
    """Find velocities (n,) of exactly zero that no sensor of this noise would have measured.

    They begin or end as no vehicle stops or starts, or are several in a row of a sensor whose noise
    is well beyond the smallest velocity that it tells from zero.
    """
    out = np.zeros(len(velocity), bool)
    known = np.flatnonzero(np.isfinite(velocity).all(axis=1))
    is_zero = (velocity[known] == 0).all(axis=1)
    if not is_zero.any() or is_zero.all():
        return out
    step = np.linalg.norm(np.diff(velocity[known], axis=0), axis=1)
    sudden = step > SUDDEN_M_S + SUDDEN_M_S2 * np.diff(t_ns[known]) / NS
    noisy = _is_noisy(velocity[known][~is_zero])
    ends = np.flatnonzero(np.diff(is_zero)) + 1
    for run in np.split(np.arange(len(known)), ends):
        if not is_zero[run[0]]:
            continue
        borders = [row for row in (run[0] - 1, run[-1]) if 0 <= row < len(sudden)]
        out[known[run]] = sudden[borders].any() or (noisy and len(run) > 1)
    return out


def _is_noisy(velocity: Array) -> bool:
    """Tell whether velocities (n, 3) have noise well above their smallest value."""
    if len(velocity) < LEAST_PINGS:
        return False
    noise = 1.4826 * np.median(np.abs(np.diff(velocity, 3, axis=0)), axis=0) / THIRD_DIFFERENCE
    smallest = np.abs(velocity[velocity != 0]).min()
    return bool(noise.min() > LEAST_NOISE * smallest)


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
