# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sections [features], [matches] and [links] of dive.toml."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from hullrecon.dive.config.schema import Positive, Section

Share = Annotated[float, Meta(ge=0, le=1)]
Count = Annotated[int, Meta(ge=1)]


class FeatureOptions(Section, frozen=True):
    """Section [features] of dive.toml."""

    level_window: Annotated[
        float,
        Meta(
            ge=0.0,
            le=0.1,
            description="ratio, sigma of the window that levels contrast to the image's width; "
            "0 leaves the image as it is",
        ),
    ] = 0.025
    max_features: Annotated[
        int, Meta(ge=50, le=100_000, description="features of an image; the strongest are kept")
    ] = 4000
    reduction: Annotated[
        float,
        Meta(
            ge=1.0, le=8.0, description="ratio, images are shrunk by this before SIFT doubles them"
        ),
    ] = 2.0


class MatchOptions(Section, frozen=True):
    """Section [matches] of dive.toml."""

    # which nodes are compared
    sequential: Annotated[
        int, Meta(ge=1, le=50, description="following nodes that each node is compared with")
    ] = 3
    min_overlap: Annotated[
        Share,
        Meta(description="share, of the predicted footprints that two nodes must have in common"),
    ] = 0.15
    min_saliency: Annotated[
        Share, Meta(description="share, images below it are not compared across legs")
    ] = 0.5

    # which features match
    column_px: Annotated[
        Positive, Meta(description="px, of a stereo match across its epipolar line")
    ] = 1.5
    sigma_px: Annotated[
        Positive,
        Meta(description="px, sigma of a feature's position, in search ellipses and depths"),
    ] = 0.4
    min_inliers: Annotated[
        Count, Meta(description="matches after verification that a pair must have")
    ] = 12
    single_node: Annotated[
        bool, Meta(description="keep landmarks that only the two cameras of one node saw")
    ] = True

    seed: Annotated[int, Meta(ge=0, description="seed of the random numbers")] = 1


class LinkOptions(Section, frozen=True):
    """Section [links] of dive.toml. How pairs are matched is in [matches]."""

    max_rounds: Annotated[
        int, Meta(ge=0, le=50, description="rounds of comparisons across legs at most")
    ] = 12
    planes: Annotated[
        bool,
        Meta(
            description="tie passes by patches of hull that the DVL saw again, "
            "where that says more than images do"
        ),
    ] = True
    appearance: Annotated[
        bool,
        Meta(
            description="recognise places by how they look where the path is known too badly "
            "to say which images overlap"
        ),
    ] = True
