# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What report/web/src/scene.js is given: a document, and one packed block of arrays that it points
into.

All arrays are little-endian, each begins at a multiple of four bytes. A vertex is three uint16
inside the part's box; its form an int16 in steps of `form_step_m` along a normal of three int8 (in
127ths), and so its relief, the part of the form that may be exaggerated; its place on the map two
float32; a triangle three uint32.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.records.deliverables import ReportedObject
from hullrecon.report.figures.survey_map import ChartView
from hullrecon.report.scene.parts import ScenePart, scene_parts
from hullrecon.report.scene.relief import relief_of
from hullrecon.report.survey import Survey
from hullrecon.typing import Array

SceneDocument = Mapping[str, object]
BLOCK = "scene-block"  # id of the element that holds the packed arrays
MAX_PATH = 2000
_STEPS = 65535


@dataclass(frozen=True, kw_only=True)
class SceneView:
    """The 3-D view: its document, and the block of arrays as base64."""

    document: SceneDocument
    block: str


def make_scene(survey: Survey, view: ChartView | None) -> SceneView | None:
    """Return the 3-D view of a survey; None where there is no surface. view: what the page's map
    shows of the chart.
    """
    surveyed, rest = scene_parts(survey.surfaces)
    if surveyed is None or view is None:
        return None
    x_sign, y_sign = (-1 if flip else 1 for flip in view.extent.flips)
    outside = OutsideMap(x_sign=x_sign, y_sign=y_sign, frame=str(survey.track.frame))
    block = bytearray()
    document: SceneDocument = {
        "block": BLOCK,
        "frame": str(survey.track.frame),
        "up": view.chart.ship_axes[2].tolist(),
        "forward": view.chart.ship_axes[0].tolist(),
        "forward_name": "bow" if survey.is_in_hull_frame else "x",
        "surveyed": _pack(surveyed, outside, block),
        "rest": None if rest is None else _pack(rest, outside, block),
        "has_form": surveyed.has_form,
        "has_cad": survey.is_in_hull_frame,
        "path": _rounded(
            _known(survey.track.poses.translation)[
                :: max(1, -(-len(survey.track.t_ns) // MAX_PATH))
            ]
        ),
        "objects": [
            _object(o)
            for o in survey.findings.objects or ()
            if np.isfinite((*o.center, *o.normal)).all()
        ],
    }
    return SceneView(document=document, block=b64encode(bytes(block)).decode())


def _pack(part: ScenePart, outside: OutsideMap, block: bytearray) -> SceneDocument:
    """Append a part's arrays to the block; return where they lie and how they are scaled."""
    low, high = part.vertices.min(axis=0), part.vertices.max(axis=0)
    span = np.maximum(high - low, 1e-6)
    form_step = max(float(np.abs(part.form).max(initial=0.0)), 1e-6) / 32767
    return {
        "count": len(part.vertices),
        "triangles": len(part.faces),
        "low": low.tolist(),
        "step": (span / _STEPS).tolist(),
        "form_step_m": form_step,
        "vertices": _append(block, np.round((part.vertices - low) / span * _STEPS).astype("<u2")),
        "form": _append(block, np.round(part.form / form_step).astype("<i2")),
        "relief": _append(
            block, np.round(relief_of(part.vertices, part.form) / form_step).astype("<i2")
        ),
        "normals": _append(block, np.round(127 * part.normals).astype("i1")),
        "map": _append(block, outside.to_map(part.chart).astype("<f4")),
        "faces": _append(block, part.faces.astype("<u4")),
    }


def _append(block: bytearray, values: np.ndarray) -> int:
    """Append an array; return the byte at which it begins."""
    block.extend(bytes(-len(block) % 4))
    start = len(block)
    block.extend(np.ascontiguousarray(values).tobytes())
    return start


def _object(found: ReportedObject) -> SceneDocument:
    return {
        "id": found.id,
        "kind": "protrusion" if found.height >= 0 else "recess",
        "at": _rounded(np.array(found.center, float)),
        "normal": _rounded(np.array(found.normal, float)),
        "outline": _rounded(_known(np.array(found.outline, float).reshape(-1, 3))),
    }


def _known(points: Array) -> Array:
    """Return the points (n, 3) without a NaN."""
    return points[np.isfinite(points).all(axis=1)]


def _rounded(values: Array) -> list[object]:
    return list(np.round(np.asarray(values, float), 4).tolist())
