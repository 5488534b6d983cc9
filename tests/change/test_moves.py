# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from change.simulated_surveys import NONE, chart, survey
from change.test_objects import LATTICE, OPTIONS, SAME

from hullrecon.change.difference import difference
from hullrecon.change.moves import surface_moves
from hullrecon.change.relief import relief_on


def moves_of(second, offset=SAME):
    reliefs = (relief_on(LATTICE, chart(), survey((), NONE)), relief_on(LATTICE, chart(), second))
    return surface_moves(difference(*reliefs, OPTIONS), [], chart(), LATTICE, offset, OPTIONS)


def test_hull_that_did_not_move_is_not_listed() -> None:
    assert moves_of(survey((), NONE)) == ()


@pytest.fixture(scope="module")
def dented():
    return moves_of(survey((), NONE, bulge=(31.5, 5.0, 0.5, -0.03)))


def test_a_dent_is_one_stretch_with_its_place_and_sign(dented) -> None:
    (move,) = dented
    assert -0.03 < move.move < -0.012
    assert move.along_girth == pytest.approx([31.5, 5.0], abs=0.2)


def test_a_stretch_has_an_area_an_outline_and_a_probability(dented) -> None:
    (move,) = dented
    assert 0.3 < move.area < 3
    assert len(move.outline) >= 4
    assert move.p_value < 0.01
    assert move.move_sigma == pytest.approx(np.hypot(0.0025, 0.0025), rel=0.5)


def test_a_dent_and_a_bulge_are_two() -> None:
    both = survey((), NONE, bulge=(30.8, 5.0, 0.35, 0.03))
    dent = survey((), NONE, bulge=(33.0, 5.0, 0.35, -0.03))
    vertices = both.as_found.vertices + dent.as_found.vertices - survey((), NONE).as_found.vertices
    moves = moves_of(replace(both, as_found=replace(both.as_found, vertices=vertices)))
    assert sorted(np.sign([move.move for move in moves])) == [-1, 1]


def test_where_the_offset_is_poorly_known_a_dent_is_not_certain() -> None:
    loose = replace(SAME, covariance=np.diag([0.02**2] * 3 + [1e-8] * 3))
    assert moves_of(survey((), NONE, bulge=(31.5, 5.0, 0.5, -0.03)), loose) == ()
