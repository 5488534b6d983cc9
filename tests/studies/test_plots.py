# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import cv2
import numpy as np
import pytest

from hullrecon.studies.figure_style import PublishedFigure
from hullrecon.studies.methods.plots import (
    CrossSection,
    DeliveredHeight,
    WholeSection,
    cross_sections,
    range_histogram,
    structure_heights,
)

LINE = np.stack([np.linspace(-0.5, 0.5, 20), np.zeros(20)], 1)


def rows(figure: PublishedFigure) -> list[list[str]]:
    return [line.split(",") for line in figure.csv.splitlines()]


def picture(figure: PublishedFigure) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(figure.png, np.uint8), cv2.IMREAD_COLOR)


def test_the_histogram_counts_every_residual_in_reach() -> None:
    before, after = (
        {"registered": np.array([-0.2, 0.0, 0.1, 9.0])},
        {"maxmix": np.array([0.001, 0.002])},
    )
    table = rows(range_histogram(before, after, 0.3))
    assert table[0] == ["residual_m", "registered", "maxmix"]
    counts = np.array([[float(v) for v in row[1:]] for row in table[1:]]).sum(0)
    np.testing.assert_array_equal(counts, [3, 2])


def test_the_spread_of_the_residuals_is_said_in_millimetres() -> None:
    spread = np.array([-0.02, -0.01, 0.0, 0.01, 0.02])  # MAD 10 mm
    assert (
        "registered 15 mm; maxmix 1 mm"
        in range_histogram({"registered": spread}, {"maxmix": 0.1 * spread}, 0.3).caption
    )


def test_heights_are_listed_with_true_and_delivered() -> None:
    found = {"geva": np.array([0.02]), "maxmix": np.array([0.1, 0.11])}
    table = rows(
        structure_heights(
            found, 0.11, "cylinder", DeliveredHeight(height_m=0.108, sigma_m=0.004, views=7)
        )
    )
    assert table[1:] == [
        ["geva", "0.02000", ""],
        ["maxmix", "0.10000", ""],
        ["maxmix", "0.11000", ""],
        ["delivered", "0.10800", "0.00400"],
        ["true", "0.11000", ""],
    ]


@pytest.mark.usefixtures("pictures")
def test_method_without_landmarks_on_top_is_plotted() -> None:
    figure = structure_heights({"naive": np.zeros(0), "maxmix": np.array([0.1])}, 0.11, "box", None)
    assert picture(figure).std() > 5
    assert "delivered" not in figure.caption


@pytest.mark.usefixtures("pictures")
def test_cross_sections_draw_a_panel_a_method_below_its_overview() -> None:
    nothing = np.zeros((0, 2))
    section = CrossSection(
        method="geva",
        weighting="as published",
        dvl=LINE + 0.01,
        on=LINE,
        off=np.add(LINE[:3], [0, 0.1]),
        steel=LINE,
        cad_model=nothing,
    )
    overview = WholeSection(
        on=LINE, off=LINE[:2], dvl=nothing, cad_model=nothing, at=np.array([0.1, 0.0])
    )
    figure = cross_sections(
        [[section, section], [section, section]], [overview, overview], "cylinder"
    )
    kinds = {row[2] for row in rows(figure)[1:]}
    assert kinds == {"dvl", "on", "off", "steel"}
    assert len(rows(figure)) == 1 + 4 * (20 + 20 + 3 + 20)
    assert picture(figure).shape[0] > 3 * 300
    assert "cylinder" in figure.caption
