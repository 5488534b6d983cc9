# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Draw values at the vertices of a mesh into a picture, in C++."""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array, Floats32, Ints, Ints32


def draw_triangles(
    points: Array, faces: Ints | Ints32, values: Array, shape: tuple[int, int]
) -> Floats32:
    """Draw faces (m, 3) into a picture, with values interpolated linearly between their corners.

    Where faces overlap, the last is drawn. A pixel is drawn if its middle lies on a face.

    Parameters
    ----------
    points
        Corners (n, 2) in pixels, columns and rows from the picture's outer corner.
    values
        At the corners (n, channels).
    shape
        Height and width of the picture.

    Returns
    -------
    Floats32
        The picture (h, w, channels), NaN where nothing was drawn.
    """
    from hullrecon.native.compiled import native

    picture = np.full((*shape, values.shape[1]), np.nan, np.float32)
    native.draw_triangles(picture, points, faces, values)
    return picture
