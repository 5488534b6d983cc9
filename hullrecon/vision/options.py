# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What [matches] of dive.toml may say."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta

from hullrecon.dive.config.schema import Positive, Section

Share = Annotated[float, Meta(ge=0, le=1)]
Count = Annotated[int, Meta(ge=1)]
TwoViewModel = Literal["automatic", "essential", "homography"]


class MatchOptions(Section, frozen=True):
    """Section [matches] of dive.toml."""

    # which nodes are compared
    sequential: Annotated[
        int, Meta(ge=1, le=50, description="following nodes that each node is compared with")
    ] = 3
    across: Annotated[
        int,
        Meta(
            ge=0,
            le=50,
            description="nodes of other legs that each is compared with until the path is tied",
        ),
    ] = 3
    revisits: Annotated[
        int,
        Meta(
            ge=0,
            le=200,
            description="nodes of other legs that each is compared with on the tied path, if they overlap by 30 %",
        ),
    ] = 20
    min_overlap: Annotated[
        Share,
        Meta(description="share, of the predicted footprints that two nodes must have in common"),
    ] = 0.15
    max_overlap: Annotated[
        Share,
        Meta(description="share, a node that overlaps the last keyframe by more is not a keyframe"),
    ] = 0.98
    min_saliency: Annotated[
        Share, Meta(description="share, images below it are not compared across legs")
    ] = 0.5

    # tolerances
    column_px: Annotated[
        Positive, Meta(description="px, of a stereo match across its epipolar line")
    ] = 1.5
    verify_px: Annotated[
        Positive, Meta(description="px, of a match from its epipolar line once the motion is known")
    ] = 1.0
    ransac_px: Annotated[
        Positive, Meta(description="px, of a triangulated point projected into the other images")
    ] = 3.0
    sigma_px: Annotated[
        Positive,
        Meta(description="px, sigma of a feature's position, in search ellipses and depths"),
    ] = 0.4
    gate_chi2: Annotated[
        Positive,
        Meta(description="chi2, size of the search ellipse; 9.21 holds 99 % of a plane Gaussian"),
    ] = 9.21

    # descriptors: ratio to the next best, and largest distance between unit vectors
    ratio: Annotated[
        Share, Meta(description="ratio, of the best to the next best descriptor distance")
    ] = 0.8
    guided_ratio: Annotated[
        Share, Meta(description="ratio, the same where the position leaves few candidates")
    ] = 0.8
    max_distance: Annotated[
        Positive, Meta(description="ratio, largest distance of two unit descriptors")
    ] = 0.75
    harris_share: Annotated[
        float,
        Meta(
            ge=0,
            le=0.5,
            description="share, of the matches of two images that may be Harris corners with Zernike moments; 0 is SIFT alone",
        ),
    ] = 0.0

    two_view_model: Annotated[
        TwoViewModel,
        Meta(
            description="what explains two images of one camera: the likelier of both, essential matrix, or homography alone"
        ),
    ] = "automatic"

    seeds: Annotated[
        Count,
        Meta(
            description="features that look for the motion near navigation's; the guided search takes all"
        ),
    ] = 500

    # acceptance
    min_putative: Annotated[
        Count, Meta(description="matches before verification that a pair must have")
    ] = 8
    min_inliers: Annotated[
        Count, Meta(description="matches after verification that a pair must have")
    ] = 12
    ransac_trials: Annotated[
        int, Meta(ge=10, le=100_000, description="RANSAC trials of a pair")
    ] = 400
    navigation_chi2: Annotated[
        Positive,
        Meta(
            description="chi2, of six numbers; a motion farther from navigation's is rejected, at 5/6 of it without a length"
        ),
    ] = 50.0

    # depth of the scene when nothing has measured it, m
    nearest_m: Annotated[
        Positive, Meta(description="m, smallest depth of the scene when nothing has measured it")
    ] = 0.3
    farthest_m: Annotated[
        Positive, Meta(description="m, largest depth of the scene when nothing has measured it")
    ] = 15.0
    range_margin: Annotated[
        Positive, Meta(description="ratio, depths lie within this factor of the DVL's ranges")
    ] = 1.8

    single_node: Annotated[
        bool, Meta(description="keep landmarks that only the two cameras of one node saw")
    ] = True

    seed: Annotated[int, Meta(ge=0, description="seed of the random numbers")] = 1


class LinkOptions(Section, frozen=True):
    """Section [links] of dive.toml; how pairs are matched is in [matches]."""

    max_rounds: Annotated[
        int, Meta(ge=0, le=50, description="rounds of comparisons across legs at most")
    ] = 12
    kernel: Annotated[
        Literal["scaling", "switch", "none"],
        Meta(
            description="what guards the path against wrong links: dynamic covariance scaling, switches, nothing"
        ),
    ] = "scaling"
    planes: Annotated[
        bool,
        Meta(
            description="tie passes by the patches of hull that the DVL saw again, where that says more than images do"
        ),
    ] = True
    appearance: Annotated[
        bool,
        Meta(
            description="recognise places by how they look where the path is known too badly to say which images overlap"
        ),
    ] = True
