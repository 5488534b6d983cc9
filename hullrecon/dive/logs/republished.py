# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find readings that a driver published again, with new stamps, until the next one was measured.

Taken for measurements they make a sensor late by half the time between two of them, and as certain
as if it had measured each time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from hullrecon.dive.logs.samples import (
    DepthSample,
    DvlSample,
    ImuSample,
    PositionSample,
    PressureSample,
    Sample,
)
from hullrecon.findings.finding import Finding
from hullrecon.geometry.robust import SIGNIFICANT
from hullrecon.typing import Array, Mask

Kind = TypeVar("Kind", bound=Sample)
LEAST_MEASURED = 20  # readings, to tell a sensor's resolution and how much its values change
# How often a reading is published over how often the median one is. Nine in ten lie within these
# limits: the rates of sensor and driver are no whole multiples
EVEN = (0.5, 2.0)


def drop_republished(name: str, samples: Sequence[Kind], notes: list[Finding]) -> list[Kind]:
    """Keep the first of each group of readings that a driver published several times.

    All are kept where the repeats may be by chance (`find_republished`), and those of servos, which
    may stand still.

    Parameters
    ----------
    name : of the stream, for the notes
    samples : readings of one sensor, in order of time
    notes : a finding of how many were dropped is added
    """
    values = [_values_of(sample) for sample in samples]
    width = max((len(row) for row in values), default=0)
    again = np.zeros(len(samples), bool)
    if width:
        table = np.full((len(values), width), np.nan)
        for row, found in zip(table, values, strict=True):
            row[: len(found)] = found
        again = find_republished(table)
    if again.any():
        counts = {"repeated": int(again.sum()), "count": len(samples)}
        notes.append(Finding("readings-republished", counts, name))
    return [sample for sample, is_old in zip(samples, again.tolist(), strict=True) if not is_old]


def find_republished(values: Array) -> Mask:
    """Find readings that repeat the one before, evenly and more often than by chance.

    Readings of a vehicle at rest, or of a coarse sensor, are alike too, but in runs of all lengths.

    Parameters
    ----------
    values : (n, k) what the sensor measures in each reading, NaN where lost

    Returns
    -------
    mask (n,), all False unless the repeats are a driver's
    """
    known: Mask = np.asarray(np.isfinite(values).any(axis=1))
    lost = np.isnan(values)
    alike = np.all((values[1:] == values[:-1]) | (lost[1:] & lost[:-1]), axis=1)
    again = np.r_[False, alike & known[1:] & known[:-1]]
    by_chance = len(values) * _chance_of_alike(values[~again])
    is_chance = again.sum() <= by_chance + SIGNIFICANT * np.sqrt(by_chance)
    return np.zeros(len(values), bool) if is_chance or not is_even(again) else again


def is_even(again: Mask) -> bool:
    """Tell whether readings that repeat the one before, `again` (n,), come in runs of one length.

    A driver that publishes faster than the sensor measures gives such runs. Nine of ten have to be
    near the median length. False for fewer than LEAST_MEASURED runs.
    """
    starts = np.flatnonzero(~again)
    lengths = np.diff(np.r_[starts, len(again)])
    median_length = float(np.median(lengths)) if len(lengths) else 0.0
    is_near_median = (lengths >= EVEN[0] * median_length) & (lengths <= EVEN[1] * median_length)
    return (
        len(starts) >= LEAST_MEASURED and median_length >= 2 and bool(is_near_median.mean() >= 0.9)
    )


def _chance_of_alike(values: Array) -> float:
    """Bound the probability that two consecutive readings of a sensor are alike by chance.

    It is, for each of the k values (n, k), at most the sensor's resolution over the value's usual
    change. The k values are taken as independent. Values that never change, or are mostly lost, say
    nothing and are passed over.
    """
    chance = 1.0
    for column in values.T:
        found = column[np.isfinite(column)]
        levels = np.unique(found)
        if len(found) < LEAST_MEASURED or len(levels) < 2:
            continue
        change = float(np.median(np.abs(np.diff(found))))
        chance *= min(1.0, float(np.diff(levels).min()) / change) if change > 0 else 1.0
    return chance


def _values_of(sample: Sample) -> Array:
    """Select the values that a sensor measures anew in each reading.

    Empty for sensors that may stand still (servos).
    """
    match sample:
        case DvlSample():
            return np.concatenate([sample.velocity, sample.ranges])
        case ImuSample():  # the driver may publish angular rates more often than orientations
            return sample.quaternion
        case PressureSample():
            return np.array([sample.pascal])
        case DepthSample():
            return np.array([sample.height])
        case PositionSample():
            return sample.place
        case _:
            return np.zeros(0)
