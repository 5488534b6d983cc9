# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The step's own section of dive.toml."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

Positive = Annotated[float, Meta(gt=0)]


class NavigateOptions(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the logs become a path."""

    longest_gap_s: Positive = 0.6  # s between two velocities or attitudes; beyond it an outage is bridged and reported
    node_spacing_s: Positive = 0.4  # s between nodes where there is no camera
    reach_s: Positive = 1.0  # s before the first and after the last velocity in which a frame still gets a node
    beam_window_s: Positive = 3.0  # s of neighbours that a return is compared with
    beam_jump_m: Positive = 0.5  # m
    beam_sigmas: Positive = 5.0  # robust sigmas
    stereo_features: Annotated[int, Meta(ge=100)] = 4000  # an image, for visual odometry
    stereo_inliers: Annotated[int, Meta(ge=6)] = 15  # features that must agree on a step
