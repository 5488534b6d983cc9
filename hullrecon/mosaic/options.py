# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Options of the two mosaic steps."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

Metres = Annotated[float, Meta(gt=0, le=1)]


class MosaicOptions(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Hold the options that both mosaics have."""

    max_faces: Annotated[
        int, Meta(ge=100, description="largest number of faces of the GLB's mesh")
    ] = 120_000
    tile_px: Annotated[
        int, Meta(ge=64, le=4096, multiple_of=16, description="px, side of a tile of the raster")
    ] = 512


class OpticalOptions(MosaicOptions, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Hold the options of mosaic-optical."""

    resolution_m: Annotated[
        Metres | None,
        Meta(description="m, side of a texel; absent: from the images' ground sample distance"),
    ] = None
    even_light: Annotated[
        bool,
        Meta(description="remove lamp, vignetting and each image's brightness before blending"),
    ] = True


class SonarOptions(MosaicOptions, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Hold the options of mosaic-sonar."""

    resolution_m: Annotated[
        Metres | None, Meta(description="m, side of a texel; absent: spacing of the range bins")
    ] = None
    even_light: Annotated[
        bool,
        Meta(
            description="remove beam pattern, spreading loss and each ping's gain before blending"
        ),
    ] = True
