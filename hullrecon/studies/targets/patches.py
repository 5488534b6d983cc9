# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Patches of side-scan tiles with and without a target, to train a detector on and to test it."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from hullrecon.studies.targets.side_scan import (
    ACROSS_M,
    ALONG_M,
    LANE_M,
    RANGES_M,
    Kind,
    Thing,
    column_of,
    draw_thing,
    draw_tile,
    level_over_range,
    row_of,
    rows_of_lanes,
    scatter_things,
)
from hullrecon.typing import Array, Floats32, Mask

ROWS, COLUMNS = 24, 72  # of a patch
# Of the things in a tile; the rest of the windows show the floor alone.
KINDS = (*[Kind.TARGET] * 4, Kind.BRIGHT, Kind.DARK, Kind.HOLLOW)
FLOOR_WINDOWS = 7  # of a tile
MARGIN = 1.5  # of a window's height to the thing's: some floor above and below
SHIFT, STRETCH = 0.025, 0.05  # of a window from what it shows, as a scan steps: share of its size


@dataclass(frozen=True, kw_only=True)
class Patches:
    """Windows of tiles, resampled to one size."""

    picture: Array  # (n, ROWS, COLUMNS) amplitudes; the floor at its range is 1
    kind: tuple[Kind, ...]  # (n,)

    @property
    def is_target(self) -> Mask:
        """Mark the patches (n,) with a target."""
        return np.array([kind is Kind.TARGET for kind in self.kind])

    def of(self, kept: Mask) -> Patches:
        """Select patches by a mask (n,)."""
        kinds = tuple(k for k, wanted in zip(self.kind, kept, strict=True) if wanted)
        return Patches(picture=self.picture[kept], kind=kinds)


def cut_patches(seed: int, tiles: int) -> Patches:
    """Cut a patch around each thing of new tiles, and patches of bare floor from other tiles."""
    rng = np.random.default_rng(seed)
    pictures, kinds = [], []
    for _ in range(tiles):
        things = scatter_things(rng, KINDS)
        tile = level_over_range(draw_tile(rng, rows_of_lanes(len(KINDS)), things))
        bare = level_over_range(draw_tile(rng, rows_of_lanes(2), []))
        for thing in things:
            pictures.append(_window(rng, tile, thing))
            kinds.append(thing.kind)
        for range_m in rng.uniform(*RANGES_M, FLOOR_WINDOWS):
            like = draw_thing(rng, Kind.TARGET, LANE_M, range_m)
            pictures.append(_window(rng, bare, like))
            kinds.append(Kind.FLOOR)
    return Patches(picture=np.array(pictures), kind=tuple(kinds))


def augment(patches: Patches, seed: int, targets: int, others: int) -> Patches:
    """Make more patches of few by scale, intensity and noise [Aulinas2011 4.3.4]."""
    rng = np.random.default_rng(seed)
    is_target = patches.is_target
    chosen = np.concatenate(
        [
            rng.choice(np.flatnonzero(is_target), targets),
            rng.choice(np.flatnonzero(~is_target), others),
        ]
    )
    pictures = [_vary(rng, patches.picture[k]) for k in chosen]
    return Patches(picture=np.array(pictures), kind=tuple(patches.kind[k] for k in chosen))


def _window(rng: np.random.Generator, tile: Floats32, thing: Thing) -> Array:
    """Cut the window of a thing out of a tile, resampled to a patch (ROWS, COLUMNS).

    It is a little shifted and stretched, as a scan over places and scales would meet it.
    """
    high, long = MARGIN * thing.width_m / ALONG_M, thing.length_m / ACROSS_M
    if thing.kind in (Kind.BRIGHT, Kind.DARK):
        # A scan has windows of a target's shape: the missing half is floor.
        like = draw_thing(rng, Kind.TARGET, thing.along_m, thing.range_m)
        long = like.length_m / ACROSS_M
    near = column_of(thing.range_m)
    if thing.kind is Kind.DARK:
        near += round(like.highlight_m / ACROSS_M)
    stretch = 1 + STRETCH * rng.uniform(-1, 1, 2)
    shift = SHIFT * rng.uniform(-1, 1, 2)
    middle = (
        near - 0.5 * long + shift[0] * long,
        row_of(thing.along_m) + shift[1] * high,
    )
    size = (max(4, round(long * stretch[0])), max(4, round(high * stretch[1])))
    cut = cv2.getRectSubPix(tile, size, middle)
    return np.asarray(cv2.resize(cut, (COLUMNS, ROWS), interpolation=cv2.INTER_AREA), float)


def _vary(rng: np.random.Generator, picture: Array) -> Array:
    """Vary a patch (ROWS, COLUMNS): scale by up to 5 per cent, intensity by up to 25, noise."""
    scale = 1 + 0.05 * rng.uniform(-1, 1, 2)
    size = (COLUMNS / scale[0], ROWS / scale[1])
    warp = np.array(
        [
            [size[0] / COLUMNS, 0, 0.5 * (COLUMNS - size[0])],
            [0, size[1] / ROWS, 0.5 * (ROWS - size[1])],
        ]
    )
    scaled = cv2.warpAffine(
        picture,
        warp,
        (COLUMNS, ROWS),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )
    noise = 0.05 * picture.mean() * rng.standard_normal(picture.shape)
    return np.asarray(np.maximum(rng.uniform(0.8, 1.25) * scaled + noise, 0))
