# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find steps in an IMU's heading that the vehicle did not make.

They happen where a filter is reset, or a compass finds north again: the orientation steps by
degrees between two readings while the rates go on evenly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.robust import robust_sigma
from hullrecon.navigation.sensors.smoothing import running_median
from hullrecon.records.clock import period
from hullrecon.typing import Array, Ints

BESIDE_S = 1.0  # of readings on either side, whose medians give a step's size
LEAST_STEP_RAD = np.radians(0.5)
STEP_SIGMAS = 8.0  # size of a step in sigmas of such differences of medians along the dive
# share of a step that happens within that time; a slower change may be an error of the rates
SUDDEN_S, SUDDEN = 0.15, 0.6
# values of sliding windows that are copied at a time, to bound the memory
MEDIAN_VALUES = 1_000_000
FASTEST_RAD_S = 1.0  # of a vehicle that inspects, where no rates are logged


@dataclass(frozen=True)
class HeadingSteps:
    """Steps (k) of a heading that the vehicle did not make."""

    row: Ints  # (k,) first reading after each step
    size: Array  # (k,) rad, about z of g
    sigma_rad: float  # of each size
    # (d,) readings about which heading and rates diverge slowly: either may be wrong
    disagreement: Ints
    disagreement_rad: Array  # (d,) size of the divergence

    def taken_off(self, quaternion: Array) -> Array:
        """Remove the steps from quaternions (n, 4): each from the reading after it to the end.

        What diverges slowly stays, as heading or rates may be wrong.
        """
        if len(self.row) == 0:
            return quaternion
        heading = np.zeros(len(quaternion))
        np.add.at(heading, self.row, self.size)
        turned = Rotation.from_euler("z", -np.cumsum(heading)[:, None]) * Rotation.from_quat(
            quaternion
        )
        return np.asarray(turned.as_quat())


NO_STEPS = HeadingSteps(np.zeros(0, np.int64), np.zeros(0), 0.0, np.zeros(0, np.int64), np.zeros(0))


def find_heading_steps(
    t_s: Array, difference: Array, least_rad: float = LEAST_STEP_RAD
) -> HeadingSteps:
    """Find steps in the heading that the rates do not explain.

    The size at each reading is the median of the difference over BESIDE_S after it, minus that
    before it. Peaks of the size are taken from the largest on. A peak is a step where most of it
    happens within SUDDEN_S, else a disagreement of heading and rates. None are found in records
    shorter than four times BESIDE_S, nor with fewer than three readings in BESIDE_S.

    Parameters
    ----------
    t_s
        Times (n,) of the readings.
    difference
        Heading minus integrated rates (n,), rad. It is level but for noise, drift and steps.
    least_rad
        Smallest step.
    """
    count = round(BESIDE_S / period(t_s)) if len(t_s) > 2 else 0
    if count < 3 or len(t_s) < 4 * count:
        return NO_STEPS
    windows = np.lib.stride_tricks.sliding_window_view(difference, count)
    block = max(1, MEDIAN_VALUES // count)
    level = np.concatenate(
        [np.median(windows[k : k + block], axis=-1) for k in range(0, len(windows), block)]
    )
    size = np.zeros(len(difference))  # level after a reading minus the level before it
    size[count : len(difference) - count + 1] = level[count:] - level[:-count]
    sigma = robust_sigma(size[count : len(difference) - count + 1], about=0.0)
    near = max(1, round(SUDDEN_S / period(t_s)))
    row: list[int] = []
    slow: list[int] = []
    peaks = np.where(np.abs(size) > max(least_rad, STEP_SIGMAS * sigma), np.abs(size), 0.0)
    while peaks.max() > 0:
        about = int(np.argmax(peaks))
        begin, end = max(1, about - count), min(len(difference), about + count)
        # the peak is flat: the step itself is where neighbouring readings differ most
        at = begin + int(np.argmax(np.abs(np.diff(difference[begin - 1 : end]))))
        sudden = abs(
            difference[min(at + near, len(difference)) - 1] - difference[max(at - near, 0)]
        )
        if sudden > SUDDEN * peaks[about] and abs(size[at]) > least_rad:
            row.append(at)
        else:
            slow.append(about)
        peaks[begin:end] = 0.0
    rows, slowly = (np.array(sorted(set(found)), np.int64) for found in (row, slow))
    return HeadingSteps(rows, size[rows], float(sigma), slowly, np.abs(size[slowly]))


def find_jumps(t_s: Array, quaternion: Array) -> HeadingSteps:
    """Find steps in a heading without rates, as turns that no vehicle makes.

    t_s, quaternion: (n,) and (n, 4), of the readings. The running median of the turn rate stands in
    for the rates. Only steps too fast for a vehicle (FASTEST_RAD_S) are found, and none in fewer
    than 12 readings. Slow divergences are not reported, as there are no rates to diverge from.
    """
    if len(t_s) < 12:
        return NO_STEPS
    orientation, step = Rotation.from_quat(quaternion), np.diff(t_s)
    turn = orientation[1:].apply((orientation[:-1].inv() * orientation[1:]).as_rotvec())[:, 2]
    excess = turn - running_median((turn / step)[:, None], 9)[:, 0] * step
    least = max(LEAST_STEP_RAD, FASTEST_RAD_S * period(t_s))
    found = find_heading_steps(t_s, np.concatenate([[0.0], np.cumsum(excess)]), least)
    return HeadingSteps(
        found.row, found.size, found.sigma_rad, NO_STEPS.disagreement, NO_STEPS.disagreement_rad
    )
