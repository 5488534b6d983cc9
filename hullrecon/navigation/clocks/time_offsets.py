# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Estimate the time offset of every sensor from comparisons of their clocks.

See docs/methods.md, Clocks. Each comparison has a cost, a clipped sum of squares, over the relative
offset of two sensors. Its minima are candidates for the offset of either sensor. A hypothesis names
the sensors whose clocks are wrong: all offsets follow by weighted least squares, in which right
clocks have a narrow prior and wrong ones none. A wrong clock has to lower chi-square by GAIN, and
must do so better than any other offset and any other sensor. Offsets change where a stream pauses,
if that lowers chi-square.

Offsets are positive where stamps are late, and are subtracted from them.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hullrecon.geometry.robust import robust_sigma
from hullrecon.navigation.clocks.comparisons import ClockComparison, ClockedSensor, Offsets, Span
from hullrecon.records.clock import NS
from hullrecon.typing import Array

SYNCHRONISED_S = 0.005  # prior sigma of a right clock's offset
UNKNOWN_S = 1000.0  # prior sigma of a wrong clock's offset
GAIN = 25.0  # by which chi-square falls where a clock is wrong: five sigmas
ALIKE = 4.0  # hypotheses whose chi-squares differ by less are equivalent
SIGNIFICANT = 5.0  # sigmas of an offset that is corrected
# offsets that are searched, and, where these do not show that clocks agree, those that are found
NEAR_S, FAR_S = 5.0, 60.0
# Farther offsets are evaluated but not accepted: a swell repeats itself, so that an offset within
# FAR_S may fit by chance where the right one is beyond
BEYOND_S = 120.0
GRID_S, FAR_GRID_S = 0.1, 0.2  # steps of the search, near and far
OTHER_S = 0.5  # between two offsets that count as different
MINIMA = 5  # of a comparison's cost that are kept
TRIED = 3  # candidates that are refined
STEP_S = 0.2  # of the numeric derivative; over a shorter one noise would look like slope
TRUSTED, WILD = 2.0, 6.0  # sigmas beyond which a residual weighs less, and nothing
LEAST_KNOWN = 0.5  # share of the rows that an offset has to leave to tell their scatter
ROUNDS, CONVERGED_S = 8, 1e-4  # of Gauss-Newton
# sigma of the offset of a clock that no comparison checks: a driver that stamps messages when they
# arrive is late by the time that the instrument and the transmission take
UNCHECKED_S = 0.1
# Sigmas from which on a clock's rate counts. Quartz is right to 1e-4, which no dive shows
SEEN_RATE = 3.0


@dataclass(frozen=True, kw_only=True)
class TimeOffset:
    """By how much a sensor's stamps are late in a span, at least SIGNIFICANT sigmas."""

    sensor: ClockedSensor
    from_ns: int
    to_ns: int
    seconds: float  # late: to be subtracted from the stamps; negative where they are early
    sigma_s: float
    relative_to: tuple[ClockedSensor, ...]  # sensors whose clocks are taken as right


@dataclass(frozen=True, kw_only=True)
class WrongClocks:
    """Sensors whose clocks are wrong, with the offsets that follow."""

    wrong: tuple[ClockedSensor, ...]
    offsets: Offsets  # of all sensors
    sigma_s: Offsets  # sigmas of the offsets
    chi2: float

    @property
    def total(self) -> float:
        """Chi-square plus GAIN for each wrong clock, by which hypotheses are compared."""
        return self.chi2 + GAIN * len(self.wrong)

    def corrections(self) -> dict[ClockedSensor, float]:
        """Select the offsets of the wrong clocks."""
        return {sensor: self.offsets[sensor] for sensor in self.wrong}


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
    comparison tells nothing (`_scan_offsets`).
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
    comparison = evidence.comparison
    moved = 0.0

    def residuals(more_s: float) -> Array:
        """Compute the residuals with the first sensor's offset changed by so much."""
        first = start.get(comparison.first, 0.0) + more_s
        return comparison.residuals({**start, comparison.first: first})

    for _ in range(ROUNDS):
        slope, found, weight = _linearise(residuals, moved)
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


