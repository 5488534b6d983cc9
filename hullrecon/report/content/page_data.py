# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the page's script is given, as JSON in the page: places in map coordinates, metres, as in
the rasters and GeoPackages.

Members: `frame`; `map` (None without a chart), which report/web/src/map.js reads; `objects`, with
their places on the map; and `scene` (None where nothing is shown in 3-D), which scene.js reads. A
layer's picture is a data URI in a script element of its own, named by `image`: a browser decodes it
when it is first shown.
"""

from __future__ import annotations

import json
import math
from base64 import b64encode
from collections.abc import Mapping, Sequence

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.links import NodePairs
from hullrecon.report.figures.chart_map import Extent
from hullrecon.report.figures.map_layers import MapLayer, bounds_of, palette
from hullrecon.report.figures.plan_view import SigmaEllipse
from hullrecon.report.figures.survey_map import ChartView
from hullrecon.report.survey import Survey
from hullrecon.typing import Array, Mask

PageData = Mapping[str, object]
ELLIPSE = np.linspace(0, 2 * np.pi, 41)


def page_data(
    survey: Survey,
    view: ChartView | None,
    layers: Sequence[MapLayer],
    ellipses: Sequence[SigmaEllipse | None],
) -> PageData:
    """Return the document of #report-data; ellipses: of the objects."""
    document: dict[str, object] = {
        "frame": str(survey.track.frame),
        "map": None,
        "objects": [],
        "scene": None,
    }
    if view is None:
        return document
    outside = _outside(view.extent, survey)
    objects = survey.findings.objects or ()
    return document | {
        "map": _map_document(survey, view, layers, outside),
        "objects": [
            _object_document(found, at, ellipse, view.chart, outside)
            for found, at, ellipse in zip(objects, view.objects, ellipses, strict=True)
        ],
    }


def script_json(data: PageData) -> str:
    """Return JSON that cannot end the script element it stands in. Raises ValueError for a NaN."""
    text = json.dumps(
        data, allow_nan=False, ensure_ascii=False, separators=(",", ":"), sort_keys=True
    )
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def image_id(layer: MapLayer) -> str:
    """Return the id of the element that holds a layer's picture."""
    return f"layer-{layer.name}"


def image_uri(layer: MapLayer) -> str:
    """Return a layer's picture as a data URI."""
    return "data:image/webp;base64," + b64encode(layer.webp).decode()


def _outside(extent: Extent, survey: Survey) -> OutsideMap:
    x, y = (-1 if flip else 1 for flip in extent.flips)
    return OutsideMap(x_sign=x, y_sign=y, frame=str(survey.track.frame))


def _map_document(
    survey: Survey, view: ChartView, layers: Sequence[MapLayer], outside: OutsideMap
) -> PageData:
    hull = survey.facts.hull
    in_ship = survey.is_in_hull_frame
    return {
        "bounds": _rounded(np.array(bounds_of(view.extent))),
        "x_sign": outside.x_sign,
        "y_sign": outside.y_sign,
        "axes": ["along", "girth"] if in_ship else ["along", "across"],
        "frame_spacing": hull.frame_spacing if hull is not None and in_ship else None,
        "layers": [_layer_document(layer) for layer in layers],
        "path": [_rounded(outside.to_map(piece)) for piece in _pieces(view.path)],
        "links": _links(survey.facts.node_pairs, view.path, outside),
    }


def _layer_document(layer: MapLayer) -> PageData:
    legend = layer.legend
    return {
        "id": layer.name,
        "title": layer.title,
        "image": image_id(layer),
        "bounds": list(layer.bounds),
        "note": layer.note,
        "legend": legend and {
            "label": legend.label,
            "low": round(legend.low, 6),
            "high": round(legend.high, 6),
            "extend": legend.extend,
            "colours": ["#" + bytes(colour).hex() for colour in palette(legend.colours)],
        },
    }  # fmt: skip


def _object_document(
    found: ReportedObject,
    at: Array,
    ellipse: SigmaEllipse | None,
    chart: Chart,
    outside: OutsideMap,
) -> PageData:
    """Return one object's places; `at` and lists are None and empty where it lies off the chart."""
    outline = (
        chart.to_chart(np.array(found.outline, float))[:, :2]
        if len(found.outline) >= 3
        else np.zeros((0, 2))
    )
    on_chart = bool(np.isfinite(at).all())
    return {
        "id": found.id,
        "kind": "protrusion" if found.height >= 0 else "recess",
        "height": round(found.height, 4),
        "at": _rounded(outside.to_map(at[None])[0]) if on_chart else None,
        "outline": _rounded(outside.to_map(outline[np.isfinite(outline).all(axis=1)])),
        "ellipse": _rounded(outside.to_map(at + _ring(ellipse)))
        if ellipse is not None and on_chart
        else [],
    }


def _ring(ellipse: SigmaEllipse) -> Array:
    """Return points (n, 2) around an ellipse about the origin, along and girth."""
    (a, b), turn = ellipse.half_axes, ellipse.angle_rad
    along, girth = a * np.cos(ELLIPSE), b * np.sin(ELLIPSE)
    cosine, sine = math.cos(turn), math.sin(turn)
    return np.stack([cosine * along - sine * girth, sine * along + cosine * girth], axis=1)


def _pieces(path: Array) -> list[Array]:
    """Return the parts of a path (n, 2) between rows with NaN."""
    good = np.isfinite(path).all(axis=1)
    ends = np.flatnonzero(np.diff(good.astype(int), prepend=0, append=0))
    return [path[a:b] for a, b in zip(ends[::2], ends[1::2], strict=True) if b - a > 1]


def _links(pairs: NodePairs | None, path: Array, outside: OutsideMap) -> list[PageData]:
    """Return the pairs of images that matched by kind, each with its segments (x, y, x, y); path:
    the nodes on the chart.
    """
    if (
        pairs is None
        or not len(pairs)
        or max(int(pairs.first.max()), int(pairs.second.max())) >= len(path)
    ):
        return []
    ends = np.hstack([outside.to_map(path[pairs.first]), outside.to_map(path[pairs.second])])
    kept = pairs.joined & np.isfinite(ends).all(axis=1)
    kinds: dict[str, Mask] = {
        "along the track": kept & ~pairs.across,
        "between legs": kept & pairs.across,
    }
    return [
        {"kind": name, "segments": _rounded(ends[which])}
        for name, which in kinds.items()
        if which.any()
    ]


def _rounded(values: Array) -> list[object]:
    rounded: list[object] = np.round(np.asarray(values, float), 4).tolist()
    return rounded
