# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tell readings of two sensors, which share a topic or a table, from those of one.

Two sensors that take turns give two groups of values: what one sensor adds by noise and motion from
reading to reading is small beside what parts it from the other.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from hullrecon.errors import InputError
from hullrecon.typing import Array

WINDOW = 20  # readings that are looked at together
LEAST_OF_ONE = 2  # of a window: a sensor that sends a tenth of the messages
LEAST_TURNS = 3  # from one group to the other within a window
APART = 5.0  # times as wide as both groups together, for white noise some 0.2
LEAST_STEPS = 2.5  # smallest differences that a coarse sensor tells, between two groups
SHARE = 0.2  # of the windows: two servos may stand at one angle for most of a dive
ROUNDING = 1e-9  # of the largest difference


def refuse_two_sensors(sensor: str, away: Array, unit: str, leave_away: str = "") -> None:
    """Raise InputError where readings are those of two sensors in turn.

    Parameters
    ----------
    sensor : whose they are to be
    away : (w, WINDOW) how far each reading of a window is from the first of the window
    unit : of these, for what is said
    leave_away : how the sensor is left away, "" where no run goes on without
    """
    if len(away) == 0:
        return
    # In each window, the widest gap between two values parts the readings into two groups. How far
    # apart the values are without that gap is what one sensor adds.
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
    """Cut values (n, ...) into windows (w, WINDOW, ...) that follow each other."""
    if len(values) < WINDOW:
        return np.zeros((0, WINDOW, *values.shape[1:]))
    return np.moveaxis(sliding_window_view(values, WINDOW, axis=0)[::WINDOW], -1, 1)
