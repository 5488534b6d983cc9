# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Readings that were published again, beside such as are alike because nothing moved."""

import numpy as np

from hullrecon.dive.logs.republished import drop_republished, find_republished
from hullrecon.dive.logs.samples import PressureSample
from hullrecon.findings.finding import sentences

NOISE = np.random.default_rng(4).standard_normal((60, 3))


def test_the_first_of_pings_that_were_published_again_is_kept():
    times = np.array([4, 3, 4, 5, 4, 4] * 10)
    again = find_republished(np.repeat(NOISE, times, axis=0))
    assert (~again).sum() == 60
    assert (np.flatnonzero(~again) == np.cumsum(times) - times).all()


def test_readings_of_a_coarse_sensor_or_at_rest_are_kept():
    coarse = np.round(0.3 * np.repeat(NOISE[:, :1], 4, axis=0) * np.arange(240)[:, None] / 240, 0)
    pauses = np.repeat(NOISE, [1, 1, 1, 1, 1, 40] * 10, axis=0)
    for values in (NOISE, coarse, pauses, np.zeros((100, 3))):
        assert not find_republished(values).any()


def test_a_pressure_that_was_published_again_is_named():
    samples = [PressureSample(t, 1e5 + 100 * NOISE[t // 5, 0]) for t in range(300)]
    notes = []
    assert len(drop_republished("pressure", samples, notes)) == 60
    assert "240 of 300 readings repeat the one before" in sentences(notes)[0]
