# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Impossible inputs to feature pairs are refused; tests/vision and C++ test what they find."""

import numpy as np
import pytest

from hullrecon import native
from hullrecon.errors import InputError

NONE = np.zeros(0, np.int64)


def test_rows_that_are_not_there_are_refused():
    a, b = np.zeros((3, 128), np.float32), np.zeros((2, 128), np.float32)
    assert native.descriptor_distances(a, b, np.array([2]), np.array([1])).tolist() == [0.0]
    with pytest.raises(InputError, match="first"):
        native.descriptor_distances(a, b, np.array([3]), np.array([1]))
    with pytest.raises(InputError, match="second"):
        native.descriptor_distances(a, b, np.array([0]), np.array([-1]))
    with pytest.raises(InputError, match="width"):
        native.descriptor_distances(a, b[:, :64], np.array([0]), np.array([0]))
    with pytest.raises(InputError, match="number"):
        native.descriptor_distances(a, b, np.array([0, 1]), np.array([0]))


def test_keys_that_are_negative_or_too_many_are_refused():
    with pytest.raises(InputError, match="key"):
        native.best_and_next(np.array([0, -1]), np.zeros(2, np.float32))
    with pytest.raises(InputError, match="number"):
        native.best_and_next(np.array([0]), np.zeros(2, np.float32))


def test_nothing_has_no_best():
    best, following = native.best_and_next(NONE, np.zeros(0, np.float32))
    assert (len(best), len(following)) == (0, 0)
    assert (
        len(
            native.descriptor_distances(
                np.zeros((0, 8), np.float32), np.zeros((0, 8), np.float32), NONE, NONE
            )
        )
        == 0
    )


def test_points_must_be_in_the_plane():
    center = np.zeros((1, 2))
    with pytest.raises(InputError, match="points"):
        native.pairs_in_regions(center, np.ones((1, 2)), None, np.zeros((4, 3)))
    first, second = native.pairs_in_regions(
        center, np.ones((1, 2)), None, np.array([[2.0, 0.0], [1.0, 1.0]])
    )
    assert (first.tolist(), second.tolist()) == ([0], [1])
