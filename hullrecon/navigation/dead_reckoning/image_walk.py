# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Follow images where DVL or IMU are silent, as far as each overlaps the previous image."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hullrecon.records.clock import longest_pause_s
from hullrecon.typing import Ints

# between images compared in a walk: closer images overlap as well
STRIDE_S = 0.5
# whether two images overlap, by their rows in the index
GoesOn = Callable[[int, int], bool]


@dataclass(frozen=True, kw_only=True)
class ImageWalk:
    """Frames of one camera, followed where nothing else measures the motion."""

    frames: tuple[Ints, Ints]  # stamps (n,), in time order, and rows in the index
    goes_on: GoesOn  # tells whether two frames overlap
    progress: Callable[[range], Iterable[int]] = iter  # shows how far a walk is

    def widened(self, span_ns: tuple[int, int]) -> tuple[int, int]:
        """Widen a span on both sides as far as each frame overlaps its neighbour."""
        t_ns = self.frames[0]
        inside = np.flatnonzero((t_ns >= span_ns[0]) & (t_ns <= span_ns[1]))
        if not len(inside):
            return span_ns
        first = self._follow(int(inside[0]), range(int(inside[0]) - 1, -1, -1))
        last = self._follow(int(inside[-1]), range(int(inside[-1]) + 1, len(t_ns)))
        return min(span_ns[0], int(t_ns[first])), max(span_ns[1], int(t_ns[last]))

    def lost_in(self, outage_ns: tuple[int, int]) -> tuple[int, int] | None:
        """Find the first and last stamp of frames in an outage that overlap neither of its sides.

        None where there are no such frames.
        """
        t_ns = self.frames[0]
        begin, end = (
            np.searchsorted(t_ns, outage_ns[0], side="right") - 1,
            np.searchsorted(t_ns, outage_ns[1]),
        )
        if begin < 0 or end >= len(t_ns) or end - begin < 2:
            return None
        first = self._follow(int(begin), range(int(begin) + 1, int(end))) + 1
        last = self._follow(int(end), range(int(end) - 1, first - 1, -1)) - 1
        return (int(t_ns[first]), int(t_ns[last])) if first <= last else None

    def _follow(self, at: int, steps: range) -> int:
        """Follow frames along `steps`, by strides where they are dense, and name the last."""
        for k in self.progress(steps):
            if (k - at) * steps.step <= 0:
                continue
            stride = self._stride(at, k, steps)
            reached = next((frame for frame in (stride, k) if self._goes_on(at, frame)), None)
            if reached is None:
                break
            at = reached
        return at

    def _stride(self, at: int, following: int, steps: range) -> int:
        """Find the farthest frame along `steps` within a stride's time, at least the next."""
        t_ns = self.frames[0]
        while (
            following + steps.step in steps
            and abs(int(t_ns[following + steps.step] - t_ns[at])) <= STRIDE_S * 1e9
        ):
            following += steps.step
        return following

    @cached_property
    def _longest_ns(self) -> float:
        return 1e9 * longest_pause_s(self.frames[0])

    def _goes_on(self, first: int, second: int) -> bool:
        t_ns, row = self.frames
        near = abs(int(t_ns[second] - t_ns[first])) <= self._longest_ns
        return near and self.goes_on(int(row[first]), int(row[second]))
