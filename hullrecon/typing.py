# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Array types by what they hold, named once for the whole project."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Floats32 = NDArray[np.float32]
Ints = NDArray[np.int64]
Ints32 = NDArray[np.int32]
Ints16 = NDArray[np.int16]
Mask = NDArray[np.bool_]
Pixels = NDArray[np.uint8]  # (h, w) or (h, w, channels), RGB
Arrays = dict[str, NDArray[np.generic]]  # the members of an .npz by name
CholeskyFactor = tuple[Array, bool]  # of scipy.linalg.cho_factor
