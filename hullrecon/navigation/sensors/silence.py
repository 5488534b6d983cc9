# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where a sensor was silent, before its first and after its last reading included: its values there
were not measured.
"""

from __future__ import annotations

import numpy as np

from hullrecon.navigation.sensors.clock import gaps
from hullrecon.typing import Array, Ints

SILENT_S, SILENT_PERIODS = 2.0, 5.0  # without a reading: a span longer than both counts


def silent_spans(t_ns: Ints, start_ns: int, stop_ns: int) -> Ints:
    """Return start and end (k, 2), ns, of the spans between two instants in which a sensor gave no
    reading; t_ns (n,): its stamps in time order.
    """
    stamps = np.concatenate([[min(start_ns, t_ns[0])], t_ns, [max(stop_ns, t_ns[-1])]])
    spans = np.clip(gaps(stamps, longest_pause_s(t_ns)), start_ns, stop_ns)
    return np.asarray(spans[spans[:, 1] > spans[:, 0]])


def longest_pause_s(t_ns: Ints) -> float:
    """Return the longest time between two readings, s, that is no silence; t_ns (n,): their stamps
    in time order.
    """
    return max(
        SILENT_S, SILENT_PERIODS * float(np.median(np.diff(t_ns))) * 1e-9 if len(t_ns) > 1 else 0.0
    )


def unread_s(t_ns: Ints, at_ns: Ints) -> Array:
    """Return how long before or after instants (m,) a sensor was last read, s; 0 where it was not
    silent.
    """
    out = np.zeros(len(at_ns))
    if not len(at_ns):
        return out
    right = np.searchsorted(t_ns, at_ns)
    before, after = t_ns[np.maximum(right - 1, 0)], t_ns[np.minimum(right, len(t_ns) - 1)]
    nearest = np.minimum(np.abs(at_ns - before), np.abs(after - at_ns)) * 1e-9
    for start, stop in silent_spans(t_ns, int(at_ns.min()), int(at_ns.max())):
        inside = (at_ns >= start) & (at_ns <= stop)
        out[inside] = nearest[inside]
    return out


def describe_silence(t_ns: Ints, at_ns: Ints) -> str:
    """Return how long a sensor was silent during a path, as a part of a sentence; "" where it was
    not. at_ns (m,): nodes.
    """
    spans = silent_spans(t_ns, int(at_ns[0]), int(at_ns[-1]))
    if not len(spans):
        return ""
    lasted_s = np.diff(spans, axis=1)[:, 0] * 1e-9
    longest = f" (the longest silence {lasted_s.max():.1f} s)" if len(spans) > 1 else ""
    return f"no reading for {lasted_s.sum():.1f} s of the path's {(at_ns[-1] - at_ns[0]) * 1e-9:.1f}{longest}"
