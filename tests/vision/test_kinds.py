# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.vision.features.descriptors import Putative, best_of_all
from hullrecon.vision.features.kinds import best_of_each_kind, like_pairs, limit_corners

NONE = np.zeros(4, bool)
LAST_TWO = np.array([False, False, True, True])


def matches(sift, corners, seed=1):
    """That many of each kind, corners last, with random distances; and which are corners."""
    rows = np.arange(sift + corners)
    distance = np.random.default_rng(seed).uniform(0.1, 0.6, len(rows)).astype(np.float32)
    return Putative(first=rows, second=rows[::-1].copy(), distance=distance), rows >= sift


def test_only_features_of_one_kind_are_compared():
    first, second = (grid.ravel() for grid in np.mgrid[0:4, 0:4])
    a, b = like_pairs(first, second, LAST_TWO, LAST_TWO)
    assert {(int(i), int(j)) for i, j in zip(a, b, strict=True)} == {
        (i, j) for i in range(4) for j in range(4) if (i < 2) == (j < 2)
    }


def test_a_corner_meets_nothing_where_the_other_side_has_none():
    first, second = (grid.ravel() for grid in np.mgrid[0:4, 0:4])
    a, _ = like_pairs(first, second, LAST_TWO, NONE)
    assert set(a.tolist()) == {0, 1}


def test_pairs_without_corners_are_handed_back_as_they_are():
    first, second = np.arange(4), np.arange(4)
    a, b = like_pairs(first, second, NONE, NONE)
    assert a is first
    assert b is second


def test_a_full_search_finds_the_copy_of_the_same_kind():
    rng = np.random.default_rng(3)
    sift, corner = (rng.random((6, 128), dtype=np.float32) for _ in range(2))
    a = np.concatenate([sift, corner]) / 7
    b = np.concatenate([corner[::-1], sift[::-1]]) / 7  # the nearest of each is of the other kind
    kind = np.arange(12) >= 6
    found = best_of_each_kind(a, b, kind, kind, 1.0, 2.0)
    assert (kind[found.first] == kind[found.second]).all()
    same = best_of_each_kind(a, np.concatenate([b[6:], b[:6]]), kind, kind, 0.8, 0.75)
    np.testing.assert_array_equal(same.first, np.arange(12))
    np.testing.assert_array_equal(same.second, np.r_[5:-1:-1, 11:5:-1])


def test_a_full_search_without_corners_is_the_plain_one():
    a, b = (np.random.default_rng(k).random((9, 128), dtype=np.float32) / 7 for k in (1, 2))
    found, plain = (
        best_of_each_kind(a, b, np.zeros(9, bool), np.zeros(9, bool), 0.99, 2.0),
        best_of_all(a, b, 0.99, 2.0),
    )
    for name in ("first", "second", "distance"):
        np.testing.assert_array_equal(getattr(found, name), getattr(plain, name))


@pytest.mark.parametrize("share", [0.1, 0.2, 0.3, 0.5])
def test_corners_are_the_share_asked_for(share):
    found, corner = matches(200, 300)
    kept = limit_corners(found, corner, share)
    got = corner[kept.first].mean()
    assert got <= share
    assert got == pytest.approx(share, abs=0.01)


def test_a_larger_share_adds_the_next_alike_and_drops_none():
    found, corner = matches(100, 80)
    before = set()
    for share in np.linspace(0, 0.5, 11):
        kept = limit_corners(found, corner, float(share))
        rows = kept.first[corner[kept.first]]
        assert before <= set(rows.tolist())
        left = np.setdiff1d(np.flatnonzero(corner), rows)
        if len(rows) and len(left):
            assert found.distance[rows].max() <= found.distance[left].min()
        before = set(rows.tolist())
    assert len(before) == 80


def test_sift_matches_are_all_kept_in_their_order():
    found, corner = matches(50, 40)
    kept = limit_corners(found, corner, 0.2)
    np.testing.assert_array_equal(kept.first, np.sort(kept.first))
    np.testing.assert_array_equal(kept.first[:50], np.arange(50))
    np.testing.assert_array_equal(kept.second, found.second[kept.first])
    np.testing.assert_array_equal(kept.distance, found.distance[kept.first])


def test_without_sift_matches_no_corner_is_kept():
    found, corner = matches(0, 40)
    assert len(limit_corners(found, corner, 0.5)) == 0


def test_a_share_of_nothing_is_sift_alone():
    found, corner = matches(30, 40)
    assert len(limit_corners(found, corner, 0.0)) == 30
