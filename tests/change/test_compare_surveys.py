# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether two CAD models are of one hull, however they are meshed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from change.conftest import ADDED, address
from change.simulated_surveys import ALONG, BEFORE, GIRTH, drawn, survey

from hullrecon.change.compare_surveys import cad_model_gap, compare_surveys
from hullrecon.change.options import ChangeOptions
from hullrecon.errors import StageError
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.change import HullChange, HullSurvey

BOX = np.array([[x, y, z] for x in (0.0, 10) for y in (-1.0, 1) for z in (0.0, 2)])
FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7]], np.int32)


def by_status(change: HullChange) -> dict[str, list]:
    found: dict[str, list] = {}
    for row in change.objects:
        found.setdefault(row.status, []).append(row)
    return found


def test_what_is_new_gone_and_grown_is_found_and_nothing_else(changed: HullChange) -> None:
    counts = {status: len(rows) for status, rows in by_status(changed).items()}
    assert counts == {"new": 3, "gone": 1, "grown": 1, "unchanged": 2}
    assert changed.moves == ()


def test_what_grew_is_told_by_how_much_within_its_sigma(changed: HullChange) -> None:
    (grown,) = by_status(changed)["grown"]
    assert grown.change == pytest.approx(0.03, abs=3 * grown.change_sigma)
    assert grown.change_sigma < 0.007
    assert (grown.first_id, grown.second_id) == (1, 1)


def test_heights_before_and_after_are_those_of_the_objects(changed: HullChange) -> None:
    (grown,), (gone,) = by_status(changed)["grown"], by_status(changed)["gone"]
    assert (grown.height_before, grown.height_after) == (0.11, 0.14)
    assert gone.height_before == 0.14
    assert abs(gone.height_after) < 0.01


def test_a_new_recess_has_a_negative_change(changed: HullChange) -> None:
    recess = next(row for row in by_status(changed)["new"] if row.change < 0)
    assert recess.change == pytest.approx(-0.04, abs=0.008)
    assert recess.second_id == 4


def test_objects_that_stayed_keep_their_numbers_in_both_dives(changed: HullChange) -> None:
    assert {(row.first_id, row.second_id) for row in by_status(changed)["unchanged"]} == {
        (2, 2),
        (3, 3),
    }


def test_changes_come_with_a_probability_and_a_place_in_words(changed: HullChange) -> None:
    for row in changed.changed():
        assert row.p_value < 1e-4
        assert row.address.startswith("x 3")
        assert row.area > 0.005


def test_nothing_is_found_between_two_dives_of_the_same_hull(unchanged: HullChange) -> None:
    assert unchanged.changed() == ()
    assert unchanged.moves == ()
    assert [row.status for row in unchanged.objects] == ["unchanged"] * 4


def test_an_unchanged_object_says_how_well_that_is_known(unchanged: HullChange) -> None:
    for row in unchanged.objects:
        assert abs(row.change) < 3 * row.change_sigma
        assert row.p_value > 0.01


def test_the_areas_add_up(unchanged: HullChange) -> None:
    window = (ALONG[1] - ALONG[0]) * (GIRTH[1] - GIRTH[0])
    assert unchanged.area_first == pytest.approx(window, rel=0.05)
    assert 0.8 * window < unchanged.area_both <= unchanged.area_first + 1e-9
    assert unchanged.places == pytest.approx(
        unchanged.area_both / ChangeOptions().min_area_m2, abs=1
    )


def test_the_map_is_known_where_both_saw_the_hull(unchanged: HullChange) -> None:
    known = np.isfinite(unchanged.map.change)
    assert (known <= (unchanged.map.first_seen & unchanged.map.second_seen)).all()
    assert np.median(np.abs(unchanged.map.change[known])) < 0.004


def test_an_object_where_the_first_dive_did_not_look_is_not_new() -> None:
    elsewhere = survey(BEFORE[1:], drawn(5), along=(31.2, 34.0))
    change = compare_surveys(elsewhere, survey(BEFORE, drawn(105)), address)
    row = next(row for row in change.objects if row.second_id == 1)
    assert row.status == "not seen before"
    assert change.changed() == ()


def test_object_where_second_dive_did_not_look_is_not_gone() -> None:
    change = compare_surveys(
        survey(BEFORE, drawn(6)), survey(BEFORE[1:], drawn(106), along=(31.2, 34.0)), address
    )
    row = next(row for row in change.objects if row.first_id == 1)
    assert row.status == "not seen again"
    assert np.isnan(row.change)
    assert change.changed() == ()


def poorly_known(found: HullSurvey, sigma_m: float) -> HullSurvey:
    return replace(found, form_sigma=np.full(len(found.form_sigma), sigma_m))


