# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Check the stamps of one sensor: their order, duplicates, jumps of the clock and gaps."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hullrecon.errors import InputError
from hullrecon.records.clock import NS, format_time
from hullrecon.typing import Ints, Mask

# a clock that moves that much against the logger's has jumped; logging delays stay below
JUMP_S = 1.0
GAP_PERIODS = 5.0  # and at least GAP_S: a silence that is named
GAP_S = 1.0
# after the first sensor, or before the last one: a late start and an early end that are named
LATE_S = 2.0
BESIDE_NS = 30 * NS  # on either side of a jump: the readings that tell its size
STEADY = 0.1  # of a jump: what half of the offsets beside it may scatter by
# readings before and after a jump, at least, of a clock that is then put right; fewer are a late
# delivery
LASTING = 20
# from the stamps of the dive: a clock that was not set yet, or a stamp that is damaged
FAR_S = 86400.0
FAR_SHARE = 0.05  # of a sensor's readings; more are another dive, which is not ours to leave out
FEW = 2  # readings with one stamp are duplicates; more, and no other, are a clock that stands still


@dataclass(frozen=True)
class Timeline:
    """Hold the rows to keep, in time order and each stamp once, their stamps, and remarks on what
    was wrong with those.
    """

    keep: Ints
    t_ns: Ints
    remarks: list[str]


def put_in_order(
    name: str, stamp_ns: ArrayLike, logged_ns: ArrayLike, log: ArrayLike | None = None
) -> Timeline:
    """Return rows by time; of rows with one stamp the first stays, and few that lie a day or more
    from all others are left out. stamp_ns, logged_ns (n,) in the order of the logs; log (n,): the
    number of the log of each, None where there is one. InputError for a clock that stands still.
    """
    stamp, logged = np.asarray(stamp_ns, np.int64), np.asarray(logged_ns, np.int64)
    number = np.zeros(len(stamp), np.int64) if log is None else np.asarray(log, np.int64)
    if len(stamp) > FEW and (stamp == stamp[0]).all():
        raise InputError(
            f"{name}: all {len(stamp)} stamps are the same, {format_time(int(stamp[0]))}",
            remedy="record the sensor with a clock that runs",
        )
    jumped = clock_error(stamp, logged)
    near = np.flatnonzero(~_far_from_all(stamp - jumped))
    jumped, far = jumped[near], np.delete(stamp, near)
    stamp, logged, number = stamp[near], logged[near], number[near]
    set_back = _set_back(stamp - jumped, logged, number)
    right = stamp - jumped - set_back
    order = np.argsort(right, kind="stable")
    kept = np.ones(len(order), bool)
    kept[1:] = np.diff(right[order]) > 0
    remarks = _describe_jumps(name, stamp, logged, number, jumped, set_back)
    doubled = int(np.count_nonzero(~kept))
    if doubled:
        remarks.append(
            f"{name}: {doubled} of {len(stamp)} stamps are duplicates; the first of each was kept"
        )
    backward = int(np.count_nonzero(np.diff(stamp) < 0))
    if backward and not remarks:
        remarks.append(f"{name}: {backward} readings stood out of order and were sorted")
    keep = order[kept]
    return Timeline(near[keep], right[keep], _describe_far(name, far) + remarks)


def _far_from_all(stamp: Ints) -> Mask:
    """Return which stamps (n,) lie a day or more from those of the dive, where they are few: a part
    that few readings agree on, beside one of LASTING and more.
    """
    order = np.argsort(stamp, kind="stable")
    part = np.zeros(len(stamp), np.int64)
    part[order[1:]] = np.cumsum(np.diff(stamp[order]) > FAR_S * NS)
    count = np.bincount(part, minlength=1)
    few = count < max(LASTING, FAR_SHARE * len(stamp))
    return np.asarray(few[part] & (count.max() >= LASTING) & (count[part] < count.max()), bool)


