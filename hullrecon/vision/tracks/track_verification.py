# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Verify tracks: test every link on every landmark that both of its nodes observed.

A wrong match joins two points into one track. Links between other nodes of that track, which had no
part in the match, contradict it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Ints32, Mask
from hullrecon.vision.pairs.gating import Motion, transfer
from hullrecon.vision.pairs.matching import GATE_CHI2, VERIFY_PX
from hullrecon.vision.pairs.two_view import essential_of, sampson_squared
from hullrecon.vision.stereo.matching import rectify, triangulate

ROUNDS = 3  # of votes: a rejected observation no longer counts against the others
BLOCK = 1 << 16  # observations computed at a time
LOOSER = 1.5  # factor on the limits that matching uses: a link's motion has an error of its own


@dataclass(frozen=True, kw_only=True)
class Link:
    """A verified pair of nodes."""

    first: int
    second: int
    motion: Motion  # between the leading cameras
    scaled: bool  # its length is measured


def contradicted_observations(
    rig: Rig,
    node: Ints32,
    label: Ints,
    top: Array,
    bottom: Array,
    links: Sequence[Link],
    sigma_px: float,
) -> Mask:
    """Reject observations (m,) that links contradict, by majority vote.

    Each link tests the landmarks that both of its nodes observed. Observations that no link tests
    are kept.

    Parameters
    ----------
    rig
        Gives the lens models and the stereo mount, by which observations become rays and depths.
    node, label
        Node, ascending, and landmark of each observation (m,).
    top, bottom
        Pixels (m, 2) in either image, NaN where not seen.
    links
        Verified pairs.
    sigma_px
        Sigma of a feature's position.
    """
    observations = _Observations(rig, top, bottom, sigma_px)
    nodes = 1 + max((max(link.first, link.second) for link in links), default=-1)
    start = np.searchsorted(node, np.arange(nodes + 1, dtype=node.dtype)).tolist()
    bounds = [slice(*ends) for ends in pairwise(start)]
    votes: list[tuple[Ints32, Ints32, Mask]] = []
    for link in links:
        i, j = bounds[link.first], bounds[link.second]
        _, a, b = np.intersect1d(label[i], label[j], assume_unique=True, return_indices=True)
        a, b = a + i.start, b + j.start
        votes.append((a.astype(np.int32), b.astype(np.int32), observations.agree(link, a, b)))
    return _outvote(len(node), votes)


def _outvote(count: int, votes: Sequence[tuple[Ints32, Ints32, Mask]]) -> Mask:
    """Reject observations (m,) that links contradict, in rounds of votes.

    A link votes on both observations of each landmark that its nodes share. The first round rejects
    only where contradictions are more than twice the confirmations, later ones where they are at
    least as many: by then votes that involve a wrong observation no longer count.

    Parameters
    ----------
    count
        Number of observations.
    votes
        For each link, observations a (k,) and b (k,) of shared landmarks, and whether they agree.
    """
    out = np.zeros(count, bool)
    for step in range(ROUNDS):
        confirmed, contradicted = np.zeros(count, np.int32), np.zeros(count, np.int32)
        # Link by link: the votes of a long dive together would fill the memory.
        for a, b, agree in votes:
            counted = ~(out[a] | out[b])
            for tally, chosen in ((confirmed, counted & agree), (contradicted, counted & ~agree)):
                tally[a[chosen]] += 1
                tally[b[chosen]] += 1
        outvoted = (contradicted > 2 * confirmed) if step == 0 else (contradicted >= confirmed)
        out |= (contradicted > 0) & outvoted
    return out


class _Observations:
    """Ideal coordinates of all observations, and depths of the stereo ones."""

    def __init__(self, rig: Rig, top: Array, bottom: Array, sigma_px: float) -> None:
        """Undistort observations of both cameras, and triangulate those that both saw.

        top, bottom: pixels (m, 2), NaN where not seen. sigma_px: of a pixel.
        """
        self._rig, self._sigma = rig, sigma_px / rig.focal_px(Camera.TOP)
        self._lead = _undistort(rig, Camera.TOP, top)
        self._other = _undistort(rig, Camera.BOTTOM, bottom)
        self._both = np.isfinite(self._lead[:, 0]) & np.isfinite(self._other[:, 0])
        self._depth = np.full(len(top), np.nan)
        if rig.stereo_mount is not None:
            turned = rectify(rig.stereo_mount)
            for some in _in_blocks(np.flatnonzero(self._both)):
                self._depth[some] = triangulate(
                    turned,
                    turned.rectify_top(self._lead[some]),
                    turned.rectify_bottom(self._other[some]),
                )[:, 2]
        # Where the bottom camera saw alone, it was its node's leading camera.
        alone = np.isnan(self._lead)
        self._lead[alone] = self._other[alone]

    def agree(self, link: Link, a: Ints, b: Ints) -> Mask:
        """Test whether observations a, b (k,) of the same landmarks agree with a link.

        They must lie on each other's epipolar lines, of both cameras where both saw the point, and
        at the point of the line that the depth predicts where it is known.
        """
        motion = link.motion.second_from_first
        limit = (LOOSER * VERIFY_PX / self._rig.focal_px(Camera.TOP)) ** 2
        good = sampson_squared(essential_of(motion), self._lead[a], self._lead[b]) < limit
        bottom_from_top = self._rig.from_top(Camera.BOTTOM)
        of_bottom = bottom_from_top @ motion @ np.linalg.inv(bottom_from_top)
        pair = self._both[a] & self._both[b]
        error = sampson_squared(essential_of(of_bottom), self._other[a], self._other[b])
        good &= ~pair | (np.nan_to_num(error) < limit)
        return good & (self._at_depth(link.motion, a, b) if link.scaled else True)

    def _at_depth(self, motion: Motion, a: Ints, b: Ints) -> Mask:
        """Test whether b (k,) is where the link and the depth of a (k,) predict it.

        An epipolar line alone leaves open where on it the point lies. True where no depth is known.
        """
        depth = self._depth[a]
        spread = depth**2 * np.sqrt(2) * self._sigma / self._rig.baseline_m
        mean, covariance = transfer(motion, self._lead[a], depth, spread, self._sigma)
        gap = self._lead[b] - mean
        known = np.isfinite(mean).all(axis=1)
        out = np.ones(len(a), bool)
        information = np.linalg.inv(covariance[known])
        chi2 = np.einsum("ni,nij,nj->n", gap[known], information, gap[known])
        out[known] = chi2 < LOOSER * GATE_CHI2
        return out


def _undistort(rig: Rig, camera: Camera, pixels: Array) -> Array:
    """Convert pixels (m, 2) to ideal coordinates, NaN where not seen."""
    out = np.full(pixels.shape, np.nan)
    for some in _in_blocks(np.flatnonzero(np.isfinite(pixels[:, 0]))):
        out[some] = rig.model(camera).undistort(pixels[some])
    return out


def _in_blocks(rows: Ints) -> Iterator[Ints]:
    return (rows[k : k + BLOCK] for k in range(0, len(rows), BLOCK))
