# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Places of features: SIFT describes a place once for each orientation that it may have [Lowe2004
5]. Each description may find the other image's, but what they find is one measurement, not two.
"""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Floats32, Ints
from hullrecon.vision.features.descriptors import Putative, mutual_best


def first_at_place(keypoints: Floats32) -> Ints:
    """Return for each feature (n,) the first row with the same pixel; keypoints (n, 4), those of
    one place side by side.
    """
    new = np.ones(len(keypoints), bool)
    new[1:] = (np.diff(keypoints[:, :2], axis=0) != 0).any(axis=1)
    return np.asarray(np.flatnonzero(new)[np.cumsum(new) - 1])


def match_places(found: Putative, place_a: Ints, place_b: Ints) -> Putative:
    """Return matches between places: of those of a place, the most alike.

    found: rows of either side; place_a (n,), place_b (m,): by feature, the row that stands for its
    place.
    """
    first, second = place_a[found.first], place_b[found.second]
    kept = mutual_best(first, second, found.distance)
    return Putative(first=first[kept], second=second[kept], distance=found.distance[kept])
