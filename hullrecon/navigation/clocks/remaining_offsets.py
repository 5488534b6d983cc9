# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Estimate by how much clocks may still differ after their offsets were corrected."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hullrecon.navigation.clocks.comparisons.comparison import ClockedSensor, Offsets, Span
from hullrecon.navigation.clocks.evidence import Evidence, linearise, refine
from hullrecon.records.clock import NS

# sigma of the offset of a clock that no comparison checks: a driver that stamps messages when they
# arrive is late by the time that the instrument and the transmission take
UNCHECKED_S = 0.1
# Sigmas from which on a clock's rate counts. Quartz is right to 1e-4, which no dive shows
SEEN_RATE = 3.0


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
        # the comparison measures the offset of its first sensor minus that of its second
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
    """Estimate the rate of a comparison's first clock relative to the second, s/s, and its sigma.

    Rate and offset are fitted together by one weighted least-squares step from the best offset. The
    sigma is cluster-robust. None where the residuals do not depend on both.

    corrected: the offsets that were found and taken off, about which the fit is linear.
    middle_ns: instant at which the rate adds nothing to the offset.
    """
    comparison = evidence.comparison
    fit = refine(evidence, corrected)
    if fit is None:
        return None
    at_s = fit.relative_s - evidence.relative(corrected)
    slope, residual, weight = linearise(comparison, corrected, at_s)
    since_s = 0.5 * ((comparison.begin_ns - middle_ns) + (comparison.end_ns - middle_ns)) / NS
    # derivatives (2, n, k) of the residuals by the offset and by the rate
    columns = np.stack([slope, slope * since_s[:, None]])
    information = np.einsum("ank,bnk->ab", columns * weight, columns)
    if not np.linalg.eigvalsh(information)[0] > 0:
        return None
    gradient = (weight * columns * residual).sum(axis=2)
    step = -np.linalg.solve(information, gradient.sum(axis=1))
    inverse = np.linalg.inv(information)
    # Gradients (2, n) of the rows after the step. Their scatter gives the variance. Errors may be
    # common to a block of rows, so the larger of the scatters by row and by block counts.
    remaining = (weight * columns * (residual + np.tensordot(step, columns, 1))).sum(axis=2)
    by_row = remaining @ remaining.T
    blocks = np.stack([np.bincount(comparison.block, each) for each in remaining])
    variance = max((inverse @ scatter @ inverse)[1, 1] for scatter in (by_row, blocks @ blocks.T))
    return float(step[1]), float(np.sqrt(variance))
