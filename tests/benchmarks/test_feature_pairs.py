# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from benchmarks.feature_pairs import compiled, plain, scene


def test_both_ways_find_the_same():
    data = scene(300)
    (rows, distance), (plain_rows, plain_distance) = compiled(data), plain(data)
    assert len(rows) > 200
    np.testing.assert_array_equal(rows, plain_rows)
    np.testing.assert_allclose(distance, plain_distance, rtol=1e-5)
