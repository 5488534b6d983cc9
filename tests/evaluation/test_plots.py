# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import cv2
import numpy as np
import pytest

from hullrecon.evaluation.plots import (
    Figure,
    Progress,
    Section,
    cost_history,
    cross_sections,
    label_frequency,
    range_histogram,
    structure_heights,
)

SOLVE = Progress("maxmix as printed", np.array([100.0, 10.0, 5.0, 5.0]), np.array([50.0, 60, 80, 80]), 100, 8.0)


def rows(figure: Figure) -> list[list[str]]:
    return [line.split(",") for line in figure.csv.splitlines()]


def picture(figure: Figure) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(figure.png, np.uint8), cv2.IMREAD_COLOR)


def test_label_frequency_is_a_share_by_iteration() -> None:
    table = rows(label_frequency([SOLVE]))
    assert table[0] == ["method", "iteration", "share_on_surface"]
    assert [float(row[2]) for row in table[1:]] == [0.5, 0.6, 0.8, 0.8]


def test_cost_is_given_by_iteration_and_by_evenly_shared_time() -> None:
    table = rows(cost_history([SOLVE]))[1:]
    assert [float(row[2]) for row in table] == [2, 4, 6, 8]
    assert [float(row[3]) for row in table] == [100, 10, 5, 5]


def test_the_histogram_counts_every_residual_in_reach() -> None:
    before, after = np.array([-0.2, 0.0, 0.1, 9.0]), {"maxmix": np.array([0.001, 0.002])}
    table = rows(range_histogram(before, after))
    assert table[0] == ["residual_m", "dead reckoned", "maxmix"]
    counts = np.array([[float(v) for v in row[1:]] for row in table[1:]]).sum(0)
    np.testing.assert_array_equal(counts, [3, 2])


def test_heights_are_listed_by_method_beside_the_true_ones() -> None:
    table = rows(structure_heights({"geva": np.array([0.02]), "maxmix": np.array([0.1, 0.11])}, np.array([0.11]), "cylinder"))
    assert table[1:] == [["geva", "0.02000"], ["maxmix", "0.10000"], ["maxmix", "0.11000"], ["true", "0.11000"]]


def test_cross_sections_draw_a_panel_a_method() -> None:
    line = np.stack([np.linspace(-0.5, 0.5, 20), np.zeros(20)], 1)
    section = Section("geva as printed", line + 0.01, line, np.add(line[:3], [0, 0.1]), line, np.zeros((0, 2)))
    figure = cross_sections([[section, section], [section, section]])
    kinds = {row[1] for row in rows(figure)[1:]}
    assert kinds == {"dvl", "on", "off", "steel"}
    assert len(rows(figure)) == 1 + 4 * (20 + 20 + 3 + 20)
    assert picture(figure).shape[1] > 800


@pytest.mark.parametrize("make", [lambda: label_frequency([SOLVE]), lambda: cost_history([SOLVE, SOLVE])])
def test_the_picture_is_not_blank_and_the_same_each_time(make) -> None:  # type: ignore[no-untyped-def]
    first, second = make(), make()
    assert first.png == second.png
    assert picture(first).std() > 5


def test_a_method_without_landmarks_on_top_does_not_break_the_plot() -> None:
    figure = structure_heights({"naive": np.zeros(0), "maxmix": np.array([0.1])}, np.zeros(0), "box")
    assert picture(figure).size > 0
