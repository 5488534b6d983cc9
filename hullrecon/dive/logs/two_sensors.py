# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tell readings of two sensors, which share a topic or a table, from those of one.

Two sensors that take turns give two groups of values. Noise and motion move the values of one
sensor from reading to reading by little, compared with the gap between the two sensors.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from hullrecon.errors import InputError
from hullrecon.typing import Array

WINDOW = 20  # readings that are looked at together
LEAST_OF_ONE = 2  # readings of a window in the smaller group: a tenth of the messages
LEAST_TURNS = 3  # from one group to the other within a window
APART = 5.0  # gap between the groups over the width of both together, for white noise some 0.2
LEAST_STEPS = 2.5  # gap between the groups in steps of a sensor's resolution
SHARE = 0.2  # of the windows with two groups: two servos may stand at one angle for most of a dive
ROUNDING = 1e-9  # of the largest difference; smaller differences are rounding, not resolution


def refuse_two_sensors(sensor: str, away: Array, unit: str, leave_away: str = "") -> None:
    """Raise InputError where readings are those of two sensors in turn.

    Neither is the right one, and their mixture would be taken for noise. Readings that fill no
    window are accepted.

    Parameters
    ----------
    sensor : name of the stream, for the message
    away : (w, WINDOW) how far each reading of a window is from the first of the window
    unit : of `away`, for the message
    leave_away : for the message, how to run without the sensor, "" where no run can
    """
    if len(away) == 0:
        return
    # In each window, the widest gap between two values parts the readings into two groups. How far
    # apart the values are without that gap is by noise and motion.
    ordered = np.sort(away, axis=1)
    gaps = np.diff(ordered, axis=1)
    at = gaps.argmax(axis=1)
    rows = np.arange(len(away))
    gap = gaps[rows, at]
    within = (ordered[:, -1] - ordered[:, 0]) - gap
    # how often readings go from one group to the other, and how many the smaller one has
    is_far = away > (ordered[rows, at] + gap / 2)[:, None]
    turns = (np.diff(is_far.astype(np.int8), axis=1) != 0).sum(axis=1)
    fewer = np.minimum(is_far.sum(axis=1), (~is_far).sum(axis=1))
    # a coarse sensor between two of its values has no other differences than one step
    steps = gaps[gaps > ROUNDING * gaps.max()]
    coarse = LEAST_STEPS * (steps.min() if steps.size else np.inf)
    parted = (fewer >= LEAST_OF_ONE) & (turns >= LEAST_TURNS) & (gap > APART * within)
    parted &= gap > coarse
    if parted.mean() < SHARE:
        return
    raise InputError(
        f"its readings jump by about {np.median(gap[parted]):.3g} {unit} to and fro, from one to "
        "the next: they are of two sensors in turn, or lost ones are written as a number",
        where=sensor,
        remedy="give a log in which each sensor has a topic or a table of its own"
        + (f", or {leave_away}" if leave_away else ""),
    )


def windows(values: Array) -> Array:
    """Cut values (n, ...) into windows (w, WINDOW, ...) that follow each other.

    Values that fill no window at the end are left out.
    """
    if len(values) < WINDOW:
        return np.zeros((0, WINDOW, *values.shape[1:]))
    return np.moveaxis(sliding_window_view(values, WINDOW, axis=0)[::WINDOW], -1, 1)
