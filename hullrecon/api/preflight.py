# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What can be known to end a run before its first step is begun."""

from __future__ import annotations

from collections.abc import Sequence

from hullrecon.api.dive_run import DiveRun
from hullrecon.artifacts.chain import StepStatus

ASKS_FOR_BOW = frozenset({"hull", "hull.bow"})  # among what a step uses


def refuse_wrong_bow(dive: DiveRun, plan: Sequence[StepStatus]) -> None:
    """Raise InputError for a `hull.bow` that the CAD model does not have, where a step that is to
    do asks for it.

    Such steps come when images have been compared for hours, and what is before them does not
    depend on it.
    """
    from hullrecon.dive.check.bow import describe_bow
    from hullrecon.dive.config.schema import Hull
    from hullrecon.dive.hull.load import read_hull

    hull = dive.chain.sections.get("hull")
    if (
        isinstance(hull, Hull)
        and hull.bow
        and any(step.to_do and ASKS_FOR_BOW & set(step.stage.uses) for step in plan)
    ):
        describe_bow(hull, read_hull(dive.chain.package / hull.mesh, hull.units, []))
