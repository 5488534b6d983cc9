# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Describe in words which parts of a dive are tied together by images."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np

from hullrecon.records.links import LinkedPath
from hullrecon.typing import Ints

LEAST_SHARE = 0.01  # of the nodes with images: smaller parts are counted, not listed
MOST_LISTED = 5


def describe_parts(path: LinkedPath, t_ns: Ints) -> str | None:
    """Describe the parts into which a dive's images fall, and how well navigation ties them.

    At most MOST_LISTED parts are listed, small ones only counted. None where images tie all nodes
    together, or none at all.

    path: the path with the part of each node. t_ns (n,): stamps of the nodes.
    """
    size = np.bincount(path.part[path.part >= 0])
    if len(size) < 2:
        return None
    listed = [k for k in range(len(size)) if k == 0 or size[k] >= LEAST_SHARE * size.sum()][
        :MOST_LISTED
    ]
    spans = [_describe_part(path, t_ns, k, int(size[k])) for k in listed]
    rest = len(size) - len(listed)
    more = f", and {rest} smaller" if rest else ""
    return (
        f"The images fall into {len(size)} parts that navigation alone ties together: "
        f"{'; '.join(spans)}{more}. "
        "Positions within a part are better than that, between parts they are not."
    )


def _describe_part(path: LinkedPath, t_ns: Ints, part: int, size: int) -> str:
    """Describe a part of the path: its nodes, when they were, and its sigma to the first part."""
    at = t_ns[path.part == part]
    first, last = (
        datetime.fromtimestamp(int(t) / 1e9, UTC).strftime("%H:%M:%S") for t in (at.min(), at.max())
    )
    sigma = "" if part == 0 else f", known to {path.part_sigma[part]:.2f} m relative to the first"
    return f"{size} nodes from {first} to {last}{sigma}"