def _linearise(residuals: Callable[[float], Array], at_s: float) -> tuple[Array, Array, Array]:
    """Compute slopes by the offset, residuals and robust weights of rows, each (n, k).

    All are 0 where a residual is unknown. The weight is 1 up to TRUSTED sigmas, less beyond, and 0
    beyond WILD sigmas.

    residuals: computes them at an offset. at_s: the offset.
    """
    found = residuals(at_s)
    slope = (residuals(at_s + STEP_S) - residuals(at_s - STEP_S)) / (2 * STEP_S)
    known = np.isfinite(found) & np.isfinite(slope)
    if not known.any():
        return np.zeros_like(slope), np.zeros_like(found), np.zeros_like(found)
    size = np.abs(np.where(known, found, np.inf))
    sigma = robust_sigma(found[known], about=0.0)
    trusted = np.minimum(1.0, TRUSTED * sigma / np.maximum(size, 1e-12))
    weight = np.where(size < WILD * sigma, trusted, 0.0)
    return np.where(known, slope, 0.0), np.where(known, found, 0.0), weight


def find_wrong_clocks(evidence: Sequence[Evidence]) -> list[WrongClocks]:
    """Find whose clocks are wrong: none, one or two.

    The hypotheses are that all clocks are right, that one sensor's is wrong, and, where that leaves
    much unexplained, that a second one is wrong too. Those of nearly the least `total` are
    equivalent.

    Returns
    -------
    list of WrongClocks
        A single hypothesis where the answer is known, without sensors where all clocks are right.
        Several that explain as much where it is not known which of them is true.
    """
    # Start from right clocks, and try each sensor alone, then with a second one.
    present = {s for e in evidence for s in (e.comparison.first, e.comparison.second)}
    sensors = [sensor for sensor in ClockedSensor if sensor in present]
    right = solve_offsets(evidence, (), {})
    if _excess_chi2(evidence, right) < GAIN:
        return [right]
    found = [right]
    for sensor in sensors:
        one = _with_one_more_wrong(evidence, right, sensor)
        if one is None:
            continue
        found.append(one)
        if _excess_chi2(evidence, one) >= GAIN:
            more = (
                _with_one_more_wrong(evidence, one, other)
                for other in sensors
                if other is not sensor
            )
            found += [two for two in more if two is not None]
    found = [_with_right_imu(evidence, hypothesis, sensors) for hypothesis in found]
    found.sort(key=lambda hypothesis: -hypothesis.total)
    # Keep those nearly as good as the best. If right clocks are among them, nothing is wrong.
    alike = {h.wrong: h for h in found if h.total < found[-1].total + ALIKE}
    if () in alike:
        return [alike[()]]
    # where two clocks disagree, the IMU's is taken as right
    return [h for h in alike.values() if ClockedSensor.IMU not in h.wrong] or list(alike.values())


