# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tell by its readings whether a topic can be the vehicle's depth, and in which unit it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from hullrecon.dive.logs.samples import DepthSample, PressureSample, Sample
from hullrecon.dive.logs.streams.pressure import DEEPEST_HULL_M, PASCALS, STILL_M
from hullrecon.records.clock import NS
from hullrecon.typing import Array

MOST_READINGS = 512  # of a topic, evenly over the log
LOWEST_AIR_PA, AIR_PA = 80e3, 101325.0  # the lowest ever measured at sea is 87 kPa
PASCALS_A_METRE = 1025 * 9.81  # of sea water
# A still topic is no depth if another one of the dive changes by at least FOLLOWS times STILL_M
FOLLOWS = 3.0


@dataclass(kw_only=True)
class DepthSignal:
    """Readings of one topic, spread over the log."""

    values: list[float] = field(default_factory=list)  # as logged: a pressure, or m
    is_pressure: bool = False
    is_number: bool = False  # a depth without a convention which way it grows
    _every_ns: int = NS  # between two readings that are kept
    _next_ns: int = 0  # when the next one is

    def is_due(self, t_ns: int) -> bool:
        """Tell whether a message logged at t_ns is to be read."""
        return t_ns >= self._next_ns

    def take(self, t_ns: int, samples: Sequence[Sample]) -> None:
        """Keep the readings of a message that is due.

        Beyond MOST_READINGS every second one is dropped, and the time between two is doubled: those
        kept are spread evenly over a log whose length is not known.
        """
        self._next_ns = t_ns + self._every_ns
        for sample in samples:
            if isinstance(sample, PressureSample):
                self.is_pressure = True
                self.values.append(sample.pascal)
            elif isinstance(sample, DepthSample):
                self.is_number = not sample.is_up
                self.values.append(sample.height)
        if len(self.values) > MOST_READINGS:
            self.values, self._every_ns = self.values[::2], 2 * self._every_ns

    @property
    def unit(self) -> str | None:
        """The largest unit in which all readings lie between the surface and the deepest hull.

        None for depths, and where no unit fits.
        """
        known = self._known()
        if not self.is_pressure or not len(known):
            return None
        deepest_pa = AIR_PA + DEEPEST_HULL_M * PASCALS_A_METRE
        fitting = [
            unit
            for unit, scale in PASCALS.items()
            if known.min() * scale >= LOWEST_AIR_PA and known.max() * scale <= deepest_pa
        ]
        return fitting[-1] if fitting else None

    @property
    def grows_up(self) -> bool:
        """Tell whether a number is negative below the water, as heights are."""
        known = self._known()
        return self.is_number and len(known) > 0 and bool(np.median(known) < -STILL_M)

    @property
    def span_m(self) -> float:
        """By how much the depth changes, m, without the outermost twentieths of the readings."""
        known = self._known()
        if not len(known):
            return 0.0
        low, high = np.percentile(known, [5, 95])
        scale = PASCALS[self.unit or "Pa"] / PASCALS_A_METRE if self.is_pressure else 1.0
        return float(scale * (high - low))

    def _known(self) -> Array:
        """Select the finite readings (n,), as logged."""
        values = np.array(self.values, float)
        return np.asarray(values[np.isfinite(values)])


def drop_still(signals: Sequence[DepthSignal]) -> list[int]:
    """List the rows of the signals that may be the depth.

    One that stays still while another changes is the pressure of something else, as of the air in
    an enclosure. All may be the depth where none changes much. Signals without a reading are kept.
    """
    spans = [signal.span_m for signal in signals]
    moving = max(spans, default=0.0)
    return [
        row
        for row, (signal, span) in enumerate(zip(signals, spans, strict=True))
        if span >= STILL_M or moving < FOLLOWS * STILL_M or not signal.values
    ]
