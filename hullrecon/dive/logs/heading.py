# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Take the heading from an IMU's rates: near a ship's steel a compass swings by tens of degrees.

Roll and pitch stay those of the logged orientation, which gravity holds. The bias of the rates
about the vertical is estimated from how the integrated heading drifts away from the compass,
against the prior that gyroscopes are calibrated to BIAS_SIGMA_RAD_S.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.errors import InputError
from hullrecon.records.clock import seconds
from hullrecon.typing import Array, Ints, Mask

# one sigma of the rates' bias that attitude systems with MEMS gyroscopes leave
BIAS_SIGMA_RAD_S = np.radians(0.05)
LONGEST_GAP_S = 1.0  # between readings; over a longer one the orientation gives the turn
LEAST_RATES = 0.9  # share of the readings that need to have rates


@dataclass(frozen=True)
class RateHeading:
    """Attitudes with the heading of the rates."""

    rotation: Rotation  # (n,) from the vehicle to `global`
    drift_rad_s: float  # of the rates' heading against the orientation's; it was taken off
    drift_sigma_rad_s: float
    difference_rad: Array  # (n,) of this heading from the orientation's, once the drift is off
    turned_rad: Array  # (n,) since the start about the vertical, by the rates alone

    @property
    def swing_rad(self) -> float:
        """Root mean square of the difference of the headings."""
        return float(np.sqrt(np.mean(np.square(self.difference_rad))))

    def swing_beyond_scale(self) -> float:
        """Compute the root mean square, rad, that a drift and a scale of the rates do not explain.

        Rates that are too large by a factor turn away from the orientation as the vehicle turns.
        """
        level, drift = np.ones(len(self.turned_rad)), np.arange(len(self.turned_rad))
        design = np.column_stack([level, drift, self.turned_rad])
        fit, *_ = np.linalg.lstsq(design, self.difference_rad, rcond=None)
        return float(np.sqrt(np.mean(np.square(self.difference_rad - design @ fit))))


def heading_by_rates(t_ns: Ints, rotation: Rotation, rates: Array) -> RateHeading:
    """Replace the heading of attitudes by the integral of the rates.

    Where readings are more than LONGEST_GAP_S apart or lack rates, the heading turns as the
    orientation does. The drift of the integral is taken off, and the median of its difference from
    the orientation's heading: that heading stays right on the whole.

    Parameters
    ----------
    t_ns : (n,) stamps
    rotation : (n,) from the vehicle to `global`
    rates : (n, 3) rad/s, in the vehicle

    Raises
    ------
    InputError
        Fewer than LEAST_RATES of the readings have rates.
    """
    known: Mask = np.asarray(np.isfinite(rates).all(axis=1))
    if len(t_ns) < 2 or known.mean() < LEAST_RATES:
        raise InputError(
            "the heading cannot be taken from rates: the IMU's angular velocities were not logged",
            where="imu.heading",
            remedy='give imu.heading = "orientation"',
        )
    t_s = seconds(t_ns, int(t_ns[0]))
    turned = rotation.apply(np.nan_to_num(rates))[:, 2]  # about the vertical, rad/s
    step_s = np.diff(t_s)
    by_orientation = (rotation[1:] * rotation[:-1].inv()).as_rotvec()[:, 2]
    by_rates = 0.5 * (turned[1:] + turned[:-1]) * step_s
    untold = (step_s > LONGEST_GAP_S) | ~known[1:] | ~known[:-1]
    by_rates[untold] = by_orientation[untold]
    # by how much the heading of the rates turns more than that of the orientation, a step, rad
    growth = by_rates - by_orientation
    # heading of the rates minus that of the orientation, rad
    difference = np.concatenate([[0.0], np.cumsum(growth)])
    drift, sigma = _estimate_drift(t_s, difference)
    difference = difference - drift * (t_s - t_s.mean())
    difference = difference - np.median(difference)
    return RateHeading(
        rotation=Rotation.from_euler("z", difference[:, None]) * rotation,
        drift_rad_s=drift,
        drift_sigma_rad_s=sigma,
        difference_rad=difference,
        turned_rad=np.concatenate([[0.0], np.cumsum(by_rates)]),
    )


def _estimate_drift(t_s: Array, difference: Array) -> tuple[float, float]:
    """Estimate the slope, rad/s, of a difference (n,) rad of headings at t_s (n,), and its sigma.

    A line is fitted and combined with the prior that the slope is zero. The residuals of the line
    are correlated, as the compass swings slowly with the ship's steel: they count as one
    independent value for each time that they change sign.
    """
    since = t_s - t_s.mean()
    spread = float(since @ since)
    slope = float(since @ difference) / spread
    residual = difference - difference.mean() - slope * since
    independent = 1 + np.count_nonzero(np.diff(np.signbit(residual)))
    variance = float(residual @ residual) / spread / independent
    weight = variance / (variance + BIAS_SIGMA_RAD_S**2)  # of the prior, a slope of zero
    return (1 - weight) * slope, float(np.sqrt(weight) * BIAS_SIGMA_RAD_S)
