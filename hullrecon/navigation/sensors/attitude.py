# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Attitude at any time: the slow part from the IMU's orientation, the fast part from its rates.

An orientation is noisy from one reading to the next and true in the long run. Integrated rates are
the reverse. So the difference of the two is smoothed and added to the integrated rates. The width
of the smoothing follows from the noise of both, which is estimated from that difference.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses, interpolate
from hullrecon.geometry.robust import NORMAL_MAD
from hullrecon.navigation.sensors.heading_steps import (
    BESIDE_S,
    NO_STEPS,
    HeadingSteps,
    find_heading_steps,
    find_jumps,
)
from hullrecon.navigation.sensors.smoothing import local_line
from hullrecon.navigation.sensors.velocity import LONGEST_GAP_S
from hullrecon.records.clock import gaps, longest_step, period, seconds
from hullrecon.records.sensors import ImuSamples
from hullrecon.typing import Array, Ints

# smallest sigma of a turn between two nodes: jitter of the stamps, and play of the mount
LEAST_SIGMA_RAD = 1e-4
# sigma of the rate at which an inspecting vehicle turns between readings
BRIDGED_RATE_RAD_S = 0.05
# time for which it turns one way; before the first and after the last reading its turns are a
# random walk beyond that time
BRIDGED_FOR_S = 4.0
LONGEST_LAG_S = 2.0  # over which the noise is estimated
WIDEST_WINDOW_S = 5.0  # sigma of the widest window in which orientations are smoothed by rates


@dataclass(frozen=True)
class AttitudeHistory:
    """Attitude global_from_vehicle at the IMU's stamps."""

    t_ns: Ints
    quaternion: Array  # (n, 4)
    sigma_rad: float  # white error of one attitude after smoothing
    walk: float  # variance of a turn by the rates alone, rad2/s
    holes: Ints  # (m, 2) intervals without readings, ns
    fused: bool  # rates were used
    steps: HeadingSteps = NO_STEPS  # jumps of the logged heading that were taken off

    def rotation(self, at_ns: Ints) -> Rotation:
        """Interpolate R_g_v (m) at times (m,), constant beyond the ends."""
        held = Poses(self.quaternion, np.zeros((len(self.quaternion), 3)))
        return interpolate(self.t_ns, held, at_ns).rotation

    def turn_variance(self, start_ns: Ints, stop_ns: Ints) -> Array:
        """Compute the variance (m,) rad2, each axis, of the turn between two instants.

        With it the turns between nodes are weighted. Over short times it is the walk of the rates,
        over long ones twice the variance of an attitude. Holes in the record, steps of the heading
        and times beyond the readings add to it.
        """
        limit = 2 * self.sigma_rad**2
        short = self.walk * (stop_ns - start_ns) * 1e-9
        # grows as the walk at first, and levels off at the limit
        bound = limit * -np.expm1(-short / limit) if self.fused else np.full(len(start_ns), limit)
        hole_s = np.zeros(len(start_ns))
        for begin, end in self.holes:
            hole_s += np.maximum(0, np.minimum(stop_ns, end) - np.maximum(start_ns, begin)) * 1e-9
        by_steps = self.variance_of_steps(stop_ns) - self.variance_of_steps(start_ns)
        beyond = self.variance_of_unread_turns(stop_ns) - self.variance_of_unread_turns(start_ns)
        return np.asarray(
            bound + LEAST_SIGMA_RAD**2 + (BRIDGED_RATE_RAD_S * hole_s) ** 2 + by_steps + beyond
        )

    def variance_of_unread_turns(self, at_ns: Ints) -> Array:
        """Compute the variance (m,), rad2, each axis, of the turn from the last reading to a time.

        Zero within the record, and negative before the first reading, so that the difference of two
        times is the variance of the turn between them.
        """
        after, before = (
            np.maximum(0, at_ns - self.t_ns[-1]) * 1e-9,
            np.maximum(0, self.t_ns[0] - at_ns) * 1e-9,
        )
        seconds2 = (
            np.minimum(after, BRIDGED_FOR_S) * after - np.minimum(before, BRIDGED_FOR_S) * before
        )
        return np.asarray(BRIDGED_RATE_RAD_S**2 * seconds2)

    def variance_of_steps(self, at_ns: Ints) -> Array:
        """Accumulate the variance (m,) rad2, about z of g, of the heading's steps up to times (m,).

        The difference of two times is the variance of the turn between them. A step that was taken
        off leaves the variance of its size. Where heading and rates diverge slowly, the whole
        divergence counts.
        """
        out = self.steps.sigma_rad**2 * np.searchsorted(
            self.t_ns[self.steps.row], at_ns, side="right"
        ).astype(float)
        reach = round(BESIDE_S * 1e9)
        for at, apart in zip(
            self.t_ns[self.steps.disagreement], self.steps.disagreement_rad, strict=True
        ):
            # the divergence is spread evenly over BESIDE_S on either side of its reading
            out += apart**2 * np.clip((at_ns - at + reach) / (2 * reach), 0.0, 1.0)
        return np.asarray(out)

    def holes_before(self, at_ns: Ints) -> Ints:
        """Count the holes (m,) that have begun by times (m,)."""
        return (
            np.asarray(np.searchsorted(self.holes[:, 0], at_ns))
            if len(self.holes)
            else np.zeros(len(at_ns), np.int64)
        )

    def hole_sigma(self, at_ns: Ints) -> Array:
        """Compute the sigma (m,) rad, each axis, of an attitude in a hole. 0 outside holes."""
        out = np.zeros(len(at_ns))
        for begin, end in self.holes:
            inside = (at_ns > begin) & (at_ns < end)
            out[inside] = BRIDGED_RATE_RAD_S * np.minimum(at_ns - begin, end - at_ns)[inside] * 1e-9
        return out

    def unread_sigma(self, at_ns: Ints) -> Array:
        """Compute the sigma (m,) rad, each axis, of attitudes in holes or beyond the readings."""
        return np.hypot(
            np.sqrt(np.abs(self.variance_of_unread_turns(at_ns))), self.hole_sigma(at_ns)
        )


