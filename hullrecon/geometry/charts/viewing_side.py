# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find how a chart is drawn so that the hull is seen from outside, with lettering not mirrored."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.tangents import STEP_M
from hullrecon.typing import Array


def flips(chart: Chart, along_girth: Array) -> tuple[bool, bool]:
    """Tell whether along has to grow to the left, and girth downwards, for a viewer outside.

    With along to the right and girth up, the chart of a CAD model shows the hull from inside. On
    the port side, where girth grows upwards, along is reversed. On the starboard side, where girth
    falls towards the deck, girth is reversed.

    Parameters
    ----------
    chart
        The chart that is drawn.
    along_girth
        Chart points (n, 2) m that are shown. The median over them decides. Neither is reversed
        where none is on the chart.
    """
    good = along_girth[np.isfinite(along_girth).all(axis=1)]
    _, normal = chart.from_chart(good)
    along, girth = (
        chart.from_chart(good + step)[0] - chart.from_chart(good - step)[0]
        for step in np.eye(2) * STEP_M
    )
    # Along x girth against the outward normal tells from which side the chart is seen, and girth's
    # part upward whether it falls
    turn, rise = (np.cross(along, girth) * normal).sum(axis=1), girth @ chart.ship_axes[2]
    known = np.isfinite(turn) & np.isfinite(rise)
    if not known.any():
        return False, False
    from_inside, falls = bool(np.median(turn[known]) < 0), bool(np.median(rise[known]) < 0)
    return from_inside != falls, falls
