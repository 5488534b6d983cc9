# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The data figures of [Ozog2016] that are not of its methods, links or scenes."""

from __future__ import annotations

from hullrecon.studies.study import DiveStudy, SceneStudy, StudyFunction

OZOG_STUDIES: tuple[DiveStudy | SceneStudy, ...] = (
    SceneStudy(
        id="toy-graph",
        source="[Ozog2016 Fig. 1.10]",
        shows="three poses on a line with a loop closure, by the normal equations",
        run=StudyFunction("estimates.toy_graph.study"),
    ),
    SceneStudy(
        id="label-boundary",
        source="[Ozog2016 Fig. 4.4]",
        shows="the distance from which a feature is off the hull",
        run=StudyFunction("estimates.label_boundary.study"),
    ),
    SceneStudy(
        id="joint-predictions",
        source="[Ozog2016 E.3]",
        shows="the sigma of a patch's mean offset by the joint covariance of its vertices",
        run=StudyFunction("estimates.joint_predictions.study"),
    ),
    DiveStudy(
        id="maps",
        source="[Ozog2016 Figs 1.14, 3.2, 3.3]",
        shows="one hull as landmarks, planes, surface and dense points; how its surface is meshed",
        run=StudyFunction("surfaces.maps.study"),
    ),
    DiveStudy(
        id="surfaces-by-source",
        source="[Ozog2016 Figs 3.8, 3.9, 3.10]",
        shows="the DVL's surface by source of poses and by interpolation, against the CAD model",
        run=StudyFunction("surfaces.by_source.study"),
    ),
    DiveStudy(
        id="sonar-variance",
        source="[Ozog2016 Figs 3.11, 3.12]",
        shows="the sonar mosaic's variance by source of poses, of a hull painted in blocks",
        run=StudyFunction("surfaces.sonar_scene.study"),
    ),
    DiveStudy(
        id="mosaics",
        source="[Ozog2016 Figs 3.7, 4.19]",
        shows="mosaics on the CAD model beside those on the hull as surveyed, shaded by height",
        run=StudyFunction("surfaces.mosaics.study"),
    ),
    DiveStudy(
        id="shapes",
        source="[Ozog2016 Figs 4.8, 4.9; Algorithms 4, 5]",
        shows="one image's shapes and one vertex moved to them, step by step",
        run=StudyFunction("structures.steps.study"),
    ),
    DiveStudy(
        id="dense-stereo",
        source="[Ozog2016 Figs 4.15, D.2, D.3]",
        shows="a rectified pair, its range image, and heights by dense stereo beside landmarks'",
        run=StudyFunction("structures.dense_stereo.study"),
    ),
    DiveStudy(
        id="thresholds",
        source="[Ozog2016 Figs 4.17, 4.18]",
        shows="structures found, missed and false by the threshold on features' heights",
        run=StudyFunction("structures.thresholds.study"),
    ),
    SceneStudy(
        id="uncertain-calibration",
        source="[Ozog2016 D.1.2, D.1.3, Algorithm 6]",
        shows="sigma of a two-view motion, calibration unsure: first order, sigma points, draws",
        run=StudyFunction("calibration.wall.study"),
    ),
)