def test_listed_object_is_tested_by_number_of_objects() -> None:
    first = poorly_known(survey(BEFORE, drawn(10)), 0.0105)
    change = compare_surveys(
        first, survey((*BEFORE, replace(ADDED[0], height_m=-0.045)), drawn(110)), address
    )
    (row,) = change.changed()
    assert (row.status, row.second_id) == ("new", 5)
    assert 1e-5 < row.p_value < 0.01


def test_object_neither_shown_nor_excluded_is_uncertain() -> None:
    first = poorly_known(survey(BEFORE, drawn(11)), 0.0115)
    change = compare_surveys(
        first, survey((*BEFORE, replace(ADDED[0], height_m=-0.025)), drawn(111)), address
    )
    assert change.changed() == ()
    assert next(row for row in change.objects if row.second_id == 5).status == "uncertain"


def test_structure_in_both_surfaces_is_no_change() -> None:
    change = compare_surveys(
        survey(BEFORE, drawn(7)), survey(BEFORE, drawn(107), listed=BEFORE[:3]), address
    )
    assert change.changed() == ()
    assert next(row for row in change.objects if row.first_id == 4).status == "unchanged"


def test_a_new_structure_is_found_though_detection_missed_it() -> None:
    change = compare_surveys(
        survey(BEFORE, drawn(8)), survey((*BEFORE, ADDED[1]), drawn(108), listed=BEFORE), address
    )
    (row,) = change.changed()
    assert (row.status, row.first_id, row.second_id) == ("new", None, None)
    assert row.change == pytest.approx(0.09, abs=0.01)
    assert len(row.outline) >= 4


def test_bare_hull_that_moved_is_no_object() -> None:
    bulged = survey(BEFORE, drawn(109), bulge=(32.4, 5.2, 0.35, -0.03))
    change = compare_surveys(survey(BEFORE, drawn(9)), bulged, address)
    assert change.changed() == ()
    assert change.moves
    assert change.moves[0].move < -0.01
    assert change.moves[0].along_girth[0] == pytest.approx(32.4 + drawn(9).pose[0], abs=0.3)


def test_changing_places_of_the_dives_turns_new_into_gone(changed: HullChange) -> None:
    after = (*BEFORE[:3], ADDED[2])
    change = compare_surveys(survey(after, drawn(102)), survey(BEFORE[:3], drawn(2)), address)
    assert [row.status for row in change.changed()] == ["gone"]


def test_dives_of_different_parts_of_the_ship_cannot_be_compared() -> None:
    far = survey((), drawn(10), along=(36.5, 37.5))
    with pytest.raises(StageError, match="too little of the same hull"):
        compare_surveys(survey(BEFORE, drawn(11)), far, address)


def test_a_dive_that_saw_nothing_is_refused() -> None:
    blind = survey(BEFORE)
    blind = replace(
        blind, as_found=replace(blind.as_found, support=np.zeros_like(blind.as_found.support))
    )
    with pytest.raises(StageError, match="saw nothing"):
        compare_surveys(survey(BEFORE), blind, address)


def test_the_same_dives_give_the_same_numbers() -> None:
    rows = [
        compare_surveys(survey(BEFORE[:2], drawn(4)), survey(BEFORE[:1], drawn(104)), address)
        for _ in range(2)
    ]
    assert [r.change for r in rows[0].objects] == [r.change for r in rows[1].objects]
    assert (rows[0].offset.covariance == rows[1].offset.covariance).all()


def test_the_same_hull_meshed_otherwise_is_the_same_hull() -> None:
    """Quads split along the other diagonal, and one of them into four about its middle."""
    turned = np.array([[0, 1, 2], [1, 3, 2], [4, 6, 5], [6, 7, 5]], np.int32)
    fan = np.array([[0, 1, 8], [1, 3, 8], [3, 2, 8], [2, 0, 8], *FACES[2:]], np.int32)
    for other in (Mesh(BOX, turned), Mesh(np.vstack([BOX, BOX[:4].mean(axis=0)]), fan)):
        assert cad_model_gap(Mesh(BOX, FACES), other) == pytest.approx(0.0, abs=1e-6)


def test_the_gap_of_two_cad_models_is_the_same_from_both_sides() -> None:
    """A part that one of them lacks counts, although all of the other lies on it."""
    whole, half = Mesh(BOX, FACES), Mesh(BOX[:4], FACES[:2])
    assert cad_model_gap(whole, half) == pytest.approx(10.0)
    assert cad_model_gap(half, whole) == pytest.approx(10.0)


@pytest.mark.parametrize("shift_m", [0.001, 0.004])
def test_the_gap_of_a_model_that_was_shifted_is_its_shift(shift_m: float) -> None:
    moved = Mesh(BOX + np.array([shift_m, 0, 0]), FACES)
    assert cad_model_gap(Mesh(BOX, FACES), moved) == pytest.approx(shift_m, rel=1e-3)
