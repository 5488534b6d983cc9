# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What steps after the adjustment take from it about cameras: the refined intrinsics (adjust.refine_intrinsics) and the
adjusted mounts, where there are any."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from numpy.typing import ArrayLike

from hullrecon.geometry.poses import Poses, from_mount

NAME = "cameras.json"


def cameras_file(inputs: Mapping[str, Path]) -> Path:
    """inputs: folders by step. The calibration as ingested where nothing was refined; it may not exist."""
    refined = inputs["adjust"] / NAME if "adjust" in inputs else None
    return refined if refined is not None and refined.exists() else inputs["ingest"] / NAME


def mount_of(adjusted: Poses | None, nominal: ArrayLike) -> Poses:
    """Return a mount as adjusted where it was, else dive.toml's six numbers."""
    return from_mount(nominal) if adjusted is None else adjusted
