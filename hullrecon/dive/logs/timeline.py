# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Put the readings of one sensor in order of time: duplicates, clock jumps, late logging, gaps."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hullrecon.dive.logs.bursts import spread_bursts
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.records.clock import NS, format_time
from hullrecon.typing import Ints, Mask

# the sensor's clock has jumped where it moves that much against the logger's; the times that
# messages take to be logged vary by less
JUMP_S = 1.0
GAP_PERIODS, GAP_S = 5.0, 1.0  # a silence that is reported exceeds both
LATE_S = 2.0  # start after the first sensor, or end before the last one, that is reported
BESIDE_NS = 30 * NS  # on either side of a jump: the readings that tell its size
STEADY = 0.1  # of a jump: width of the interval that half of the offsets around it may take
# readings that a clock must keep its new offset for; fewer are messages that were delivered late
LASTING = 20
# a day from the other stamps of the dive: a clock that was not set yet, or a stamp that is damaged
FAR_S = 86400.0
UNSET_NS = 10 * 365 * 86400 * NS  # a clock before 1980 was never set
FAR_SHARE = 0.05  # of a sensor's readings; more are another dive, which is not ours to leave out
# ntpd steps a clock by no less. After such a step back AGAIN readings or more have stamps before
# the last one of the previous part
STEPPED_NS, AGAIN = round(0.128 * NS), 3
SUMMER_NS = 3600 * NS  # by which clocks of local time fall back when summer time ends
# between stamps of which several readings have each: a motion is told from readings closer than
# that. Of readings in shorter steps the first of each is enough
COARSE_S = 1.0
FEW = 2  # readings with one stamp are duplicates; more, and no other, are a clock that stands still
MOST_GAPS = 5  # that are listed one by one


@dataclass(frozen=True)
class Timeline:
    """The readings of one sensor in order of time, each stamp once."""

    keep: Ints  # (m,) rows of the readings that are kept, among those given
    t_ns: Ints  # (m,) their corrected stamps
    notes: list[Finding]  # what was wrong with the stamps


def put_in_order(
    name: str,
    stamp_ns: ArrayLike,
    logged_ns: ArrayLike,
    log: ArrayLike | None = None,
    *,
    spread: bool = False,
) -> Timeline:
    """Sort readings by time, correct clock jumps, and drop duplicates and stray stamps.

    Of readings with one stamp the first is kept. A few readings that lie a day or more from all
    others are left out.

    Parameters
    ----------
    name : of the stream, for the notes
    stamp_ns, logged_ns : (n,) stamps of sensor and logger, in the order of the logs
    log : (n,) number of the log of each reading, None where there is one log
    spread : whether readings that came in bursts get the times at which they were measured

    Raises
    ------
    InputError
        The sensor's clock stands still or is too coarse, or changes in a way that nothing tells how
        to correct.
    """
    stamp, logged = np.asarray(stamp_ns, np.int64), np.asarray(logged_ns, np.int64)
    number = np.zeros(len(stamp), np.int64) if log is None else np.asarray(log, np.int64)
    if len(stamp) > FEW and (stamp == stamp[0]).all():
        raise InputError(
            f"{name}: all {len(stamp)} stamps are the same, {format_time(int(stamp[0]))}",
            remedy="write the stamps with all their digits, or log those of the sensor",
        )
    # Clock errors: jumps against the logger's clock, then a clock that was set back with it.
    logged = _on_first_logger(stamp, logged, number)
    jumped = clock_error(stamp, logged)
    near = np.flatnonzero(~_far_from_all(stamp - jumped))
    jumped, far = jumped[near], np.delete(stamp, near)
    stamp, logged, number = stamp[near], logged[near], number[near]
    set_back = _set_back(stamp - jumped, logged, number)
    right, bursts = stamp - jumped - set_back, list[Finding]()
    if spread:
        right = spread_bursts(name, right, logged, bursts)
    _refuse_two_bases(name, right)
    _refuse_open_step(name, right, number)
    # In order, each stamp once.
    order = np.argsort(right, kind="stable")
    kept = np.ones(len(order), bool)
    kept[1:] = np.diff(right[order]) > 0
    notes = bursts
    if not bursts or (jumped + set_back).any():
        notes += _describe_jumps(name, stamp, logged, number, jumped, set_back)
    doubled = int(np.count_nonzero(~kept))
    _refuse_coarse(name, right[order][kept], len(right))
    if doubled:
        notes.append(Finding("stamps-doubled", {"doubled": doubled, "count": len(stamp)}, name))
    backward = int(np.count_nonzero(np.diff(stamp) < 0))
    if backward and not notes:
        notes.append(Finding("stamps-unordered", {"count": backward}, name))
    if len(far):
        values = {"count": len(far), "time": format_time(int(far[0]))}
        notes.insert(0, Finding("stamps-far", values, name))
    keep = order[kept]
    return Timeline(near[keep], right[keep], notes)


