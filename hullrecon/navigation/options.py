# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The step's own section of dive.toml."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

Positive = Annotated[float, Meta(gt=0)]


class NavigateOptions(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the logs become a path."""

    longest_gap_s: Annotated[
        Positive,
        Meta(
            description="s, between two velocities or attitudes; a longer outage is bridged and reported"
        ),
    ] = 0.6
    node_spacing_s: Annotated[
        Positive, Meta(description="s, between nodes where there is no camera")
    ] = 0.4
    reach_s: Annotated[
        Positive,
        Meta(
            description="s, before the first and after the last velocity in which each image gets a node; beyond, it gets one "
            "as far as it goes on from the image next to it"
        ),
    ] = 1.0
    beam_window_s: Annotated[
        Positive, Meta(description="s, of neighbouring ranges that a DVL range is compared with")
    ] = 3.0
    beam_jump_m: Annotated[
        Positive, Meta(description="m, smallest jump from its neighbours that rejects a DVL range")
    ] = 0.5
    beam_sigmas: Annotated[
        Positive, Meta(description="sigmas, robust, beyond which a DVL range is rejected")
    ] = 5.0
    stereo_features: Annotated[
        int,
        Meta(ge=100, description="features of an image for visual odometry, and beyond the DVL"),
    ] = 4000
    stereo_inliers: Annotated[
        int, Meta(ge=6, description="features that must agree on a motion")
    ] = 15
