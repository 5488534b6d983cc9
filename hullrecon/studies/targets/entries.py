# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The studies of targets."""

from __future__ import annotations

from hullrecon.studies.study import SceneStudy, StudyFunction

TARGET_STUDIES: tuple[SceneStudy, ...] = (
    SceneStudy(
        id="side-scan-thresholds",
        source="[Aulinas2011 4.3.1, Fig. 4.9]",
        shows="targets in side-scan sonar by two thresholds: bright spot with a shadow behind it",
        run=StudyFunction("targets.side_scan_study.detect_by_two_thresholds"),
    ),
    SceneStudy(
        id="side-scan-cascade",
        source="[Aulinas2011 4.3.2 to 4.3.4, Figs 4.13 to 4.15, Tables 4.1, 4.2]",
        shows="targets in side-scan sonar by boosted rectangle features in a cascade",
        run=StudyFunction("targets.side_scan_study.detect_by_cascade"),
    ),
    SceneStudy(
        id="sonar-targets",
        source="[Aulinas2011 4.2.2, 4.3]",
        shows="targets that several side-scan passes show: paired, placed, with covariance",
        run=StudyFunction("targets.sonar_targets_study.study"),
    ),
    SceneStudy(
        id="regions-of-interest",
        source="[Aulinas2011 4.4, Figs 4.20 to 4.22]",
        shows="rocks in images by edges and hue together, their features over a quarter turn",
        run=StudyFunction("targets.region_study.find_rocks"),
    ),
)
