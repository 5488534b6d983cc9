# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Features of two images pair by pair: which lie near each other, how far their descriptors are
apart, which are the best.
"""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array, Floats32, Ints


def pairs_in_regions(
    center: Array, half_width: Array, form: Array | None, points: Array
) -> tuple[Ints, Ints]:
    """Return the pairs (row of center, row of points), in order of both, of the points (m, 2)
    within half_width (n, 2) of a center (n, 2), and where `form` (n, 3) is given with `xx dx^2 + 2
    xy dx dy + yy dy^2 <= 1`; none with what is not finite.

    Raises InputError for shapes that do not fit.
    """
    import hullrecon._native as _native  # compiled; loads the solver's libraries

    forms = np.zeros((len(center), 3)) if form is None else form
    first, second = _native.pairs_in_regions(
        np.hstack([center, half_width, forms]), np.asarray(points, float)
    )
    return first, second


def descriptor_distances(a: Floats32, b: Floats32, first: Ints, second: Ints) -> Floats32:
    """Return the Euclidean distances (m,) of the rows first of a (n, w) and second of b (k, w).

    Raises InputError for rows that are not there.
    """
    import hullrecon._native as _native

    distance: Floats32 = _native.descriptor_distances(a, b, first, second)
    return distance


def best_and_next(key: Ints, distance: Floats32) -> tuple[Ints, Floats32]:
    """Return the row of the least distance of each key, the first of equals, in order of the keys,
    and by key the second least (inf where there is none). key (m,): not negative; distance (m,).
    """
    import hullrecon._native as _native

    best, following = _native.best_and_next(key, distance)
    return best[best >= 0], following
