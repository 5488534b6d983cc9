# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The cost of a comparison of two clocks over their relative offset, and its minima.

The cost is a clipped sum of squares. Its minima are candidates for the offset of either sensor.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from hullrecon.geometry.robust import GAIN, robust_sigma
from hullrecon.navigation.clocks.comparisons.comparison import ClockComparison, Offsets, Span
from hullrecon.typing import Array

# offsets that are searched, and, where these do not show that clocks agree, those that are found
NEAR_S, FAR_S = 5.0, 60.0
# Farther offsets are evaluated but not accepted: a swell repeats itself, so that an offset within
# FAR_S may fit by chance where the right one is beyond
BEYOND_S = 120.0
GRID_S, FAR_GRID_S = 0.1, 0.2  # steps of the search, near and far
OTHER_S = 0.5  # between two offsets that count as different
MINIMA = 5  # of a comparison's cost that are kept
STEP_S = 0.2  # of the numeric derivative; over a shorter one noise would look like slope
FULL_WEIGHT, ANY_WEIGHT = 2.0, 6.0  # sigmas up to which a residual has full, and any weight
LEAST_KNOWN = 0.5  # share of the rows that an offset has to leave to estimate their scatter
ROUNDS, CONVERGED_S = 8, 1e-4  # of Gauss-Newton


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """A comparison with the scatter of its residuals and the minima of its cost."""

    comparison: ClockComparison
    sigma: float  # of a residual
    # (n,) mean cost of each row over all offsets, used at offsets where the row's cost is unknown
    mean_cost: Array
    minima_s: list[float]  # relative offsets at the minima, the lowest minimum first
    rows_per_error: float = 1.0  # how many rows share one error, by the scatter among blocks
    least_chi2: float = 0.0  # chi-square at the best relative offset

    def cost(self, offsets: Offsets, span: Span | None = None) -> float:
        """Compute chi-square at some offsets, of all rows or of those in a span."""
        cost = _filled(_clipped(self.comparison.residuals(offsets), self.sigma), self.mean_cost)
        if span is not None:
            inside = self.comparison.begin_ns >= span[0]
            cost = cost[inside & (self.comparison.end_ns <= span[1])]
        return float(cost.sum()) / self.rows_per_error

    def relative(self, offsets: Offsets) -> float:
        """Compute the offset of the first sensor relative to the second, s."""
        return offsets.get(self.comparison.first, 0.0) - offsets.get(self.comparison.second, 0.0)


def weigh_comparisons(comparisons: Iterable[ClockComparison]) -> list[Evidence]:
    """Scan the cost of each comparison over offsets, to find offsets at which its sensors agree.

    Comparisons with too few rows, or without any scatter, are left out.
    """
    found = (_weigh_comparison(comparison) for comparison in comparisons if comparison.is_enough)
    return [evidence for evidence in found if evidence is not None]


def _weigh_comparison(comparison: ClockComparison) -> Evidence | None:
    """Scan near offsets, and far ones too unless the near ones show that the clocks agree.

    They do where the best offset is near zero and any other costs GAIN more. None where the
    comparison has no information (`_scan_offsets`).
    """
    steps = round(NEAR_S / GRID_S)
    near = np.asarray(GRID_S * np.arange(-steps, steps + 1), float)
    found = _scan_offsets(comparison, near)
    if found is not None and abs(found.minima_s[0]) < OTHER_S:
        second = {comparison.first: found.minima_s[1]}
        if found.cost(second) - found.least_chi2 >= GAIN:
            return found
    far = np.arange(NEAR_S + FAR_GRID_S, BEYOND_S + FAR_GRID_S / 2, FAR_GRID_S, dtype=float)
    return _scan_offsets(comparison, np.concatenate([-far[::-1], near, far]))


