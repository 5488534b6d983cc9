# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stretches of a log in which clocks run evenly, between the pauses that a jump of one of them
would look like; and what is wrong with the clocks in each.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from hullrecon.dive.logs.timeline import JUMP_S
from hullrecon.navigation.clocks.clock_errors import ClockError
from hullrecon.records.clock import NS
from hullrecon.typing import Ints

MOST_PAUSES = 4  # of a stream, the longest; one with more loses readings all the time
PREFERRED = 2.0  # sigmas by which one of two explanations has to be the better one
CLEAR = 5.0  # by which it is beyond doubt

Span = tuple[int, int]  # first and last instant, ns
# what is wrong with the clocks in a span; sentences on what is not known of it
Decision = tuple[list[ClockError], list[str]]
# How many sigmas better some errors of the clocks explain what was measured in a span than others
# do; negative where worse.
Better = Callable[[Span, Sequence[ClockError], Sequence[ClockError]], float]


def decide_by_stretch(
    spans: Sequence[Span], decide: Callable[[Span], Decision], better: Better
) -> Decision:
    """Return the errors of the clocks over all stretches: the same all along, as the whole dive
    shows them, but in a stretch that contradicts them.

    A pause is seldom a jump of a clock, and a stretch that is too short to tell by itself is
    likelier to go with the rest than to be right beside it. Where the whole shows no errors, each
    stretch is asked; one that does not tell goes with a neighbour whose errors explain it better
    than none.
    """
    whole = decide((spans[0][0], spans[-1][1]))
    if len(spans) == 1:
        return whole
    found = [_decide_within(span, whole[0], decide, better) for span in spans]
    errors: list[ClockError] = []
    unknown: list[str] = []
    for k, (span, (own, sentences)) in enumerate(zip(spans, found, strict=True)):
        beside = (
            []
            if own
            else [_within(found[j][0], span) for j in (k - 1, k + 1) if 0 <= j < len(spans)]
        )
        likelier = [other for other in beside if other and better(span, other, ()) >= PREFERRED]
        errors += own or next(iter(likelier), [])
        unknown += [] if own or likelier else sentences
    return errors, list(dict.fromkeys(unknown))


def _decide_within(
    span: Span, of_whole: Sequence[ClockError], decide: Callable[[Span], Decision], better: Better
) -> Decision:
    """Return the errors in a stretch of a dive that has some as a whole."""
    whole = _within(of_whole, span)
    gain = better(span, whole, ()) if whole else 0.0
    if whole and gain >= CLEAR:
        return whole, []
    own = decide(span)
    if whole and gain > -PREFERRED and not (own[0] and better(span, own[0], whole) >= CLEAR):
        return whole, []
    return own


def _within(errors: Iterable[ClockError], span: Span) -> list[ClockError]:
    return [replace(error, from_ns=span[0], to_ns=span[1]) for error in errors]


def stretches(streams: Sequence[Ints]) -> list[Span]:
    """Return first and last instant, ns, of the stretches between the pauses of any stream;
    streams: stamps in time order, none of them empty.
    """
    ends = min(int(t_ns[0]) for t_ns in streams), max(int(t_ns[-1]) for t_ns in streams)
    inner = np.unique(np.concatenate([_pauses(t_ns) for t_ns in streams])).tolist()
    return list(
        itertools.pairwise([ends[0], *(t for t in inner if ends[0] < t < ends[1]), ends[1]])
    )


def _pauses(t_ns: Ints) -> Ints:
    """Return the middles of a stream's longest pauses: those that a jump of its clock would leave."""
    if len(t_ns) < 2:
        return np.zeros(0, np.int64)
    step = np.diff(t_ns)
    long = np.flatnonzero(step - np.median(step) >= JUMP_S * NS)
    longest = long[np.argsort(-step[long], kind="stable")[:MOST_PAUSES]]
    return np.asarray(t_ns[longest] + step[longest] // 2, np.int64)
