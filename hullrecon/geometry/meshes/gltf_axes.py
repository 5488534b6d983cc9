# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The axes of glTF, which has y up, whichever axis of a mesh's own frame is."""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array


def gltf_from(up: Array) -> Array:
    """Return the rotation (4, 4) into glTF of a frame in which `up` (3,) is up.

    up: a unit vector, an axis of the frame or against one. The rotation depends on up alone, not on
    the bow: an importer that turns glTF back to z up finds a model with z up where its file has it.
    """
    right = np.eye(3)[min(k for k in range(3) if up[k] == 0)]
    turn = np.eye(4)
    turn[:3, :3] = np.stack([right, up, np.cross(right, up)]) + 0.0  # without the sign of a zero
    return turn
