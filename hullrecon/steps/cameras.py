# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which cameras.json a step after the adjustment reads: the refined one where there is one (adjust.refine_intrinsics)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

NAME = "cameras.json"


def cameras_file(inputs: Mapping[str, Path]) -> Path:
    """inputs: folders by step. The calibration as ingested where nothing was refined; it may not exist."""
    refined = inputs["adjust"] / NAME if "adjust" in inputs else None
    return refined if refined is not None and refined.exists() else inputs["ingest"] / NAME
