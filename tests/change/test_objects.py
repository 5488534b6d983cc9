# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from change.conftest import ADDED, GROWN
from change.simulated_surveys import BEFORE, NONE, chart, survey

from hullrecon.change.difference import changed_regions, difference
from hullrecon.change.objects import ObjectComparison, compare_objects
from hullrecon.change.options import ChangeOptions
from hullrecon.change.relief import relief_on
from hullrecon.geometry.charts.lattice import Lattice
from hullrecon.geometry.poses import identity
from hullrecon.records.change import SurveyOffset

OPTIONS = ChangeOptions()
LATTICE = Lattice(origin=np.array([29.8, 4.0]), step_m=0.02, shape=(220, 110))
SAME = SurveyOffset(
    first_from_second=identity(),
    covariance=1e-6 * np.eye(6),
    prior_covariance=1e-4 * np.eye(6),
    center=np.array([32.0, 4, 2]),
    chi_square=0.0,
    p_value=1.0,
)


def rows_of(first, second):
    found = difference(*(relief_on(LATTICE, chart(), s) for s in (first, second)), OPTIONS)
    on = ObjectComparison(
        chart=chart(), lattice=LATTICE, offset=SAME, difference=found, options=OPTIONS, places=1000
    )
    return compare_objects(first, second, changed_regions(found, 1000, OPTIONS), on)


@pytest.fixture(scope="module")
def before():
    return survey(BEFORE, NONE)


def test_an_object_is_itself_in_both_surveys(before) -> None:
    rows = rows_of(before, before)
    assert {(row.first_id, row.second_id, row.status) for row in rows} == {
        (k, k, "unchanged") for k in (1, 2, 3, 4)
    }
    assert max(abs(row.change) for row in rows) < 1e-6


def test_numbers_may_differ_between_the_surveys(before) -> None:
    rows = rows_of(before, survey(BEFORE[::-1], NONE))
    assert {(row.first_id, row.second_id) for row in rows} == {(1, 4), (2, 3), (3, 2), (4, 1)}


def test_a_structure_that_grew_and_one_that_shrank() -> None:
    lower = replace(BEFORE[1], height_m=0.07)
    surveys = (BEFORE, (GROWN, lower, *BEFORE[2:]))
    rows = rows_of(*(survey(items, NONE, step_m=0.02) for items in surveys))
    status = {row.first_id: (row.status, round(row.change, 2)) for row in rows}
    assert status[1] == ("grown", 0.03)
    assert status[2] == ("shrunk", -0.05)
    assert status[3][0] == status[4][0] == "unchanged"


def test_a_recess_that_got_deeper_has_grown() -> None:
    deeper = replace(ADDED[0], height_m=-0.08)
    (row,) = rows_of(survey(ADDED[:1], NONE), survey((deeper,), NONE))
    assert row.status == "grown"
    assert row.change == pytest.approx(-0.04, abs=0.005)


def test_new_object_changed_by_its_whole_height() -> None:
    dome = survey(ADDED[2:], NONE)
    (new,), (gone,) = rows_of(survey((), NONE), dome), rows_of(dome, survey((), NONE))
    for row, sign in ((new, 1), (gone, -1)):
        assert (
            row.change
            == pytest.approx(row.height_after - row.height_before)
            == pytest.approx(0.1 * sign, abs=0.004)
        )
        assert row.change_sigma == pytest.approx(
            np.hypot(row.height_before_sigma, row.height_after_sigma)
        )
    assert new.height_after_sigma == gone.height_before_sigma == 0.008
    assert 0 < new.height_before_sigma < 0.008


def test_unlisted_structure_has_sigma_of_surface() -> None:
    (row,) = rows_of(survey((), NONE), survey(ADDED[1:2], NONE, listed=()))
    assert (row.status, row.second_id) == ("new", None)
    assert row.height_after == pytest.approx(0.09, abs=0.005)
    assert 0.002 < row.height_after_sigma == row.height_before_sigma < 0.006


def test_a_structure_in_the_place_of_another_is_not_the_same(before) -> None:
    moved = replace(BEFORE[3], along_m=32.4)
    rows = rows_of(before, survey((*BEFORE[:3], moved), NONE))
    assert sorted(row.status for row in rows if row.status != "unchanged") == ["gone", "new"]


def test_a_recess_where_a_bump_was_is_gone_and_new() -> None:
    bump, hole = (
        replace(BEFORE[0], height_m=0.06),
        replace(ADDED[0], along_m=30.6, girth_m=4.8, height_m=-0.06),
    )
    rows = rows_of(survey((bump,), NONE), survey((hole,), NONE))
    assert sorted(row.status for row in rows) == ["gone", "new"]
    assert {row.change < 0 for row in rows} == {True}


def test_what_changed_stands_before_what_did_not(before) -> None:
    rows = rows_of(before, survey((GROWN, *BEFORE[1:3], ADDED[1]), NONE))
    assert [row.status for row in rows] == ["gone", "new", "grown", "unchanged", "unchanged"]


def test_an_object_without_an_outline_is_compared_by_its_size(before) -> None:
    bare = replace(before, objects=tuple(replace(o, outline=()) for o in before.objects))
    assert {row.status for row in rows_of(bare, bare)} == {"unchanged"}


def test_the_place_of_an_object_has_its_delivered_sigma(before) -> None:
    row = rows_of(before, before)[0]
    assert row.sigma == pytest.approx([0.15, 0.04, 0.02])


def test_unlisted_structure_has_place_sigma_of_hull_poses(before) -> None:
    rows = rows_of(before, survey((*BEFORE, ADDED[1]), NONE, listed=BEFORE))
    row = next(row for row in rows if row.status == "new")
    assert row.second_id is None
    # 7 mm and what a turn of 10 mrad moves at this distance
    assert ((row.sigma > 0.005) & (row.sigma < 0.02)).all()


def test_two_hulls_without_objects_have_no_rows() -> None:
    assert rows_of(survey((), NONE), survey((), NONE)) == ()
