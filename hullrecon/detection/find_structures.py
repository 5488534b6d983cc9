# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Estimate the hull as found and its structures from landmarks and base [Ozog2016 4.3]."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace

import numpy as np

from hullrecon.detection.as_found.hull_as_found import (
    Fusion,
    as_found_surface,
    estimate_hull_as_found,
    fuse_heights,
    surface_on_cad_model,
)
from hullrecon.detection.as_found.landmarks import (
    Background,
    FieldBackground,
    SurfaceLandmarks,
    measure_surface,
    median_background,
)
from hullrecon.detection.base_surface import BaseSurface
from hullrecon.detection.deviation import split_deviation
from hullrecon.detection.objects.find_objects import find_objects
from hullrecon.detection.options import MIN_OFFSET_M, DetectOptions
from hullrecon.detection.views import CameraViews
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.records.solution import DeviationField, Landmarks
from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.typing import Array, Mask

Facts = dict[str, object]
# Without a deviation field, an offset over an area wider than this is of the hull, not a structure
BACKGROUND_WIDTH_M = 1.5
MAX_OFFSET_M = 0.6  # landmarks farther off the base are left out
CAD_EDGE_M = 0.12  # edges of a CAD model that is moved to the DVL's surface, whose edges are 0.1 m


@dataclass(frozen=True, kw_only=True)
class Structures:
    """The hull as found, and the objects on it."""

    as_found: Surface | None  # None without landmarks and CAD model
    deviation: DeviationSplit | None  # from the CAD model, None without one
    objects: list[Facts]  # rows of objects.json
    facts: Facts  # detect.json


def find_structures(
    base: BaseSurface,
    landmarks: Landmarks,
    field: DeviationField | None,
    views: CameraViews | None,
    options: DetectOptions,
    fusion: Fusion = fuse_heights,
) -> Structures:
    """Estimate the hull as found and the objects on it.

    Without a camera or enough landmarks, the hull is as the DVL alone found it, and no objects are
    looked for.

    Parameters
    ----------
    base
        The hull without structures.
    landmarks
        In g, with covariances. Those near the base give the heights.
    field
        Deviation field of the adjustment, which is the hull without structures. None: medians of
        landmarks are.
    views
        Images of the top camera. None without a camera.
    options
        The section [detect] of dive.toml.
    fusion
        How regressed heights and the views' shapes become vertices.
    """
    if views is None:
        return _without_landmarks(base, "no camera was carried")
    # Landmarks as heights over the base
    measured = measure_surface(
        Scene(base.mesh),
        base.result_from_global.apply(landmarks.position),
        landmarks.covariance,
        landmarks.views,
        MAX_OFFSET_M,
        0.5 * MIN_OFFSET_M,
        base.hull_pose,
    )
    if len(measured) < options.min_landmarks:
        return _without_landmarks(base, "the images gave too few landmarks on the surface")
    # The hull without structures, then with them
    background = _choose_background(base, field, measured)
    found = estimate_hull_as_found(base.mesh, measured, background, views, options, fusion)
    # Structures: regions that stand off the hull beyond doubt
    objects, rejected = find_objects(found, measured, views, base, options)
    rows = [asdict(replace(item, id=k + 1)) for k, item in enumerate(objects)]
    facts: Facts = {
        "reference": base.description,
        "landmarks_used": len(measured),
        "not_reported": [asdict(item) for item in rejected],
    }
    as_found = as_found_surface(found, measured, base.cad_model is not None)
    bare = np.abs(found.height) < MIN_OFFSET_M
    deviation = _split(base, as_found, np.where(found.measured, found.sigma, 0.0), bare)
    return Structures(as_found=as_found, deviation=deviation, objects=rows, facts=facts)


def _split(
    base: BaseSurface, as_found: Surface, own_sigma: Array | None, bare: Mask
) -> DeviationSplit | None:
    """Split the deviation as `split_deviation` does. None without a CAD model or its pose."""
    if base.cad_model is None or base.hull_pose is None:
        return None
    return split_deviation(as_found, own_sigma, bare, base.cad_model, base.chart, base.hull_pose)


def _choose_background(
    base: BaseSurface,
    field: DeviationField | None,
    measured: SurfaceLandmarks,
) -> Background:
    """Choose the hull without structures: the deviation field, or medians of landmarks.

    Medians are taken without a field, or where a value of it is not finite.
    """
    if field is not None and np.isfinite(field.value).all():
        return FieldBackground(chart=base.chart, field=field)
    return median_background(measured.foot, measured.offset, BACKGROUND_WIDTH_M)


def _without_landmarks(base: BaseSurface, why: str) -> Structures:
    """Give what is found without landmarks: the CAD model moved to the DVL's surface, no objects.

    Without a CAD model there is no hull as found besides the surveyed surface. `why`: the reason,
    which the report prints after a colon.
    """
    facts: Facts = {"reference": base.description, "objects": why}
    if base.cad_model is None:
        facts["as_found"] = (
            "no landmarks and no CAD model: the surface from the DVL is what was found"
        )
        return Structures(as_found=None, deviation=None, objects=[], facts=facts)
    facts["as_found"] = "from the DVL's surface"
    moved = surface_on_cad_model(base.cad_model, base.surveyed, CAD_EDGE_M)
    deviation = _split(base, moved, None, np.ones(len(moved.vertices), bool))
    return Structures(as_found=moved, deviation=deviation, objects=[], facts=facts)
