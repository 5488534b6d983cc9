# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the page's script is given, as JSON in the page. Positions are map coordinates, metres.

Members:

- `frame`: M or g
- `map`: read by report/web/src/map.js, None without a chart
- `objects`: the objects with their positions on the map
- `scene`: read by scene.js, None if nothing is shown in 3-D

A layer's picture is a data URI in a script element of its own, named by `image`. A browser decodes
it when it is first shown.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from hullrecon.records.links import NodePairs
from hullrecon.report.figures.hull_map import ChartedObject, HullMap
from hullrecon.report.figures.map_pictures import MapLayer, palette
from hullrecon.report.figures.map_tiles import TILE_PX, TileIndex
from hullrecon.report.survey import Survey
from hullrecon.typing import Array, Mask

PageData = Mapping[str, object]


def page_data(
    survey: Survey,
    view: HullMap | None,
    layers: Sequence[MapLayer],
    tiles: Mapping[str, TileIndex] = MappingProxyType({}),
) -> PageData:
    """Build the document of #report-data, without its scene.

    `tiles` has the tiles beside the page, by the name of their layer.
    """
    objects = [] if view is None else [_object(placed, view) for placed in view.objects]
    return {
        "frame": str(survey.track.frame),
        "map": None if view is None else _map(survey, view, layers, tiles),
        "objects": objects,
        "scene": None,
    }


def script_json(data: PageData) -> str:
    """Encode JSON that cannot end the script element around it. Raises ValueError for a NaN."""
    text = json.dumps(
        data, allow_nan=False, ensure_ascii=False, separators=(",", ":"), sort_keys=True
    )
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")


def image_id(layer: MapLayer) -> str:
    """Name the element that holds a layer's picture."""
    return f"layer-{layer.name}"


def _map(
    survey: Survey,
    view: HullMap,
    layers: Sequence[MapLayer],
    tiles: Mapping[str, TileIndex],
) -> PageData:
    """Describe the map: its bounds, axes and layers, the path and the links."""
    hull, in_ship = survey.facts.hull, survey.is_in_hull_frame
    outside = view.extent.outside
    return {
        "bounds": rounded(np.array(view.extent.bounds)),
        "x_sign": outside.x_sign,
        "y_sign": outside.y_sign,
        "axes": ["along", "girth"] if in_ship else ["along", "across"],
        "frame_spacing": hull.frame_spacing if hull is not None and in_ship else None,
        "layers": [_layer(layer, tiles.get(layer.name)) for layer in layers],
        "path": [rounded(outside.to_map(piece)) for piece in _pieces(view.path)],
        "links": _links(survey.facts.node_pairs, view),
    }


def _layer(layer: MapLayer, tiles: TileIndex | None) -> PageData:
    """Describe a layer of the map with its legend and its tiles."""
    legend = layer.legend
    return {
        "id": layer.name,
        "title": layer.title,
        "image": image_id(layer),
        "bounds": list(layer.bounds),
        "note": layer.note,
        "tiles": tiles and {
            "folder": f"tiles/{layer.name}",  # beside the page
            "step_m": tiles.step_m,
            "side_px": TILE_PX,
            "levels": tiles.levels,
        },
        "legend": legend and {
            "label": legend.label,
            "low": round(legend.low, 6),
            "high": round(legend.high, 6),
            "extend": legend.extend,
            "colours": ["#" + bytes(colour).hex() for colour in palette(legend.colours)],
        },
    }  # fmt: skip


def _object(placed: ChartedObject, view: HullMap) -> PageData:
    """Describe an object with its position, outline and sigma ellipse on the map.

    Off the chart `at` is None and the ellipse empty. Outline points off the chart are left out.
    """
    found, at, outside = placed.found, placed.at, view.extent.outside
    outline = np.zeros((0, 2))
    if len(found.outline) >= 3:
        outline = view.chart.to_chart(np.array(found.outline, float))[:, :2]
    on_chart = bool(np.isfinite(at).all())
    ellipse = placed.ellipse if on_chart else None
    return {
        "id": found.id,
        "kind": "protrusion" if found.height >= 0 else "recess",
        "height": round(found.height, 4),
        "at": rounded(outside.to_map(at[None])[0]) if on_chart else None,
        "outline": rounded(outside.to_map(outline[np.isfinite(outline).all(axis=1)])),
        "ellipse": [] if ellipse is None else rounded(outside.to_map(at + ellipse.ring())),
    }


def _pieces(path: Array) -> list[Array]:
    """Split a path (n, 2) at rows with NaN. Pieces of a single point are dropped."""
    good = np.isfinite(path).all(axis=1)
    ends = np.flatnonzero(np.diff(good.astype(int), prepend=0, append=0))
    return [path[a:b] for a, b in zip(ends[::2], ends[1::2], strict=True) if b - a > 1]


def _links(pairs: NodePairs | None, view: HullMap) -> list[PageData]:
    """List the matched pairs of images as lines between their vehicle positions, by kind.

    Each line is (x, y, x, y). Empty where the pairs are of other nodes than the path.
    """
    if pairs is None or not len(pairs):
        return []
    if max(int(pairs.first.max()), int(pairs.second.max())) >= len(view.path):
        return []
    places = view.extent.outside.to_map(view.path)
    ends = np.hstack([places[pairs.first], places[pairs.second]])
    kept = pairs.joined & np.isfinite(ends).all(axis=1)
    kinds: dict[str, Mask] = {
        "along the track": kept & ~pairs.across,
        "between legs": kept & pairs.across,
    }
    return [
        {"kind": name, "segments": rounded(ends[which])}
        for name, which in kinds.items()
        if which.any()
    ]


def rounded(values: Array) -> list[object]:
    """Round to 0.1 mm, for JSON."""
    return list(np.round(np.asarray(values, float), 4).tolist())
