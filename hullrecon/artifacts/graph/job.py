# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One stage with all that it works on, and the recipe that decides its result."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from hullrecon.artifacts.graph.recipe import make_recipe
from hullrecon.artifacts.graph.settings import settings_for
from hullrecon.artifacts.graph.stage import Stage
from hullrecon.artifacts.graph.stage_settings import StageSettings
from hullrecon.artifacts.storage.hashing import HashCache
from hullrecon.artifacts.storage.manifest import Recipe


@dataclass(frozen=True, kw_only=True)
class Job:
    """One stage with all that it works on. source: the package's folder. recipe: what decides the
    result.
    """

    stage: Stage
    settings: StageSettings
    inputs: Mapping[str, Path]
    source: Path | None
    recipe: Recipe


def make_job(
    stage: Stage, sections: Mapping[str, object], inputs: Mapping[str, Path], source: Path | None, hashes: HashCache,
    failures: Mapping[str, str] = MappingProxyType({}),
) -> Job:  # fmt: skip
    """Return the job; failures: why steps of this run left no artifact, of which those that it
    could use count.

    Raises InputError when a file of the package is missing, UsageError for an option that is not
    finite.
    """
    settings = settings_for(stage, sections)
    own = {name: failures[name] for name in stage.optional if name in failures}
    return Job(
        stage=stage,
        settings=settings,
        inputs=inputs,
        source=source,
        recipe=make_recipe(stage, settings, inputs, source, hashes, own),
    )