def solve_offsets(
    evidence: Sequence[Evidence], wrong: tuple[ClockedSensor, ...], start: Offsets
) -> WrongClocks:
    """Estimate all offsets by weighted least squares, given which clocks are wrong.

    Each comparison, refined from `start`, measures the difference of two offsets. Comparisons are
    weighted by their scatter alone. Sigmas and chi-square include their systematic error too.

    Parameters
    ----------
    evidence
        The comparisons. Those whose residuals do not depend on the offset add to chi-square alone.
    wrong
        Sensors whose clocks are taken as wrong, so that their offsets are free. Others are held
        near zero.
    start
        Offsets of the wrong ones, near which minima are searched.
    """
    sensors = list(ClockedSensor)
    prior = np.array([UNKNOWN_S if sensor in wrong else SYNCHRONISED_S for sensor in sensors])
    # a row for each comparison: +1 and -1 at its two sensors, and the difference that it measured
    cost, rows, measured, variance, systematic = 0.0, [], [], [], []
    for one in evidence:
        fit = refine(one, start)
        if fit is None:  # its residuals do not depend on the offset
            cost += one.cost(start)
            continue
        first, second = one.comparison.first, one.comparison.second
        moved = fit.relative_s - one.relative(start)
        cost += one.cost({**start, first: start.get(first, 0.0) + moved})
        rows.append([(sensor is first) - float(sensor is second) for sensor in sensors])
        measured.append(fit.relative_s)
        variance.append(fit.variance)
        systematic.append(one.comparison.systematic_s)
    design = np.array(rows).reshape(-1, len(sensors))
    by_scatter, whole = np.array(variance), np.array(variance) + np.square(systematic)
    information = design.T @ (design / by_scatter[:, None]) + np.diag(prior**-2.0)
    offsets = np.linalg.solve(information, design.T @ (measured / by_scatter))
    covariance = np.linalg.inv(design.T @ (design / whole[:, None]) + np.diag(prior**-2.0))
    misfit = np.square(design @ offsets - measured) / whole
    return WrongClocks(
        wrong=wrong,
        offsets=dict(zip(sensors, offsets.tolist(), strict=True)),
        sigma_s=dict(zip(sensors, np.sqrt(np.diag(covariance)).tolist(), strict=True)),
        chi2=cost + float(misfit.sum() + np.square(offsets / prior).sum()),
    )


def remaining_offset_sigmas(
    evidence: Sequence[Evidence], corrected: Offsets, span: Span
) -> dict[ClockedSensor, float]:
    """Estimate the sigma, s, of each sensor's remaining offset from the IMU, after a correction.

    The path's sigmas are widened by it. A sensor that no comparison checks gets UNCHECKED_S. The
    sigma includes an offset that is seen but was not corrected, and the drift of a clock that runs
    fast or slow. Where it is not known which of two clocks drifts, both get it.

    Parameters
    ----------
    evidence
        The comparisons, with rows within the span alone.
    corrected
        Offsets that are taken off the stamps. What is seen beyond them remains.
    span
        First and last instant, from which the time follows over which a clock drifts.
    """
    middle_ns, lasts_s = (span[0] + span[1]) // 2, (span[1] - span[0]) / NS
    # Least squares for the offsets of all sensors but the IMU, with a wide prior about zero.
    sensors = [sensor for sensor in ClockedSensor if sensor is not ClockedSensor.IMU]
    information, gradient = np.eye(len(sensors)) / UNCHECKED_S**2, np.zeros(len(sensors))
    rates = np.zeros(len(sensors))
    for one in evidence:
        fit, rate = refine(one, corrected), _relative_rate(one, corrected, middle_ns)
        first, second = one.comparison.first, one.comparison.second
        row = np.array([(sensor is first) - float(sensor is second) for sensor in sensors])
        systematic = one.comparison.systematic_s
        if fit is not None:
            weight = 1 / (fit.variance + systematic**2)
            information += weight * np.outer(row, row)
            gradient += weight * row * (fit.relative_s - one.relative(corrected))
        # systematic errors may differ between the ends of the dive, and so look like a rate
        if rate is not None and abs(rate[0]) > SEEN_RATE * np.hypot(rate[1], systematic / lasts_s):
            rates = np.maximum(rates, np.abs(row) * abs(rate[0]))
    covariance = np.linalg.inv(information)
    offset = covariance @ gradient
    # of a steady drift about the middle of the span the variance is (rate * time)^2 / 12
    sigma = np.sqrt(np.diag(covariance) + offset**2 + (rates * lasts_s) ** 2 / 12)
    return dict(zip(sensors, sigma.tolist(), strict=True))


