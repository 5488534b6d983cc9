# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Check the stamps of one sensor: their order, duplicates, jumps of the clock and gaps."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
from numpy.typing import ArrayLike

from hullrecon.errors import InputError
from hullrecon.typing import Ints

NS = 1_000_000_000
JUMP_S = 1.0  # a clock that moves that much against the logger's has jumped; logging delays stay below
GAP_PERIODS = 5.0  # and at least GAP_S: a silence that is named
GAP_S = 1.0
LATE_S = 2.0  # after the first sensor, or before the last one: a late start and an early end that are named
BESIDE_NS = 30 * NS  # on either side of a jump: the readings that tell its size
STEADY = 0.1  # of a jump: what half of the offsets beside it may scatter by
LASTING = 20  # readings before and after a jump, at least, of a clock that is then put right; fewer are a late delivery
FEW = 2  # readings with one stamp are duplicates; more, and no other, are a clock that stands still


@dataclass(frozen=True)
class Timeline:
    """Hold the rows to keep, in time order and each stamp once, their stamps, and remarks on what was wrong with those."""

    keep: Ints
    t_ns: Ints
    remarks: list[str]


def put_in_order(name: str, stamp_ns: ArrayLike, logged_ns: ArrayLike) -> Timeline:
    """Return rows by time; of rows with one stamp the first stays. stamp_ns, logged_ns (n,) in the order of the log. InputError
    for a clock that stands still."""
    stamp, logged = np.asarray(stamp_ns, np.int64), np.asarray(logged_ns, np.int64)
    if len(stamp) > FEW and (stamp == stamp[0]).all():
        raise InputError(
            f"{name}: all {len(stamp)} stamps are the same, {format_time(int(stamp[0]))}",
            remedy="record the sensor with a clock that runs",
        )
    right = stamp - clock_error(stamp, logged)
    order = np.argsort(right, kind="stable")
    kept = np.ones(len(order), bool)
    kept[1:] = np.diff(right[order]) > 0
    remarks = describe_clock_jumps(name, stamp, logged)
    doubled = int(np.count_nonzero(~kept))
    if doubled:
        remarks.append(f"{name}: {doubled} of {len(stamp)} stamps are duplicates; the first of each was kept")
    backward = int(np.count_nonzero(np.diff(stamp) < 0))
    if backward and not remarks:
        remarks.append(f"{name}: {backward} readings stood out of order and were sorted")
    keep = order[kept]
    return Timeline(keep, right[keep], remarks)


def clock_error(stamp: Ints, logged: Ints) -> Ints:
    """Return by how much stamps (n,) are off after jumps of the sensor's clock against the logger's, ns; zeros where nothing
    shows it. A log without a clock of its own shows a clock that was set back.

    A jump counts that LASTING readings on either side agree on: what was logged late, and then caught up, is none. Right is the
    stretch whose offset is below JUMP_S, as of clocks that were synchronised, else the longest.
    """
    offset = stamp - logged
    if not offset.any():
        return _set_back(stamp)
    limits = np.concatenate([[0], 1 + np.flatnonzero(np.abs(np.diff(offset)) >= JUMP_S * NS), [len(stamp)]])
    stretches = [slice(a, b) for a, b in itertools.pairwise(limits.tolist()) if b - a >= LASTING]
    if len(stretches) < 2:
        return np.zeros_like(stamp)
    steps = [_lasting_jump(stamp, offset, before, after) for before, after in itertools.pairwise(stretches)]
    moved = np.concatenate([[0], np.cumsum(np.array(steps, np.int64))])
    away = np.array([abs(float(np.median(offset[stretch]))) for stretch in stretches])
    longest = int(np.argmax([stretch.stop - stretch.start for stretch in stretches]))
    right = int(np.argmin(away)) if away.min() < JUMP_S * NS else longest
    # readings of a stretch too short to tell go with the one before
    starts = np.array([stretch.start for stretch in stretches])
    of = np.maximum(np.searchsorted(starts, np.arange(len(stamp)), side="right") - 1, 0)
    return np.asarray((moved - moved[right])[of])