def _describe_far(name: str, far: Ints) -> list[str]:
    """Return a sentence on readings that were left out for their stamps (n,)."""
    if not len(far):
        return []
    many = "reading was" if len(far) == 1 else "readings were"
    return [
        f"{name}: {len(far)} {many} left out, stamped a day or more from all others, "
        f"{'as' if len(far) == 1 else 'the first as'} {format_time(int(far[0]))}"
    ]


def clock_error(stamp: Ints, logged: Ints) -> Ints:
    """Return by how much stamps (n,) are off after jumps of the sensor's clock against the
    logger's, ns; zeros where nothing shows it.

    A jump counts that LASTING readings on either side agree on: what was logged late, and then
    caught up, is none. Right is the stretch whose offset is below JUMP_S, as of clocks that were
    synchronised, else the longest.
    """
    offset = stamp - logged
    limits = np.concatenate(
        [[0], 1 + np.flatnonzero(np.abs(np.diff(offset)) >= JUMP_S * NS), [len(stamp)]]
    )
    stretches = [slice(a, b) for a, b in itertools.pairwise(limits.tolist()) if b - a >= LASTING]
    if len(stretches) < 2:
        return np.zeros_like(stamp)
    steps = [
        _lasting_jump(stamp, offset, before, after)
        for before, after in itertools.pairwise(stretches)
    ]
    moved = np.concatenate([[0], np.cumsum(np.array(steps, np.int64))])
    away = np.array([abs(float(np.median(offset[stretch]))) for stretch in stretches])
    longest = int(np.argmax([stretch.stop - stretch.start for stretch in stretches]))
    right = int(np.argmin(away)) if away.min() < JUMP_S * NS else longest
    # readings of a stretch too short to tell go with the one before
    starts = np.array([stretch.start for stretch in stretches])
    of = np.maximum(np.searchsorted(starts, np.arange(len(stamp)), side="right") - 1, 0)
    return np.asarray((moved - moved[right])[of])


def _set_back(stamp: Ints, logged: Ints, log: Ints) -> Ints:
    """Return by how much stamps (n,), in the order of the logs, are off where the one clock of
    sensor and logger was set back, ns. Within one log only: where another begins, it may have been
    recorded beside the first.
    """
    out = np.zeros_like(stamp)
    for number in np.unique(log):
        rows = log == number
        out[rows] = _set_back_within(stamp[rows], logged[rows])
    return out


def _set_back_within(stamp: Ints, logged: Ints) -> Ints:
    """Return by how much stamps (n,) of one log are off, ns, where they and the log's own go back
    while the sensor went on: a later part then begins within the one before and ends after it.
    Zeros where parts were logged in another order or twice.
    """
    out, step = np.zeros_like(stamp), np.diff(stamp)
    back = (step <= -JUMP_S * NS) & (np.diff(logged) <= -JUMP_S * NS)
    limits = [0, *(1 + np.flatnonzero(back)).tolist(), len(stamp)]
    for (begin, middle), (_, end) in itertools.pairwise(itertools.pairwise(limits)):
        before, after = stamp[begin:middle], stamp[middle:end]
        # stamps on a grid meet those of before by chance
        overlap = logged[middle:end][after <= before[-1]]
        if (
            min(len(before), len(after)) < LASTING
            or after[0] <= before[0]
            or after[-1] <= before[-1]
        ):
            return np.zeros_like(stamp)
        if np.isin(overlap, logged[begin:middle]).mean() > 0.5:
            return np.zeros_like(stamp)
        out[middle:] -= before[-1] - after[0] + round(float(np.median(step[step > 0])))
    return out


def _lasting_jump(stamp: Ints, offset: Ints, before: slice, after: slice) -> int:
    """Return by how much the offset changes between two stretches, ns, by the readings beside the
    jump; 0 where either side is not steady.
    """
    sides = [
        offset[before][stamp[before] >= stamp[before][-1] - BESIDE_NS],
        offset[after][stamp[after] <= stamp[after][0] + BESIDE_NS],
    ]
    low, middle, high = (
        np.array([np.percentile(side, share) for side in sides]) for share in (25, 50, 75)
    )
    jump = int(middle[1] - middle[0])
    return jump if abs(jump) >= JUMP_S * NS and (high - low).max() < STEADY * abs(jump) else 0


