# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stages of the chain that make their surface as the sources do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

from hullrecon.artifacts.stage import Context, Stage
from hullrecon.steps import detect, surface
from hullrecon.studies.surfaces.kernels import RadialKernel, WendlandKernel
from hullrecon.studies.surfaces.linear import by_triangles
from hullrecon.studies.surfaces.ray_fusion import move_along_rays
from hullrecon.studies.surfaces.references import heights_over_plane, offsets_from_plane
from hullrecon.surface.build import gaussian_process


def _stage(base: Stage, run: Callable[[Context[Any]], None]) -> Stage:
    return replace(base, run=run)


# of the step surface, by name; the product's own is "Gaussian process"
SURFACES = {
    "linear": _stage(surface.STAGE, partial(surface.run, regression=by_triangles)),
    "radial kernel": _stage(
        surface.STAGE,
        partial(surface.run, regression=partial(gaussian_process, form=RadialKernel)),
    ),
    "wendland kernel": _stage(
        surface.STAGE,
        partial(surface.run, regression=partial(gaussian_process, form=WendlandKernel)),
    ),
    "offsets from a plane": _stage(
        surface.STAGE, partial(surface.run, reference=offsets_from_plane)
    ),
    "heights over a plane": _stage(
        surface.STAGE, partial(surface.run, reference=heights_over_plane)
    ),
}
# of the step detect
AS_FOUND = {"rays": _stage(detect.STAGE, partial(detect.run, fusion=move_along_rays))}
