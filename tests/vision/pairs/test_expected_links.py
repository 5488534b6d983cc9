# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Links foreseen from ten comparisons of neighbours: images of 200 features, of which node 8 and 9
see next to nothing.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from hullrecon.records.links import CameraLinks
from hullrecon.vision.pairs.expected_links import Compared, ExpectedLinks, learn_links

NODES, OVERLAP, LEAST = 12, 0.5, 12
COVARIANCE = np.diag([1e-6, 4e-6, 9e-6, 1e-8, 1e-8, 4e-8])
FIRST = np.arange(10)
COMMON = np.where(FIRST < 8, 100, 0)  # those of 8 and 9 fail
TWO, ONE = np.array([0]), np.array([5])


def links(rows: np.ndarray, scaled: bool = True) -> CameraLinks:
    return CameraLinks(
        first=FIRST[rows],
        second=FIRST[rows] + 1,
        translation=np.tile([0.2, 0.0, 0.0], (len(rows), 1)),
        quaternion=np.tile([0.0, 0.0, 0.0, 1.0], (len(rows), 1)),
        covariance=np.tile(COVARIANCE, (len(rows), 1, 1)),
        scaled=np.full(len(rows), scaled),
        bottom=np.zeros((len(rows), 2), bool),
    )


def learnt(common: np.ndarray = COMMON, scaled: bool = True) -> ExpectedLinks:
    rows = np.flatnonzero(common)
    compared = Compared(first=FIRST, second=FIRST + 1, overlap=np.full(10, OVERLAP), common=common)
    return learn_links(NODES, compared, links(rows, scaled), common[rows], LEAST)


def information(found: ExpectedLinks, common: float) -> np.ndarray:
    translation = np.array([[0.0, 0.3, 0.0]])
    return found.link_information(TWO, ONE, np.array([common]), translation)[0]


def test_common_features_follow_from_overlap_and_features_found_again() -> None:
    found = learnt()
    assert_allclose(found.common(TWO, ONE, np.array([0.25])), [50])
    # node 9 was compared twice, in vain
    assert_allclose(found.common(TWO, np.array([9]), np.array([0.25])), [0])


def test_a_node_not_compared_is_expected_to_be_like_the_dive() -> None:
    assert learnt().found_again[11] == pytest.approx(COMMON.sum() / (10 * OVERLAP))


def test_a_link_is_expected_to_tell_what_such_links_told() -> None:
    assert_allclose(information(learnt(), 100), np.linalg.inv(COVARIANCE))
    # half as many features, spread half as wide
    assert_allclose(information(learnt(), 50), np.linalg.inv(COVARIANCE) / 4)


def test_the_least_link_tells_something() -> None:
    assert_allclose(information(learnt(), 0), np.linalg.inv(COVARIANCE) * (LEAST / 100) ** 2)


def test_a_link_without_length_tells_nothing_along_its_motion() -> None:
    found = information(learnt(scaled=False), 100)
    assert_allclose(found[1], 0, atol=1e-9)
    assert_allclose(found[2, 2], 1 / 9e-6 - 1 / 0.2**2)
    assert_allclose(found[3:, 3:], np.linalg.inv(COVARIANCE)[3:, 3:])


def test_poor_images_match_less_probably_but_may() -> None:
    rich, poor = learnt().probability(np.array([100.0, 0.0]))
    assert rich > 0.95
    assert 0.01 < poor < 0.2


def test_where_all_match_or_none_does_the_probability_stays_one() -> None:
    for common in (np.full(10, 100), np.zeros(10, np.int64)):
        assert 0 < learnt(common).probability(np.array([30.0]))[0] < 1