def _relative_rate(
    evidence: Evidence, corrected: Offsets, middle_ns: int
) -> tuple[float, float] | None:
    """Estimate the relative rate of a comparison's clocks, s a second, and its sigma.

    Rate and offset are fitted together by one weighted least-squares step from the best offset. The
    sigma is cluster-robust. None where the residuals do not depend on both.

    middle_ns: instant at which the rate adds nothing to the offset.
    """
    comparison = evidence.comparison

    def residuals(more_s: float) -> Array:
        """Compute the residuals with the first sensor's offset changed by so much."""
        first = corrected.get(comparison.first, 0.0) + more_s
        return comparison.residuals({**corrected, comparison.first: first})

    fit = refine(evidence, corrected)
    if fit is None:
        return None
    at_s = fit.relative_s - evidence.relative(corrected)
    slope, found, weight = _linearise(residuals, at_s)
    since_s = 0.5 * ((comparison.begin_ns - middle_ns) + (comparison.end_ns - middle_ns)) / NS
    # derivatives (2, n, k) of the residuals by the offset and by the rate
    columns = np.stack([slope, slope * since_s[:, None]])
    information = np.einsum("ank,bnk->ab", columns * weight, columns)
    if not np.linalg.eigvalsh(information)[0] > 0:
        return None
    gradient = (weight * columns * found).sum(axis=2)
    step = -np.linalg.solve(information, gradient.sum(axis=1))
    inverse = np.linalg.inv(information)
    # gradients (2, n) of the rows after the step, whose scatter by row and by block is the variance
    remaining = (weight * columns * (found + np.tensordot(step, columns, 1))).sum(axis=2)
    by_row = remaining @ remaining.T
    blocks = np.stack([np.bincount(comparison.block, each) for each in remaining])
    variance = max((inverse @ scatter @ inverse)[1, 1] for scatter in (by_row, blocks @ blocks.T))
    return float(step[1]), float(np.sqrt(variance))


def _excess_chi2(evidence: Sequence[Evidence], hypothesis: WrongClocks) -> float:
    """Compute by how much chi-square exceeds that of each comparison at its own best offset."""
    return hypothesis.chi2 - sum(one.least_chi2 for one in evidence)


def _with_one_more_wrong(
    evidence: Sequence[Evidence], base: WrongClocks, sensor: ClockedSensor
) -> WrongClocks | None:
    """Test the hypothesis that one more sensor's clock is wrong.

    None where chi-square falls by less than GAIN, where it falls as much at another offset, or
    where the offset is not significant or is beyond FAR_S.

    base: the hypothesis so far, without this sensor.
    """
    # Offsets of the sensor at which one of its comparisons has a minimum, with the cost of all.
    start = base.corrections()
    wrong = tuple(other for other in ClockedSensor if other in base.wrong or other is sensor)
    candidates: list[tuple[float, float]] = []
    for one in evidence:
        first, second = one.comparison.first, one.comparison.second
        if sensor in (first, second):
            for minimum in one.minima_s:
                other = start.get(second if sensor is first else first, 0.0)
                at = other + minimum if sensor is first else other - minimum
                cost = sum(each.cost({**start, sensor: at}) for each in evidence)
                candidates.append((cost, at))
    # Solve from the cheapest of them that lie apart.
    best: list[WrongClocks] = []
    tried: list[float] = []
    for _, at in sorted(candidates):
        if len(tried) < TRIED and all(abs(at - other) >= OTHER_S for other in tried):
            tried.append(at)
            best.append(solve_offsets(evidence, wrong, {**start, sensor: at}))
    # The best one counts if it gains enough, is significant, and no other offset gains as much.
    best.sort(key=lambda hypothesis: hypothesis.chi2)
    if not best or base.chi2 - best[0].chi2 < GAIN:
        return None
    found = best[0].offsets[sensor]
    if abs(found) > FAR_S or abs(found) < SIGNIFICANT * best[0].sigma_s[sensor]:
        return None
    others = (h for h in best[1:] if abs(h.offsets[sensor] - found) >= OTHER_S)
    return None if any(h.chi2 - best[0].chi2 < GAIN for h in others) else best[0]


