# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The studies of many sessions before one hull, and of what the source leaves to the future."""

from __future__ import annotations

from hullrecon.studies.study import SceneStudy, StudyFunction

SESSION_STUDIES: tuple[SceneStudy, ...] = (
    SceneStudy(
        id="sessions",
        source="[Ozog2016 1.3.2, 2.4.2, Figs 1.11, 1.12, 2.4, 2.9]",
        shows="three sessions in one graph, by anchors and without, and in a common frame",
        run=StudyFunction("sessions.alignment_study.study"),
    ),
    SceneStudy(
        id="node-removal",
        source="[Ozog2016 2.4.1, Algorithm 2, Figs 2.12, 2.16, 2.19 to 2.21]",
        shows="eight sessions whose nodes are removed by linear constraints, beside the full graph",
        run=StudyFunction("sessions.removal_study.study"),
    ),
    SceneStudy(
        id="reacquisition",
        source="[Ozog2016 2.4.3, 2.5.4, Algorithm 1, Fig. 2.10, Table 2.2]",
        shows="a vehicle found again in an old map by planes, and how many images that leaves",
        run=StudyFunction("sessions.particles_study.study"),
    ),
    SceneStudy(
        id="periscope",
        source="[Ozog2016 2.4.3.3, Fig. 2.11, eq. D.12]",
        shows="where points of one image above water lie in another, taken for a plane",
        run=StudyFunction("sessions.periscope.study"),
    ),
    SceneStudy(
        id="lone-beams",
        source="[Ozog2016 2.3.4.3, Fig. 2.7]",
        shows="a leg at the surface held by two beams to the planes of the leg below",
        run=StudyFunction("sessions.lone_beams.study"),
    ),
    SceneStudy(
        id="incremental",
        source="[Ozog2016 1.3.2, 2.3.2]",
        shows="a session solved pose by pose by updates of a square root, beside the batch",
        run=StudyFunction("sessions.incremental.study"),
    ),
    SceneStudy(
        id="next-leg",
        source="[Ozog2016 5.2]",
        shows="legs that could be driven next, ranked by what they do to the path's sigma",
        run=StudyFunction("sessions.next_leg.study"),
    ),
    SceneStudy(
        id="sonar-structure",
        source="[Ozog2016 5.2]",
        shows="features by range and bearing with the servo as an unknown, held to the hull or not",
        run=StudyFunction("sonar.structure.study"),
    ),
)
