# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Place the nodes of the trajectory at the camera's frames, and at DVL pings far from frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.records.clock import nearest, seconds_to_nearest
from hullrecon.typing import Ints, Mask

FAR_FROM_FRAME_S = 1.0  # pings farther from any frame get nodes of their own
NODE_SPACING_S = 0.4  # between nodes where there is no camera


@dataclass(frozen=True)
class Nodes:
    """Nodes of the trajectory in time order."""

    t_ns: Ints  # (n,)
    # (n, 2) rows in the indices of camera_top and camera_bottom, -1 where there is none
    image: Ints
    unpaired: int  # frames of the bottom camera without a partner
    outside: int  # frames that navigation does not reach
    lone: int = 0  # frames of the top camera without a partner, where there is a bottom camera


def pair_frames(top_ns: Ints, bottom_ns: Ints) -> Ints:
    """Pair the frames of two cameras: mutually nearest stamps within half a frame period.

    The period is that of the faster camera. Stamps are in time order. Returns rows (k, 2) of the
    two arrays, without the frames that have no partner.
    """
    if not len(top_ns) or not len(bottom_ns):
        return np.zeros((0, 2), np.int64)
    periods = [np.median(np.diff(s)) for s in (top_ns, bottom_ns) if len(s) > 1]
    reach = 0.5 * min(periods) if periods else np.inf
    partner = nearest(bottom_ns, top_ns)
    back = nearest(top_ns, bottom_ns)
    mutual = back[partner] == np.arange(len(top_ns))
    close = np.abs(bottom_ns[partner] - top_ns) <= reach
    row = np.flatnonzero(mutual & close)
    return np.stack([row, partner[row]], axis=1).astype(np.int64)


def choose_nodes(
    top: tuple[Ints, Ints],
    bottom: tuple[Ints, Ints],
    pings_ns: Ints,
    span_ns: tuple[int, int],
    lost_ns: Sequence[tuple[int, int]] = (),
) -> Nodes:
    """Place nodes at the camera's frames, and at DVL pings far from any frame.

    Parameters
    ----------
    top, bottom
        Stamps and rows in the index of the usable frames, in time order. A pair stands at the top
        camera's stamp.
    pings_ns
        Stamps of the DVL.
    span_ns
        What navigation covers. Frames outside get no node.
    lost_ns
        Spans in which frames get no node either.
    """
    # A node for each frame of the top camera, with its partner, then for each frame without one.
    (top_ns, top_row), (bottom_ns, bottom_row) = top, bottom
    pair = pair_frames(top_ns, bottom_ns)
    unpaired = np.setdiff1d(np.arange(len(bottom_ns)), pair[:, 1])
    frame_ns = np.concatenate([top_ns, bottom_ns[unpaired]])
    image = np.full((len(frame_ns), 2), -1, np.int64)
    image[: len(top_ns), 0] = top_row
    image[pair[:, 0], 1] = bottom_row[pair[:, 1]]
    image[len(top_ns) :, 1] = bottom_row[unpaired]

    inside = (frame_ns >= span_ns[0]) & (frame_ns <= span_ns[1])
    for begin, end in lost_ns:
        inside &= (frame_ns < begin) | (frame_ns > end)
    frame_ns, image = frame_ns[inside], image[inside]

    # Nodes without an image, at pings far from any frame.
    far = pings_ns[seconds_to_nearest(np.sort(frame_ns), pings_ns) > FAR_FROM_FRAME_S]
    extra = far[_thin(far)]
    t_ns = np.concatenate([frame_ns, extra])
    image = np.vstack([image, np.full((len(extra), 2), -1, np.int64)])
    order = np.argsort(t_ns, kind="stable")
    return Nodes(
        t_ns[order],
        image[order],
        len(unpaired) if len(top_ns) else 0,
        int((~inside).sum()),
        len(top_ns) - len(pair) if len(bottom_ns) else 0,
    )


def _thin(t_ns: Ints) -> Mask:
    """Choose the first stamp in each interval of nearly NODE_SPACING_S, so that nodes lie apart.

    Intervals are a tenth shorter, so that stamps with jitter do not skip one.
    """
    if not len(t_ns):
        return np.zeros(0, bool)
    cell = (t_ns - t_ns[0]) // int(0.9e9 * NODE_SPACING_S)
    return np.concatenate([[True], np.diff(cell) > 0])
