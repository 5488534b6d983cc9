# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import cv2
import numpy as np
import pytest

from hullrecon.studies.scenes.gic_by_relief import CriterionTrials, gic_by_relief

PEAK_M = np.array([0.0, 0.01, 0.1])


def trials(homography: list[list[float]], essential: float = 700.0) -> CriterionTrials:
    """Trials in which the essential matrix scores alike everywhere."""
    scores = np.array(homography)
    return CriterionTrials(
        peak_m=PEAK_M, homography=scores, essential=np.full(scores.shape, essential)
    )


RISING = trials([[590.0, 610.0], [650.0, 670.0], [690.0, 830.0]])


def rows(csv: str) -> list[list[str]]:
    return [line.split(",") for line in csv.splitlines()]


def test_homography_is_chosen_by_smaller_criterion() -> None:
    np.testing.assert_array_equal(RISING.share_of_homography(), [1.0, 1.0, 0.5])


def test_the_means_are_equal_on_the_line_between_two_heights() -> None:
    """From 40 below to 60 above: after two fifths of the way from 10 to 100 mm."""
    assert RISING.crossing_m() == pytest.approx(0.01 + 0.4 * 0.09)


@pytest.mark.parametrize("level", [500.0, 900.0])
def test_means_that_never_meet_are_nowhere_equal(level: float) -> None:
    apart = trials([[level, level]] * 3)
    assert apart.crossing_m() is None
    assert "nowhere equal" in gic_by_relief({"as published": apart, "capped": apart}).caption


def test_means_that_are_equal_at_a_height_cross_there() -> None:
    assert trials([[600.0], [700.0], [800.0]]).crossing_m() == pytest.approx(0.01)


def test_table_has_row_a_height_and_scoring() -> None:
    table = rows(
        gic_by_relief({"as published": RISING, "capped": trials([[600.0, 600.0]] * 3)}).csv
    )
    assert [row[0] for row in table[1:]] == ["as published"] * 3 + ["capped"] * 3
    assert {len(row) for row in table} == {8}
    last = dict(zip(table[0], table[3], strict=True))
    assert (last["peak_m"], last["trials"], last["share_homography"]) == ("0.100", "2", "0.500")
    assert (float(last["homography_mean"]), float(last["homography_sigma"])) == (760.0, 70.0)
    assert (float(last["essential_mean"]), float(last["essential_sigma"])) == (700.0, 0.0)


def test_caption_says_where_the_choice_turns() -> None:
    caption = gic_by_relief({"as published": RISING, "capped": RISING}).caption
    assert "as published: mean criteria equal at 46 mm" in caption
    assert (
        "the homography chosen in 100 % of the trials at 0 mm and in 50 % of the trials at 100 mm"
        in caption
    )


@pytest.mark.usefixtures("pictures")
def test_growing_criterion_is_drawn_deterministically() -> None:
    """On a logarithmic axis, beside one that is not."""
    steep = trials([[600.0, 600.0], [700.0, 720.0], [9000.0, 9500.0]])
    figure = gic_by_relief({"as published": steep, "capped": RISING})
    assert figure.png == gic_by_relief({"as published": steep, "capped": RISING}).png
    assert figure.png != gic_by_relief({"as published": RISING, "capped": RISING}).png


@pytest.mark.usefixtures("pictures")
def test_there_is_a_panel_a_scoring_and_one_for_the_choice() -> None:
    one, two = (gic_by_relief(dict.fromkeys(names, RISING)).png for names in (["a"], ["a", "b"]))
    width = [
        cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR).shape[1] for png in (one, two)
    ]
    assert width[1] == pytest.approx(1.5 * width[0], rel=0.01)


def test_a_single_trial_has_no_spread_and_chooses_all_or_nothing() -> None:
    table = rows(gic_by_relief({"as published": trials([[600.0], [650.0], [800.0]])}).csv)
    column = dict(zip(table[0], zip(*table[1:], strict=True), strict=True))
    assert set(column["homography_sigma"]) == {"0.000"}
    assert column["share_homography"] == ("1.000", "1.000", "0.000")
