# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The studies of filters and submaps."""

from __future__ import annotations

from hullrecon.studies.study import SceneStudy, StudyFunction

SUBMAP_STUDIES: tuple[SceneStudy, ...] = (
    SceneStudy(
        id="filters",
        source="[Aulinas2011 Algorithms 1, 2, eqs (3.7) to (3.11)]",
        shows="Kalman filter, information filter and smoother against the batch",
        run=StudyFunction("submaps.filter_study.study_filters"),
    ),
    SceneStudy(
        id="submap-consistency",
        source="[Aulinas2011 Fig. 2.2, eq (3.21)]",
        shows="one filter and submaps, laps around a square: normalised error against its bound",
        run=StudyFunction("submaps.consistency_study.study_consistency"),
    ),
    SceneStudy(
        id="submap-world",
        source="[Aulinas2011 3.4.1, Figs 3.4 to 3.6, Tables 3.2, 3.3]",
        shows="441 landmarks by one filter and by submaps joined in all ways: time and error",
        run=StudyFunction("submaps.world_figures.study_world"),
    ),
    SceneStudy(
        id="submap-threshold",
        source="[Aulinas2011 3.3.4, Fig. 3.2]",
        shows="how much two submaps must share to be fused: cost and error",
        run=StudyFunction("submaps.threshold_study.study_threshold"),
    ),
    SceneStudy(
        id="submap-park",
        source="[Aulinas2011 3.4.2, Figs 3.7, 3.9, 3.10, eq (3.22)]",
        shows="a park's trees mapped by a car: track, innovations, cost over the mission",
        run=StudyFunction("submaps.park_study.study_park"),
    ),
)
