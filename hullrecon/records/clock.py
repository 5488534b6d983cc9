# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Times of readings: nearest stamp, period, gaps and silences, and the format of a time.

Stamps are whole nanoseconds since 1970 (UTC), ascending without duplicates, as ingest leaves them.
"""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np

from hullrecon.typing import Array, Ints

NS = 1_000_000_000  # nanoseconds in a second
# Readings are missing where the time between two exceeds HOLE_PERIODS periods and BURST_S. The
# latter is for serial adapters (USB), which pass several readings on at once every 16 ms
HOLE_PERIODS, BURST_S = 5.0, 0.05
BURST = 20  # readings whose mean step is a first guess of the period even if they come in bursts
ROUNDS = 3  # of refining the period
# a sensor is silent where the time between two readings exceeds both
SILENT_S, SILENT_PERIODS = 2.0, 5.0


def seconds(t_ns: Ints, start_ns: int) -> Array:
    """Convert stamps to seconds since a start, exact to the nanosecond over a year."""
    return np.asarray((t_ns - start_ns) * 1e-9)


def format_time(t_ns: int) -> str:
    """Format a stamp as UTC to the millisecond, or as seconds outside of the calendar."""
    try:
        whole = datetime.fromtimestamp(t_ns // NS, UTC).strftime("%Y-%m-%dT%H:%M:%S")
    except (ValueError, OverflowError, OSError):
        return f"{t_ns / NS:.3f} s"
    return f"{whole}.{t_ns % NS // 1_000_000:03d}Z"


def nearest(sorted_ns: Ints, wanted_ns: Ints) -> Ints:
    """Find the row (m,) of the stamp (n,), n > 0, nearest to each wanted time (m,).

    Of two stamps that are equally near, the earlier one is taken.
    """
    right = np.clip(np.searchsorted(sorted_ns, wanted_ns), 1, max(1, len(sorted_ns) - 1))
    left = right - 1
    right = np.minimum(right, len(sorted_ns) - 1)
    return np.where(wanted_ns - sorted_ns[left] <= sorted_ns[right] - wanted_ns, left, right)


def seconds_to_nearest(sorted_ns: Ints, wanted_ns: Ints) -> Array:
    """Measure the time (m,), s, from each wanted time to the nearest stamp. inf without stamps."""
    if not len(sorted_ns):
        return np.full(len(wanted_ns), np.inf)
    return np.asarray(np.abs(wanted_ns - sorted_ns[nearest(sorted_ns, wanted_ns)]) * 1e-9)


def median_period_s(t_ns: Ints) -> float:
    """Compute the median time between stamps, s. 0 for fewer than two stamps."""
    return float(np.median(np.diff(t_ns))) * 1e-9 if len(t_ns) > 1 else 0.0


def period(t_s: Array) -> float:
    """Estimate the mean time between readings at t_s (n,), n > 1, without the holes.

    Steps beyond `longest_step` are left out, and the mean of the others is refined in ROUNDS. The
    median step would be far too short if a serial adapter delivers readings in bursts.
    """
    step, few = np.diff(t_s), min(BURST, max(1, len(t_s) // 4))
    is_short = step <= longest_step(float(np.median(t_s[few:] - t_s[:-few])) / few)
    for _ in range(ROUNDS):
        is_short = step <= longest_step(float(step[is_short].mean()))
    return float(step[is_short].mean())


def rate_hz(t_ns: Ints) -> float:
    """Estimate the rate of readings outside of holes, Hz. 0 for fewer than two readings."""
    return 1 / period((t_ns - t_ns[0]) / NS) if len(t_ns) > 1 else 0.0


def longest_step(period_s: float) -> float:
    """Compute the time between two readings, s, beyond which some are missing."""
    return max(HOLE_PERIODS * period_s, BURST_S)


def gaps(t_ns: Ints, longest_s: float) -> Ints:
    """Find the start and end (m, 2), ns, of the intervals between stamps longer than longest_s."""
    long = np.flatnonzero(np.diff(t_ns) > longest_s * NS)
    return np.stack([t_ns[long], t_ns[long + 1]], axis=1).astype(np.int64)


def longest_pause_s(t_ns: Ints) -> float:
    """Compute the longest time between two readings, s, that is no silence."""
    return max(SILENT_S, SILENT_PERIODS * median_period_s(t_ns))


def silent_spans(t_ns: Ints, start_ns: int, stop_ns: int) -> Ints:
    """Find the start and end (k, 2), ns, of a sensor's silences between two times.

    The times before its first reading and after its last one count as well.
    """
    stamps = np.concatenate([[min(start_ns, t_ns[0])], t_ns, [max(stop_ns, t_ns[-1])]])
    spans = np.clip(gaps(stamps, longest_pause_s(t_ns)), start_ns, stop_ns)
    return np.asarray(spans[spans[:, 1] > spans[:, 0]])


def unread_s(t_ns: Ints, at_ns: Ints) -> Array:
    """Measure how far times (m,) within a sensor's silences are from its nearest reading, s.

    0 outside of silences.
    """
    out = np.zeros(len(at_ns))
    if not len(at_ns):
        return out
    apart_s = seconds_to_nearest(t_ns, at_ns)
    for start, stop in silent_spans(t_ns, int(at_ns.min()), int(at_ns.max())):
        inside = (at_ns >= start) & (at_ns <= stop)
        out[inside] = apart_s[inside]
    return out


def describe_silence(t_ns: Ints, at_ns: Ints) -> str:
    """Say how long a sensor was silent along a path with nodes at_ns (m,). Empty if it was not."""
    spans = silent_spans(t_ns, int(at_ns[0]), int(at_ns[-1]))
    if not len(spans):
        return ""
    lasted_s = np.diff(spans, axis=1)[:, 0] / NS
    longest = f" (the longest silence {lasted_s.max():.1f} s)" if len(spans) > 1 else ""
    path_s = (at_ns[-1] - at_ns[0]) / NS
    return f"no reading for {lasted_s.sum():.1f} s of the path's {path_s:.1f}{longest}"
