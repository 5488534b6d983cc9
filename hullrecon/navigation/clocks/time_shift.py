# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How much later one sensor's clock is than another's: the shift in time at which what both
measured agrees best.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.robust import robust_sigma
from hullrecon.typing import Array, Ints

# shifts that are found; the far ones but where a near search says that clocks agree
NEAR_S, FAR_S = 5.0, 60.0
# shifts that are looked at for a far one: a swell that repeats itself fits a minute off a clock
# still later
BEYOND_S = 120.0
GRID_S, FAR_GRID_S = 0.1, 0.2  # between shifts; between those that are far
# over which residuals are taken to be straight; over less, noise would look like their slope
STEP_S = 0.2
TRUSTED = 2.0  # sigmas; what differs by more weighs less
WILD = 6.0  # sigmas; what differs by more weighs nothing
LEAST_KNOWN = 0.5  # of the rows; a shift that leaves fewer does not tell how much residuals scatter
ROUNDS = 8
CONVERGED_S = 1e-4
# sigmas by which a shift has to explain what was measured better than none does, and than any other
LEAST_GAIN = 5.0
OTHER_S = 0.5  # from a shift to another one

# of a shift in s: (n, k) what does not agree, any unit, NaN where nothing is known
Residuals = Callable[[float], Array]


@dataclass(frozen=True, kw_only=True)
class Disagreement:
    """How two clocks part: residuals of a shift, and the numbers (n,) of the blocks in which errors
    go together. is_enough: the rows are enough to find a shift, and how sure it is; fewer can but
    compare two.
    """

    residuals: Residuals
    block: Ints
    is_enough: bool = True


@dataclass(frozen=True, kw_only=True)
class TimeShift:
    """seconds to be added to the one sensor's stamps to ask the other, with their sigma; over_none,
    over_others: how many sigmas better the shift explains what was measured than none does, and
    than any other one.
    """

    seconds: float
    sigma_s: float
    over_none: float
    over_others: float

    def is_unique(self) -> bool:
        """Return whether no shift elsewhere explains what was measured as well."""
        return self.over_others >= LEAST_GAIN

    def is_sure(self, sigmas: float) -> bool:
        """Return whether the shift is no chance: at least so many of its sigmas, and the best
        explanation.
        """
        return (
            abs(self.seconds) >= sigmas * self.sigma_s
            and self.is_unique()
            and self.over_none >= LEAST_GAIN
        )


def find_time_shift(residuals: Residuals, block: Ints, reach_s: float = NEAR_S) -> TimeShift | None:
    """Return the shift that makes residuals smallest; None where none within reach does. Far ones
    (reach_s over NEAR_S) have to be better than those beyond them too.

    block (n,): numbers of the rows' blocks; what is wrong in a row is taken to be wrong in its
    block, and blocks to be independent of each other. The sigma is that of the scatter among them.
    """
    shifts = _grid(reach_s if reach_s <= NEAR_S else max(reach_s, BEYOND_S))
    table = [residuals(float(shift)) for shift in shifts]
    sigma = _least_sigma(table)
    if sigma is None:
        return None
    cost = np.array([_cost(found, sigma) for found in table])
    usual = _usual_cost(cost)
    cost = _filled(cost, usual)
    best = int(np.argmin(cost.sum(axis=1)))
    if abs(shifts[best]) > reach_s - GRID_S / 2:
        return None
    refined = _refine(residuals, block, float(shifts[best]))
    if refined is None or abs(refined.seconds - shifts[best]) > 2 * GRID_S:
        return None
    others = np.flatnonzero(np.abs(shifts - refined.seconds) >= OTHER_S)
    other = int(others[np.argmin(cost[others].sum(axis=1))])
    own, none = (_filled(_cost(residuals(shift), sigma), usual) for shift in (refined.seconds, 0.0))
    return TimeShift(
        seconds=refined.seconds,
        sigma_s=refined.sigma_s,
        over_none=_gain(none - own, refined.together),
        over_others=_gain(cost[other] - own, refined.together),
    )


def find_far_shift(residuals: Residuals, block: Ints) -> TimeShift | None:
    """Return the shift as find_time_shift does: that clocks agree, where a near search says so,
    else the best of far ones.
    """
    near = find_time_shift(residuals, block)
    if near is not None and near.is_unique() and abs(near.seconds) < OTHER_S:
        return near
    return find_time_shift(residuals, block, FAR_S)


