# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Simulated side-scan sonar of a sea floor with targets, and with what resembles them.

A tile has a ping a row. Its columns lie on the port side, so ground range falls to the right, the
sonar is beyond the right edge, and a shadow falls to the left of what casts it, as in the features
of [Aulinas2011 Fig. 4.13].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import cv2
import numpy as np

from hullrecon.typing import Array, Floats32

ALTITUDE_M = 4.0  # a vehicle at 12 m over a floor at 16 m [Aulinas2011 5.2.3]
NEAR_M, FAR_M = 12.0, 47.0  # ground range of a tile
ACROSS_M, ALONG_M = 0.05, 0.1  # of a pixel
LANE_M = 2.6  # along the track, for one thing
RANGES_M = (15.0, 38.0)  # ground range of things
LOOKS = 3  # of the speckle: independent intensities averaged in a pixel
FLOOR_LEVEL = 70.0  # grey level of the floor where the gain is right
BEAM_RAD = 0.007  # width of the beam along the track, which blurs with range


class Kind(StrEnum):
    """What lies on the floor."""

    TARGET = "target"  # stands up: a highlight, and its shadow behind it
    BRIGHT = "bright only"  # a flat hard patch or a fish
    DARK = "dark only"  # mud
    HOLLOW = "hollow"  # shadow first, and the lit far wall behind it
    FLOOR = "floor"


@dataclass(frozen=True, kw_only=True)
class Thing:
    """A thing on the floor as the sonar draws it."""

    kind: Kind
    along_m: float  # middle, along the track
    range_m: float  # ground range of its near edge
    width_m: float  # along the track
    highlight_m: float  # across; zero without one
    shadow_m: float  # across; zero without one
    brightness: float  # amplitude of the highlight over the floor's
    shade: float  # the same of the shadow: what is left is noise and multiple scattering

    @property
    def length_m(self) -> float:
        """Compute its extent across the track, highlight and shadow."""
        return self.highlight_m + self.shadow_m


def draw_thing(
    rng: np.random.Generator,
    kind: Kind,
    along_m: float,
    range_m: float,
    altitude_m: float = ALTITUDE_M,
) -> Thing:
    """Draw the size and brightness of a thing at a place, at random around those of a mine.

    A target has a flank of 45 degrees, seen as a highlight as long as it is high. A height h casts
    a shadow of h R / (H - h) at ground range R below a sonar at altitude H, so shadow and
    highlight are as R to H - h. What is bright or dark alone has the same extents.
    """
    height_m = rng.uniform(0.3, 0.5)
    shadow_m = height_m * (range_m + height_m) / (altitude_m - height_m)
    return Thing(
        kind=kind,
        along_m=along_m,
        range_m=range_m,
        width_m=rng.uniform(0.8, 1.4),
        highlight_m=0.0 if kind is Kind.DARK else height_m,
        shadow_m=0.0 if kind is Kind.BRIGHT else shadow_m,
        brightness=rng.uniform(2.2, 4.0),
        shade=rng.uniform(0.1, 0.4),
    )


def draw_tile(rng: np.random.Generator, rows: int, things: Sequence[Thing]) -> Array:
    """Draw a tile in grey levels (rows, columns), 0 to 255.

    The floor has patches and ripples, multiplied by speckle and by a gain that is wrong by up to
    30 per cent over the range.
    """
    columns = round((FAR_M - NEAR_M) / ACROSS_M)
    amplitude = _floor(rng, rows, columns)
    for thing in things:
        _paint(amplitude, thing)
    amplitude = _seen_by_beam(amplitude)
    speckle = np.sqrt(rng.gamma(LOOKS, 1.0 / LOOKS, (rows, columns)))
    gain = 1.0 + 0.3 * np.sin(np.linspace(0, 1, columns) * rng.uniform(2, 5) + rng.uniform(0, 6))
    return np.asarray(np.clip(FLOOR_LEVEL * gain * amplitude * speckle, 0, 255))


def scatter_things(rng: np.random.Generator, kinds: Sequence[Kind]) -> list[Thing]:
    """Draw a thing of each kind in a lane of its own, in random order and at random ranges."""
    along = (rng.permutation(len(kinds)) + 0.5) * LANE_M
    ranges = rng.uniform(*RANGES_M, len(kinds))
    return [draw_thing(rng, *it) for it in zip(kinds, along, ranges, strict=True)]


def rows_of_lanes(lanes: int) -> int:
    """Count the rows of a tile with that many lanes."""
    return row_of(lanes * LANE_M)


def level_over_range(tile: Array) -> Floats32:
    """Divide a tile by the floor's level at each range: the gain goes, and the floor is 1."""
    return np.asarray(tile / np.maximum(np.median(tile, axis=0), 1.0), dtype=np.float32)


def column_of(range_m: float) -> int:
    """Find the column of a ground range."""
    return round((FAR_M - range_m) / ACROSS_M)


def row_of(along_m: float) -> int:
    """Find the row of a place along the track."""
    return round(along_m / ALONG_M)


def _floor(rng: np.random.Generator, rows: int, columns: int) -> Array:
    """Simulate the floor's amplitude (rows, columns), around 1: soft patches, and ripples."""
    patches = rng.standard_normal((rows // 8 + 2, columns // 16 + 2))
    smooth = cv2.GaussianBlur(cv2.resize(patches, (columns, rows)), (0, 0), 8)
    wave, heading = rng.uniform(0.8, 2.0), rng.uniform(0, np.pi)
    y, x = np.meshgrid(np.arange(rows) * ALONG_M, np.arange(columns) * ACROSS_M, indexing="ij")
    ripple = np.sin(2 * np.pi / wave * (x * np.cos(heading) + y * np.sin(heading)))
    strength = rng.uniform(0.0, 0.2)
    return np.asarray(1.0 + 0.1 * smooth / smooth.std() + strength * ripple)


def _seen_by_beam(amplitude: Array) -> Array:
    """Blur the floor's amplitude (rows, columns) along the track by the width of the beam.

    That grows with range, which is taken as constant over bands of 5 m.
    """
    seen = np.empty_like(amplitude)
    band = round(5.0 / ACROSS_M)
    for start in range(0, amplitude.shape[1], band):
        range_m = FAR_M - (start + band / 2) * ACROSS_M
        sigma = 0.5 * BEAM_RAD * range_m / ALONG_M
        part = amplitude[:, start : start + band]
        seen[:, start : start + band] = cv2.GaussianBlur(part, (0, 0), sigmaX=1e-3, sigmaY=sigma)
    return seen


def _paint(amplitude: Array, thing: Thing) -> None:
    """Paint a thing into the floor's amplitude, in place, row by row."""
    near = column_of(thing.range_m)
    end = column_of(thing.range_m + thing.length_m)
    hollow = thing.kind is Kind.HOLLOW
    first = thing.shadow_m if hollow else thing.highlight_m  # what is nearer to the sonar
    edge = column_of(thing.range_m + first)
    middle, half = row_of(thing.along_m), 0.5 * thing.width_m / ALONG_M
    for row in range(max(0, round(middle - half)), min(len(amplitude), round(middle + half) + 1)):
        across = np.sqrt(max(0.0, 1 - ((row - middle) / (half + 0.5)) ** 2))
        # The far edge of a shadow is round as the top that casts it.
        reach = end if hollow else round(end + 0.25 * (1 - across) * (edge - end))
        light = thing.brightness * (0.7 + 0.3 * across)
        far, close = (light, thing.shade) if hollow else (thing.shade, light)
        amplitude[row, max(0, reach) : max(0, edge)] = far
        amplitude[row, max(0, edge) : max(0, near)] = close
