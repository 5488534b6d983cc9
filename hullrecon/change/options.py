# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What tells a change from two surveys' errors."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class ChangeOptions:
    """max_p_value: largest probability that an unchanged hull shows a change anywhere. cell_m: of
    the lattice. min_change_m: of a structure's height; min_area_m2: of what changed. min_views:
    images that must have seen a place for it to count as looked at; max_sigma_m: of the surface
    there. edge_m: how far an edge may be drawn from one survey to the next. smooth_m: wider than
    this is the hull's form, narrower a structure. patch_m: of the hull on which form is compared;
    min_move_m.
    """

    max_p_value: float = 0.01
    cell_m: float = 0.02
    min_change_m: float = 0.015
    min_area_m2: float = 0.0025
    min_views: int = 2
    max_sigma_m: float = 0.015
    edge_m: float = 0.03
    smooth_m: float = 1.0
    patch_m: float = 0.4
    min_move_m: float = 0.005
