# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Options of the two mosaic steps."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

Metres = Annotated[float, Meta(gt=0, le=1)]


class OpticalOptions(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Hold the options of mosaic-optical."""

    resolution_m: Annotated[
        Metres | None,
        Meta(description="m, side of a texel; absent: from the images' ground sample distance"),
    ] = None
    min_resolution_m: Annotated[
        Metres, Meta(description="m, smallest side of a texel that is chosen")
    ] = 0.001
    max_resolution_m: Annotated[
        Metres, Meta(description="m, largest side of a texel that is chosen")
    ] = 0.02
    samples_per_texel: Annotated[
        float,
        Meta(gt=0, description="px, image pixels along a texel's side that the choice aims at"),
    ] = 1.0
    max_incidence_deg: Annotated[
        float, Meta(gt=0, lt=90, description="deg, views more oblique than this are not used")
    ] = 70.0
    even_light: Annotated[
        bool,
        Meta(description="remove lamp, vignetting and each image's brightness before blending"),
    ] = True
    texture_px: Annotated[
        int, Meta(ge=256, le=16384, description="px, longer side of the GLB's texture")
    ] = 4096
    max_faces: Annotated[
        int, Meta(ge=100, description="largest number of faces of the GLB's mesh")
    ] = 120_000
    tile_px: Annotated[
        int, Meta(ge=64, le=4096, multiple_of=16, description="px, side of a tile of the raster")
    ] = 512
    reach_m: Annotated[
        float, Meta(gt=0, description="m, largest distance of the surface from the chart")
    ] = 0.6


class SonarOptions(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Hold the options of mosaic-sonar."""

    resolution_m: Annotated[
        Metres | None, Meta(description="m, side of a texel; absent: spacing of the range bins")
    ] = None
    max_incidence_deg: Annotated[
        float,
        Meta(
            gt=0,
            lt=90,
            description="deg, views more oblique than this are not used; an imaging sonar grazes the hull",
        ),
    ] = 82.0
    aperture_share: Annotated[
        float,
        Meta(
            gt=0,
            le=1,
            description="share, of the elevation aperture that is used: little comes back at its edge",
        ),
    ] = 0.9
    even_light: Annotated[
        bool,
        Meta(
            description="remove beam pattern, spreading loss and each ping's gain before blending"
        ),
    ] = True
    texture_px: Annotated[
        int, Meta(ge=256, le=16384, description="px, longer side of the GLB's texture")
    ] = 4096
    max_faces: Annotated[
        int, Meta(ge=100, description="largest number of faces of the GLB's mesh")
    ] = 120_000
    tile_px: Annotated[
        int, Meta(ge=64, le=4096, multiple_of=16, description="px, side of a tile of the raster")
    ] = 512
    reach_m: Annotated[
        float, Meta(gt=0, description="m, largest distance of the surface from the chart")
    ] = 0.6
