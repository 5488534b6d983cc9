# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Options of the DVL surface: the section [surface] of dive.toml."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

Positive = Annotated[float, Meta(gt=0)]


class SurfaceOptions(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Hold how the surface is made of the DVL's returns."""

    # One sigma, as published, took a fifth of a simulated dive's returns for outliers, those along
    # the rim where returns are sparse: 429 of 2,280, where 16 of all are off by more than 5 cm and
    # 13 of these are flagged before. Three took 21.
    outlier_sigmas: Annotated[
        Positive,
        Meta(
            description="sigmas, mean distance to the neighbours beyond which a return is an "
            "outlier"
        ),
    ] = 3.0
    landmarks: Annotated[bool, Meta(description="landmarks on the hull are observations too")] = (
        False
    )
    fit: Annotated[
        bool,
        Meta(
            description="estimate lengths and sigma by marginal likelihood, starting from those "
            "given"
        ),
    ] = True
    length_along_m: Annotated[
        Positive, Meta(description="m, distance along the hull at which the kernel ends")
    ] = 15.0
    length_girth_m: Annotated[
        Positive, Meta(description="m, distance around the girth at which the kernel ends")
    ] = 3.0
    offset_sigma_m: Annotated[
        Positive, Meta(description="m, one sigma of the offsets from the base surface")
    ] = 0.03
    cell_m: Annotated[
        Positive, Meta(description="m, cell whose returns are averaged before the regression")
    ] = 0.15
    max_edge_m: Annotated[Positive, Meta(description="m, longest edge after subdivision")] = 0.1
    reach_m: Annotated[
        Positive, Meta(description="m, the surface extends this far from a return")
    ] = 0.4
