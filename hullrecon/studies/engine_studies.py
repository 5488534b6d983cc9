# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The figures of [KimEustice2009] that are not of paths over the hull."""

from __future__ import annotations

from hullrecon.studies.study import DiveStudy, SceneStudy, StudyFunction

ENGINE_STUDIES: tuple[DiveStudy | SceneStudy, ...] = (
    DiveStudy(
        id="pair-stages",
        source="[KimEustice2009 Fig. 1]",
        shows="two images of two legs registered stage by stage, counts beside the truth",
        run=StudyFunction("engine.pair_stages.study"),
    ),
    SceneStudy(
        id="relief-views",
        source="[KimEustice2009 Fig. 2(a)]",
        shows="a surface with relief in two views, and the relief at which the choice turns",
        run=StudyFunction("engine.relief_views.study"),
    ),
    DiveStudy(
        id="pair-overlap",
        source="[KimEustice2009 Fig. 2(b)]",
        shows="matches that either two-view model accepts outside what two images share",
        run=StudyFunction("engine.pair_overlap.study"),
    ),
    SceneStudy(
        id="planar-adjustment",
        source="[KimEustice2009 III-C]",
        shows="two views adjusted by a homography and by epipolar lines, on hulls that bend",
        run=StudyFunction("engine.planar_adjustment.study"),
    ),
    SceneStudy(
        id="one-camera-survey",
        source="[KimEustice2009 IV, Figs 4, 5(b)]",
        shows="a survey with a blank and a bare stern, tied by either two-view model and by choice",
        run=StudyFunction("engine.survey.study"),
    ),
    DiveStudy(
        id="fly-through",
        source="[KimEustice2009 IV, Fig. 6]",
        shows="a flight over the textured hull as found, the objects on it ringed",
        run=StudyFunction("engine.fly_through.study"),
    ),
)
