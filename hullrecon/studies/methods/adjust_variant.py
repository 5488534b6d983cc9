# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The step `adjust` with the sources' methods, weighting and labels."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

from msgspec import Meta

from hullrecon import native
from hullrecon.adjustment.options import AdjustOptions, Strategy
from hullrecon.artifacts.stage import Context
from hullrecon.steps import adjust
from hullrecon.steps.chain import stage
from hullrecon.studies.methods import hard_em

# Off the hull beyond this a landmark is a mismatch. Pulled to the hull, one near the camera passes
# through the camera's plane, and the solve stalls there.
NO_STRUCTURE_M = 0.5


class VariantOptions(AdjustOptions, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Options of `adjust`, and which variant of the method is solved."""

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


def strategy_of(options: VariantOptions) -> Strategy:
    """Build the strategy of a variant.

    As published [Ozog2016], there are no systematic errors of navigation, no deviation field with
    its shared weights, and sigmas are those of dive.toml.
    """
    outer = options.labels == "outer" and options.method == "maxmix"
    ours = not options.as_published
    return Strategy(
        method=options.method,
        solve=hard_em.solve if outer else native.solve,
        systematic_errors=ours,
        deviation_field=ours,
        estimate_sigmas=ours,
        max_off_hull_m=NO_STRUCTURE_M if options.method == "geva" else float("inf"),
    )


def run(context: Context[VariantOptions]) -> None:
    """Adjust the dive by a variant."""
    adjust.run_adjustment(context, strategy_of(context.parameters))


STAGE = replace(stage("adjust"), parameters=VariantOptions, run=run)
