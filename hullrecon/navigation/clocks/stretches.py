# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stretches of a log in which clocks run evenly: between the pauses that a jump of one of them would look like."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from hullrecon.dive.logs.timeline import JUMP_S, NS
from hullrecon.typing import Ints

MOST_PAUSES = 4  # of a stream, the longest; one with more loses readings all the time


def stretches(streams: Sequence[Ints]) -> list[tuple[int, int]]:
    """Return first and last instant, ns, of the stretches between the pauses of any stream; streams: stamps in time order, none
    of them empty."""
    ends = min(int(t_ns[0]) for t_ns in streams), max(int(t_ns[-1]) for t_ns in streams)
    inner = np.unique(np.concatenate([_pauses(t_ns) for t_ns in streams])).tolist()
    return list(itertools.pairwise([ends[0], *(t for t in inner if ends[0] < t < ends[1]), ends[1]]))


def _pauses(t_ns: Ints) -> Ints:
    """Return the middles of a stream's longest pauses: those that a jump of its clock would leave."""
    if len(t_ns) < 2:
        return np.zeros(0, np.int64)
    step = np.diff(t_ns)
    long = np.flatnonzero(step - np.median(step) >= JUMP_S * NS)
    longest = long[np.argsort(-step[long], kind="stable")[:MOST_PAUSES]]
    return np.asarray(t_ns[longest] + step[longest] // 2, np.int64)
