# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The DVL's velocities that can be used, and what lies between them when the bottom is lost."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.robust import NORMAL_MAD
from hullrecon.navigation.sensors.clock import gaps
from hullrecon.navigation.sensors.smoothing import running_median
from hullrecon.records.sensors import DvlPings
from hullrecon.typing import Array, Ints, Mask

OUTLIER_M_S = 0.25  # no inspection vehicle leaves the median of its neighbours by more in a second
OUTLIER_SIGMAS = 8.0


@dataclass(frozen=True, kw_only=True)
class Velocities:
    """Pings with a velocity: t_ns (n,), velocity (n, 3) m/s of the instrument in dvl, sigma (n,) m/s each axis. outages (m, 2):
    intervals without one that were bridged, ns. agitation: variance of a velocity's change, m2/s3. outliers: pings rejected."""

    t_ns: Ints
    velocity: Array
    sigma: Array
    outages: Ints
    agitation: float
    outliers: Ints

    def bridged_variance(self, start_ns: Ints, stop_ns: Ints) -> Array:
        """Return variance (m,) m2 that intervals add where they lie in an outage of length T: that of a velocity that walks
        between its two known ends adds up to agitation T^3 / 12 over the whole."""
        out = np.zeros(len(start_ns))
        for begin, end in self.outages:
            inside = np.maximum(0, np.minimum(stop_ns, end) - np.maximum(start_ns, begin)) * 1e-9
            out += self.agitation * ((end - begin) * 1e-9) ** 2 / 12 * inside
        return out


def usable_velocities(dvl: DvlPings, span_ns: tuple[int, int], longest_gap_s: float) -> Velocities:
    """Return the velocities that are finite, near their neighbours, and within the span that the attitude covers (ns)."""
    finite = np.isfinite(dvl.velocity).all(axis=1) & np.isfinite(dvl.velocity_sigma) & (dvl.velocity_sigma > 0)
    finite &= (dvl.t_ns >= span_ns[0]) & (dvl.t_ns <= span_ns[1])
    t, v, sigma = dvl.t_ns[finite], dvl.velocity[finite], dvl.velocity_sigma[finite]
    outlier = _find_outliers(v)
    t_good, v_good, sigma_good = t[~outlier], v[~outlier], sigma[~outlier]
    return Velocities(
        t_ns=t_good,
        velocity=v_good,
        sigma=sigma_good,
        outages=gaps(t_good, longest_gap_s),
        agitation=_agitation(t_good, v_good, sigma_good),
        outliers=t[outlier],
    )


def _find_outliers(velocity: Array, count: int = 9) -> Mask:
    """Return pings that leave the running median by a jump and by many robust sigma of that."""
    if len(velocity) < count:
        return np.zeros(len(velocity), bool)
    away = np.linalg.norm(velocity - running_median(velocity, count), axis=1)
    return np.asarray(away > max(OUTLIER_M_S, OUTLIER_SIGMAS * NORMAL_MAD * float(np.median(away))))


def _agitation(t_ns: Ints, velocity: Array, sigma: Array) -> float:
    """Return the agitation from the changes over a second or so, less the instrument's noise; at least that of 0.01 m/s in a
    second."""
    if len(t_ns) < 12:
        return 0.01
    step = (t_ns[5:] - t_ns[:-5]) * 1e-9
    change = (velocity[5:] - velocity[:-5]) ** 2 - (sigma[5:] ** 2 + sigma[:-5] ** 2)[:, None]
    return max(float(np.mean(change / step[:, None])), 1e-4)
