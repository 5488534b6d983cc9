# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Options of the adjustment (the section [adjust] of dive.toml), and its strategy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta, Struct

from hullrecon import native

MOST_PARTS = 64
Positive = Annotated[float, Meta(gt=0)]


class AdjustOptions(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How the dive is adjusted."""

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
    threads: Annotated[
        int, Meta(ge=1, le=64, description="threads of the solve; any number gives the same bytes")
    ] = 2
    parts: Annotated[
        Annotated[int, Meta(ge=1, le=MOST_PARTS)] | Literal["auto"],
        Meta(
            description="stripes across the hull in which a round is solved, which takes "
            "less memory; auto: one until the solver takes 300 MB, then more. The result is the "
            "same but for rounding"
        ),
    ] = "auto"


@dataclass(frozen=True, kw_only=True)
class Strategy:
    """What the solves treat as unknown. The defaults are the product's."""

    # Surface factors: "maxmix" by hidden label, "geva" for every landmark, "naive" for none
    method: str = "maxmix"
    solve: Callable[[native.Problem, native.Options], native.Result] = native.solve
    # Errors of navigation and of the DVL's mount are unknowns, with priors that may be widened
    systematic_errors: bool = True
    # The CAD model may be wrong: a field of deviations from it is solved, and the hull's pose is
    # estimated with the CAD model's error as correlated noise
    deviation_field: bool = True
    estimate_sigmas: bool = True  # from the residuals of each round
    max_off_hull_m: float = np.inf  # landmarks farther off the hull are left out
    hull: bool = True  # the hull enters: its CAD model, and patches of it that two passes saw

    def native_options(self, options: AdjustOptions) -> native.Options:
        """Build the solver's options. Those not named here have their defaults."""
        return native.Options(method=self.method, threads=options.threads)


PRODUCT = Strategy()