def _describe_jumps(
    name: str, stamp: Ints, logged: Ints, log: Ints, jumped: Ints, set_back: Ints
) -> list[str]:
    """Return a sentence on jumps of the sensor's clock by a second or more against the logger's or
    its own last reading, and what became of the stamps; on readings that were logged late, and on
    logs that were read in another order.
    """
    moved, back = np.diff(stamp - logged) / NS, np.diff(stamp) / NS
    jump = np.where(np.abs(moved) >= JUMP_S, moved, np.where(back <= -JUMP_S, back, 0.0))
    late = np.zeros(len(stamp), bool) if jumped.any() else _logged_late(stamp, logged)
    jump[late[1:] | late[:-1]] = 0.0
    # both clocks go back where another log begins: no clock did
    sorted_in = (np.diff(log) != 0) & (back <= -JUMP_S) & (np.abs(moved) < JUMP_S)
    jump[sorted_in] = 0.0
    out = []
    if late.any():
        longest_s = float((logged - stamp)[late].max() - np.median(logged - stamp)) / NS
        out.append(
            f"{name}: {np.count_nonzero(late)} readings were logged late, by up to {longest_s:.1f} s, the first at "
            f"{format_time(int(stamp[late][0]))}; their stamps were kept"
        )
    if sorted_in.any():
        first = int(np.flatnonzero(sorted_in)[0])
        out.append(
            f"{name}: logs were read in another order than they were recorded, or overlap: {-back[first]:.1f} s back to "
            f"{format_time(int(stamp[first + 1]))}; their readings were sorted"
        )
    where = np.flatnonzero(jump)
    if len(where):
        more = f", and {len(where) - 1} more times" if len(where) > 1 else ""
        wrong = np.count_nonzero(jumped + set_back)
        by = "as if it had been set back" if set_back.any() else "by the logger's clock"
        done = (
            f"{wrong} stamps were put right {by}" if wrong else "stamps around it cannot be trusted"
        )
        out.append(
            f"{name}: the clock jumps by {jump[where[0]]:+.3f} s at {format_time(int(stamp[where[0]]))}{more}; {done}"
        )
    return out


def _logged_late(stamp: Ints, logged: Ints) -> Mask:
    """Return which readings (n,) the logger wrote late: their own clock ran on, and the delay
    ended.
    """
    out = np.zeros(len(stamp), bool)
    offset, row = stamp - logged, 0
    drops = np.flatnonzero((np.diff(offset) <= -JUMP_S * NS) & (np.diff(stamp) >= 0))
    for last in drops.tolist():
        if last < row:
            continue
        caught_up = np.flatnonzero(offset[last + 1 :] > offset[last] - JUMP_S * NS)
        if not len(caught_up):
            break
        row = last + 1 + int(caught_up[0])
        out[last + 1 : row] = (np.diff(stamp[last : row + 1]) >= 0).all()
    return out


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
    return lines + (
        [f"{name}: {len(silent) - longest} more gaps, shorter"] if len(silent) > longest else []
    )


def describe_ends(name: str, t_ns: Ints, start_ns: int, stop_ns: int) -> list[str]:
    """Return a sentence where a sensor began late or ended early beside the whole log, by LATE_S or
    more.
    """
    late_s, early_s = (int(t_ns[0]) - start_ns) / NS, (stop_ns - int(t_ns[-1])) / NS
    out = [f"{name}: begins {late_s:.1f} s after the log does"] if late_s >= LATE_S else []
    return out + (
        [f"{name}: ends {early_s:.1f} s before the log does"] if early_s >= LATE_S else []
    )
