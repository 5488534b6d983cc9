# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The DVL's usable velocities, and the outages between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.robust import NORMAL_MAD
from hullrecon.navigation.sensors.smoothing import running_median
from hullrecon.records.clock import gaps
from hullrecon.records.sensors import DvlPings
from hullrecon.typing import Array, Ints, Mask

LONGEST_GAP_S = (
    0.6  # between two velocities or attitudes; a longer gap is an outage, bridged and reported
)
# largest departure of an inspection vehicle from its neighbours' median within half a second
OUTLIER_M_S = 0.25
OUTLIER_WITHIN_S = 0.5
OUTLIER_SIGMAS = 8.0
# pings before and after a ping that its median is of, at most, and how far in time they may be; the
# nearest on either side always count
NEIGHBOURS, NEAR_S = 4, 0.9
LEAST_AGITATION = 1e-4  # m2/s3: 0.01 m/s in a second
FIRST_LAG_S = 1.0  # the shortest at which changes are measured


@dataclass(frozen=True, kw_only=True)
class Agitation:
    """How a velocity changes with time: variance of its change over a lag, per second of lag.

    It is the same at all lags for a random walk. For a vehicle that speeds up steadily or turns
    back it grows with the lag.
    """

    lag_s: Array  # (k,)
    rate: Array  # (k,) m2/s3, variance of the change over a lag per second of it, each axis

    def over(self, duration_s: Array) -> Array:
        """Interpolate the rate (m,) for outages of duration_s (m,)."""
        return np.asarray(np.interp(duration_s, self.lag_s, self.rate))


@dataclass(frozen=True, kw_only=True)
class Velocities:
    """Pings with a velocity that is not an outlier."""

    t_ns: Ints  # (n,)
    velocity: Array  # (n, 3) m/s of the instrument in the DVL's frame
    sigma: Array  # (n,) m/s, each axis
    outages: Ints  # (m, 2) intervals without a velocity that were bridged, ns
    agitation: Agitation  # how the velocity changes meanwhile
    outliers: Ints  # stamps of pings rejected

    def bridged_variance(self, start_ns: Ints, stop_ns: Ints) -> Array:
        """Compute the variance (m,), m2, that outages add to the displacement over intervals.

        In an outage of length T the velocity is a random walk between two known ends, which adds
        agitation * T^3 / 12. Before the first and after the last velocity it is one with a single
        known end, which adds agitation * T^3 / 3.

        start_ns, stop_ns: (m,) of the intervals.
        """
        out = np.zeros(len(start_ns))
        for begin, end in self.outages:
            lasts_s = (end - begin) * 1e-9
            # seconds of the outage within each interval, to which its variance is shared out
            inside = np.maximum(0, np.minimum(stop_ns, end) - np.maximum(start_ns, begin)) * 1e-9
            out += self.agitation.over(lasts_s) * lasts_s**2 / 12 * inside
        # how far the interval's two ends lie beyond the record, the nearer end first
        before, after = (
            np.maximum(0, away) * 1e-9
            for away in (
                self.t_ns[0] - np.stack([stop_ns, start_ns]),
                np.stack([start_ns, stop_ns]) - self.t_ns[-1],
            )
        )
        walked = sum(self.agitation.over(away) * away**3 for away in (before, after))
        return np.asarray(out + np.diff(walked, axis=0)[0] / 3)


def usable_velocities(
    dvl: DvlPings, span_ns: tuple[int, int], longest_gap_s: float = LONGEST_GAP_S
) -> Velocities:
    """Select the velocities that are finite, near their neighbours, and within a span (ns).

    Rejected outliers are listed by their stamps. Gaps of more than longest_gap_s between the others
    are outages, across which the path is bridged with a wider sigma. There may be no velocity left.
    """
    finite = (
        np.isfinite(dvl.velocity).all(axis=1)
        & np.isfinite(dvl.velocity_sigma)
        & (dvl.velocity_sigma > 0)
    )
    finite &= (dvl.t_ns >= span_ns[0]) & (dvl.t_ns <= span_ns[1])
    t, v, sigma = dvl.t_ns[finite], dvl.velocity[finite], dvl.velocity_sigma[finite]
    outlier = _find_outliers(t, v)
    t_good, v_good, sigma_good = t[~outlier], v[~outlier], sigma[~outlier]
    return Velocities(
        t_ns=t_good,
        velocity=v_good,
        sigma=sigma_good,
        outages=gaps(t_good, longest_gap_s),
        agitation=_estimate_agitation(t_good, v_good, sigma_good),
        outliers=t[outlier],
    )


def _find_outliers(t_ns: Ints, velocity: Array) -> Mask:
    """Find pings that differ from the running median by a jump and by many robust sigmas.

    A stop that takes less than half of the window looks like outliers. So the window of a slow DVL
    has fewer pings: nine of them are 9 s at 1 Hz. Between the pings of a slow DVL a vehicle may
    also change its velocity by more, so the threshold grows with their period. With fewer pings
    than the window none is an outlier.
    """
    if len(velocity) < 3:
        return np.zeros(len(velocity), bool)
    period_s = float(np.median(np.diff(t_ns))) * 1e-9
    count = 2 * min(NEIGHBOURS, max(1, int(NEAR_S / period_s))) + 1
    if len(velocity) < count:
        return np.zeros(len(velocity), bool)
    away = np.linalg.norm(velocity - running_median(velocity, count), axis=1)
    jump = OUTLIER_M_S * max(1.0, period_s / OUTLIER_WITHIN_S)
    return np.asarray(away > max(jump, OUTLIER_SIGMAS * NORMAL_MAD * float(np.median(away))))


def _estimate_agitation(t_ns: Ints, velocity: Array, sigma: Array) -> Agitation:
    """Estimate the agitation at lags of 1, 2, 4, ... s, up to half of the record.

    With it the sigma of the path across an outage follows from the outage's length. It is the mean
    squared change of the velocity less that of the instrument's noise, of the axis that changes
    most. It is kept from falling with the lag.

    Parameters
    ----------
    t_ns, velocity, sigma
        Stamps (n,) of pings, their velocities (n, 3) and sigmas (n,), m/s. Fewer than 12 give a
        fixed value of 0.01 m2/s3.
    """
    lag, rate = [FIRST_LAG_S], [0.01 if len(t_ns) < 12 else LEAST_AGITATION]
    lasts_ns = int(t_ns[-1] - t_ns[0]) if len(t_ns) else 0
    while len(t_ns) >= 12 and 2e9 * lag[-1] <= lasts_ns:
        # the squared change of the velocity to the first ping after the lag, less its noise
        later = np.searchsorted(t_ns, t_ns + round(1e9 * lag[-1]))
        first = np.flatnonzero(later < len(t_ns))
        later = later[first]
        step_s = (t_ns[later] - t_ns[first]) * 1e-9
        near = step_s < 1.5 * lag[-1]
        noise = sigma[later] ** 2 + sigma[first] ** 2
        change = (velocity[later] - velocity[first]) ** 2 - noise[:, None]
        if near.any():
            rate[-1] = max(rate[-1], float((change / step_s[:, None])[near].mean(axis=0).max()))
        lag.append(2 * lag[-1])
        rate.append(rate[-1])
    return Agitation(lag_s=np.array(lag), rate=np.array(rate))
