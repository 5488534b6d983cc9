# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The dive that another is compared with, and the thresholds of a change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from msgspec import Meta

from hullrecon.dive.config.schema import FileName, Section


@dataclass(frozen=True, kw_only=True)
class ChangeOptions:
    """Thresholds of what counts as a change."""

    max_p_value: float = 0.01  # probability that an unchanged hull shows a change anywhere
    cell_m: float = 0.02  # side of a cell of the lattice
    min_change_m: float = 0.015  # least change of a structure's height
    min_area_m2: float = 0.0025  # least area that changed
    min_views: int = 2  # images that must have seen a cell for it to be compared
    max_sigma_m: float = 0.015  # largest sigma of the surface in a cell that is compared
    edge_m: float = 0.03  # by which an edge may be shifted between two surveys without a change
    smooth_m: float = 1.0  # width from which a difference is the hull's form, not a structure
    patch_m: float = 0.4  # side of a patch of hull on which form is compared
    min_move_m: float = 0.005  # least move of bare hull


class EarlierDive(Section, frozen=True):
    """The dive that this one is compared with."""

    earlier: Annotated[
        FileName | None,
        Meta(
            description="folder of an earlier dive's run (RUNS/<dive>), relative to dive.toml; "
            "the report says what changed"
        ),
    ] = None