def _on_first_logger(stamp: Ints, logged: Ints, log: Ints) -> Ints:
    """Put the logging times of recordings that overlap onto the clock of the first one's logger.

    Two computers that record the same messages write different logging times beside the same
    stamps. The median of their difference is taken off. Recordings that follow each other in time
    are left unchanged: after the sensor's clock fell back, stamps on a grid can be equal by chance.

    Parameters
    ----------
    stamp, logged : (n,) ns
    log : (n,) number of the recording of each reading

    Returns
    -------
    logging times (n,), ns
    """
    out, numbers = logged.copy(), np.unique(log)
    for number in numbers[1:]:
        rows, before = np.flatnonzero(log == number), np.flatnonzero(log < number)
        _, same, same_before = np.intersect1d(stamp[rows], stamp[before], return_indices=True)
        first, last = logged[before].min(), logged[before].max()
        if len(same) >= LASTING and logged[rows].min() < last and logged[rows].max() > first:
            out[rows] -= int(np.median(logged[rows][same] - out[before][same_before]))
    return out


def _refuse_coarse(name: str, distinct: Ints, count: int) -> None:
    """Raise InputError where most readings have the stamp of another one, seconds from the next.

    Their clock is written with too few digits. Where its steps are even and hold enough readings,
    these were spread over them before.

    distinct: (m,) sorted stamps, each once. count: of the readings.
    """
    if count < LASTING or 2 * len(distinct) >= count:
        return
    step_s = float(np.median(np.diff(distinct))) / NS
    if step_s < COARSE_S:
        return
    raise InputError(
        f"{name}: {count} readings have only {len(distinct)} stamps, {step_s:.3g} s apart",
        remedy="write the stamps with all their digits, or log those of the sensor",
    )


def _refuse_two_bases(name: str, stamp: Ints) -> None:
    """Raise InputError for stamps (n,) ns of which a part counts from 1970, as after a reset.

    name: of the stream, for the message. The clock was set, or lost its time, within the log, by an
    unknown amount.
    """
    unset = stamp < UNSET_NS
    if min(unset.sum(), (~unset).sum()) < LASTING:
        return
    first = format_time(int(stamp[~unset].min()))
    raise InputError(
        f"{name}: the clock was set anew amid the log: {unset.sum()} of {len(stamp)} stamps count "
        f"from 1970, the others begin at {first}",
        remedy=f"leave those that count from 1970 out with dive.from = {first}, or write them anew",
    )


def _far_from_all(stamp: Ints) -> Mask:
    """Mark the stamps (n,) ns of small groups that lie a day or more from all other stamps.

    Such stamps are of a clock that was not set yet, or damaged. Groups are parted by gaps of FAR_S.
    The largest group is kept whatever its size.
    """
    order = np.argsort(stamp, kind="stable")
    part = np.zeros(len(stamp), np.int64)
    part[order[1:]] = np.cumsum(np.diff(stamp[order]) > FAR_S * NS)
    count = np.bincount(part, minlength=1)
    few = count < max(LASTING, FAR_SHARE * len(stamp))
    return np.asarray(few[part] & (count.max() >= LASTING) & (count[part] < count.max()), bool)


def clock_error(stamp: Ints, logged: Ints) -> Ints:
    """Estimate by how much stamps (n,) are off after jumps of the sensor's clock, ns.

    A jump against the logger's clock must be confirmed by LASTING readings on each side (a late
    delivery that catches up is not a jump). The error is to be subtracted. It is zero in the
    segment between jumps whose offset from the logger's clock is smallest, if that is below JUMP_S
    (its clocks were synchronised), else in the longest segment. Zeros without a jump.

    stamp, logged: (n,) ns, by the sensor's and by the logger's clock, in the order of the logs.
    """
    offset = stamp - logged
    limits = np.concatenate(
        [[0], 1 + np.flatnonzero(np.abs(np.diff(offset)) >= JUMP_S * NS), [len(stamp)]]
    )
    segments = [slice(a, b) for a, b in itertools.pairwise(limits.tolist()) if b - a >= LASTING]
    if len(segments) < 2:
        return np.zeros_like(stamp)
    steps = [
        _lasting_jump(stamp, offset, before, after)
        for before, after in itertools.pairwise(segments)
    ]
    moved = np.concatenate([[0], np.cumsum(np.array(steps, np.int64))])
    away = np.array([abs(float(np.median(offset[segment]))) for segment in segments])
    longest = int(np.argmax([segment.stop - segment.start for segment in segments]))
    reference = int(np.argmin(away)) if away.min() < JUMP_S * NS else longest
    # readings of a segment too short to tell go with the one before
    starts = np.array([segment.start for segment in segments])
    segment_of = np.maximum(np.searchsorted(starts, np.arange(len(stamp)), side="right") - 1, 0)
    return np.asarray((moved - moved[reference])[segment_of])


