# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Changes as layers over the orthos: change.geojson and change.gpkg, in the map coordinates of the
first dive's rasters.
"""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.records.change import HullChange
from hullrecon.report.change.document import move_document, object_document
from hullrecon.report.change.table import MOVED
from hullrecon.report.export.geopackage import Layer, geopackage_bytes
from hullrecon.typing import Array

FIELDS: dict[str, type] = {
    "status": str,
    "first_id": int,
    "second_id": int,
    "along": float,
    "girth": float,
    "sigma_along": float,
    "sigma_girth": float,
    "height_before": float,
    "height_before_sigma": float,
    "height_after": float,
    "height_after_sigma": float,
    "change": float,
    "change_sigma": float,
    "p_value": float,
    "area": float,
    "address": str,
}
LEAST_M = 0.05  # half the side of the square that stands for a place without an outline
Fields = dict[str, int | float | str | None]


def change_layers(change: HullChange, outside: OutsideMap) -> list[Layer]:
    """Return the layer `changes`: outlines of objects and of bare hull that moved, unchanged
    objects included.
    """
    shapes, fields = [], []
    for row in change.objects:
        shapes.append(_ring(row.outline, row.along_girth, outside))
        fields.append(_fields(object_document(row)))
    for move in change.moves:
        document = move_document(move)
        shapes.append(_ring(move.outline, move.along_girth, outside))
        fields.append(
            _fields(
                {
                    **document,
                    "status": MOVED,
                    "change": document["move"],
                    "change_sigma": document["move_sigma"],
                }
            )
        )
    known = [k for k, shape in enumerate(shapes) if np.isfinite(shape).all()]
    return [
        Layer(
            name="changes",
            description="what changed from the first dive to the second, metres",
            polygons=True,
            types=FIELDS,
            shapes=[shapes[k] for k in known],
            fields=[fields[k] for k in known],
        ),
    ]


def change_geojson(layers: list[Layer], outside: OutsideMap) -> dict[str, object]:
    """Return change.geojson; its coordinates are metres of the map, as its member `crs` says."""
    return {
        "type": "FeatureCollection",
        "name": "changes",
        "crs": {"type": "name", "properties": {"name": outside.wkt}},
        "features": [
            {
                "type": "Feature",
                "id": k + 1,
                "properties": dict(fields),
                "geometry": {
                    "type": "Polygon",
                    "coordinates": [[*ring.round(5).tolist(), ring[0].round(5).tolist()]],
                },
            }
            for k, (ring, fields) in enumerate(zip(layers[0].shapes, layers[0].fields, strict=True))
        ],
    }


def change_gpkg(layers: list[Layer], outside: OutsideMap, t_ns: int) -> bytes:
    """Return change.gpkg; t_ns: time of the second dive's last pose, which stands for that of the
    file.
    """
    changed = f"{np.datetime64(t_ns, 'ns').astype('datetime64[ms]')}Z"
    return geopackage_bytes(layers, outside.name, outside.wkt, changed)


def _fields(document: dict[str, object]) -> Fields:
    values = {name: document.get(name) for name in FIELDS}
    return {
        name: value if isinstance(value, int | float | str) else None
        for name, value in values.items()
    }


def _ring(outline: Array, at: Array, outside: OutsideMap) -> Array:
    if len(outline) >= 3:
        return outside.to_map(outline)
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * LEAST_M
    return outside.to_map(at + square)
