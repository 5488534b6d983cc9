# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The files of a comparison of two dives: document, table, layers, map and page."""

from __future__ import annotations

import json
import math

import numpy as np

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.records.change import HullChange, ObjectChange, SurfaceMove, SurveyOffset
from hullrecon.report.change.chapter import change_chapter, verdict
from hullrecon.report.change.map import change_png
from hullrecon.report.export.layers import Fields, Layer, geojson, geopackage
from hullrecon.report.export.tables import csv_text
from hullrecon.report.figures.style import picture_uri
from hullrecon.report.render import render_template
from hullrecon.typing import Array

MOVED = "surface moved"
HEIGHTS = ("height_before", "height_after", "height_before_sigma", "height_after_sigma")
MEASURED = (*HEIGHTS, "change", "change_sigma")  # of an object, m
LEAST_M = 0.05  # half the side of the square that is drawn for an object without an outline
FIELDS: dict[str, type] = {  # of change.csv, change.geojson and change.gpkg
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
# of change.csv, by field
HEADINGS = {name: f"{name}_m" if of is float else name for name, of in FIELDS.items()}
HEADINGS |= {"area": "area_m2", "p_value": "p_value"}


def change_files(change: HullChange, outside: OutsideMap, t_ns: int) -> dict[str, bytes]:
    """Write document, table, layers and map of a comparison, by file name.

    `t_ns`: time of the second dive's last pose, written as the GeoPackage's time.
    """
    layer = change_layer(change, outside)
    ids = range(1, len(layer.shapes) + 1)
    return {
        "change.csv": change_csv(change).encode(),
        "change.geojson": _json(geojson(layer, outside, ids)),
        "change.gpkg": geopackage([layer], outside, t_ns),
        "change.png": change_png(change, outside),
        "change.json": _json(change_document(change, outside)),
    }


def comparison_files(change: HullChange, outside: OutsideMap, t_ns: int) -> dict[str, bytes]:
    """Write the files of `change_files` and change.html.

    change.json comes last, so that a folder that holds it holds all files.
    """
    files = change_files(change, outside, t_ns)
    document = files.pop("change.json")
    page = change_page(change, files["change.png"]).encode()
    return {**files, "change.html": page, "change.json": document}


def change_page(change: HullChange, png: bytes) -> str:
    """Render the changes as a self-contained page in which the map, a PNG, is embedded."""
    variables = {"change": change_chapter(change), "change_map": picture_uri(png)}
    return render_template("change.html", variables)


def change_csv(change: HullChange) -> str:
    """Write change.csv, with a row for each object and each stretch of bare hull that moved."""
    rows = _rows(change)
    return csv_text({HEADINGS[name]: [row.get(name) for row in rows] for name in FIELDS})


def change_layer(change: HullChange, outside: OutsideMap) -> Layer:
    """Outline all objects, unchanged ones included, and the bare hull that moved.

    Those off the hull chart, whose coordinates are NaN, are left out. outside: the hull chart's
    map, with the hull seen from the water.
    """
    # In the order of `_rows`: the objects, then the moves
    shapes = [_ring(row.outline, row.along_girth, outside) for row in change.objects]
    shapes += [_ring(move.outline, move.along_girth, outside) for move in change.moves]
    fields = [_fields(row) for row in _rows(change)]
    known = [k for k, shape in enumerate(shapes) if np.isfinite(shape).all()]
    return Layer(
        name="changes",
        description="what changed from the first dive to the second, metres",
        polygons=True,
        types=FIELDS,
        shapes=[shapes[k] for k in known],
        fields=[fields[k] for k in known],
    )


def _rows(change: HullChange) -> list[dict[str, object]]:
    """Tabulate objects, then moved stretches of bare hull, as members of change.json by name."""
    rows = [object_document(row) for row in change.objects]
    for move in change.moves:
        document = move_document(move)
        moved = {"change": document["move"], "change_sigma": document["move_sigma"]}
        rows.append({**document, "status": MOVED, **moved})
    return rows


def _fields(row: dict[str, object]) -> Fields:
    """Select the fields of a feature from a row. Members of other types become null."""
    values = {name: row.get(name) for name in FIELDS}
    return {n: v if isinstance(v, int | float | str) else None for n, v in values.items()}


def _ring(outline: Array, at: Array, outside: OutsideMap) -> Array:
    """Convert an outline (n, 2) to map coordinates, a square about `at` (2,) if it has none.

    outline, at: along and girth, m.
    """
    if len(outline) >= 3:
        return outside.to_map(outline)
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * LEAST_M
    return outside.to_map(at + square)


def _json(value: object) -> bytes:
    return (json.dumps(value, indent=1, allow_nan=False, ensure_ascii=False) + "\n").encode()


def change_document(change: HullChange, outside: OutsideMap) -> dict[str, object]:
    """Build change.json (docs/deliverables.md)."""
    return {
        "schema": 1,
        "verdict": verdict(change),
        "first": change.first,
        "second": change.second,
        "frame": outside.frame,
        "offset": offset_document(change.offset),
        "coverage": {
            "both_m2": _number(change.area_both, 4),
            "first_m2": _number(change.area_first, 4),
            "second_m2": _number(change.area_second, 4),
            "detectable_m": _number(change.detectable_m, 4),
            "places": change.places,
        },
        "objects": [object_document(row) for row in change.objects],
        "surface_moves": [move_document(row) for row in change.moves],
        "map": outside.document(),
    }


def offset_document(offset: SurveyOffset) -> dict[str, object]:
    """Describe the second dive's pose in the first dive's frame, which is no change of the hull."""
    motion = offset.first_from_second
    at_center = motion.apply(offset.center[None])[0] - offset.center
    return {
        "center": _numbers(offset.center),
        "translation_m": _numbers(at_center),
        "rotation_rad": _numbers(motion.rotation.as_rotvec()[0], 6),
        "covariance": [[float(f"{v:.6g}") for v in row] for row in offset.covariance],
        "prior_covariance": [[float(f"{v:.6g}") for v in row] for row in offset.prior_covariance],
        "chi_square": _number(offset.chi_square, 2),
        "p_value": float(f"{offset.p_value:.3g}"),
    }


def object_document(row: ObjectChange) -> dict[str, object]:
    """Describe an object of either dive for change.json. Unknown values are null."""
    return {
        "status": row.status,
        "first_id": row.first_id,
        "second_id": row.second_id,
        "center": _numbers(row.center),
        "along": _number(row.along_girth[0]),
        "girth": _number(row.along_girth[1]),
        "sigma_along": _number(row.sigma[0]),
        "sigma_girth": _number(row.sigma[1]),
        "sigma_normal": _number(row.sigma[2]),
        **{name: _number(getattr(row, name)) for name in MEASURED},
        "p_value": None if not math.isfinite(row.p_value) else float(f"{row.p_value:.3g}"),
        "area": _number(row.area, 4),
        "address": row.address,
    }


def move_document(row: SurfaceMove) -> dict[str, object]:
    """Describe a stretch of bare hull that moved for change.json."""
    return {
        "along": _number(row.along_girth[0]),
        "girth": _number(row.along_girth[1]),
        "move": _number(row.move),
        "move_sigma": _number(row.move_sigma),
        "p_value": float(f"{row.p_value:.3g}"),
        "area": _number(row.area, 4),
        "address": row.address,
    }


def _number(value: float, digits: int = 5) -> float | None:
    return round(float(value), digits) if math.isfinite(value) else None


def _numbers(values: Array, digits: int = 5) -> list[float]:
    return [round(float(v), digits) for v in np.asarray(values)]
