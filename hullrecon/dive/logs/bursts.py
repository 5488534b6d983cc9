# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find stamps that say when readings were received, in bursts, and spread them over the time.

A computer that reads a serial buffer now and then, and a clock of whole seconds, give several
readings within no time, and none for as long as the next ones take to gather.
"""

from __future__ import annotations

import numpy as np

from hullrecon.findings.finding import Finding
from hullrecon.records.clock import NS
from hullrecon.typing import Array, Ints

CLOSE = 0.2  # of the mean step: readings of one burst are closer
LEAST_BURSTS, LEAST_SIZE = 10, 3  # bursts, and readings of their median
UNEVEN = 2.0  # times the median interval, which nine of ten intervals between bursts stay below
LONGEST_S = 5.0  # between bursts; an instrument that measures in bursts pauses for minutes
# between the clocks of sensor and logger, from which on only their difference says anything
FAR_S = 60.0


def spread_bursts(name: str, stamp: Ints, logged: Ints, notes: list[Finding]) -> Ints:
    """Spread stamps that come in bursts over the time in which they were measured.

    Where the logger's times do not come in bursts, those are taken. Other streams are kept.

    Parameters
    ----------
    name : of the stream, for the notes
    stamp, logged : (n,) ns, by sensor and by logger; alike where the log has one time only
    notes : what was done is added
    """
    order = np.argsort(stamp, kind="stable")
    starts = _bursts(stamp[order])
    if starts is None:
        return stamp
    values: dict[str, object] = {"count": len(stamp), "bursts": len(starts)}
    if _bursts(np.sort(logged)) is None:
        delay = int(np.median(logged - stamp))
        notes.append(Finding("stamps-in-bursts", {**values, "within_s": None}, name))
        return logged - (delay if abs(delay) > FAR_S * NS else 0)
    spread, within_s = _spread(stamp[order], starts)
    notes.append(Finding("stamps-in-bursts", {**values, "within_s": within_s}, name))
    out = np.empty_like(stamp)
    out[order] = spread
    return out


def _bursts(t_ns: Ints) -> Ints | None:
    """Find the first rows (b,) of bursts among sorted stamps. None where there are none."""
    if len(t_ns) < LEAST_BURSTS * LEAST_SIZE:
        return None
    step = np.diff(t_ns)
    starts = np.flatnonzero(np.r_[True, step >= CLOSE * step.mean()])
    sizes, apart = np.diff(np.r_[starts, len(t_ns)]), np.diff(t_ns[starts])
    if len(starts) < LEAST_BURSTS or np.median(sizes) < LEAST_SIZE:
        return None
    usual = float(np.median(apart))
    is_even = np.percentile(apart, 90) < UNEVEN * usual <= UNEVEN * LONGEST_S * NS
    return starts if is_even else None


def _spread(t_ns: Ints, starts: Ints) -> tuple[Ints, float]:
    """Spread each burst over the time since the one before, where stamps grow within it.

    A clock of whole seconds, of which all stamps of a burst are alike, stands at their beginning.

    Returns
    -------
    stamps (n,), and the median time between two of them, s, to which they are known
    """
    ends = np.r_[starts[1:], len(t_ns)]
    is_coarse = bool((t_ns[ends - 1] == t_ns[starts]).mean() > 0.5)
    at = t_ns[starts] if is_coarse else t_ns[ends - 1]
    apart = np.diff(at)
    usual = int(np.median(apart))
    # a pause is no time in which readings gathered
    lasts = np.minimum(np.r_[apart, usual] if is_coarse else np.r_[usual, apart], 2 * usual)
    begin = at if is_coarse else at - lasts
    burst = np.repeat(np.arange(len(starts)), ends - starts)
    share: Array = (np.arange(len(t_ns)) - starts[burst] + 0.5) / (ends - starts)[burst]
    spread = begin[burst] + np.round(share * lasts[burst]).astype(np.int64)
    return spread, float(np.median(lasts / (ends - starts))) / NS
