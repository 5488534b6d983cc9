# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What steps after the adjustment take from it about cameras: the refined intrinsics (adjust.refine_intrinsics) and the
adjusted mounts, where there are any."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hullrecon.geometry.poses import Poses, from_mount, of_seven

NAME = "cameras.json"


def cameras_file(inputs: Mapping[str, Path]) -> Path:
    """inputs: folders by step. The calibration as ingested where nothing was refined; it may not exist."""
    refined = inputs["adjust"] / NAME if "adjust" in inputs else None
    return refined if refined is not None and refined.exists() else inputs["ingest"] / NAME


def mount_of(adjusted: NDArray[np.float64] | None, nominal: ArrayLike) -> Poses:
    """A mount as adjusted (x y z qx qy qz qw) where that is known, else dive.toml's six numbers."""
    return of_seven(adjusted) if adjusted is not None and np.isfinite(adjusted).all() else from_mount(nominal)
