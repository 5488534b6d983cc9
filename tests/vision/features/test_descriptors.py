# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.vision.features.descriptors import (
    best_of_all,
    best_of_pairs,
    sparse_distance,
    to_unit,
)


@pytest.fixture
def vectors():
    """20 random unit vectors and a shuffled, slightly disturbed copy."""
    rng = np.random.default_rng(1)
    a = rng.random((20, 128), dtype=np.float32)
    order = rng.permutation(20)
    a /= np.linalg.norm(a, axis=1, keepdims=True)
    return a, a[order] + np.float32(0.001), order


def test_bytes_become_vectors_of_unit_length():
    np.testing.assert_array_equal(
        to_unit(np.array([[255, 0, 128]], np.uint8)), np.array([[255, 0, 128]], np.float32) / 512
    )


def test_sparse_distances_equal_plain_ones(vectors):
    a, b, _ = vectors
    rng = np.random.default_rng(2)
    first, second = rng.integers(20, size=1000), rng.integers(20, size=1000)
    np.testing.assert_allclose(
        sparse_distance(a, b, first, second),
        np.linalg.norm(a[first] - b[second], axis=1),
        rtol=1e-5,
    )


def test_full_search_finds_copy_of_each(vectors):
    a, b, order = vectors
    found = best_of_all(a, b, 0.8, 0.75)
    np.testing.assert_array_equal(found.first, np.arange(20))
    np.testing.assert_array_equal(order[found.second], found.first)


def test_full_search_equals_search_among_all_candidates(vectors):
    a, b, _ = vectors
    first, second = (m.ravel() for m in np.mgrid[0:20, 0:20])
    sparse = best_of_pairs(first, second, sparse_distance(a, b, first, second), 0.9, 1.0)
    dense = best_of_all(a, b, 0.9, 1.0)
    np.testing.assert_array_equal(sparse.first, dense.first)
    np.testing.assert_array_equal(sparse.second, dense.second)
    np.testing.assert_allclose(sparse.distance, dense.distance, atol=2e-3)


def test_match_must_be_best_of_both_sides():
    found = best_of_pairs(
        np.array([0, 1]), np.array([5, 5]), np.array([0.3, 0.1], np.float32), 0.8, 1.0
    )
    assert (found.first.tolist(), found.second.tolist()) == ([1], [5])


def test_two_like_candidates_are_ambiguous():
    first, second = np.array([0, 0]), np.array([3, 4])
    assert len(best_of_pairs(first, second, np.array([0.30, 0.32], np.float32), 0.8, 1.0)) == 0
    assert len(best_of_pairs(first, second, np.array([0.30, 0.40], np.float32), 0.8, 1.0)) == 1


def test_lone_candidate_must_be_close():
    one = np.array([0])
    assert len(best_of_pairs(one, one, np.array([0.7], np.float32), 0.8, 0.6)) == 0
    assert len(best_of_pairs(one, one, np.array([0.5], np.float32), 0.8, 0.6)) == 1


def test_nothing_is_found_in_nothing():
    none = np.zeros(0, np.int64)
    assert len(best_of_pairs(none, none, np.zeros(0, np.float32), 0.8, 1.0)) == 0
    assert (
        len(best_of_all(np.zeros((0, 128), np.float32), np.zeros((5, 128), np.float32), 0.8, 1.0))
        == 0
    )
