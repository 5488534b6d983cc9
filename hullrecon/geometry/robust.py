# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Robust spread of values, quantiles of weighted values, and thresholds of significance."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

from hullrecon.typing import Array

# Ratio of the sigma of normal values to their median absolute deviation: 1 / Phi^-1(3/4)
NORMAL_MAD = 1.4826
SIGNIFICANT = 5.0  # sigmas by which an error has to differ from zero to be believed
GAIN = SIGNIFICANT**2  # by which chi-square has to fall for a hypothesis to be believed
ALIKE = 4.0  # hypotheses whose chi-squares differ by less explain as much
HUBER = 2.0  # sigmas of a residual beyond which its weight falls


def robust_sigma(values: Array, about: float | None = None) -> float:
    """Estimate the sigma of values (n,) by their median absolute deviation from `about`.

    The values are assumed normal, with up to half of them outliers. By default `about` is their
    median. NaN for no values.
    """
    if not len(values):
        return float("nan")
    distance = values - (np.median(values) if about is None else about)
    np.abs(distance, out=distance)
    return float(NORMAL_MAD * np.median(distance, overwrite_input=True))


def median_of_known(values: Array) -> Array:
    """Compute the medians (...) of rows (..., m), each of its values that are not NaN.

    As `numpy.nanmedian`, which masks arrays of short rows and takes ten times as long. NaN, without
    a warning, where all values are.
    """
    ordered = np.sort(values, axis=-1)  # NaN is last
    known = np.count_nonzero(~np.isnan(ordered), axis=-1, keepdims=True)
    middle = np.concatenate([np.maximum(known - 1, 0) // 2, known // 2], axis=-1)
    return np.asarray(np.take_along_axis(ordered, middle, axis=-1).sum(axis=-1) / 2)


def huber_weight(residual: Array, sigma: float | Array) -> Array:
    """Compute weights of residuals in least squares: 1 / sigma^2, less beyond HUBER sigmas."""
    ratio = HUBER * sigma / np.maximum(np.abs(residual), 1e-12)
    return np.asarray(np.minimum(1.0, ratio) / sigma**2)


def robust_sigma_of_blocks(blocks: Callable[[], Iterable[Array]]) -> float:
    """Compute `robust_sigma` of the values of all blocks together, a block at a time.

    blocks: reads the blocks, each of which has values. It is called several times.
    """
    middle = _median(blocks)
    return float(NORMAL_MAD * _median(lambda: (np.abs(values - middle) for values in blocks())))


def _median(blocks: Callable[[], Iterable[Array]]) -> float:
    """Find the median of the values of all blocks together."""
    # It lies between the least and the largest median of a block: of few values, where blocks are
    # alike. Of an even number of values both in the middle are needed, here as in each block.
    middles = [_middle(values) for values in blocks()]
    low, high = min(of_block[0] for of_block in middles), max(of_block[-1] for of_block in middles)
    count, below, near = 0, 0, []
    for values in blocks():
        count += len(values)
        below += int(np.count_nonzero(values < low))
        near.append(values[(values >= low) & (values <= high)])
    return float(np.mean(_middle(np.concatenate(near), count, below)))


def _middle(values: Array, count: int | None = None, below: int = 0) -> Array:
    """Find the one or two values in the middle of `count` values, of which `below` are left out."""
    count = len(values) if count is None else count
    ranks = np.unique([(count - 1) // 2, count // 2]) - below
    return np.asarray(np.partition(values, ranks)[ranks])


def weighted_quantile(values: Array, weight: Array, share: float) -> float:
    """Find which of the values (n,) has the cumulated weight (n,) reach a share of its total."""
    order = np.argsort(values, kind="stable")
    total = np.cumsum(weight[order])
    at = np.searchsorted(total, share * total[-1])
    return float(values[order][min(int(at), len(values) - 1)])