def _with_right_imu(
    evidence: Sequence[Evidence], found: WrongClocks, sensors: Sequence[ClockedSensor]
) -> WrongClocks:
    """Refer the offsets to the IMU's clock, unless that makes more clocks wrong.

    Only differences of offsets are observed, so that one clock has to be taken as right.
    """
    if ClockedSensor.IMU not in found.wrong or len(found.wrong) < 2:
        return found
    moved = {s: found.offsets[s] - found.offsets[ClockedSensor.IMU] for s in sensors}
    wrong = tuple(s for s in sensors if abs(moved[s]) >= SIGNIFICANT * found.sigma_s[s])
    if len(wrong) > len(found.wrong):
        return found
    return solve_offsets(evidence, wrong, {sensor: moved[sensor] for sensor in wrong})


def choose_by_segment(
    evidence: Sequence[Evidence], spans: Sequence[Span], states: Sequence[Offsets]
) -> list[int]:
    """Choose the offsets of each segment by least chi-square, plus ALIKE for each change.

    So offsets change at a pause only where the comparisons clearly ask for it. The best sequence is
    found by dynamic programming (Viterbi).

    Parameters
    ----------
    evidence
        The comparisons over the whole dive.
    spans
        First and last instant of each segment, in time order.
    states
        Offsets to choose from.

    Returns
    -------
    list of int
        For each segment a row of `states`.
    """
    # (segments, states); then, by segment: the least total that ends in each state, and the state
    # of the segment before from which it came
    cost = np.array(
        [[sum(e.cost(state, span) for e in evidence) for state in states] for span in spans]
    )
    change = ALIKE * (1 - np.eye(len(states)))
    total, came_from = cost[0], []
    for own in cost[1:]:
        came_from.append(np.argmin(total[:, None] + change, axis=0))
        total = own + (total[:, None] + change).min(axis=0)
    chosen = [int(np.argmin(total))]
    for row in reversed(came_from):
        chosen.append(int(row[chosen[-1]]))
    return chosen[::-1]


def segments(pauses_ns: Iterable[int], span: Span) -> list[Span]:
    """Cut a span where streams pause. Pauses outside are ignored, and common ones cut once."""
    inner = sorted({t for t in pauses_ns if span[0] < t < span[1]})
    return list(itertools.pairwise([span[0], *inner, span[1]]))


def time_offsets(
    spans: Sequence[Span], chosen: Sequence[WrongClocks], sensors: Sequence[ClockedSensor]
) -> list[TimeOffset]:
    """Join neighbouring segments with the same hypothesis, and list the wrong clocks of each.

    Parameters
    ----------
    spans, chosen
        The segments in time order, and the hypothesis that was chosen for each.
    sensors
        Sensors that were compared. Those among them with right clocks are named with each offset.

    Returns
    -------
    list of TimeOffset
        By sensor, then by time. Empty where all clocks are right.
    """
    out: list[TimeOffset] = []
    k = 0
    for hypothesis, group in itertools.groupby(chosen):
        count = len(list(group))
        begin, end = spans[k][0], spans[k + count - 1][1]
        right = tuple(sensor for sensor in sensors if sensor not in hypothesis.wrong)
        out += [
            TimeOffset(
                sensor=sensor,
                from_ns=begin,
                to_ns=end,
                seconds=hypothesis.offsets[sensor],
                sigma_s=hypothesis.sigma_s[sensor],
                relative_to=right,
            )
            for sensor in hypothesis.wrong
        ]
        k += count
    return sorted(
        out, key=lambda offset: (list(ClockedSensor).index(offset.sensor), offset.from_ns)
    )


def _clipped(residuals: Array, sigma: float) -> Array:
    """Sum the squares of residuals (n, k) in sigmas by row (n,), each clipped at half of WILD."""
    return np.asarray(np.square(np.minimum(np.abs(residuals) / sigma, WILD / 2)).sum(axis=1))


def _filled(cost: Array, mean_cost: Array) -> Array:
    """Replace unknown costs of a row by its mean cost, so that they favour no offset.

    With zero in their place the largest offsets, which leave the fewest rows, would look best.
    """
    return np.where(np.isfinite(cost), cost, mean_cost)
