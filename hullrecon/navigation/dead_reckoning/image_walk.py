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

# between images that are compared in a walk; those between them then overlap as well
STRIDE_S = 0.5
# tells whether two images overlap, given by their rows in the index
GoesOn = Callable[[int, int], bool]


@dataclass(frozen=True, kw_only=True)
class ImageWalk:
    """Frames of one camera, followed where nothing else measures the motion."""

    frames: tuple[Ints, Ints]  # stamps (n,), in time order, and rows in the index
    goes_on: GoesOn  # tells whether two frames overlap
    progress: Callable[[range], Iterable[int]] = iter  # shows how far a walk is

    def widened(self, span_ns: tuple[int, int]) -> tuple[int, int]:
        """Widen a span (ns) on both sides as far as each frame overlaps its neighbour.

        Images there can get nodes, as links will hold them. The span is returned as it is where no
        frame lies within it.
        """
        t_ns = self.frames[0]
        inside = np.flatnonzero((t_ns >= span_ns[0]) & (t_ns <= span_ns[1]))
        if not len(inside):
            return span_ns
        first = self._last_joined(int(inside[0]), range(int(inside[0]) - 1, -1, -1))
        last = self._last_joined(int(inside[-1]), range(int(inside[-1]) + 1, len(t_ns)))
        return min(span_ns[0], int(t_ns[first])), max(span_ns[1], int(t_ns[last]))

    def lost_in(self, outage_ns: tuple[int, int]) -> tuple[int, int] | None:
        """Find the frames in an outage that no chain of overlapping frames joins to either side.

        In a long outage the position of the vehicle is unknown, so they get no node. Returns their
        first and last stamp. None where there are no such frames, or no frames on one side.
        """
        t_ns = self.frames[0]
        begin, end = (
            np.searchsorted(t_ns, outage_ns[0], side="right") - 1,
            np.searchsorted(t_ns, outage_ns[1]),
        )
        if begin < 0 or end >= len(t_ns) or end - begin < 2:
            return None
        first = self._last_joined(int(begin), range(int(begin) + 1, int(end))) + 1
        last = self._last_joined(int(end), range(int(end) - 1, first - 1, -1)) - 1
        return (int(t_ns[first]), int(t_ns[last])) if first <= last else None

    def _last_joined(self, at: int, steps: range) -> int:
        """Find the last frame that a chain of overlapping frames joins to frame `at`.

        To compare few frames, the chain goes on by strides of up to STRIDE_S. Where the frame at
        the end of a stride does not overlap, the next frame is tried. It is `at` itself if none
        overlaps.

        steps: frames to go along, forward or backward.
        """
        for k in self.progress(steps):
            if (k - at) * steps.step <= 0:  # within the last stride
                continue
            stride = self._farthest_within_stride(at, k, steps)
            reached = next((frame for frame in (stride, k) if self._goes_on(at, frame)), None)
            if reached is None:
                break
            at = reached
        return at

    def _farthest_within_stride(self, at: int, following: int, steps: range) -> int:
        """Find the farthest frame along `steps` within a stride's time, at least the next.

        at: the frame from which the stride begins. following: the next one.
        """
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
        """Tell whether two frames overlap. False without comparing them after a long pause.

        After a pause, another place of the hull may look the same.
        """
        t_ns, row = self.frames
        near = abs(int(t_ns[second] - t_ns[first])) <= self._longest_ns
        return near and self.goes_on(int(row[first]), int(row[second]))
