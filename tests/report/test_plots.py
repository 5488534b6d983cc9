# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from PIL import Image
from report_pages import draw_all_plots

from hullrecon.records.sensors import DvlPings
from hullrecon.records.solution import Solution
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.report.figures.plots import (
    convergence,
    depth_and_standoff,
    deviation_histogram,
    deviation_shares,
    labels,
    residuals,
    standoff,
)
from hullrecon.report.survey import FactorResiduals, Survey


def test_plots_of_a_survey_have_picture_words_and_numbers(survey: Survey) -> None:
    found = {p.name: p for p in draw_all_plots(survey)}
    assert list(found) == [
        "depth_standoff",
        "position_sigma",
        "convergence",
        "labels",
        "deviation_histogram",
    ]
    for plot in found.values():
        with Image.open(BytesIO(plot.png)) as picture:
            assert picture.width > 600
            assert "Software" not in picture.info
        assert plot.alt.endswith(".")
        assert len({len(column) for column in plot.table.values()}) == 1


def test_a_bare_dive_has_the_plots_of_its_navigation(bare: Survey) -> None:
    assert [p.name for p in draw_all_plots(bare)] == ["depth_standoff", "position_sigma"]


def test_the_standoff_is_the_median_of_the_beams_that_came_back(dvl: DvlPings) -> None:
    np.testing.assert_allclose(standoff(dvl), [1.2, 1.2, np.nan])
    odd = replace(dvl, ranges=np.array([[1.0, 2.0, 3.0, np.nan]]) / 0.75**0.5)
    np.testing.assert_allclose(standoff(odd), [2.0])


def test_depth_without_a_dvl_is_drawn_alone() -> None:
    plot = depth_and_standoff(np.arange(3) * 10**9, np.array([1.0, 2.0, 3.0]), None)
    assert list(plot.table) == ["t_s", "depth_m"]
    assert plot.alt == "Depth from 1.00 to 3.00 m."


def test_convergence_lists_the_cost_of_each_factor() -> None:
    plot = convergence({"cost": np.array([9.0, 4.0]), "cost_stereo": np.array([8.0, 3.0])})
    assert plot.table["cost"] == ["9", "4"]
    assert plot.table["stereo"] == ["8", "3"]
    assert plot.alt == "The cost falls from 9 to 4 in 1 iteration."


def test_a_step_that_was_not_taken_shows_the_cost_that_stayed() -> None:
    plot = convergence(
        {"cost": np.array([9.0, 1e28, 4.0]), "accepted": np.array([True, False, True])}
    )
    assert plot.table["cost"] == ["9", "9", "4"]


def test_costs_of_two_rounds_are_told_apart() -> None:
    plot = convergence(
        {
            "cost": np.array([9.0, 4.0, 90.0]),
            "round": np.array([1, 1, 2]),
            "pixel_sigma_px": np.array([1, 1, 0.2]),
        }
    )
    assert plot.table["round"] == [1, 1, 2]
    assert "from 9 to 4 in 1 iteration, then from 90 to 90 in 0 iterations" in plot.alt
    assert "do not compare" in plot.alt


def test_labels_say_how_many_ended_on_the_hull() -> None:
    plot = labels({"on_surface": np.array([5, 7]), "label_changes": np.array([0, 2])})
    assert (
        plot.alt == "7 of 7 landmarks end as on the hull; 2 labels changed at the last iteration."
    )


def test_labels_are_a_share_of_the_landmarks_of_their_round() -> None:
    record = {
        "on_surface": [5, 70],
        "label_changes": [0, 0],
        "landmarks": [10, 100],
        "round": [1, 2],
    }
    plot = labels({name: np.array(values) for name, values in record.items()})
    assert plot.table["landmarks"] == [10, 100]
    assert plot.alt.startswith("70 of 100 landmarks")


def test_residuals_compare_the_factors_that_both_have() -> None:
    plot = residuals(
        {"stereo": FactorResiduals(rms=4.0), "range": FactorResiduals(rms=2.0)},
        {"stereo": FactorResiduals(rms=1.1, count=90)},
    )
    assert plot.table == {
        "factor": ["stereo"],
        "rms_before": ["4"],
        "rms_after": ["1.1"],
        "count": [90],
    }


def test_without_depth_and_dvl_there_is_nothing_to_draw_of_them(dvl: DvlPings) -> None:
    times = np.arange(3) * 10**9
    assert depth_and_standoff(times, None, None) is None
    plot = depth_and_standoff(times, None, dvl)
    assert plot is not None
    assert list(plot.table) == ["t_s", "standoff_m"]
    assert plot.title == "Distance to the hull"


def test_a_distance_is_given_only_while_the_dvl_was_heard(dvl: DvlPings) -> None:
    heard = np.r_[np.arange(11.0), np.arange(70.0, 81.0)]
    ranges = np.repeat(np.where(heard < 20, 1.0, 3.0)[:, None], dvl.ranges.shape[1], axis=1)
    pings = replace(dvl, t_ns=(1e9 * heard).astype(np.int64), ranges=ranges)
    plot = depth_and_standoff(10**9 * np.array([0, 5, 10, 11, 75, 100]), None, pings)
    assert plot is not None
    given = plot.table["standoff_m"]
    assert [bool(cell) for cell in given] == [True, True, True, False, True, False]
    assert given[0] == given[1] == given[2] != given[4]


def test_the_histogram_weighs_a_surface_by_its_area(plate: Surface, split: DeviationSplit) -> None:
    deviation = np.where(plate.vertices[:, 0] < 0.5, 0.048, 0.0)
    shares = deviation_shares(
        None, replace(plate, deviation=deviation), replace(split, form=deviation - 0.02)
    )
    assert shares is not None
    plot = deviation_histogram(shares)
    for column, first, second in (
        ("as_found_percent", "0.046", "-0.002"),
        ("form_percent", "0.026", "-0.022"),
    ):
        share = dict(zip(plot.table["from_m"], map(float, plot.table[column]), strict=True))
        # of the columns x = -1, 0, 1 (seen) the first has half the area of the others
        assert share[first] == pytest.approx(100 * 1.5 / 2.5, abs=1e-3)
        assert share[second] == pytest.approx(100 * 1.0 / 2.5, abs=1e-3)


def test_the_histogram_tells_the_offset_with_its_sigma(
    plate: Surface, split: DeviationSplit, solution: Solution
) -> None:
    shares = deviation_shares(solution, plate, split)
    assert shares is not None
    plot = deviation_histogram(shares)
    assert "offset of the whole patch +6 mm, one sigma 20 mm" in plot.alt
    assert "median one sigma 2.0 mm" in plot.alt
    assert list(plot.table) == [
        "from_m",
        "to_m",
        "landmarks_percent",
        "as_found_percent",
        "form_percent",
    ]


def test_without_a_cad_model_there_is_no_histogram(plate: Surface, solution: Solution) -> None:
    assert deviation_shares(solution, plate, None) is None
