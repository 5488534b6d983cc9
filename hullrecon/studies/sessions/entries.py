# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The studies of many sessions before one hull."""

from __future__ import annotations

from hullrecon.studies.study import SceneStudy, study_of

SESSION_STUDIES: tuple[SceneStudy, ...] = (
    SceneStudy(
        id="sessions",
        source="[Ozog2016 1.3.2, 2.4.2, Figs 1.11, 1.12, 2.1, 2.8, 2.9]",
        shows="three sessions in one graph, by anchors and without, and in a common frame",
        run=study_of("sessions.alignment_study"),
    ),
    SceneStudy(
        id="node-removal",
        source="[Ozog2016 2.4.1, Algorithm 2, Figs 2.12, 2.16, 2.19 to 2.21]",
        shows="eight sessions whose nodes are removed by linear constraints, beside the full graph",
        run=study_of("sessions.removal_study"),
    ),
)
