# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read the parts that many messages share: vectors, and values that are lost."""

from __future__ import annotations

import numpy as np

from hullrecon.dive.logs.messages.decode import Fields
from hullrecon.typing import Array

LOST = np.full(3, np.nan)


def vector(v: Fields) -> Array:
    """Return x, y, z of a geometry_msgs/Vector3 or Point."""
    return np.array([v.x, v.y, v.z], float)
