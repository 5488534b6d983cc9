# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read the observations of landmarks in blocks, as those of a long dive do not fit into memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from hullrecon.adjustment.problem.lens import displacement
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.geometry.frames import Camera
from hullrecon.records.tracks import Tracks
from hullrecon.rows import read_rows
from hullrecon.threads import in_threads
from hullrecon.typing import Array, Ints, Mask

ROWS = 1 << 15  # of a block: with some 300 bytes each, triangulation works within the cache
BLOCKS_AT_A_TIME = 2  # in threads: what is computed of a block takes some 20 MB
Result = TypeVar("Result")


@dataclass(frozen=True, kw_only=True)
class Block:
    """All observations of some landmarks."""

    rows: Ints | slice  # rows of the dive's tracks that the block holds
    tracks: Tracks  # these rows. Its colours are those of all landmarks of the dive

    @property
    def landmarks(self) -> slice:
        """The range of landmark numbers from the block's first to its last."""
        number = self.tracks.landmark
        return slice(int(number.min()), int(number.max()) + 1)

    @property
    def numbered_from_0(self) -> Tracks:
        """The rows, with landmarks numbered from 0 on at the start of `landmarks`."""
        return replace(self.tracks, landmark=self.tracks.landmark - self.landmarks.start)


def landmark_count(m: Measurements) -> int:
    """Count the landmarks of the tracks."""
    return 0 if m.tracks is None else len(m.tracks.color)


def map_blocks(
    m: Measurements, work: Callable[[Block], Result], wanted: Mask | None = None
) -> Iterator[Result]:
    """Yield what `work` computes from each block of whole landmarks, in threads.

    The lenses' displacements are applied to the pixels. Nothing is yielded without tracks.

    Parameters
    ----------
    m
        With the tracks, which may be mapped from a file, and the displacements found so far.
    work
        Computes from one block alone.
    wanted
        (L,) landmarks whose observations are read. None: all.
    """
    tracks = m.tracks
    if tracks is None:
        return

    def make(rows: slice) -> list[Result]:
        return [
            work(replace(b, tracks=_moved(m, b.tracks))) for b in _read_block(tracks, rows, wanted)
        ]

    every = [rows for rows, _ in _whole_landmarks(tracks.landmark)]
    for made in in_threads(make, every, most=BLOCKS_AT_A_TIME):
        yield from made


def read_blocks(m: Measurements, wanted: Mask | None = None) -> Iterator[Block]:
    """Read observations in blocks of whole landmarks, with the lenses' displacements applied."""
    return map_blocks(m, lambda block: block, wanted)


def read_tracks(tracks: Tracks | None, wanted: Mask | None = None) -> Iterator[Block]:
    """Read tracks in blocks as `read_blocks` does, but with the pixels as they were detected."""
    if tracks is not None:
        for rows, _ in _whole_landmarks(tracks.landmark):
            yield from _read_block(tracks, rows, wanted)


def _read_block(tracks: Tracks, rows: slice, wanted: Mask | None) -> list[Block]:
    """Read rows of tracks as a block. Empty where no row is of a wanted landmark.

    wanted (L,): landmarks whose rows are read. None: all.
    """
    landmark = read_rows(tracks.landmark, rows)
    if wanted is None:
        return [Block(rows=rows, tracks=_read(tracks, landmark, rows))]
    kept = np.flatnonzero(wanted[landmark])
    if not len(kept):
        return []
    return [Block(rows=rows.start + kept, tracks=_read(tracks, landmark, rows).take(kept))]


def first_nodes(m: Measurements) -> Ints:
    """Find the first node (L,) that observed each landmark. Without one, the maximum of int64."""
    first = np.full(landmark_count(m), np.iinfo(np.int64).max)
    if m.tracks is not None:
        for rows, landmark in _whole_landmarks(m.tracks.landmark):
            np.minimum.at(first, landmark, read_rows(m.tracks.node, rows))
    return first


def _whole_landmarks(landmark: Ints) -> Iterator[tuple[slice, Ints]]:
    """Yield slices of about ROWS rows that end where a landmark ends, with their landmarks.

    landmark (m,): of each row, ascending. It may be mapped from a file, and is read by slices.
    """
    first, size = 0, ROWS
    while first < len(landmark):
        own = read_rows(landmark, slice(first, first + size))
        if first + len(own) < len(landmark):
            # The last landmark may go on in the next rows
            own = own[: np.searchsorted(own, own[-1])]
        if not len(own):
            size *= 2  # one landmark has more rows than a block
            continue
        yield slice(first, first + len(own)), own
        first, size = first + len(own), ROWS


def _read(tracks: Tracks, landmark: Ints, rows: slice) -> Tracks:
    """Read rows of tracks into memory. landmark: of these rows, read before."""
    return Tracks(
        landmark=landmark,
        node=read_rows(tracks.node, rows),
        top=read_rows(tracks.top, rows),
        bottom=read_rows(tracks.bottom, rows),
        response=read_rows(tracks.response, rows),
        color=tracks.color,
    )


def _moved(m: Measurements, tracks: Tracks) -> Tracks:
    """Move pixels by the lens displacements that each round found, one after the other."""
    return replace(
        tracks,
        top=_moved_pixels(m, Camera.TOP, tracks.top),
        bottom=_moved_pixels(m, Camera.BOTTOM, tracks.bottom),
    )


def _moved_pixels(m: Measurements, camera: Camera, pixels: Array) -> Array:
    """Move raw pixels (n, 2) of a camera by its lens displacements."""
    model = m.rig.camera_models.get(camera)
    if model is not None:
        for found in m.lens_steps:
            pixels = pixels + displacement(pixels, model, found[camera.column])
    return pixels
