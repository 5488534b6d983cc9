# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What [matches] of dive.toml may say."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from hullrecon.dive.config import Positive, Section

Share = Annotated[float, Meta(ge=0, le=1)]
Count = Annotated[int, Meta(ge=1)]


class MatchOptions(Section, frozen=True):
    """Section [matches] of dive.toml."""

    # which nodes are compared
    sequential: Annotated[int, Meta(ge=1, le=50)] = 3  # each node with that many following ones
    across: Annotated[int, Meta(ge=0, le=50)] = 3  # and with that many of other legs, those of most overlap first
    min_overlap: Share = 0.15  # of the predicted footprints
    max_overlap: Share = 0.98  # a node that overlaps the last keyframe by more is not a keyframe
    min_saliency: Share = 0.5  # images below it stay in the chain but are not compared across legs

    # tolerances
    column_px: Positive = 1.5  # of a stereo match across its epipolar line
    verify_px: Positive = 1.0  # of a match against its epipolar line once the motion is known
    ransac_px: Positive = 3.0  # of a triangulated point transferred into the other images
    sigma_px: Positive = 0.4  # of a feature's place, in ellipses and depths
    gate_chi2: Positive = 9.21  # 99 % of a plane Gaussian: the ellipse in which descriptors are compared

    # descriptors: ratio to the next best, and largest distance between unit vectors
    ratio: Share = 0.8
    guided_ratio: Share = 0.8  # where the place alone leaves few to choose from
    max_distance: Positive = 0.75

    seeds: Count = 500  # features that look for the motion where navigation predicts it; the guided search takes all

    # acceptance
    min_putative: Count = 8
    min_inliers: Count = 12
    ransac_trials: Annotated[int, Meta(ge=10, le=100_000)] = 400
    navigation_chi2: Positive = 50.0  # of six numbers: a motion farther from navigation's is not believed

    # depth of the scene when nothing has measured it, m
    nearest_m: Positive = 0.3
    farthest_m: Positive = 15.0
    range_margin: Positive = 1.8  # with DVL: depth lies within this factor of the ranges' spread

    single_node: bool = True  # landmarks that the two cameras of one node alone saw

    seed: Annotated[int, Meta(ge=0)] = 1