def _set_back(stamp: Ints, logged: Ints, log: Ints) -> Ints:
    """Estimate the error of stamps, ns, where sensor and logger share a clock that was set back.

    Each log is searched by itself: a second log may have been recorded at the same time.

    Parameters
    ----------
    stamp, logged : (n,) ns
    log : (n,) number of the log of each reading

    Returns
    -------
    (n,) ns, to be subtracted, zero before a step
    """
    out = np.zeros_like(stamp)
    for number in np.unique(log):
        rows = log == number
        out[rows] = _set_back_within(stamp[rows], logged[rows])
    return out


def _set_back_within(stamp: Ints, logged: Ints) -> Ints:
    """Estimate by how much stamps (n,) of one log are off after its clock was set back, ns.

    Steps back of JUMP_S or more are sought first, which one reading shows. Where there are none,
    steps as small as a time server makes are sought, which several readings have to show.

    stamp, logged: (n,) ns, by the sensor's and by the logger's clock.
    """
    step = np.diff(stamp)
    if not (step > 0).any():
        return np.zeros_like(stamp)
    period = round(float(np.median(step[step > 0])))
    out = _stepped_back(stamp, logged, period, round(JUMP_S * NS), 1)
    if out.any():
        return out
    return _stepped_back(stamp, logged, period, max(STEPPED_NS, AGAIN * period), AGAIN)


def _stepped_back(stamp: Ints, logged: Ints, period: int, least: int, again: int) -> Ints:
    """Estimate by how much stamps (n,) are off after their clock was stepped back, ns.

    The result is to be subtracted: it is negative after a step back. The part after a step begins
    within the span of the part before and ends after it, or it begins an hour before the previous
    one ended, as when summer time ends. The error is such that the parts follow each other by one
    period. All zeros where any part is too short (LASTING), or was logged in another order or
    twice.

    Parameters
    ----------
    stamp, logged : (n,) of one log, ns
    period : median time between two readings, ns
    least : smallest step that counts, ns
    again : readings after a step, at least, with stamps not after the last one before it
    """
    out = np.zeros_like(stamp)
    back = (np.diff(stamp) <= -least) & (np.diff(logged) <= -least)
    limits = [0, *(1 + np.flatnonzero(back)).tolist(), len(stamp)]
    for (begin, middle), (_, end) in itertools.pairwise(itertools.pairwise(limits)):
        before, after = stamp[begin:middle], stamp[middle:end]
        # logged times tell a part that was logged twice: stamps on a grid are equal by chance
        overlap = logged[middle:end][after <= before[-1]]
        if min(len(before), len(after)) < LASTING or (after[:again] > before[-1]).any():
            return np.zeros_like(stamp)
        step_back = int(before[-1] - after[0]) + period
        is_summer = abs(step_back - SUMMER_NS) < max(period, JUMP_S * NS)
        if not (is_summer or (after[0] > before[0] and after[-1] > before[-1])):
            return np.zeros_like(stamp)
        if np.isin(overlap, logged[begin:middle]).mean() > 0.5:
            return np.zeros_like(stamp)
        out[middle:] -= SUMMER_NS if is_summer else step_back
    return out


def _refuse_open_step(name: str, stamp: Ints, log: Ints) -> None:
    """Raise InputError where stamps (n,) fall back so far that a gap stays before the log's start.

    name: of the stream. stamp, log: ns, and number of the log that holds each reading. The clock
    was set back by an unknown amount, more than the log lasted, or two recordings were put into one
    log. Where the later part ends just before the earlier one begins, the two were only logged in
    another order.
    """
    for number in np.unique(log):
        part = stamp[log == number]
        for at in 1 + np.flatnonzero(np.diff(part) <= -JUMP_S * NS):
            before, after = part[:at], part[at:]
            if min(len(before), len(after)) < LASTING or after.max() >= before.min():
                continue
            if before.min() - after.max() < GAP_S * NS:
                continue
            raise InputError(
                f"{name}: its stamps fall back by {(before[-1] - after[0]) / NS:.1f} s at "
                f"{format_time(int(before[-1]))}, to before the log began: its clock was set back, "
                "or two recordings were joined",
                remedy=f"give one part of it, with dive.from = {format_time(int(before.min()))} or "
                f"dive.to = {format_time(int(after.max()))}, or write the stamps anew",
            )


