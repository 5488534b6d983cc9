# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stamps of receipt, and of coarse clocks, are spread to where readings were measured."""

import numpy as np
import pytest

from hullrecon.dive.logs.bursts import spread_bursts
from hullrecon.dive.logs.timeline import put_in_order

NS = 10**9
START = 1_777_887_000 * NS
TRUE = START + np.round((0.07 + np.arange(0.0, 40.0, 0.19)) * NS).astype(np.int64)
RECEIVED = START + -(-(TRUE - START) // NS) * NS + np.arange(len(TRUE)) * 100_000
WHOLE_SECONDS = START + (TRUE - START) // NS * NS


@pytest.mark.parametrize("stamp", [RECEIVED, WHOLE_SECONDS])
def test_bursts_are_spread_to_a_reading(stamp):
    line = put_in_order("dvl", stamp, stamp, spread=True)
    assert len(line.t_ns) == len(TRUE)
    np.testing.assert_allclose(line.t_ns, TRUE[line.keep], atol=0.19 * NS)
    (said,) = line.notes
    assert f"its {len(TRUE)} stamps come in 40 bursts" in said.sentence
    assert "known to some 0.2 s" in said.sentence


def test_times_of_logging_are_taken_where_they_come_one_by_one():
    notes = []
    put = spread_bursts("dvl", WHOLE_SECONDS, TRUE + 4_000_000, notes)
    np.testing.assert_array_equal(put, TRUE + 4_000_000)
    assert "the times of logging were taken" in notes[0].sentence


def test_a_pause_between_bursts_is_no_time_in_which_readings_gathered():
    kept = (TRUE < START + 10 * NS) | (TRUE > START + 30 * NS)
    line = put_in_order("dvl", RECEIVED[kept], RECEIVED[kept], spread=True)
    away = np.abs(line.t_ns - TRUE[kept][line.keep])
    assert np.median(away) < 0.1 * NS
    assert away.max() < 1.2 * NS


def _regular(rng):
    return TRUE + rng.integers(-(10**7), 10**7, len(TRUE))


def _by_event(rng):  # a servo logged at 10 Hz as it turns, for 2 s every 40 s
    turning = (np.arange(0.0, 2.0, 0.1)[None] + 40.0 * np.arange(20)[:, None]).ravel()
    return START + np.round(turning * NS).astype(np.int64)


def _twice(rng):
    return np.repeat(TRUE, 2)


@pytest.mark.parametrize("stamps", [_regular, _by_event, _twice])
def test_other_stamps_stay(stamps):
    stamp, notes = np.sort(stamps(np.random.default_rng(1))), []
    np.testing.assert_array_equal(spread_bursts("dvl", stamp, stamp, notes), stamp)
    assert notes == []
