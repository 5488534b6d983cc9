# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Features of two images pair by pair: near ones, distances of descriptors, best ones."""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array, Floats32, Ints


def pairs_in_regions(
    center: Array, half_width: Array, form: Array | None, points: Array
) -> tuple[Ints, Ints]:
    """Find the pairs (row of center, row of points) of points within a region of a center.

    In order of both. What is not finite pairs with nothing. Raises InputError for shapes that do
    not fit.

    Parameters
    ----------
    center, half_width
        (n, 2) of the regions.
    form
        (n, 3) where given: `xx dx^2 + 2 xy dx dy + yy dy^2 <= 1` within the region.
    points
        (m, 2).
    """
    import hullrecon._native as _native  # compiled; loads the solver's libraries

    forms = np.zeros((len(center), 3)) if form is None else form
    first, second = _native.pairs_in_regions(
        np.hstack([center, half_width, forms]), np.asarray(points, float)
    )
    return first, second


def descriptor_distances(a: Floats32, b: Floats32, first: Ints, second: Ints) -> Floats32:
    """Compute the Euclidean distances (m,) of rows `first` of a (n, w) and `second` of b (k, w).

    Raises InputError for rows that are not there.
    """
    import hullrecon._native as _native

    distance: Floats32 = _native.descriptor_distances(a, b, first, second)
    return distance


def best_and_next(key: Ints, distance: Floats32) -> tuple[Ints, Floats32]:
    """Find the row of the least distance of each key, and each key's second least distance.

    Rows are in order of the keys, the first of equals; the second least is inf where there is none.
    key (m,): not negative; distance (m,).
    """
    import hullrecon._native as _native

    best, following = _native.best_and_next(key, distance)
    return best[best >= 0], following
