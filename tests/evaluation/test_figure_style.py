# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import pytest

from hullrecon.evaluation.figures.figure_style import COLOURS, INK, colour, finish_figure, new_canvas


@pytest.mark.parametrize("method", ["naive", "geva", "maxmix"])
def test_a_method_keeps_its_colour_whatever_its_weighting(method: str) -> None:
    assert colour(f"{method} as published") == colour(method) == COLOURS[method]


def test_another_name_is_drawn_in_ink() -> None:
    assert colour("delivered") == INK


def test_a_canvas_has_a_row_of_axes_for_each_row() -> None:
    _, axes = new_canvas(4, 3, rows=2, columns=3)
    assert [len(row) for row in axes] == [3, 3]


def test_a_figure_ends_its_table_with_a_line_end() -> None:
    canvas, _ = new_canvas(2, 1)
    figure = finish_figure("name", canvas, ["a,b", "1,2"], "What it shows.")
    assert figure.csv == "a,b\n1,2\n"
    assert figure.png[:4] == b"\x89PNG"
