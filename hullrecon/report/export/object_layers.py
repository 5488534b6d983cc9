# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The objects as layers over the orthos: objects.geojson and objects.gpkg, in the map coordinates
of the rasters.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.records.deliverables import ReportedObject
from hullrecon.report.export.geopackage import Layer, geopackage_bytes
from hullrecon.typing import Array

FIELDS: dict[str, type] = {
    "id": int,
    "kind": str,
    "height": float,
    "height_sigma": float,
    "deviation": float,
    "deviation_sigma": float,
    "area": float,
    "area_sigma": float,
    "volume": float,
    "volume_sigma": float,
    "views": int,
    "p_value": float,
    "along": float,
    "girth": float,
    "side": str,
    "frame": float,
    "depth": float,
    "depth_sigma": float,
    "sigma_along": float,
    "sigma_girth": float,
    "sigma_normal": float,
    "open_edge": float,
    "address": str,
}
Fields = dict[str, int | float | str | None]


def object_layers(
    objects: Sequence[ReportedObject], photos: Collection[int], chart: Chart, outside: OutsideMap
) -> list[Layer]:
    """Return outlines and centers of objects, those without an outline on the chart left out of the
    first; photos: ids of those with a photo file.
    """
    fields = [object_fields(found, photos) for found in objects]
    rings = [_on_map(found.outline, chart, outside) for found in objects]
    drawn = [k for k, ring in enumerate(rings) if len(ring) >= 3]
    centers = [_on_map((found.center,), chart, outside) for found in objects]
    placed = [k for k, center in enumerate(centers) if len(center)]
    types = {**FIELDS, "photo": str}
    return [
        Layer(
            name="objects",
            description="outlines of the objects' footprints",
            polygons=True,
            types=types,
            shapes=[rings[k] for k in drawn],
            fields=[fields[k] for k in drawn],
        ),
        Layer(
            name="object_centers",
            description="the objects' centers",
            polygons=False,
            types=types,
            shapes=[centers[k] for k in placed],
            fields=[fields[k] for k in placed],
        ),
    ]


def object_fields(found: ReportedObject, photos: Collection[int]) -> Fields:
    """Return the fields of a feature, as in objects.json, metres."""
    values: Fields = {name: getattr(found, name) for name in FIELDS if name != "kind"}
    return values | {
        "kind": "protrusion" if found.height >= 0 else "recess",
        "photo": photo_name(found.id) if found.id in photos else None,
    }


def photo_name(number: int) -> str:
    """Return the file of an object's photo, below deliver/."""
    return f"objects/{number}.jpg"


def objects_geojson(layers: Sequence[Layer], outside: OutsideMap) -> dict[str, object]:
    """Return objects.geojson: the outlines. Its coordinates are metres of the map, not degrees,
    which the member `crs` of the 2008 specification says to programs that read it.
    """
    outlines = layers[0]
    return {
        "type": "FeatureCollection",
        "name": "objects",
        "crs": {"type": "name", "properties": {"name": outside.wkt}},
        "features": [
            {
                "type": "Feature",
                "id": fields["id"],
                "properties": dict(fields),
                "geometry": {
                    "type": "Polygon",
                    "coordinates": [[*ring.round(5).tolist(), ring[0].round(5).tolist()]],
                },
            }
            for ring, fields in zip(outlines.shapes, outlines.fields, strict=True)
        ],
    }


def objects_gpkg(layers: Sequence[Layer], outside: OutsideMap, t_ns: int) -> bytes:
    """Return objects.gpkg; t_ns: time of the dive's last pose, which stands for that of the file."""
    changed = f"{np.datetime64(t_ns, 'ns').astype('datetime64[ms]')}Z"
    return geopackage_bytes(layers, outside.name, outside.wkt, changed)


def _on_map(points: Sequence[Sequence[float]], chart: Chart, outside: OutsideMap) -> Array:
    """Return points (n, 3) in map coordinates (k, 2), without those off the chart."""
    if not len(points):
        return np.zeros((0, 2))
    at = outside.to_map(chart.to_chart(np.array(points, float))[:, :2])
    return np.asarray(at[np.isfinite(at).all(axis=1)])
