# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import re

import cv2
import numpy as np
import pytest

from hullrecon.studies.figure_style import (
    COLOURS,
    INK,
    colour,
    finish_figure,
    label_log_axis,
    new_canvas,
)


@pytest.mark.parametrize("method", ["naive", "geva", "maxmix"])
def test_a_method_keeps_its_colour_whatever_its_weighting(method: str) -> None:
    assert colour(f"{method} as published") == colour(method) == COLOURS[method]


def test_another_name_is_drawn_in_ink() -> None:
    assert colour("delivered") == INK


def test_a_canvas_has_a_row_of_axes_for_each_row() -> None:
    _, axes = new_canvas(4, 3, rows=2, columns=3)
    assert [len(row) for row in axes] == [3, 3]


@pytest.mark.usefixtures("pictures")
def test_a_figure_ends_its_table_with_a_line_end() -> None:
    canvas, _ = new_canvas(2, 1)
    figure = finish_figure("name", canvas, ["a,b", "1,2"], "What it shows.")
    assert figure.csv == "a,b\n1,2\n"
    assert figure.png[:4] == b"\x89PNG"


@pytest.mark.usefixtures("pictures")
def test_a_picture_is_as_large_as_asked_and_without_a_date() -> None:
    canvas, axes = new_canvas(4, 3)
    axes[0][0].plot([0, 1], [0, 1])
    png = finish_figure("name", canvas, [], "").png
    assert cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR).shape == (450, 600, 3)
    assert re.search(rb"Software|matplotlib|20\d\d-\d\d", png) is None


def test_log_axis_has_plain_numbers_at_one_two_five() -> None:
    canvas, axes = new_canvas(4, 3)
    axis = axes[0][0]
    axis.plot([1, 2], [400, 12000])
    axis.set_yscale("log")
    label_log_axis(axis.yaxis)
    canvas.draw_without_rendering()
    low, high = axis.get_ylim()
    seen = [
        label.get_text()
        for label in axis.get_yticklabels()
        if low <= label.get_position()[1] <= high
    ]
    assert seen == ["500", "1,000", "2,000", "5,000", "10,000"]


def test_rows_may_share_an_axis_and_differ_in_height() -> None:
    canvas, axes = new_canvas(4, 6, rows=2, sharex="all", height_ratios=(3.0, 1.0))
    axes[0][0].set_xlim(2, 7)
    assert axes[1][0].get_xlim() == (2, 7)
    canvas.draw_without_rendering()
    tall, low = (row[0].get_position().height for row in axes)
    assert tall == pytest.approx(3 * low, rel=0.05)
