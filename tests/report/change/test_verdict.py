# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest
from report.change.conftest import MOVE, hull_change, object_change

from hullrecon.records.change import HullChange
from hullrecon.report.change.chapter import move_sentence, object_sentence, verdict


def test_the_verdict_says_what_changed_and_what_would_show(
    change: HullChange,
) -> None:
    line = verdict(change)
    assert line.startswith(
        "may to june: 2 new, 1 gone, 1 grown and 1 stretch of bare hull moved, "
        "1 object where only one dive"
    )
    assert "7.6 m² compared" in line
    assert line.endswith(
        "in half of which a structure whose height changed by 15 mm would stand out"
    )
    assert "\n" not in line


def test_no_change_is_said_to_be_none() -> None:
    line = verdict(hull_change([object_change("unchanged", 1, 1, 31.0, 0.1, 0.1)]))
    assert line.startswith("may to june: no change; 7.6 m² compared")


def test_an_uncertain_object_of_one_dive_is_counted() -> None:
    line = verdict(hull_change([object_change("uncertain", None, 2, 31.0, 0.0, -0.03)]))
    assert line.startswith(
        "may to june: no change, 1 object that one dive lists "
        "and the other neither shows nor excludes; "
    )


def test_two_stretches_are_plural() -> None:
    assert "2 stretches of bare hull moved" in verdict(hull_change(moves=[MOVE, MOVE]))


def test_one_change_stands_alone() -> None:
    assert verdict(hull_change([object_change("gone", 1, None, 31.0, 0.1, 0.0)])).startswith(
        "may to june: 1 gone; "
    )


@pytest.mark.parametrize(
    ("row", "sentence"),
    [
        (
            object_change("gone", 4, None, 33.0, 0.14, 0.0),
            "gone: object 4 of the first dive at frame 55, port, height 140 ± 3 mm",
        ),
        (
            object_change("new", None, 5, 33.0, 0.0, 0.09),
            "new: object 5 at frame 55, port, height 90 ± 4 mm",
        ),
        (
            object_change("new", None, None, 33.0, 0.0, -0.04),
            "new: a structure at frame 55, port, recess 40 ± 4 mm",
        ),
        (
            object_change("grown", 1, 2, 33.0, 0.11, 0.14),
            "grown: object 2 at frame 55, port, height +30 ± 4 mm",
        ),
        (
            object_change("shrunk", 1, 2, 33.0, 0.11, 0.05),
            "shrunk: object 2 at frame 55, port, height −60 ± 4 mm",
        ),
    ],
)
def test_a_sentence_says_what_became_of_an_object(row, sentence: str) -> None:
    assert object_sentence(row) == sentence


def test_bare_hull_that_moved_is_said_with_area_and_sigma() -> None:
    assert (
        move_sentence(MOVE)
        == "moved: 0.36 m² of bare hull at frame 53, port, −12 ± 3 mm along the normal"
    )


def test_heights_of_the_sentence_are_positive() -> None:
    row = object_change("gone", 3, None, 33.0, -0.05, 0.0)
    assert object_sentence(row).endswith("recess 50 ± 3 mm")
    assert np.isfinite(row.change)
