# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Plots in one style. PNG bytes without date or version, so that equal runs give equal bytes."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import TYPE_CHECKING

from hullrecon.typing import Pixels

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

INK, BLUE, ORANGE, GREEN, GRAY = "#1c2733", "#1f5f99", "#c8541b", "#2b7a4b", "#7b8794"


@dataclass(frozen=True, kw_only=True)
class Plot:
    """A picture with the numbers behind it."""

    name: str  # stem of its files
    title: str
    alt: str  # what it shows, in words
    png: bytes
    table: Mapping[str, Sequence[object]]  # columns by heading


def new_figure(
    width_in: float = 7.2, height_in: float = 3.0, rows: int = 1, columns: int = 1
) -> tuple[Figure, list[Axes]]:
    """Make a matplotlib figure and its axes, row by row, without pyplot's global state."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height_in), dpi=150, layout="constrained")
    axes: list[Axes] = figure.subplots(rows, columns, squeeze=False).ravel().tolist()
    for axis in axes:
        style_axes(axis)
    return figure, axes


def style_axes(axis: Axes) -> None:
    """Give axes a quiet frame, a light grid and small type."""
    axis.spines[["top", "right"]].set_visible(False)
    axis.spines[["left", "bottom"]].set_color(GRAY)
    axis.tick_params(colors=INK, labelsize=8)
    axis.grid(True, color="#e3e8ee", linewidth=0.7)
    axis.set_axisbelow(True)
    for label in (axis.xaxis.label, axis.yaxis.label):
        label.set_fontsize(9)
        label.set_color(INK)


def label_log_axis(axis: Axis) -> None:
    """Label a logarithmic axis with plain numbers: many spans are shorter than a decade."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def label_counts(axis: Axis) -> None:
    """Label an axis of counts: no fractions, no offset."""
    from matplotlib.ticker import MaxNLocator, StrMethodFormatter

    axis.set_major_locator(MaxNLocator(nbins=6, integer=True))
    axis.set_major_formatter(StrMethodFormatter("{x:,.0f}"))


def finish_plot(
    figure: Figure, name: str, title: str, alt: str, table: Mapping[str, Sequence[object]]
) -> Plot:
    """Encode a figure as PNG, and join it with its words and its numbers."""
    return Plot(name=name, title=title, alt=alt, png=png_bytes(figure), table=table)


def png_bytes(figure: Figure) -> bytes:
    """Encode a figure as PNG, without the library's own metadata."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    FigureCanvasAgg(figure)
    if layout := figure.get_layout_engine():
        layout.execute(figure)
        figure.set_layout_engine(None)  # else savefig draws all twice, first for the layout
    buffer = BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()


def encode_png(picture: Pixels) -> bytes:
    """Encode a picture (h, w, 4) as PNG."""
    from PIL import Image

    buffer = BytesIO()
    Image.fromarray(picture, "RGBA").save(buffer, format="PNG")
    return buffer.getvalue()


def picture_uri(picture: bytes, form: str = "png") -> str:
    """Write an encoded picture as a data URI. form: png, jpeg or webp."""
    return f"data:image/{form};base64,{b64encode(picture).decode()}"
