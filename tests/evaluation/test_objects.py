# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Objects that were reported against the block, the painted ring and the lesser lump of
conftest.py.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hullrecon.evaluation.objects import find_reported, reach_m, score_objects
from hullrecon.evaluation.truth import Truth, read_truth
from hullrecon.geometry.poses import from_mount, identity
from hullrecon.records.deliverables import ReportedObject

BLOCK = ReportedObject(
    id=1, center=(1.0, 0.112, 0.0), height=0.1, height_sigma=0.004, views=9, area=0.09
)
MARK = ReportedObject(id=2, center=(2.0, 0.02, 0.0), height=0.03)
LUMP = ReportedObject(id=3, center=(3.0, 0.02, 0.5), height=0.05)


@pytest.fixture(scope="module")
def truth(package: Path) -> Truth:
    return read_truth(package)


def test_a_perfect_report_has_full_recall_and_no_error(truth: Truth) -> None:
    figures = score_objects([BLOCK], truth, identity())
    assert figures["recall"] == 1
    assert figures["height_error_worst_m"] == 0
    assert figures["false_reports"] == 0
    assert figures["height_error_over_sigma"] == 0


def test_a_reports_centre_is_moved_before_it_is_matched(truth: Truth) -> None:
    shifted = replace(BLOCK, center=(2.5, 0.112, 0.4))
    assert score_objects([shifted], truth, identity())["recall"] == 0
    assert score_objects([shifted], truth, from_mount([-1.5, 0, -0.4, 0, 0, 0]))["recall"] == 1


def test_a_lesser_structure_is_neither_due_nor_false(truth: Truth) -> None:
    figures = score_objects([LUMP], truth, identity())
    assert figures["due"] == 1
    assert figures["recall"] == 0
    assert figures["false_reports"] == 0
    assert figures["lesser_structures_found"] == 1


def test_a_report_on_paint_is_false_and_counted_as_such(truth: Truth) -> None:
    figures = score_objects([MARK], truth, identity())
    assert figures["false_reports"] == 1
    assert figures["false_on_paint"] == 1


def test_of_two_reports_the_better_height_counts(truth: Truth) -> None:
    figures = score_objects(
        [replace(BLOCK, height=0.2), replace(BLOCK, height=0.11)], truth, identity()
    )
    assert figures["reported_twice"] == 1
    assert figures["height_error_worst_m"] == pytest.approx(0.01)


def test_a_height_without_a_sigma_does_not_enter_the_ratio(truth: Truth) -> None:
    figures = score_objects([replace(BLOCK, height=0.12, height_sigma=None)], truth, identity())
    assert np.isnan(figures["height_error_over_sigma"])
    assert score_objects([replace(BLOCK, height=0.108)], truth, identity())[
        "height_error_over_sigma"
    ] == pytest.approx(2)


def test_the_reach_grows_with_the_structure(truth: Truth) -> None:
    (block,) = truth.due()
    assert reach_m(block) == pytest.approx(0.10 + 0.15)
    inside, outside = (replace(BLOCK, center=(1.0 + gap, 0.112, 0.0)) for gap in (0.24, 0.26))
    assert score_objects([inside], truth, identity())["recall"] == 1
    assert score_objects([outside], truth, identity())["recall"] == 0


def test_the_report_of_a_structure_is_the_one_with_most_images(truth: Truth) -> None:
    (block,) = truth.due()
    few = replace(BLOCK, id=7, views=2)
    found = find_reported(block, [few, BLOCK, MARK], truth, identity())
    assert found is not None
    assert found.id == 1
    assert find_reported(block, [MARK], truth, identity()) is None


def test_nothing_reported_misses_what_is_due(truth: Truth) -> None:
    figures = score_objects([], truth, identity())
    assert figures["missed"] == [1]
    assert np.isnan(figures["height_error_median_m"])
