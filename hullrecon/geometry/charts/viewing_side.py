# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How a chart is drawn so that the hull is seen from outside and lettering is not mirrored."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.typing import Array


def flips(chart: Chart, along_girth: Array, step_m: float = 0.05) -> tuple[bool, bool]:
    """Test whether along has to grow to the left, and girth downwards, for chart points (n, 2).

    With along to the right and girth up a hull is seen from inside. On its port side, where girth
    rises, the CAD model is mirrored along. On the starboard side, where girth falls towards the
    deck, it is mirrored in girth.
    """
    good = along_girth[np.isfinite(along_girth).all(axis=1)]
    _, normal = chart.from_chart(good)
    along, girth = (
        chart.from_chart(good + step)[0] - chart.from_chart(good - step)[0]
        for step in np.eye(2) * step_m
    )
    turn, rise = (np.cross(along, girth) * normal).sum(axis=1), girth @ chart.ship_axes[2]
    known = np.isfinite(turn) & np.isfinite(rise)
    if not known.any():
        return False, False
    from_inside, falls = bool(np.median(turn[known]) < 0), bool(np.median(rise[known]) < 0)
    return from_inside != falls, falls
