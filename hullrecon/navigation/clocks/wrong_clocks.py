# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find whose clocks are wrong, and by how much, from comparisons of two clocks each.

See docs/methods.md, Clocks. A hypothesis names the sensors whose clocks are wrong: all offsets
follow by weighted least squares, in which right clocks have a narrow prior and wrong ones none. A
wrong clock has to lower chi-square by GAIN, and must do so better than any other offset and any
other sensor.

Offsets are positive where stamps are late, and are subtracted from them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.robust import ALIKE, GAIN, SIGNIFICANT
from hullrecon.navigation.clocks.comparisons.comparison import ClockedSensor, Offsets
from hullrecon.navigation.clocks.evidence import FAR_S, OTHER_S, Evidence, refine

SYNCHRONISED_S = 0.005  # prior sigma of a right clock's offset
UNKNOWN_S = 1000.0  # prior sigma of a wrong clock's offset
TRIED = 3  # candidates that are refined


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
    # the best last, so that it remains where two name the same sensors
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
        cost += one.cost(one.comparison.moved(start, fit.relative_s - one.relative(start)))
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
