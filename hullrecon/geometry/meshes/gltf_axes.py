# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The axes of glTF, which has y up, from those of a mesh's own frame."""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array


def gltf_from(up: Array) -> Array:
    """Build the rotation (4, 4) into glTF from a frame in which `up` (3,) is up.

    `up` is a unit vector along an axis of the frame, in either direction. The rotation depends on
    up alone, not on the bow. So an importer that turns glTF back to z up gets a model with z up if
    its file has z up.
    """
    right = np.eye(3)[min(k for k in range(3) if up[k] == 0)]
    turn = np.eye(4)
    turn[:3, :3] = np.stack([right, up, np.cross(right, up)]) + 0.0  # without the sign of a zero
    return turn