def _scan_offsets(comparison: ClockComparison, shifts: Array) -> Evidence | None:
    """Compute the cost of a comparison at many offsets, and list its lowest minima.

    The sigma of a residual is the least scatter at any offset, as residuals scatter more at a wrong
    one. None where no offset leaves enough rows, or where there is no scatter.

    shifts: offsets of the comparison's first sensor, s.
    """
    table = [comparison.residuals({comparison.first: float(shift)}) for shift in shifts]
    known = [np.isfinite(found) for found in table]
    sigmas = [
        robust_sigma(found[fit], about=0.0)
        for found, fit in zip(table, known, strict=True)
        if fit.mean() >= LEAST_KNOWN
    ]
    if not sigmas or not min(sigmas) > 0:
        return None
    # (offsets, rows)
    cost = np.array([_clipped(found, min(sigmas)) for found in table])
    given = np.isfinite(cost)
    mean_cost = np.where(given, cost, 0.0).sum(axis=0) / np.maximum(given.sum(axis=0), 1)
    total = _filled(cost, mean_cost).sum(axis=1)
    # take the lowest, exclude offsets within OTHER_S of it, and go on with the rest
    minima: list[float] = []
    while len(minima) < MINIMA and np.isfinite(total).any():
        minima.append(float(shifts[np.argmin(total)]))
        total = np.where(np.abs(shifts - minima[-1]) < OTHER_S, np.inf, total)
    found = Evidence(comparison=comparison, sigma=min(sigmas), mean_cost=mean_cost, minima_s=minima)
    best = refine(found, {comparison.first: minima[0]})
    if best is None:
        return None
    found = replace(found, rows_per_error=best.rows_per_error)
    return replace(found, least_chi2=found.cost({comparison.first: best.relative_s}))


@dataclass(frozen=True)
class Refined:
    """The relative offset at a minimum of a comparison's cost."""

    relative_s: float  # of the first sensor, minus that of the second
    variance: float  # s2, from the scatter among blocks
    rows_per_error: float  # how many rows share one error


def refine(evidence: Evidence, start: Offsets) -> Refined | None:
    """Minimise a comparison's cost from some offsets, by Gauss-Newton with robust weights.

    The offset of its first sensor is changed, by at most a second. Its variance is cluster-robust:
    the larger of those by rows and by blocks. None where the residuals do not depend on it.

    start: offsets of all sensors, of which that of the first one is refined.
    """
    comparison, moved = evidence.comparison, 0.0
    for _ in range(ROUNDS):
        slope, found, weight = linearise(comparison, start, moved)
        curvature, gradient = float((weight * slope**2).sum()), (weight * slope * found).sum(axis=1)
        if curvature <= 0:
            return None
        step = -float(gradient.sum()) / curvature
        moved = float(np.clip(moved + step, -1.0, 1.0))
        if abs(step) < CONVERGED_S:
            break
    # scatter of the gradient, if errors were independent from row to row, or common within a block
    by_row = float(np.square(gradient).sum())
    by_block = float(np.square(np.bincount(comparison.block, gradient)).sum())
    if by_row <= 0:
        return None
    return Refined(
        evidence.relative(start) + moved,
        max(by_row, by_block) / curvature**2,
        max(1.0, by_block / by_row),
    )


def linearise(
    comparison: ClockComparison, start: Offsets, more_s: float
) -> tuple[Array, Array, Array]:
    """Compute slopes by the first sensor's offset, residuals and robust weights, each (n, k).

    All are 0 where a residual is unknown. The weight is 1 up to FULL_WEIGHT sigmas, less beyond,
    and 0 beyond ANY_WEIGHT sigmas.

    They are computed at the offsets `start`, with that of the first sensor changed by more_s.
    """
    behind, found, ahead = (
        comparison.residuals(comparison.moved(start, more_s + step_s))
        for step_s in (-STEP_S, 0.0, STEP_S)
    )
    slope = (ahead - behind) / (2 * STEP_S)
    known = np.isfinite(found) & np.isfinite(slope)
    if not known.any():
        return np.zeros_like(slope), np.zeros_like(found), np.zeros_like(found)
    size = np.abs(np.where(known, found, np.inf))
    sigma = robust_sigma(found[known], about=0.0)
    huber = np.minimum(1.0, FULL_WEIGHT * sigma / np.maximum(size, 1e-12))
    weight = np.where(size < ANY_WEIGHT * sigma, huber, 0.0)
    return np.where(known, slope, 0.0), np.where(known, found, 0.0), weight


def _clipped(residuals: Array, sigma: float) -> Array:
    """Sum squares of residuals (n, k) in sigmas by row (n,), each clipped at ANY_WEIGHT / 2."""
    return np.asarray(np.square(np.minimum(np.abs(residuals) / sigma, ANY_WEIGHT / 2)).sum(axis=1))


def _filled(cost: Array, mean_cost: Array) -> Array:
    """Replace unknown costs of a row by its mean cost, so that they favour no offset.

    With zero in their place the largest offsets, which leave the fewest rows, would look best.
    """
    return np.where(np.isfinite(cost), cost, mean_cost)
