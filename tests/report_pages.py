# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The variables of a report's page, as `deliver` joins them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hullrecon.report.content.objects import Crop
from hullrecon.report.content.page_context import (
    PageContext,
    draw_page,
    join_drawings,
    print_context,
)
from hullrecon.report.figures.hull_map import hull_map
from hullrecon.report.figures.map_pictures import form_drawing
from hullrecon.report.figures.plots import plot_drawings
from hullrecon.report.figures.style import Plot
from hullrecon.report.stream import draw
from hullrecon.report.survey import Survey


def draw_all_plots(survey: Survey) -> list[Plot]:
    """Draw the plots of a survey, as `deliver` does."""
    return [plot for plot in map(draw, plot_drawings(survey)) if plot is not None]


def page_context(
    survey: Survey,
    plots: Sequence[Plot],
    deliverables: Mapping[str, object],
    photos: Mapping[int, Crop],
) -> PageContext:
    """Build all variables of the page's template."""
    view = hull_map(survey)
    drawing = form_drawing(survey, view)
    form = draw(drawing) if drawing is not None else None
    printed = print_context(survey, view, plots, form, deliverables, photos)
    return join_drawings(printed, draw_page(survey, view, deliverables))
