# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The studies of [Aulinas2011] that are not of one of its experiments."""

from __future__ import annotations

from hullrecon.studies.study import SceneStudy, StudyFunction

AULINAS_STUDIES: tuple[SceneStudy, ...] = (
    SceneStudy(
        id="joining-schemes",
        source="[Aulinas2011 Figs 2.3 to 2.5]",
        shows="submaps joined in a tree, in a graph over a mission, and with shared variables",
        run=StudyFunction("schemes.schemes_study.study"),
    ),
    SceneStudy(
        id="board-calibration",
        source="[Aulinas2011 4.5, Fig. 4.23]",
        shows="a small camera calibrated by sharp and by noisy images of a board",
        run=StudyFunction("calibration.board.study"),
    ),
)
