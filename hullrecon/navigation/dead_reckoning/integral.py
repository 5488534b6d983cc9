# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Integrate signals sampled at uneven times, linear between their samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.typing import Array


@dataclass(frozen=True)
class Integral:
    """A running integral from the first sample, by the trapezoidal rule."""

    t_s: Array  # (n,)
    signal: Array  # (n, ...)
    total: Array  # (n, ...) integral up to each sample

    def at(self, t_s: Array) -> Array:
        """Evaluate the integral (m, ...) at times (m,).

        Beyond the ends the signal holds its last value.
        """
        left = np.clip(np.searchsorted(self.t_s, t_s, side="right") - 1, 0, len(self.t_s) - 2)
        # Seconds from the sample before each time: as far as the next sample, and beyond an end
        step_s = self.t_s[left + 1] - self.t_s[left]
        inside_s = np.clip(t_s - self.t_s[left], 0.0, step_s)
        outside_s = t_s - self.t_s[left] - inside_s
        start, stop = self.signal[left], self.signal[left + 1]
        rows = (slice(None), *[None] * (self.signal.ndim - 1))  # (m,) broadcast over the signal
        within = start * inside_s[rows] + (stop - start) * (0.5 * inside_s**2 / step_s)[rows]
        beyond = np.where((outside_s > 0)[rows], stop, start) * outside_s[rows]
        return np.asarray(self.total[left] + within + beyond)


def integral(t_s: Array, signal: Array) -> Integral:
    """Integrate a signal, linear between its samples (n, ...), of which there are at least two.

    t_s: (n,) their times, increasing.
    """
    step = np.diff(t_s).reshape(-1, *[1] * (signal.ndim - 1))
    pieces = 0.5 * (signal[1:] + signal[:-1]) * step
    return Integral(
        t_s, signal, np.concatenate([np.zeros((1, *signal.shape[1:])), np.cumsum(pieces, axis=0)])
    )
