# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One style for the figures of `hullrecon study figures`, with reproducible image bytes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure as Canvas
from matplotlib.patches import Ellipse

from hullrecon.report.figures.style import png_bytes, style_axes
from hullrecon.studies.study import ComparedValue
from hullrecon.typing import Array

Share = Literal["none", "all", "row", "col"]

COLOURS = {"naive": "#7b8794", "geva": "#c8541b", "maxmix": "#1f5f99"}
INK, GREEN, RED, LIGHT = "#1c2733", "#2b7a4b", "#b3202c", "#cdd5dd"


@dataclass(frozen=True, kw_only=True)
class PublishedFigure:
    """A figure of the sources, drawn again."""

    name: str  # without ending
    png: bytes  # the picture
    csv: str  # the numbers in it
    caption: str  # what it shows, in a sentence
    compared: tuple[ComparedValue, ...] = ()  # numbers that the source prints, with ours
    film: bytes = b""  # WebM, empty for a figure that does not move


def new_canvas(
    width_in: float,
    height_in: float,
    rows: int = 1,
    columns: int = 1,
    sharex: Share = "none",
    sharey: Share = "none",
    height_ratios: tuple[float, ...] | None = None,
) -> tuple[Canvas, list[list[Axes]]]:
    """Make a matplotlib figure and its axes (rows, columns), without pyplot's global state."""
    figure = Canvas(figsize=(width_in, height_in), dpi=150, layout="constrained")
    axes = figure.subplots(
        rows, columns, squeeze=False, sharex=sharex, sharey=sharey, height_ratios=height_ratios
    )
    for axis in axes.flat:
        style_axes(axis)
    return figure, axes.tolist()


def colour(method: str) -> str:
    """Choose the colour of a method, given its name with or without the weighting."""
    return next((value for name, value in COLOURS.items() if method.startswith(name)), INK)


def label_log_axis(axis: Axis) -> None:
    """Label a logarithmic axis with plain numbers, not powers of ten."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
    axis.set_major_formatter(StrMethodFormatter("{x:,g}"))
    axis.set_minor_formatter(NullFormatter())


def finish_figure(
    name: str,
    canvas: Canvas,
    table: list[str],
    caption: str,
    compared: tuple[ComparedValue, ...] = (),
) -> PublishedFigure:
    """Join a drawn figure's picture and its table's lines as CSV."""
    return PublishedFigure(
        name=name,
        png=png_bytes(canvas),
        csv="\n".join(table) + "\n",
        caption=caption,
        compared=compared,
    )


def draw_ellipse(
    axis: Axes, middle: Array, covariance: Array, sigmas: float, ink: str, width_pt: float = 1.0
) -> None:
    """Draw the ellipse of a covariance (2, 2) around a point (2,), of `sigmas` sigmas."""
    values, vectors = np.linalg.eigh(covariance)
    high, wide = 2 * sigmas * np.sqrt(np.maximum(values, 0))
    turn = float(np.degrees(np.arctan2(vectors[1, 1], vectors[0, 1])))
    place = (float(middle[0]), float(middle[1]))
    axis.add_patch(Ellipse(place, wide, high, angle=turn, fill=False, ec=ink, lw=width_pt))
