# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The objects as layers over the orthos: their outlines and centers in map coordinates."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.records.deliverables import ReportedObject
from hullrecon.report.export.geopackage import Fields, Layer
from hullrecon.typing import Array

# of a feature, as in objects.json, metres
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


def object_layers(
    objects: Sequence[ReportedObject], photos: Collection[int], chart: Chart, outside: OutsideMap
) -> list[Layer]:
    """Make the layers of outlines and of centers, each of the objects that the chart shows.

    `photos` holds the numbers of the objects with a photo file.
    """
    outlines = [_on_map(found.outline, chart, outside) for found in objects]
    centers = [_on_map((found.center,), chart, outside) for found in objects]
    fields = [object_fields(found, photos) for found in objects]
    kinds = (
        ("objects", "outlines of the objects' footprints", True, outlines, 3),
        ("object_centers", "the objects' centers", False, centers, 1),
    )
    layers = []
    for name, description, polygons, shapes, least in kinds:
        kept = [k for k, shape in enumerate(shapes) if len(shape) >= least]
        layer = Layer(
            name=name,
            description=description,
            polygons=polygons,
            types={**FIELDS, "photo": str},
            shapes=[shapes[k] for k in kept],
            fields=[fields[k] for k in kept],
        )
        layers.append(layer)
    return layers


def object_fields(found: ReportedObject, photos: Collection[int]) -> Fields:
    """Collect the fields of an object's feature."""
    values: dict[str, int | float | str | None] = {
        name: getattr(found, name) for name in FIELDS if name != "kind"
    }
    return values | {
        "kind": "protrusion" if found.height >= 0 else "recess",
        "photo": photo_name(found.id) if found.id in photos else None,
    }


def photo_name(number: int) -> str:
    """Name the file of an object's photo, below deliver/."""
    return f"objects/{number}.jpg"


def _on_map(points: Sequence[Sequence[float]], chart: Chart, outside: OutsideMap) -> Array:
    """Transform points (n, 3) to map coordinates (k, 2), without those off the chart."""
    if not len(points):
        return np.zeros((0, 2))
    at = outside.to_map(chart.to_chart(np.array(points, float))[:, :2])
    return np.asarray(at[np.isfinite(at).all(axis=1)])
