# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How a chart is drawn so that a viewer sees the hull from outside, as a diver does, and lettering is not mirrored."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.chart import Chart

Array = NDArray[np.float64]


def flips(chart: Chart, along_girth: Array, step_m: float = 0.05) -> tuple[bool, bool]:
    """Whether along has to grow to the left, and girth downwards, for a drawing of these chart points (n, 2).

    With along to the right and girth up a hull is seen from inside. On the port side (girth positive, up is up) the drawing is
    mirrored along; on the starboard side, where girth falls towards the deck, it is mirrored in girth.
    """
    good = along_girth[np.isfinite(along_girth).all(axis=1)]
    _, normal = chart.from_chart(good)
    along, girth = (chart.from_chart(good + step)[0] - chart.from_chart(good - step)[0] for step in np.eye(2) * step_m)
    turn = (np.cross(along, girth) * normal).sum(axis=1)
    turn = turn[np.isfinite(turn)]
    if not len(turn) or np.median(turn) > 0:
        return False, False
    port = float(np.median(good[:, 1])) >= 0
    return port, not port
