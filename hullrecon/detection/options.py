# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Options of the detection: the section [detect] of dive.toml."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

Positive = Annotated[float, Meta(gt=0)]
Count = Annotated[int, Meta(ge=1)]
MIN_OFFSET_M = 0.025  # a landmark or vertex this far off the hull is part of a structure
MIN_CLUSTER_POINTS = 3  # least number of neighbours of a cluster's core point (DBSCAN)


class DetectOptions(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Thresholds that distinguish structures from the hull."""

    min_height_m: Annotated[
        Positive, Meta(description="m, height of the lowest structure that is reported")
    ] = 0.03
    min_area_m2: Annotated[
        Positive, Meta(description="m2, footprint at half height of the smallest object")
    ] = 0.0025
    min_landmarks: Annotated[Count, Meta(description="landmarks that must lie on an object")] = 6
    min_views: Annotated[Count, Meta(description="images whose features must show its shape")] = 3
    max_p_value: Annotated[
        Positive,
        Meta(
            lt=1,
            description="probability, largest false-alarm probability of an object over all places "
            "tested",
        ),
    ] = 1e-3
    cluster_reach_m: Annotated[Positive, Meta(description="m, DBSCAN's radius")] = 0.06
    max_edge_m: Annotated[
        Positive, Meta(description="m, longest edge of the as-found mesh where the hull was seen")
    ] = 0.03
    max_vertices: Annotated[
        Count, Meta(description="of the as-found mesh; it is made coarser rather than larger")
    ] = 1_500_000
