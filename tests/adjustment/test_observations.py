# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Observations read in blocks."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from adjustment.simulated_dive import simulate
from adjustment.test_assembly import true_state

from hullrecon.adjustment.problem import observations
from hullrecon.adjustment.problem.observations import read_blocks
from hullrecon.adjustment.problem.selection import find_landmarks
from hullrecon.artifacts.stage import map_arrays
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.tracks import Tracks


@pytest.fixture(scope="module")
def dive():
    return simulate()


@pytest.mark.parametrize("size", [3, 64])
def test_blocks_of_any_size_find_the_same(dive, monkeypatch, size):
    state, found = true_state(dive), []
    for rows in (1 << 16, size):
        monkeypatch.setattr(observations, "ROWS", rows)
        after, chosen = find_landmarks(dive.measured, state, 2.0)
        found.append([after.landmark, *vars(chosen).values()])
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-12)


def test_blocks_hold_whole_landmarks_and_only_those_asked_for(dive, monkeypatch):
    monkeypatch.setattr(observations, "ROWS", 64)
    tracks = dive.measured.tracks
    of = np.arange(len(tracks.color)) % 3 == 0
    blocks = list(read_blocks(dive.measured, of))
    assert len(blocks) > 5
    rows = np.concatenate([block.rows for block in blocks])
    np.testing.assert_array_equal(rows, np.flatnonzero(of[tracks.landmark]))
    ends = [(block.tracks.landmark[0], block.tracks.landmark[-1]) for block in blocks]
    assert all(last < first for (_, last), (first, _) in itertools.pairwise(ends))


def test_tracks_mapped_from_a_file_are_read_as_they_were_written(dive, tmp_path, monkeypatch):
    monkeypatch.setattr(observations, "ROWS", 64)
    np.savez(tmp_path / "tracks.npz", **to_arrays(dive.measured.tracks))
    mapped = from_arrays(Tracks, map_arrays(tmp_path / "tracks.npz"))
    assert isinstance(mapped.top, np.memmap)
    of_file = read_blocks(replace(dive.measured, tracks=mapped))
    for one, other in zip(of_file, read_blocks(dive.measured), strict=True):
        for name in ("landmark", "node", "top", "bottom", "response"):
            np.testing.assert_array_equal(getattr(one.tracks, name), getattr(other.tracks, name))
