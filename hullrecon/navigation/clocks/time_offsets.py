# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The time offsets of the sensors along a dive. They may change where a stream pauses.

Offsets are positive where stamps are late, and are subtracted from them.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.robust import ALIKE
from hullrecon.navigation.clocks.comparisons.comparison import ClockedSensor, Offsets, Span
from hullrecon.navigation.clocks.evidence import Evidence
from hullrecon.navigation.clocks.wrong_clocks import WrongClocks


@dataclass(frozen=True, kw_only=True)
class TimeOffset:
    """By how much a sensor's stamps are late in a span, at least SIGNIFICANT sigmas."""

    sensor: ClockedSensor
    from_ns: int
    to_ns: int
    seconds: float  # late: to be subtracted from the stamps; negative where they are early
    sigma_s: float
    relative_to: tuple[ClockedSensor, ...]  # sensors whose clocks are taken as right


def segments(pauses_ns: Iterable[int], span: Span) -> list[Span]:
    """Cut a span where streams pause. Pauses outside are ignored, and common ones cut once."""
    inner = sorted({t for t in pauses_ns if span[0] < t < span[1]})
    return list(itertools.pairwise([span[0], *inner, span[1]]))


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
