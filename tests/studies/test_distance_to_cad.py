# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import cv2
import numpy as np
import pytest

from hullrecon.studies.paths.path_figures import ReturnsOnHull, distance_to_cad_model


def on_hull(distance: np.ndarray) -> ReturnsOnHull:
    points = np.column_stack([np.linspace(0, 10, len(distance)), distance, np.zeros(len(distance))])
    return ReturnsOnHull(points=points, distance=distance)


def test_the_table_has_a_row_a_path_with_its_spread() -> None:
    figure = distance_to_cad_model(
        {
            "dead reckoning": on_hull(np.array([-0.3, 0.1, 0.2, 0.0])),
            "planes": on_hull(np.full(3, 0.01)),
        }
    )
    rows = [line.split(",") for line in figure.csv.splitlines()]
    assert rows[1][:3] == ["dead reckoning", "4", "0.15000"]
    assert float(rows[1][5]) == 0.5
    assert rows[2][0] == "planes"
    assert "planes 10 mm in the mean, 0 % beyond 0.1 m" in figure.caption


@pytest.mark.usefixtures("pictures")
def test_there_is_a_panel_a_path_and_one_for_the_histogram() -> None:
    rng = np.random.default_rng(0)
    few = distance_to_cad_model({"a": on_hull(rng.normal(size=50))})
    many = distance_to_cad_model(
        {"a": on_hull(rng.normal(size=9000)), "b": on_hull(0.1 * rng.normal(size=50))}
    )
    width = [
        cv2.imdecode(np.frombuffer(f.png, np.uint8), cv2.IMREAD_COLOR).shape[1] for f in (few, many)
    ]
    assert width[1] > 1.4 * width[0]


def test_returns_that_all_lie_on_the_cad_model_break_nothing() -> None:
    assert "0 mm" in distance_to_cad_model({"planes": on_hull(np.zeros(5))}).caption


def test_the_printed_distances_stand_beside_ours() -> None:
    laid = {
        "without planes": on_hull(np.array([0.0, 2.0])),
        "with planes": on_hull(np.full(4, 0.2)),
    }
    compared = distance_to_cad_model(laid).compared
    assert [(v.printed, round(v.ours or 0.0, 6)) for v in compared] == [
        (1.31, 1.0), (1.38, 1.0), (20.0, 50.0), (0.45, 0.2), (0.19, 0.0), (0.0, 0.0),
    ]  # fmt: skip
