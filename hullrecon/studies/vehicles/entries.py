# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The studies of vehicles."""

from __future__ import annotations

from hullrecon.studies.study import SceneStudy, StudyFunction

VEHICLE_STUDIES: tuple[SceneStudy, ...] = (
    SceneStudy(
        id="remus-run",
        source="[Aulinas2011 5.2, Figs 5.5 to 5.7]",
        shows="a mission with side-scan targets as landmarks of submaps, held against LBL",
        run=StudyFunction("vehicles.remus_study.run_remus"),
    ),
    SceneStudy(
        id="sparus-run",
        source="[Aulinas2011 5.3, Figs 5.13, 5.16 to 5.18]",
        shows="a mission with one camera, its landmarks by inverse depth, in submaps",
        run=StudyFunction("vehicles.sparus_study.run_sparus"),
    ),
    SceneStudy(
        id="inverse-depth",
        source="[Aulinas2011 5.3.2, eqs (5.19) to (5.24); Civera2008]",
        shows="how a landmark finds its depth from little parallax",
        run=StudyFunction("vehicles.convergence_study.study_convergence"),
    ),
)
