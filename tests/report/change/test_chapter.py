# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The texts of the chapter on change."""

from __future__ import annotations

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from report.change.conftest import hull_change, object_change

from hullrecon.records.change import HullChange
from hullrecon.report.change.chapter import (
    ChangeChapter,
    change_chapter,
    offset_sentence,
    outcome,
    verdict,
)


def test_the_chapter_says_verdict_and_a_line_a_change(change: HullChange) -> None:
    chapter = change_chapter(change)
    assert (chapter.first, chapter.second, chapter.verdict) == ("may", "june", verdict(change))
    assert chapter.verdict == f"may to june: {chapter.outcome}" == f"may to june: {outcome(change)}"
    assert [line.split(":")[0] for line in chapter.lines] == [
        "gone",
        "new",
        "new",
        "grown",
        "moved",
    ]


def test_the_table_of_changes_has_numbers_of_both_dives(
    change: HullChange,
) -> None:
    rows = change_chapter(change).rows
    assert [(row.status, row.changed, row.first, row.second) for row in rows] == [
        ("gone", True, "4", "–"),
        ("new", True, "–", "5"),
        ("new", True, "–", "–"),
        ("grown", True, "1", "1"),
        ("not seen again", False, "7", "–"),
        ("unchanged", False, "2", "3"),
    ]
    assert (rows[3].before, rows[3].after, rows[3].change, rows[3].chance) == (
        "110 ± 3",
        "141 ± 4",
        "31 ± 4",
        "< 0.0001",
    )
    assert (rows[4].after, rows[4].change, rows[4].chance) == ("–", "–", "–")


def test_a_height_without_a_sigma_stands_alone() -> None:
    row = replace(object_change("unchanged", 1, 1, 31.0, 0.1, 0.12), height_before_sigma=np.nan)
    (written,) = change_chapter(hull_change([row])).rows
    assert (written.before, written.after) == ("100", "120 ± 4")


def test_bare_hull_that_moved_has_its_chance(change: HullChange) -> None:
    assert change_chapter(change).moves == (
        ("moved: 0.36 m² of bare hull at frame 53, port, −12 ± 3 mm along the normal", "0.0002"),
    )


def test_the_chapter_is_the_same_after_it_was_stored(change: HullChange) -> None:
    chapter = change_chapter(change)
    assert msgspec.json.decode(msgspec.json.encode(chapter), type=ChangeChapter) == chapter


def test_areas_and_what_would_stand_out_are_words(change: HullChange) -> None:
    chapter = change_chapter(change)
    assert (chapter.area_first, chapter.area_second, chapter.area_both) == (
        "8.0 m²",
        "7.8 m²",
        "7.6 m²",
    )
    assert (chapter.detectable, chapter.places) == ("15 mm", "3,040")


def test_where_nothing_could_be_compared_the_verdict_says_so() -> None:
    blind = replace(hull_change(), detectable_m=float("nan"), area_both=0.0)
    assert verdict(blind) == "may to june: no change; no hull was seen well enough by both dives"


def test_the_offset_is_told_with_its_sigma_and_what_was_expected(change: HullChange) -> None:
    sentence = offset_sentence(change.offset)
    assert sentence.startswith(
        "To lie on the first dive the second was moved by x +50 ± 1 mm, y +0 ± 1 mm, z −10 ± 1 mm"
    )
    assert "turned by 0.06°" in sentence
    assert (
        "as their hull poses foresaw: one sigma 200, 200, 200 mm, chi-square 2.5 of 6" in sentence
    )


@pytest.mark.parametrize(
    ("p_value", "words"),
    [(1e-5, "farther than their hull poses foresaw"), (0.4, "as their hull poses")],
)
def test_an_offset_beyond_its_gate_is_said_to_be_one(
    change: HullChange, p_value: float, words: str
) -> None:
    assert words in offset_sentence(replace(change.offset, p_value=p_value))
