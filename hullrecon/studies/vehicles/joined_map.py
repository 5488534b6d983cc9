# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Submaps joined selectively into one map [Aulinas2011 3.3.3, Algorithm 3].

Submaps share attitude with the world, so that a submap lies in the map by a shift in x and y, and
in depth too where no pressure is measured: joining is linear, and exact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.stats import chi2

from hullrecon.studies.submaps.ekf_slam import update_state
from hullrecon.typing import Array, Ints

SHARED = 0.4  # of a submap's landmarks that have to be known for it to be fused [Aulinas2011 3.4.1]
SAME = float(chi2.ppf(0.99, 3))  # squared Mahalanobis distance of what may be one landmark
FAR_M = 30.0  # landmarks farther apart in x or y are not tried: saves time
NUDGE_M2 = 1e-6  # variance of "the same place"


@dataclass(frozen=True, kw_only=True)
class Submap:
    """What a finished submap hands on, in its own frame."""

    points: Array  # (n, 3) landmarks
    end: Array  # (axes,) x, y and perhaps z of the vehicle where the next submap starts
    covariance: Array  # (3n + axes, 3n + axes) of points, then end
    labels: tuple[int, ...]  # (n,) true numbers


class JoinedMap:
    """Where each submap starts (`axes` numbers) and the landmarks (3 each), with covariance."""

    def __init__(self, axes: int, labelled: bool = False) -> None:
        """Start an empty map at the origin.

        Parameters
        ----------
        axes
            2 if a submap is shifted in x and y, 3 if in depth too.
        labelled
            Pair landmarks by their true labels, or by place.
        """
        self._axes = axes
        self._labelled = labelled
        self.mean, self.covariance = np.zeros(axes), 1e-9 * np.eye(axes)
        self._starts = [0]  # first row of each submap's start
        self._landmarks: list[int] = []  # first row of each landmark
        self.labels: list[int] = []
        self.wrong_pairs = 0  # pairs of landmarks that were not one
        self.fused = 0  # submaps that were

    @property
    def starts(self) -> Array:
        """Where submaps start (n, axes); the last is where the next one will."""
        return self.mean[np.array(self._starts)[:, None] + np.arange(self._axes)]

    @property
    def points(self) -> Array:
        """Landmarks (n, 3)."""
        return self.mean[self._rows(self._landmarks)].reshape(-1, 3)

    def start_covariance(self, k: int) -> Array:
        """Covariance (axes, axes) of where a submap starts."""
        rows = self._starts[k] + np.arange(self._axes)
        return self.covariance[np.ix_(rows, rows)]

    def point_covariance(self, k: int) -> Array:
        """Covariance (3, 3) of a landmark."""
        rows = self._landmarks[k] + np.arange(3)
        return self.covariance[np.ix_(rows, rows)]

    def join(self, submap: Submap) -> None:
        """Append a submap, and fuse it where enough of its landmarks are known."""
        known = len(self._landmarks)
        self._append(submap)
        pairs = self._pairs(known)
        if len(pairs) >= max(1.0, SHARED * len(submap.points)):
            self._fuse(pairs)
            self.fused += 1

    def _append(self, submap: Submap) -> None:
        """Append a submap's landmarks and end to the state, shifted to where the submap starts.

        Their covariance is that of the submap plus that of its start, with which they correlate.
        """
        n, base = len(submap.points), self._starts[-1] + np.arange(self._axes)
        # derivative of landmarks and end by the start
        shift = np.zeros((3 * n + self._axes, self._axes))
        for axis in range(self._axes):
            shift[axis : 3 * n : 3, axis] = 1.0
            shift[3 * n + axis, axis] = 1.0
        across = shift @ self.covariance[base]
        own = shift @ self.covariance[np.ix_(base, base)] @ shift.T + submap.covariance
        placed = np.r_[submap.points.ravel(), submap.end] + shift @ self.mean[base]
        first = len(self.mean)
        self.mean = np.concatenate([self.mean, placed])
        self.covariance = np.block([[self.covariance, across.T], [across, own]])
        self._landmarks += [first + 3 * k for k in range(n)]
        self._starts.append(first + 3 * n)
        self.labels += submap.labels

    def _pairs(self, known: int) -> list[tuple[int, int]]:
        """Pair known landmarks with those just appended: by label, or by place within a gate.

        known: number of landmarks before the submap was appended. By place, the pairs of least
        summed squared Mahalanobis distance are taken.
        """
        if self._labelled:
            at = {label: k for k, label in enumerate(self.labels[:known])}
            new = enumerate(self.labels[known:], start=known)
            return [(at[label], j) for j, label in new if label in at]
        # far beyond the gate where a pair is not looked at, so that it is not taken
        cost = np.full((known, len(self._landmarks) - known), 10 * SAME)
        for j in range(cost.shape[1]):
            for i in range(known):
                a, b = self._landmarks[i] + np.arange(3), self._landmarks[known + j] + np.arange(3)
                off = self.mean[b] - self.mean[a]
                if np.abs(off[:2]).max() > FAR_M:
                    continue
                mixed = self.covariance[np.ix_(a, b)]
                spread = (
                    self.covariance[np.ix_(a, a)]
                    + self.covariance[np.ix_(b, b)]
                    - mixed
                    - mixed.T
                    + NUDGE_M2 * np.eye(3)
                )
                cost[i, j] = min(cost[i, j], off @ np.linalg.solve(spread, off))
        taken = zip(*linear_sum_assignment(cost), strict=True)
        return [(int(i), int(known + j)) for i, j in taken if cost[i, j] < SAME]

    def _fuse(self, pairs: list[tuple[int, int]]) -> None:
        """Make pairs of landmarks one: their difference is zero (3.15). Copies are dropped."""
        self.wrong_pairs += sum(self.labels[i] != self.labels[j] for i, j in pairs)
        a = self._rows([self._landmarks[i] for i, _ in pairs])
        b = self._rows([self._landmarks[j] for _, j in pairs])
        carried = self.covariance[:, a] - self.covariance[:, b]
        spread = carried[a] - carried[b] + NUDGE_M2 * np.eye(len(a))
        apart = self.mean[b] - self.mean[a]
        update_state(self.mean, self.covariance, carried, spread, apart)
        self._drop([j for _, j in pairs])

    def _drop(self, landmarks: list[int]) -> None:
        """Drop landmarks, given by number, from the state, and renumber the rows of the others."""
        gone = self._rows([self._landmarks[j] for j in landmarks])
        kept = np.setdiff1d(np.arange(len(self.mean)), gone)
        at = {int(row): k for k, row in enumerate(kept)}
        self.mean, self.covariance = self.mean[kept], self.covariance[np.ix_(kept, kept)]
        left = [k for k in range(len(self._landmarks)) if k not in set(landmarks)]
        self._landmarks = [at[self._landmarks[k]] for k in left]
        self.labels = [self.labels[k] for k in left]
        self._starts = [at[row] for row in self._starts]

    @staticmethod
    def _rows(firsts: list[int]) -> Ints:
        """List the three rows of each landmark, given the first of them."""
        return np.asarray((np.array(firsts, int)[:, None] + np.arange(3)).ravel())
