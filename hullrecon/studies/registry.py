# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The registry of studies: what of the sources is reproduced, by the id that commands take."""

from __future__ import annotations

from hullrecon.errors import UsageError
from hullrecon.studies.association.entries import ASSOCIATION_STUDIES
from hullrecon.studies.aulinas_studies import AULINAS_STUDIES
from hullrecon.studies.engine_studies import ENGINE_STUDIES
from hullrecon.studies.hull_studies import HULL_STUDIES
from hullrecon.studies.ozog_studies import OZOG_STUDIES
from hullrecon.studies.sessions.entries import SESSION_STUDIES
from hullrecon.studies.study import DiveStudy, SceneStudy
from hullrecon.studies.submaps.entries import SUBMAP_STUDIES
from hullrecon.studies.targets.entries import TARGET_STUDIES
from hullrecon.studies.vehicles.entries import VEHICLE_STUDIES

# each folder of studies lists its own
STUDIES: tuple[DiveStudy | SceneStudy, ...] = (
    *HULL_STUDIES,
    *OZOG_STUDIES,
    *SESSION_STUDIES,
    *AULINAS_STUDIES,
    *SUBMAP_STUDIES,
    *ASSOCIATION_STUDIES,
    *TARGET_STUDIES,
    *VEHICLE_STUDIES,
    *ENGINE_STUDIES,
)
FIGURES = ("method-figures", "path-figures", "scene-figures")  # those that draw


def find_study(name: str) -> DiveStudy | SceneStudy:
    """Look a study up. Raises UsageError for an unknown id."""
    found = {study.id: study for study in STUDIES}.get(name)
    if found is None:
        raise UsageError(f"no study is called {name!r}", remedy="see `hullrecon study list`")
    return found
