# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Options of the detection: the section [detect] of dive.toml."""

from __future__ import annotations

from typing import Annotated, Literal

from msgspec import Meta, Struct

Positive = Annotated[float, Meta(gt=0)]
Count = Annotated[int, Meta(ge=1)]


class DetectOptions(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How structures are told from the hull."""

    threshold: Annotated[Positive, Meta(description="m, a feature this far off the hull is part of a structure")] = 0.025
    least_height: Annotated[Positive, Meta(description="m, lower structures are not reported")] = 0.03
    least_area: Annotated[Positive, Meta(description="m2, footprint at half height of the smallest object")] = 0.0025
    least_landmarks: Annotated[Count, Meta(description="landmarks that must lie on an object")] = 8
    least_views: Annotated[Count, Meta(description="images whose features must show its shape")] = 3
    least_agreement: Annotated[Positive, Meta(le=1, description="share, of the landmarks on an object that must agree")] = 0.6
    significance: Annotated[
        Positive, Meta(lt=1, description="probability, largest p-value of an object, over all places tested")
    ] = 1e-3
    cluster_reach: Annotated[Positive, Meta(description="m, DBSCAN's radius")] = 0.06
    cluster_points: Annotated[Count, Meta(description="smallest number of points of a cluster (DBSCAN)")] = 3
    alpha: Annotated[Positive, Meta(description="m, largest circumradius of a triangle of an alpha shape")] = 0.06
    fusion: Annotated[
        Literal["heights", "rays"], Meta(description="as-found heights by local regression, or by running means along rays")
    ] = "heights"
    edge: Annotated[Positive, Meta(description="m, longest edge of the as-found mesh where the hull was seen")] = 0.03
    fine_edge: Annotated[Positive, Meta(description="m, longest edge at objects")] = 0.012
    reach: Annotated[Positive, Meta(description="m, landmarks farther from a vertex say nothing of it")] = 0.08
    neighbours: Annotated[Count, Meta(description="landmarks that decide the height of a vertex")] = 20
    farthest: Annotated[Positive, Meta(description="m, landmarks farther off the hull belong to something else")] = 0.6
    background: Annotated[Positive, Meta(description="m, hull wider than this is hull, without a deviation field")] = 1.5
    most_vertices: Annotated[Count, Meta(description="the as-found mesh is made coarser rather than larger")] = 1_500_000
