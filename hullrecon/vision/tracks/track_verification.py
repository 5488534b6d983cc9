# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Verification of tracks: every verified pair is held against every landmark that both of its nodes
claim to have seen.

A wrong match joins two points into one track; the pairs that did not make that match contradict it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Ints32, Mask
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.gating import Motion, transfer
from hullrecon.vision.pairs.two_view import essential_of, sampson_squared
from hullrecon.vision.stereo.rectification import rectify, triangulate

ROUNDS = 3


@dataclass(frozen=True, kw_only=True)
class Link:
    """A verified pair of nodes and the motion between their leading cameras; scaled: its length is
    measured.
    """

    first: int
    second: int
    motion: Motion
    scaled: bool


def contradicted_observations(
    rig: Rig,
    node: Ints,
    label: Ints,
    top: Array,
    bottom: Array,
    links: Sequence[Link],
    options: MatchOptions,
) -> Mask:
    """Return which observations (m,) at least as many pairs contradict as confirm, one at least.
    node (m,) ascending.
    """
    observations = _Observations(rig, top, bottom)
    bounds = {
        k: slice(*np.searchsorted(node, [k, k + 1]))
        for k in {n for link in links for n in (link.first, link.second)}
    }
    votes: list[tuple[Ints32, Ints32, Mask]] = []
    for link in links:
        i, j = bounds[link.first], bounds[link.second]
        _, a, b = np.intersect1d(label[i], label[j], assume_unique=True, return_indices=True)
        a, b = a + i.start, b + j.start
        votes.append(
            (a.astype(np.int32), b.astype(np.int32), observations.agree(link, a, b, options))
        )
    return _outvote(len(node), votes)


def _outvote(count: int, votes: Sequence[tuple[Ints32, Ints32, Mask]]) -> Mask:
    """Return which of the observations are rejected, in rounds: a rejected one no longer counts
    against the others.

    votes: of each pair its observations a and b, each once, and whether the two agree.
    """
    out = np.zeros(count, bool)
    for step in range(ROUNDS):
        yes, no = np.zeros(count, np.int32), np.zeros(count, np.int32)
        # pair by pair: those of a long dive together would fill the memory
        for a, b, good in votes:
            counted = ~(out[a] | out[b])
            for tally, chosen in ((yes, counted & good), (no, counted & ~good)):
                tally[a[chosen]] += 1
                tally[b[chosen]] += 1
        out |= (no > 0) & ((no > 2 * yes) if step == 0 else (no >= yes))
    return out


class _Observations:
    """Ideal coordinates of all observations, and points of the stereo ones."""

    def __init__(self, rig: Rig, top: Array, bottom: Array) -> None:
        self._rig = rig
        upper, lower = _undistort(rig, Camera.TOP, top), _undistort(rig, Camera.BOTTOM, bottom)
        self._other = lower
        # the bottom camera leads where it saw alone
        self._lead = np.where(np.isfinite(upper), upper, lower)
        self._depth = np.full(len(top), np.nan)
        both = np.isfinite(upper[:, 0]) & np.isfinite(lower[:, 0])
        if rig.stereo_mount is not None:
            turned = rectify(rig.stereo_mount)
            self._depth[both] = triangulate(
                turned, turned.rectify_top(upper[both]), turned.rectify_bottom(lower[both])
            )[:, 2]
        self._both = both

    def agree(self, link: Link, a: Ints, b: Ints, options: MatchOptions) -> Mask:
        """Return whether the observations lie on each other's epipolar lines and, with a depth, at
        the right place on them.
        """
        motion = link.motion.second_from_first
        limit = (1.5 * options.verify_px / self._rig.focal_px(Camera.TOP)) ** 2
        good = sampson_squared(essential_of(motion), self._lead[a], self._lead[b]) < limit
        down = self._rig.from_top(Camera.BOTTOM)
        below = down @ motion @ np.linalg.inv(down)
        pair = self._both[a] & self._both[b]
        error = sampson_squared(essential_of(below), self._other[a], self._other[b])
        good &= ~pair | (np.nan_to_num(error) < limit)
        return good & (self._at_depth(link.motion, a, b, options) if link.scaled else True)

    def _at_depth(self, motion: Motion, a: Ints, b: Ints, options: MatchOptions) -> Mask:
        """Return whether the observations lie where their depth puts them; true as well where no
        depth is known.
        """
        sigma = options.sigma_px / self._rig.focal_px(Camera.TOP)
        depth = self._depth[a]
        spread = depth**2 * np.sqrt(2) * sigma / self._rig.baseline_m
        mean, covariance = transfer(motion, self._lead[a], depth, spread, sigma)
        gap = self._lead[b] - mean
        known = np.isfinite(mean).all(axis=1)
        out = np.ones(len(a), bool)
        information = np.linalg.inv(covariance[known])
        chi2 = np.einsum("ni,nij,nj->n", gap[known], information, gap[known])
        out[known] = chi2 < 1.5 * options.gate_chi2
        return out


def _undistort(rig: Rig, camera: Camera, pixels: Array) -> Array:
    out = np.full(pixels.shape, np.nan)
    seen = np.isfinite(pixels[:, 0])
    if seen.any():
        out[seen] = rig.model(camera).undistort(pixels[seen])
    return out
