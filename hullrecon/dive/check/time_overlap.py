# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find sensors that were never read at the same time as the others: their clocks are apart."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Protocol

import numpy as np

from hullrecon.dive.logs.timeline import UNSET_NS
from hullrecon.findings.finding import Finding
from hullrecon.geometry.frames import Camera
from hullrecon.records.clock import NS
from hullrecon.typing import Ints

KEYS = {  # of dive.toml, by which a record's stamps are corrected
    **{name: f"{name}.time_offset" for name in ("dvl", "imu", "pressure", "sonar", "position")},
    **dict.fromkeys(("tray", "sonar_tray"), "tray.time_offset"),
    **{camera.key: f"{camera.section}.time_offset" for camera in Camera},
}
JOINTS = dict.fromkeys(("tray", "sonar_tray"), "joints")  # the sensor of a record
# records that may begin after all others or end before them: GPS at the surface, a servo that
# turned before the dive
ALONE = frozenset({"position", "tray", "sonar_tray"})
LONG_ALONE_S = 3600.0  # apart from all others; then they are of another clock too
HOUR_S, MOST_HOURS = 3600.0, 14  # an hour, and how many lie between two time zones
AGREE_S = 1.0  # between the starts, or the ends, of logs that one switch started and stopped
ALIKE_S = 2.0  # between how late a stream begins and how late it ends, in one that is shifted
LEAST_SHIFT_S = 5.0  # of both ends; smaller shifts are not reported
TOGETHER_S = 300.0  # between starts, or ends, of logs that were started, or stopped, together
FACTORS = (1000, 1_000_000)  # between s, ms, us
MOST_UNLIKE = 2.0  # ratio of the lengths of streams that one switch started and stopped
Span = tuple[int, int]  # first and last stamp, ns


class Stream(Protocol):
    """Any record with stamps."""

    @property
    def t_ns(self) -> Ints:
        """Stamps (n,), ns since 1970."""


def clock_gaps(
    streams: Mapping[str, Stream], added_ns: Mapping[str, int] = MappingProxyType({})
) -> list[Finding]:
    """Report streams that were never read at the same time as the others. Empty where all were.

    Streams are gathered into groups that overlap in time. The largest group is taken as right, and
    streams outside it are reported, with an offset where one is likely. A stream of one reading, as
    of a joint that stands still, says nothing about a clock and is passed over. Where a stream's
    stamps are in another unit, only that is reported.

    Parameters
    ----------
    streams : records by name
    added_ns : by sensor, what dive.toml has already added to the stamps
    """
    spans = {
        name: (int(s.t_ns[0]), int(s.t_ns[-1])) for name, s in streams.items() if len(s.t_ns) > 1
    }
    stretched = _in_other_unit({name: spans[name] for name in spans if name not in ALONE})
    if stretched:
        return stretched
    groups = _group_overlapping(spans)
    if len(groups) < 2:
        return []
    main = max(groups, key=lambda names: _rank_of_group(names, spans))
    whole = _union(main, spans)
    others = [name for name in spans if name in main]
    given_s = {name: added_ns.get(JOINTS.get(name, name), 0) / NS for name in spans}
    return [
        _describe_gap(name, spans[name], others, whole, given_s[name])
        for name in spans
        if name not in main
    ]


def shifted_streams(streams: Mapping[str, Stream]) -> list[Finding]:
    """Report a stream that begins and ends late, or early, by the same time beside all others.

    Where the others were started and stopped together, that shows a clock that is off. Elsewhere
    nothing is reported. "seconds" is positive where the stamps are late.
    """
    spans = {
        name: (int(s.t_ns[0]) / NS, int(s.t_ns[-1]) / NS)
        for name, s in streams.items()
        if len(s.t_ns) > 1
    }
    out = []
    for name, (begin, end) in spans.items():
        others = np.array([span for other, span in spans.items() if other != name])
        if len(others) < 2 or np.ptp(others, axis=0).max() > AGREE_S:
            continue
        late = np.array([begin, end]) - np.median(others, axis=0)
        seconds, shared_s = (
            float(late.mean()),
            float(min(end, others[0, 1]) - max(begin, others[0, 0])),
        )
        if abs(seconds) < LEAST_SHIFT_S or np.ptp(late) > ALIKE_S or shared_s <= 0:
            continue
        values = {"seconds": seconds, "shared_s": shared_s, "length_s": end - begin}
        out.append(Finding("stream-shifted", {**values, "key": KEYS[name]}, name))
    return out


