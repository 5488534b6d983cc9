# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The variants of the method: solved when out of date, else read back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, cast

import msgspec

from hullrecon.api.dive_run import DiveRun
from hullrecon.artifacts.chain import Chain
from hullrecon.artifacts.runner import RunContext, run_chain
from hullrecon.artifacts.workspace import Workspace
from hullrecon.errors import InputError
from hullrecon.studies.dive_steps import build_step, with_stages, workspace_beside

if TYPE_CHECKING:
    from hullrecon.adjustment.options import AdjustOptions
    from hullrecon.records.deliverables import ReportedObject
    from hullrecon.studies.methods.comparison import DeadReckoning, SolvedVariant

WHOLE_SOLVE_ITERATIONS = 200  # 26 to 51 in [Ozog2016 Fig. 4.13]


@dataclass(frozen=True, kw_only=True)
class MethodVariant:
    """A method of the adjustment with a weighting."""

    method: str
    weighting: str
    as_published: bool  # without our weights, deviation field and rounds

    def chain(self, whole: Chain) -> Chain:
        """Put this variant in place of the step adjust.

        As published is one solve from the registration on, as [Ozog2016] did it, so that its
        history is that of one function.
        """
        from hullrecon.studies.methods.adjust_variant import STAGE, VariantOptions

        if self.is_product:
            return whole
        given = msgspec.structs.asdict(cast("AdjustOptions", whole.sections["adjust"]))
        own = msgspec.convert(
            {**given, "method": self.method, "as_published": self.as_published}, VariantOptions
        )
        if self.as_published:
            own = msgspec.structs.replace(
                own, rounds=1, max_iterations=max(own.max_iterations, WHOLE_SOLVE_ITERATIONS)
            )
        return replace(with_stages(whole, STAGE), sections={**whole.sections, "adjust": own})

    @property
    def is_product(self) -> bool:
        """Whether the step `adjust` itself solves it."""
        return self.method == "maxmix" and not self.as_published

    def workspace(self, dive: DiveRun) -> Workspace:
        """Choose where the variant is solved.

        RUNS/<dive> for the variant that the chain itself solves, else
        RUNS/<dive>/compare/<variant>.
        """
        if self.is_product:
            return dive.workspace
        return workspace_beside(dive, f"{self.method} {self.weighting}")


def variants() -> list[MethodVariant]:
    """List every solve that is compared."""
    from hullrecon.studies.methods.method_figures import METHODS, WEIGHTINGS

    return [
        MethodVariant(method=method, weighting=weighting, as_published=as_published)
        for weighting, as_published in WEIGHTINGS.items()
        for method in METHODS
    ]


def run_before_adjust(dive: DiveRun, run_context: RunContext) -> None:
    """Bring the steps before adjust up to date."""
    whole = dive.chain.up_to("adjust")
    before = replace(whole, stages=tuple(s for s in whole.stages if s.name != "adjust"))
    run_chain(before, dive.workspace, run_context)


def solve_all(dive: DiveRun, run_context: RunContext) -> None:
    """Bring the steps before adjust up to date, then every variant of adjust."""
    run_before_adjust(dive, run_context)
    whole = dive.chain.up_to("adjust")
    with dive.workspace.lock():
        for variant in variants():
            build_step(
                "adjust", variant.chain(whole), dive.workspace, variant.workspace(dive), run_context
            )
        run_context.hashes.save()


def run_to_detect(dive: DiveRun, run_context: RunContext) -> None:
    """Bring the chain up to date as far as `detect`, whose heights are delivered."""
    if any(s.name == "detect" for s in dive.chain.stages):
        run_chain(dive.chain.up_to("detect"), dive.workspace, run_context)


def read_solutions(dive: DiveRun) -> list[SolvedVariant]:
    """Read what solve_all left. Raises InputError when a variant is missing."""
    return [_read_solution(variant, variant.workspace(dive)) for variant in variants()]


def _read_solution(variant: MethodVariant, workspace: Workspace) -> SolvedVariant:
    """Read a solved variant from its workspace. Raises InputError if it was not solved."""
    import numpy as np

    from hullrecon.geometry.poses import pose_from_vector
    from hullrecon.steps.artifacts import AdjustArtifact
    from hullrecon.studies.methods.comparison import SolvedVariant

    manifest = workspace.manifest("adjust")
    if manifest is None:
        name = f"{variant.method} {variant.weighting}"
        raise InputError(
            f"{name} was not solved",
            where=str(workspace.root),
            remedy="run `hullrecon study methods`",
        )
    artifact = AdjustArtifact(workspace.artifact("adjust"))
    registration = artifact.summary.get("registration")
    seven = registration.get("T_g_M") if isinstance(registration, dict) else None
    return SolvedVariant(
        method=variant.method,
        weighting=variant.weighting,
        solution=artifact.solution,
        iterations=artifact.iterations,
        seconds=float(manifest.run["seconds"]),
        iterations_s=np.asarray(manifest.run.get("times", {}).get("iterations_s", []), float),
        registered=None if seven is None else pose_from_vector(np.asarray(seven, float)),
        chart=artifact.chart,
    )


def read_dead_reckoning(dive: DiveRun) -> DeadReckoning:
    """Read the dead-reckoned dive and the rig as configured or logged.

    Raises InputError where navigate left nothing.
    """
    from hullrecon.artifacts.stage import StageSettings
    from hullrecon.dive.config.schema import RIG_KEYS
    from hullrecon.rig import rig_from_settings
    from hullrecon.steps.artifacts import InputArtifacts
    from hullrecon.studies.methods.comparison import DeadReckoning

    artifacts = InputArtifacts(
        {name: dive.workspace.artifact(name) for name in ("ingest", "navigate")}
    )
    artifact = artifacts.navigate
    given = StageSettings("navigate", {key: _setting(dive.chain.sections, key) for key in RIG_KEYS})
    rig = rig_from_settings(artifacts.mounted(given), {})
    return DeadReckoning(trajectory=artifact.trajectory, returns=artifact.returns, rig=rig)


def read_objects(dive: DiveRun) -> tuple[ReportedObject, ...]:
    """Read the objects that the chain's own detect reports, none where it left nothing."""
    from hullrecon.records.deliverables import ReportedObject
    from hullrecon.steps.artifacts import DetectArtifact

    rows = DetectArtifact(dive.workspace.artifact("detect")).objects.get("objects", ())
    return msgspec.convert(rows, tuple[ReportedObject, ...])


def _setting(sections: Mapping[str, object], key: str) -> object:
    """Look up a value by dotted key. None where its section is absent."""
    section, _, name = key.rpartition(".")
    value = sections.get(section)
    return None if value is None else getattr(value, name, None)
