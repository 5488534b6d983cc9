# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Plots in one style. PNG bytes without date or version, so that equal runs give equal bytes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import numpy as np

INK, BLUE, ORANGE, GREEN, GRAY = "#1c2733", "#1f5f99", "#c8541b", "#2b7a4b", "#7b8794"


@dataclass(frozen=True)
class Plot:
    """A picture with the numbers behind it: name (file stem), title, alt (what it shows, in words), png, table (columns)."""

    name: str
    title: str
    alt: str
    png: bytes
    table: Mapping[str, Any]


def new_figure(width_in: float = 7.2, height_in: float = 3.0, rows: int = 1, columns: int = 1) -> tuple[Any, Any]:
    """A matplotlib figure and its axes (flat array when there are several), without pyplot's global state."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height_in), dpi=150, layout="constrained")
    axes = np.asarray(figure.subplots(rows, columns, squeeze=False)).ravel()
    for axis in axes:
        dress(axis)
    return figure, axes[0] if rows * columns == 1 else axes


def dress(axis: Any) -> None:
    """Quiet frame, light grid, small type."""
    axis.spines[["top", "right"]].set_visible(False)
    axis.spines[["left", "bottom"]].set_color(GRAY)
    axis.tick_params(colors=INK, labelsize=8)
    axis.grid(True, color="#e3e8ee", linewidth=0.7)
    axis.set_axisbelow(True)
    for label in (axis.xaxis.label, axis.yaxis.label):
        label.set_size(9)
        label.set_color(INK)


def plain_log(axis: Any) -> None:
    """Numbers as they are on a logarithmic axis, not powers of ten: many spans are shorter than a decade."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def whole_numbers(axis: Any) -> None:
    """Counts: no fractions, no offset."""
    from matplotlib.ticker import MaxNLocator, StrMethodFormatter

    axis.set_major_locator(MaxNLocator(nbins=6, integer=True))
    axis.set_major_formatter(StrMethodFormatter("{x:,.0f}"))


def png_bytes(figure: Any, **more: Any) -> bytes:
    """Without what the library writes of itself; more: as savefig has it."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure)
    buffer = BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None}, **more)
    return buffer.getvalue()
