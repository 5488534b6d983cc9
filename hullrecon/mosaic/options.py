# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Options of the two mosaic steps."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

Metres = Annotated[float, Meta(gt=0, le=1)]


class OpticalOptions(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Of mosaic-optical."""

    resolution_m: Metres | None = None  # a texel's side; absent: from the images' ground sample distance
    least_resolution_m: Metres = 0.003  # bounds of that choice
    most_resolution_m: Metres = 0.02
    samples_per_texel: Annotated[float, Meta(gt=0)] = 2.0  # pixels along a texel's side that the choice aims at
    most_incidence_deg: Annotated[float, Meta(gt=0, lt=90)] = 70.0
    even_light: bool = True  # take lamp, vignetting and each image's brightness out before blending
    texture_px: Annotated[int, Meta(ge=256, le=16384)] = 4096  # longer side of the GLB's texture
    faces: Annotated[int, Meta(ge=100)] = 120_000  # of the GLB's mesh
    tile_px: Annotated[int, Meta(ge=64, le=4096, multiple_of=16)] = 512
    reach_m: Annotated[float, Meta(gt=0)] = 0.6  # of the surface from the chart


class SonarOptions(Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Of mosaic-sonar."""

    resolution_m: Metres | None = None  # a texel's side; absent: the range bins' spacing
    most_incidence_deg: Annotated[float, Meta(gt=0, lt=90)] = 82.0  # an imaging sonar grazes the hull
    aperture_share: Annotated[float, Meta(gt=0, le=1)] = 0.9  # of the elevation aperture: at its edge little comes back
    even_light: bool = True  # take the beams' pattern, the spreading loss and each ping's gain out before blending
    texture_px: Annotated[int, Meta(ge=256, le=16384)] = 4096
    faces: Annotated[int, Meta(ge=100)] = 120_000
    tile_px: Annotated[int, Meta(ge=64, le=4096, multiple_of=16)] = 512
    reach_m: Annotated[float, Meta(gt=0)] = 0.6