def _lasting_jump(stamp: Ints, offset: Ints, before: slice, after: slice) -> int:
    """Measure by how much the clock's offset changes between two segments, ns.

    It is the difference of the median offsets of readings within BESIDE_NS of the change. 0 where
    the offset is not steady on both sides, or changes by less than JUMP_S: then no clock jumped.

    Parameters
    ----------
    stamp, offset : (n,) stamps, and stamps minus logging times, ns
    before, after : rows of the two segments
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
) -> list[Finding]:
    """Describe clock jumps, late logging, and logs that were read in another order.

    Parameters
    ----------
    name : of the stream
    stamp, logged, log : (n,) as of put_in_order
    jumped, set_back : (n,) errors of the stamps that were found, ns, zero where none was
    """
    moved, back = np.diff(stamp - logged) / NS, np.diff(stamp) / NS
    jump = np.where(np.abs(moved) >= JUMP_S, moved, np.where(back <= -JUMP_S, back, 0.0))
    late = np.zeros(len(stamp), bool) if jumped.any() else _logged_late(stamp, logged)
    jump[late[1:] | late[:-1]] = 0.0
    # both clocks go back where another log begins: no clock did
    sorted_in = (np.diff(log) != 0) & (back <= -JUMP_S) & (np.abs(moved) < JUMP_S)
    jump[sorted_in] = 0.0
    jump = np.where(np.diff(set_back) != 0, back, jump)
    out = []
    if late.any():
        longest_s = float((logged - stamp)[late].max() - np.median(logged - stamp)) / NS
        values: dict[str, object] = {
            "count": int(np.count_nonzero(late)),
            "seconds": longest_s,
            "time": format_time(int(stamp[late][0])),
        }
        out.append(Finding("logged-late", values, name))
    if sorted_in.any():
        first = int(np.flatnonzero(sorted_in)[0])
        values = {"seconds": float(-back[first]), "time": format_time(int(stamp[first + 1]))}
        out.append(Finding("logs-overlap", values, name))
    where = np.flatnonzero(jump)
    if len(where):
        values = {
            "seconds": float(jump[where[0]]),
            "time": format_time(int(stamp[where[0]])),
            "more": len(where) - 1,
            "corrected": int(np.count_nonzero(jumped + set_back)),
            "set_back": bool(set_back.any()),
        }
        out.append(Finding("clock-jumps", values, name))
    return out


def _logged_late(stamp: Ints, logged: Ints) -> Mask:
    """Find the readings (n,) that were logged late: their clock ran on while logging lagged.

    stamp, logged: (n,) ns, by the sensor's clock and by the logger's, in order of logging.

    Their stamps are right, so that nothing is corrected. Logging has to catch up again. Where it
    never does, the sensor's clock jumped instead.
    """
    out = np.zeros(len(stamp), bool)
    offset, resumed = stamp - logged, 0
    # Where the stamps fall behind the logger's clock at once, but do not go back
    drops = np.flatnonzero((np.diff(offset) <= -JUMP_S * NS) & (np.diff(stamp) >= 0))
    for last in drops.tolist():
        if last < resumed:
            continue
        caught_up = np.flatnonzero(offset[last + 1 :] > offset[last] - JUMP_S * NS)
        if not len(caught_up):
            break
        resumed = last + 1 + int(caught_up[0])  # first row after logging has caught up
        out[last + 1 : resumed] = (np.diff(stamp[last : resumed + 1]) >= 0).all()
    return out


def describe_gaps(name: str, t_ns: Ints, longest: int = MOST_GAPS) -> list[Finding]:
    """Describe silences longer than five periods and longer than a second, the longest first.

    At most `longest` are described one by one, of the others their number. Empty without silences.
    """
    step = np.diff(t_ns) / NS
    if len(step) < 2:
        return []
    silent = np.flatnonzero(step > max(GAP_S, GAP_PERIODS * float(np.median(step))))
    out = []
    for i in sorted(silent, key=lambda i: -step[i])[:longest]:
        start, end = (format_time(int(t)) for t in t_ns[[i, i + 1]])
        values: dict[str, object] = {"seconds": float(step[i]), "start": start, "end": end}
        out.append(Finding("stream-silent", values, name))
    if len(silent) > longest:
        out.append(Finding("stream-more-gaps", {"count": len(silent) - longest}, name))
    return out


def describe_ends(name: str, t_ns: Ints, start_ns: int, stop_ns: int) -> list[Finding]:
    """Describe a sensor that began long after the first one, or ended long before the last one.

    Empty for less than LATE_S. start_ns, stop_ns: first and last stamp of all sensors.
    """
    late_s, early_s = (int(t_ns[0]) - start_ns) / NS, (stop_ns - int(t_ns[-1])) / NS
    ends = (("stream-late", late_s), ("stream-early", early_s))
    return [Finding(code, {"seconds": s}, name) for code, s in ends if s >= LATE_S]