def _in_other_unit(spans: Mapping[str, Span]) -> list[Finding]:
    """Report a stream that lasts a thousand, or a million, times longer or shorter than the others.

    Its stamps are in another unit. Nothing is reported unless the others last about equally long.
    """
    out = []
    for name, (begin, end) in spans.items():
        others = [other for other in spans if other != name]
        lengths = np.array([spans[other][1] - spans[other][0] for other in others]) / NS
        if len(others) < 2 or lengths.max() > MOST_UNLIKE * lengths.min():
            continue
        times = (end - begin) / NS / float(np.median(lengths))
        near = [f for f in FACTORS if 1 / MOST_UNLIKE < max(times, 1 / times) / f < MOST_UNLIKE]
        if near:
            values = {"others": others, "factor": near[0], "larger": times > 1}
            out.append(Finding("stamps-in-other-unit", values, name))
    return out


def _group_overlapping(spans: Mapping[str, Span]) -> list[set[str]]:
    """Gather streams that overlap in time into groups.

    Two streams that do not overlap are in one group where others fill the time between them.
    """
    groups: list[set[str]] = []
    end = 0
    for name in sorted(spans, key=lambda name: spans[name]):
        if not groups or spans[name][0] > end:
            groups.append(set())
            end = spans[name][1]
        groups[-1].add(name)
        end = max(end, spans[name][1])
    return groups


def _rank_of_group(names: set[str], spans: Mapping[str, Span]) -> tuple[int, int, bool, bool, int]:
    """Rank a group of streams: the one with the highest rank is taken as right.

    More sensors count first. Between equals it is the group whose clocks were set, then that with
    the IMU, then the longer one.
    """
    begin, end = _union(names, spans)
    return len(names - ALONE), len(names), begin >= UNSET_NS, "imu" in names, end - begin


def _union(names: set[str], spans: Mapping[str, Span]) -> Span:
    return min(spans[name][0] for name in names), max(spans[name][1] for name in names)


def _describe_gap(name: str, span: Span, others: list[str], whole: Span, given_s: float) -> Finding:
    """Report a sensor that was read at other times than the others, with the likeliest cause.

    It ran alone, its stamps are in another unit, or its clock is off: by the hours of a time zone,
    or by what puts both of its ends onto those of the others.

    Parameters
    ----------
    name, span : the sensor, and its first and last stamp, ns
    others, whole : names of the others, and their first and last stamp together, ns
    given_s : what dive.toml has already added to the stamps
    """
    after = span[0] > whole[1]
    gap_s = (span[0] - whole[1] if after else whole[0] - span[1]) / NS
    values: dict[str, object] = {"others": others, "seconds": gap_s, "after": after}
    hours, by_ends_s = whole_hours(span, whole), offset_by_ends(span, whole)
    # Sensors of ALONE may run alone. That is believed unless hours and both ends explain the gap.
    of_zone = hours is not None and by_ends_s is not None
    if name in ALONE and gap_s < LONG_ALONE_S and not of_zone:
        return Finding("read-beside", values, name)
    factor = stamp_factor(span, whole)
    if factor is not None:
        in_unit = {"others": others, "factor": factor, "larger": False}
        return Finding("stamps-in-other-unit", in_unit, name)
    found_s = by_ends_s if hours is None else hours * HOUR_S
    values |= {
        "key": KEYS[name],
        "unset": span[0] < UNSET_NS <= whole[0],
        "given_s": given_s,  # by dive.toml already
        "hours": hours,
        "offset_s": None if found_s is None else given_s + found_s,
        "by_motion": False,
    }
    return Finding("clocks-apart", values, name)


def stamp_factor(span: Span, whole: Span) -> int | None:
    """Find by how many times stamps are too small, as milliseconds read as microseconds are.

    None where no factor of FACTORS makes a stream overlap the others.
    """
    near = (f for f in FACTORS if f * span[0] <= whole[1] and f * span[1] >= whole[0])
    return next(near, None)


def offset_by_ends(span: Span, whole: Span) -> float | None:
    """Compute what to add to the stamps of a stream, s, so that both ends are those of the others.

    None where the stream is longer or shorter than theirs: one end alone says nothing.
    """
    early = np.subtract(whole, span) / NS
    return round(float(early.mean()), 2) if np.ptp(early) < AGREE_S else None


def whole_hours(span: Span, whole: Span) -> float | None:
    """Find the hours to add to a stream's stamps so that it begins or ends with the others.

    Time zones are whole or half hours apart, so only these are tried. None where none fits.

    span, whole: first and last stamp, ns, of the stream and of the others.
    """
    hours = 0.5 * np.arange(-2 * MOST_HOURS, 2 * MOST_HOURS + 1)
    shift_ns = np.round(hours * HOUR_S * NS).astype(np.int64)
    begin, end = (span[k] + shift_ns for k in (0, 1))
    shared = np.minimum(end, whole[1]) - np.maximum(begin, whole[0])
    apart = np.minimum(np.abs(begin - whole[0]), np.abs(end - whole[1]))
    least = 0.5 * min(span[1] - span[0], whole[1] - whole[0])
    fits = (shared > least) & (apart < TOGETHER_S * NS)
    return float(hours[np.argmax(np.where(fits, shared, -1))]) if fits.any() else None
