# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Pairs of features of two images, in C++: in regions, by descriptor distances, the best ones."""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array, Floats32, Ints


def pairs_in_regions(
    center: Array, half_width: Array, form: Array | None, points: Array
) -> tuple[Ints, Ints]:
    """Find the points in regions: pairs (row of center, row of points), sorted by both.

    A region is a rectangle, or the part of it in an ellipse. Centers and points that are not finite
    have no pairs. Raises InputError for shapes that do not fit.

    Parameters
    ----------
    center, half_width
        (n, 2) px, middles of the rectangles and half their sides.
    form
        (n, 3) xx, xy, yy of the ellipses xx dx^2 + 2 xy dx dy + yy dy^2 <= 1. None: rectangles.
    points
        (k, 2) px.
    """
    from hullrecon.native.compiled import native  # loads the solver's libraries

    forms = np.zeros((len(center), 3)) if form is None else form
    first, second = native.pairs_in_regions(
        np.hstack([center, half_width, forms]), np.asarray(points, float)
    )
    return first, second


def descriptor_distances(a: Floats32, b: Floats32, first: Ints, second: Ints) -> Floats32:
    """Compute the Euclidean distances (m,) of descriptors: rows `first` of a and `second` of b.

    Descriptors a are (n, w), b (k, w). Rows are (m,) each. Raises InputError for rows out of range.
    """
    from hullrecon.native.compiled import native

    distance: Floats32 = native.descriptor_distances(a, b, first, second)
    return distance


def best_and_next(key: Ints, distance: Floats32) -> tuple[Ints, Floats32]:
    """Find for each key the row with the least distance, and the second least distance.

    Rows are in the order of the keys. Of equal distances the first row is taken. The second least
    distance is inf where a key has one row only.

    key (m,): not negative. distance (m,): of the same rows.
    """
    from hullrecon.native.compiled import native

    best, following = native.best_and_next(key, distance)
    return best[best >= 0], following
