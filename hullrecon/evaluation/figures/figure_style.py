# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One look for the figures of `hullrecon figures`: axes, colours by method, pictures as bytes that do not vary."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any

COLOURS = {"naive": "#7b8794", "geva": "#c8541b", "maxmix": "#1f5f99"}
INK, GREEN, RED, LIGHT = "#1c2733", "#2b7a4b", "#b3202c", "#cdd5dd"


@dataclass(frozen=True)
class Figure:
    """name without ending; png: the picture; csv: the numbers in it; words: what it shows, in a sentence."""

    name: str
    png: bytes
    csv: str
    words: str


def new_figure(width_in: float, height_in: float, rows: int = 1, columns: int = 1, **more: Any) -> tuple[Any, Any]:
    """A matplotlib figure and its axes (rows, columns), without pyplot's global state."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(width_in, height_in), dpi=150, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **more)
    for axis in axes.flat:
        axis.spines[["top", "right"]].set_visible(False)
        axis.spines[["left", "bottom"]].set_color("#7b8794")
        axis.tick_params(colors=INK, labelsize=8)
        axis.grid(True, color="#e3e8ee", linewidth=0.7)
        axis.set_axisbelow(True)
        axis.xaxis.label.set_size(9)
        axis.yaxis.label.set_size(9)
    return figure, axes


def colour(method: str) -> str:
    return next((value for name, value in COLOURS.items() if method.startswith(name)), INK)


def plain_log(axis: Any) -> None:
    """Numbers as they are on a logarithmic axis, not powers of ten."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
    axis.set_major_formatter(StrMethodFormatter("{x:,g}"))
    axis.set_minor_formatter(NullFormatter())


def finished(name: str, figure: Any, table: list[str], words: str) -> Figure:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return Figure(name, buffer.getvalue(), "\n".join(table) + "\n", words)
