# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Options of the adjustment: the section [adjust] of dive.toml."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta, Struct

Positive = Annotated[float, Meta(gt=0)]


class AdjustOptions(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How the dive is adjusted. `as_published` keeps the published weighting, for comparison: no
    deviation field, every surface factor at full weight, no systematic errors of navigation, sigmas
    as in dive.toml.
    """

    method: Annotated[
        Literal["naive", "geva", "maxmix"],
        Meta(description="surface factors: none, all, or by hidden label"),
    ] = "maxmix"
    as_published: Annotated[
        bool, Meta(description="the published weighting, without a deviation field")
    ] = False
    labels: Annotated[
        Literal["inside", "outer"],
        Meta(description="decided within the solve, or held and updated between solves"),
    ] = "inside"
    on_hull_sigma_m: Annotated[
        Positive, Meta(description="m, sigma of the distance to the hull of a landmark on it")
    ] = 0.02
    off_hull_sigma_m: Annotated[
        Positive, Meta(description="m, sigma of the distance to the hull of a landmark off it")
    ] = 1.0
    refine_intrinsics: Annotated[
        bool, Meta(description="the cameras' intrinsics are unknowns with priors")
    ] = False
    focal_sigma: Annotated[
        Positive, Meta(description="share, sigma of the focal length's calibration")
    ] = 0.005
    center_sigma_px: Annotated[
        Positive, Meta(description="px, sigma of the principal point's calibration")
    ] = 5.0
    distortion_sigma: Annotated[
        Positive, Meta(description="ratio, sigma of k1, k2, k3; p1 and p2 have a tenth of it")
    ] = 0.01
    rounds: Annotated[
        int, Meta(ge=1, le=10, description="solves between which outliers and sigmas are updated")
    ] = 3
    max_iterations: Annotated[
        int, Meta(ge=1, le=1000, description="iterations of one solve at most")
    ] = 60
    function_tolerance: Annotated[
        Positive, Meta(description="ratio, relative change of cost that ends a solve")
    ] = 1e-6
    anchors: Annotated[
        int,
        Meta(
            ge=1000,
            description="landmarks of the rounds before the last: about so many, of each image one at least",
        ),
    ] = 20000
    min_sigma_px: Annotated[
        Positive, Meta(description="px, lower bound of the estimated pixel sigmas")
    ] = 0.03
    outlier_sigmas: Annotated[
        Positive, Meta(description="sigmas, observations with larger residuals are left out")
    ] = 5.0
    threads: Annotated[
        int, Meta(ge=1, le=64, description="threads of the solve; any number gives the same bytes")
    ] = 2
