# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Smooth unevenly sampled signals without lag, by a local line with Gaussian weights.

A straight trend is left unchanged, at the ends too. The time taken does not grow with the width.
"""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.robust import median_of_known
from hullrecon.typing import Array, Ints

BINS_A_WIDTH = 6
REACH = 4  # widths of the Gaussian that count


def local_line(t_s: Array, values: Array, at_s: Array, width_s: float) -> tuple[Array, Array]:
    """Fit lines to samples by weighted least squares, with Gaussian weights about given times.

    Samples are gathered into bins of a sixth of the width, whose moments up to the second are
    convolved with the Gaussian. Bins exist only near samples, so that memory does not grow with the
    time that they span. Where a gap leaves no sample within reach, the result is interpolated.

    Parameters
    ----------
    t_s, values
        Samples (n, k) at times (n,).
    at_s
        Times (m,) about which lines are fitted.
    width_s
        Sigma of the weights.

    Returns
    -------
    tuple
        Value (m, k) and slope (m, k) of the lines.
    """
    step = width_s / BINS_A_WIDTH
    start = min(t_s.min(), at_s.min())
    # bin of each sample, and its offset from the bin's middle
    cell = np.floor((t_s - start) / step + 0.5).astype(np.int64)
    off = t_s - start - cell * step
    values = values.reshape(len(t_s), -1)
    bins = _bins_near(cell)
    bin_of = np.searchsorted(bins, cell)
    weight = [_sum_by_bin(bin_of, off**power, len(bins)) for power in range(3)]
    moment = [
        np.stack([_sum_by_bin(bin_of, off**power * v, len(bins)) for v in values.T], axis=1)
        for power in range(2)
    ]
    level, slope = _fit_lines(weight, moment, step, width_s)
    node = start + step * bins
    return _interpolate(node, level, at_s), _interpolate(node, slope, at_s)


def running_median(values: Array, count: int) -> Array:
    """Compute the running median of (n, k) over `count` (odd) neighbours, ignoring NaN.

    Beyond the ends the first and the last value are repeated. The result is NaN where all
    neighbours are.
    """
    padded = np.pad(values, ((count // 2, count // 2), (0, 0)), mode="edge")
    return median_of_known(np.lib.stride_tricks.sliding_window_view(padded, count, axis=0))


def _bins_near(cell: Ints) -> Ints:
    """List the bins (g,), ascending, within reach of any sample. cell: (n,) bin of each sample.

    Where the list leaves a gap, the samples on one side do not reach the bins on the other.
    """
    reach = REACH * BINS_A_WIDTH
    used = np.unique(cell)
    first = np.concatenate([[0], 1 + np.flatnonzero(np.diff(used) > 2 * reach)])
    low, high = used[first] - reach, used[np.concatenate([first[1:], [len(used)]]) - 1] + reach
    return np.concatenate(
        [np.arange(a, b + 1) for a, b in zip(low.tolist(), high.tolist(), strict=True)]
    )


def _sum_by_bin(cell: Ints, weight: Array, size: int) -> Array:
    return np.asarray(np.bincount(cell, weight, minlength=size)[:size], float)


def _fit_lines(
    weight: list[Array], moment: list[Array], step: float, width_s: float
) -> tuple[Array, Array]:
    """Fit level (g, k) and slope (g, k) at the bins. NaN where no sample is in reach.

    Both follow from the weighted sums of x^0, x^1, x^2 (s0, s1, s2) and of y, x y (y0, y1), where x
    counts from the bin.

    Parameters
    ----------
    weight
        Sums (g,) over the samples of each bin of their offset from its middle to the power of 0, 1
        and 2.
    moment
        Sums (g, k) of y, and of y times the offset.
    step, width_s
        Size of a bin, and sigma of the weights.
    """
    x = step * np.arange(-REACH * BINS_A_WIDTH, REACH * BINS_A_WIDTH + 1)
    kernel = np.exp(-0.5 * (x / width_s) ** 2)
    s0 = _correlate(weight[0], kernel)
    s1 = _correlate(weight[0], kernel * x) + _correlate(weight[1], kernel)
    s2 = (
        _correlate(weight[0], kernel * x**2)
        + 2 * _correlate(weight[1], kernel * x)
        + _correlate(weight[2], kernel)
    )
    y0 = _correlate(moment[0], kernel)
    y1 = _correlate(moment[0], kernel * x) + _correlate(moment[1], kernel)
    in_reach = s0 > 1e-6
    s0 = np.where(in_reach, s0, np.nan)
    spread = s2 - s1**2 / s0
    # samples that lie too close together show no slope: the line is level there
    per_spread = np.where(spread > 1e-3 * width_s**2 * s0, 1.0, 0.0) / np.maximum(spread, 1e-12)
    slope = (y1 - (s1 / s0)[:, None] * y0) * per_spread[:, None]
    return (y0 - slope * s1[:, None]) / s0[:, None], slope


def _correlate(signal: Array, kernel: Array) -> Array:
    from scipy.ndimage import correlate1d

    return np.asarray(correlate1d(signal, kernel, axis=0, mode="constant"))


def _interpolate(node: Array, table: Array, at_s: Array) -> Array:
    known = np.isfinite(table[:, 0])
    return np.stack([np.interp(at_s, node[known], column[known]) for column in table.T], axis=1)
