# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How good the guess of the hull's pose is where dive.toml does not say."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hullrecon.geometry.poses import from_mount, up_in
from hullrecon.typing import Array

LEVEL_M, VERTICAL_M = 1.0, 0.3  # the draught is known better than the berth
# heel and trim are small and read off; the heading is a compass's beside steel
TILT_DEG, HEADING_DEG = 1.0, 5.0


def guess_sigma(pose: Sequence[float], given: Sequence[float] | None) -> Array:
    """Return sigma (6,) of `hull.pose`, m and deg, by M's axes: as given, else by the axis of the
    file that it turns up.
    """
    if given is not None:
        return np.array(given, float)
    vertical = int(np.argmax(np.abs(up_in(from_mount(pose)))))
    sigma: Array = np.r_[np.full(3, LEVEL_M), np.full(3, TILT_DEG)]
    sigma[[vertical, 3 + vertical]] = VERTICAL_M, HEADING_DEG
    return sigma