def _set_back(stamp: Ints) -> Ints:
    """Return by how much stamps (n,), in the order of the log, are off where the clock was set back while the sensor went on,
    ns: a later part then begins within the one before and ends after it. Zeros where parts were logged in another order or
    twice."""
    out, step = np.zeros_like(stamp), np.diff(stamp)
    limits = [0, *(1 + np.flatnonzero(step <= -JUMP_S * NS)).tolist(), len(stamp)]
    for (begin, middle), (_, end) in itertools.pairwise(itertools.pairwise(limits)):
        before, after = stamp[begin:middle], stamp[middle:end]
        overlap = after[after <= before[-1]]
        if min(len(before), len(after)) < LASTING or after[0] <= before[0] or after[-1] <= before[-1]:
            return np.zeros_like(stamp)
        if np.isin(overlap, before).mean() > 0.5:
            return np.zeros_like(stamp)
        out[middle:] -= before[-1] - after[0] + round(float(np.median(step[step > 0])))
    return out


def _lasting_jump(stamp: Ints, offset: Ints, before: slice, after: slice) -> int:
    """Return by how much the offset changes between two stretches, ns, by the readings beside the jump; 0 where either side is
    not steady."""
    sides = [
        offset[before][stamp[before] >= stamp[before][-1] - BESIDE_NS],
        offset[after][stamp[after] <= stamp[after][0] + BESIDE_NS],
    ]
    low, middle, high = (np.array([np.percentile(side, share) for side in sides]) for share in (25, 50, 75))
    jump = int(middle[1] - middle[0])
    return jump if abs(jump) >= JUMP_S * NS and (high - low).max() < STEADY * abs(jump) else 0


def describe_clock_jumps(name: str, stamp: Ints, logged: Ints) -> list[str]:
    """Return a sentence on jumps of the sensor's clock by a second or more against the logger's or its own last reading, and
    what became of the stamps."""
    moved = np.diff(stamp - logged) / NS
    back = np.diff(stamp) / NS
    jump = np.where(np.abs(moved) >= JUMP_S, moved, np.where(back <= -JUMP_S, back, 0.0))
    where = np.flatnonzero(jump)
    if not len(where):
        return []
    first = int(where[0])
    more = f", and {len(where) - 1} more times" if len(where) > 1 else ""
    at = format_time(int(stamp[first]))
    error = clock_error(stamp, logged)
    wrong = np.count_nonzero(error)
    by = "as if it had been set back" if np.array_equal(stamp, logged) else "by the logger's clock"
    done = f"{wrong} stamps were put right {by}" if wrong else "stamps around it cannot be trusted"
    return [f"{name}: the clock jumps by {jump[first]:+.3f} s at {at}{more}; {done}"]


def describe_gaps(name: str, t_ns: Ints, longest: int = 5) -> list[str]:
    """Return a sentence for each silence longer than five periods and a second, the longest first."""
    step = np.diff(t_ns) / NS
    if len(step) < 2:
        return []
    limit = max(GAP_S, GAP_PERIODS * float(np.median(step)))
    silent = np.flatnonzero(step > limit)
    lines = [
        f"{name}: nothing for {step[i]:.1f} s from {format_time(int(t_ns[i]))} to {format_time(int(t_ns[i + 1]))}"
        for i in sorted(silent, key=lambda i: -step[i])[:longest]
    ]
    return lines + ([f"{name}: {len(silent) - longest} more gaps, shorter"] if len(silent) > longest else [])


def describe_ends(name: str, t_ns: Ints, start_ns: int, stop_ns: int) -> list[str]:
    """Return a sentence where a sensor began late or ended early beside the whole log, by LATE_S or more."""
    late_s, early_s = (int(t_ns[0]) - start_ns) / NS, (stop_ns - int(t_ns[-1])) / NS
    out = [f"{name}: begins {late_s:.1f} s after the log does"] if late_s >= LATE_S else []
    return out + ([f"{name}: ends {early_s:.1f} s before the log does"] if early_s >= LATE_S else [])


def rate_hz(t_ns: Ints) -> float:
    """Return the rate by the median step, Hz; 0 for fewer than two readings."""
    return float(NS / np.median(np.diff(t_ns))) if len(t_ns) > 1 else 0.0


def format_time(t_ns: int) -> str:
    """Return a stamp as UTC to the millisecond, or as seconds where it lies outside the calendar."""
    try:
        return datetime.fromtimestamp(t_ns // NS, UTC).strftime("%Y-%m-%dT%H:%M:%S") + f".{t_ns % NS // 1_000_000:03d}Z"
    except (ValueError, OverflowError, OSError):
        return f"{t_ns / NS:.3f} s"