def attitude_history(
    imu: ImuSamples, sigma_tilt_rad: float, longest_gap_s: float = LONGEST_GAP_S
) -> AttitudeHistory:
    """Smooth an IMU's orientation by its rates, and take off steps of its heading.

    With fewer than 50 readings or without rates nothing is smoothed: only jumps of the heading are
    taken off.

    Parameters
    ----------
    imu
        Orientations and rates, in time order. All orientations are known.
    sigma_tilt_rad
        White error of roll and pitch where no rates can show it.
    longest_gap_s
        Between readings; a longer one is a hole.
    """
    holes = gaps(imu.t_ns, longest_gap_s)
    t = seconds(imu.t_ns, int(imu.t_ns[0]))
    if len(imu.t_ns) < 50 or np.isfinite(imu.angular_velocity).all(axis=1).mean() < 0.99:
        steps = find_jumps(t, imu.quaternion)
        return AttitudeHistory(
            imu.t_ns, steps.taken_off(imu.quaternion), sigma_tilt_rad, 0.0, holes, False, steps
        )
    steps = find_heading_steps(t, _orientation_minus_rates(t, imu)[:, 2])
    imu = replace(imu, quaternion=steps.taken_off(imu.quaternion))
    difference = _orientation_minus_rates(t, imu)
    white, walk = _estimate_noise(t, difference)
    period_s = period(t)
    # The wider the window, the less noise it leaves, and the more of the drift it smooths away
    width_s = float(
        np.clip(np.sqrt(white * period_s / max(walk, 1e-12)), 3 * period_s, WIDEST_WINDOW_S)
    )
    slow, _ = local_line(t, difference, t, width_s)
    # the orientation less the difference is the integrated rates, to which the smooth part is added
    smooth = Rotation.from_rotvec(slow - difference) * Rotation.from_quat(imu.quaternion)
    # sigma of white noise that a Gaussian of that width leaves
    smoothed = np.sqrt(2 * white * period_s / (2 * np.sqrt(np.pi) * width_s))
    sigma_rad = max(float(np.hypot(smoothed, _turn_within_jitter(t, imu))), LEAST_SIGMA_RAD)
    return AttitudeHistory(imu.t_ns, smooth.as_quat(), sigma_rad, walk, holes, True, steps)


def _turn_within_jitter(t: Array, imu: ImuSamples) -> float:
    """Estimate the turn about an axis, rad, within the jitter of the stamps.

    Both are root mean squares. Stamps are uneven where readings come in bursts.
    """
    step, usual = np.diff(t), period(t)
    jitter_s = np.sqrt(np.mean(np.square(step[step <= longest_step(usual)] - usual)))
    return float(jitter_s * np.sqrt(np.nanmean(np.square(imu.angular_velocity))))


def _orientation_minus_rates(t: Array, imu: ImuSamples) -> Array:
    """Compute the rotation vector in g (n, 3), rad, from the integrated rates to the orientation.

    t: (n,) s, of the readings. The rates' mean bias is taken off. Where readings are missing
    nothing is added. Small rotations are summed as vectors: the sum wanders by far less than a
    degree, so that their order does not matter.
    """
    row = np.arange(len(t))
    known = np.isfinite(imu.angular_velocity).all(axis=1)
    rate = np.stack([np.interp(row, row[known], w[known]) for w in imu.angular_velocity.T], axis=1)
    orientation = Rotation.from_quat(imu.quaternion)
    step = np.diff(t)[:, None]
    turned = (orientation[:-1].inv() * orientation[1:]).as_rotvec()
    growth = turned - 0.5 * (rate[1:] + rate[:-1]) * step
    usual = step[:, 0] < longest_step(period(t))
    bias = growth[usual].sum(axis=0) / step[usual].sum()
    growth = np.where(usual[:, None], growth - bias * step, 0.0)
    return np.vstack([np.zeros(3), np.cumsum(orientation[1:].apply(growth), axis=0)])


def _estimate_noise(t: Array, difference: Array) -> tuple[float, float]:
    """Estimate the white variance (rad2) of the orientation and the walk (rad2/s) of the rates.

    The walk is the variance that integrated rates gain in each second. Both set how wide the
    smoothing is. The variance of differences over a lag is twice the white variance plus the walk
    times the lag. A line through these variances at several lags gives both. The variances are
    robust, from median absolute differences, so that a jolt does not count.

    Parameters
    ----------
    t
        (n,) s.
    difference
        (n, 3) rad, rotation by the orientation minus that by the rates.
    """
    step = period(t)
    lags = np.unique(np.geomspace(1, max(2, LONGEST_LAG_S / step), 12).astype(int))
    lags = lags[lags < len(t) // 2]
    spread = [
        np.mean((NORMAL_MAD * np.median(np.abs(difference[lag:] - difference[:-lag]), axis=0)) ** 2)
        for lag in lags
    ]
    design = np.stack([np.full(len(lags), 2.0), lags * step], axis=1)
    white, walk = np.linalg.lstsq(design, np.asarray(spread), rcond=None)[0]
    return max(float(white), 1e-12), max(float(walk), 1e-10)
