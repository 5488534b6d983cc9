# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which features may be the same point, by position alone: inside a box, or inside each feature's
own ellipse (PCCS).
"""

from __future__ import annotations

import numpy as np

from hullrecon import native
from hullrecon.typing import Array, Ints


def in_box(wanted: Array, half_width: Array, points: Array) -> tuple[Ints, Ints]:
    """Return pairs (row of wanted, row of points) with both |differences| within half_width (2,),
    in order of both rows; rows with NaN pair with none.
    """
    return native.pairs_in_regions(wanted, np.broadcast_to(half_width, wanted.shape), None, points)


def in_ellipse(wanted: Array, covariance: Array, points: Array, chi2: float) -> tuple[Ints, Ints]:
    """Return pairs whose squared Mahalanobis distance under covariance (n, 2, 2) of each wanted (n,
    2) is at most chi2.
    """
    xx, xy, yy = covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]
    form = np.stack([yy, -xy, xx], axis=1) / (chi2 * (xx * yy - xy * xy))[:, None]
    return native.pairs_in_regions(
        wanted, np.sqrt(chi2 * covariance[:, [0, 1], [0, 1]]), form, points
    )
