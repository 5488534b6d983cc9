# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The studies of association, and of the trees that were associated."""

from __future__ import annotations

from hullrecon.studies.study import SceneStudy, StudyFunction

ASSOCIATION_STUDIES: tuple[SceneStudy, ...] = (
    SceneStudy(
        id="association",
        source="[Aulinas2011 4.2.2, Fig. 4.6]",
        shows="which points of two surveys are the same: nearest neighbour, JCBB, RJC",
        run=StudyFunction("association.association_study.compare_methods"),
    ),
    SceneStudy(
        id="tree-trunks",
        source="[Aulinas2011 4.2.1, Figs 4.4, 4.5, 4.7]",
        shows="the middles of tree trunks in a laser's half circle",
        run=StudyFunction("association.trunk_study.study_trunks"),
    ),
)
