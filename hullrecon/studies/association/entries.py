# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The studies of association, and of the trees that were associated."""

from __future__ import annotations

from hullrecon.studies.study import SceneStudy, StudyResult


def _association() -> StudyResult:
    from hullrecon.studies.association.association_study import compare_methods

    return compare_methods()


def _trunks() -> StudyResult:
    from hullrecon.studies.association.trunk_study import study_trunks

    return study_trunks()


ASSOCIATION_STUDIES: tuple[SceneStudy, ...] = (
    SceneStudy(
        id="association",
        source="[Aulinas2011 4.2.2, Fig. 4.6]",
        shows="which points of two surveys are the same: nearest neighbour, JCBB, RJC",
        run=_association,
    ),
    SceneStudy(
        id="tree-trunks",
        source="[Aulinas2011 4.2.1, Figs 4.4, 4.5, 4.7]",
        shows="the middles of tree trunks in a laser's half circle",
        run=_trunks,
    ),
)