def preference(first: Array, second: Array, block: Ints) -> float:
    """Return how many sigmas smaller the residuals (n, k) of one explanation are than those of
    another; negative where larger. block (n,): as of find_time_shift.
    """
    sigmas = [robust_sigma(found[np.isfinite(found)], about=0.0) for found in (first, second)]
    if not min(sigmas) > 0:
        return 0.0
    by_row = np.nan_to_num(_cost(second, min(sigmas)) - _cost(first, min(sigmas)))
    by_block = np.bincount(block, by_row)
    return _gain(by_row, float(np.square(by_block).sum() / max(np.square(by_row).sum(), 1e-12)))


def sum_of_sigmas(preferences: Iterable[float]) -> float:
    """Return what several preferences that know nothing of each other say together."""
    total = sum(one * abs(one) for one in preferences)
    return float(np.sign(total) * np.sqrt(abs(total)))


def _gain(saved: Array, together: float) -> float:
    """Return what is saved (n,), squares of sigmas, as sigmas, where so many rows are wrong
    together.
    """
    total = float(saved.sum()) / max(1.0, together)
    return float(np.sign(total) * np.sqrt(abs(total)))


def _grid(reach_s: float) -> Array:
    """Return the shifts (s,) that are looked at, in order, with none among them."""
    steps = round(min(reach_s, NEAR_S) / GRID_S)
    near = GRID_S * np.arange(-steps, steps + 1)
    far = np.arange(NEAR_S + FAR_GRID_S, reach_s + FAR_GRID_S / 2, FAR_GRID_S)
    return np.concatenate([-far[::-1], near, far])


def _least_sigma(table: Sequence[Array]) -> float | None:
    """Return the least scatter of the residuals (n, k) of shifts that leave enough of them; None
    where none has one.
    """
    known = [np.isfinite(found) for found in table]
    sigmas = [
        robust_sigma(found[fit], about=0.0)
        for found, fit in zip(table, known, strict=True)
        if fit.mean() >= LEAST_KNOWN
    ]
    return min(sigmas) if sigmas and min(sigmas) > 0 else None


def _cost(residuals: Array, sigma: float) -> Array:
    """Return (n,) the squares of residuals (n, k) in sigmas, each at most that of a wild one; NaN
    where one is not known.
    """
    return np.asarray(np.square(np.minimum(np.abs(residuals) / sigma, WILD / 2)).sum(axis=1))


def _usual_cost(cost: Array) -> Array:
    """Return the mean cost (n,) of each row over the shifts (s, n) at which it is known; 0 for a
    row that never is.
    """
    known = np.isfinite(cost)
    return np.asarray(np.where(known, cost, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1))


def _filled(cost: Array, usual: Array) -> Array:
    """Return costs (..., n) with the usual one where a row is not known: it speaks neither for a
    shift nor against it. If rows cost nothing there, the farthest shifts, which leave the fewest,
    would look best.
    """
    return np.where(np.isfinite(cost), cost, usual)


@dataclass(frozen=True)
class _Refined:
    """together: how many rows are wrong as one, by the scatter among blocks."""

    seconds: float
    sigma_s: float
    together: float


def _refine(residuals: Residuals, block: Ints, shift: float) -> _Refined | None:
    """Return the shift by Gauss-Newton with weights, from a shift near it; None where the residuals
    do not change with it.
    """
    start = shift
    for _ in range(ROUNDS):
        found = residuals(shift)
        slope = (residuals(shift + STEP_S) - residuals(shift - STEP_S)) / (2 * STEP_S)
        known = np.isfinite(found) & np.isfinite(slope)
        size = np.abs(np.where(known, found, np.inf))
        sigma = robust_sigma(found[known], about=0.0)
        weight = np.where(
            size < WILD * sigma, np.minimum(1.0, TRUSTED * sigma / np.maximum(size, 1e-12)), 0.0
        )
        slope, found = np.where(known, slope, 0.0), np.where(known, found, 0.0)
        curvature, pull = float((weight * slope**2).sum()), (weight * slope * found).sum(axis=1)
        if curvature <= 0:
            return None
        step = -float(pull.sum()) / curvature
        shift = float(np.clip(shift + step, start - 1.0, start + 1.0))
        if abs(step) < CONVERGED_S:
            break
    by_row, by_block = (
        float(np.square(pull).sum()),
        float(np.square(np.bincount(block, pull)).sum()),
    )
    if by_row <= 0:
        return None
    return _Refined(
        shift, float(np.sqrt(max(by_row, by_block))) / curvature, max(1.0, by_block / by_row)
    )
