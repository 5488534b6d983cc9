# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Layers of a map: the objects' features, as GeoPackage and GeoJSON."""

from __future__ import annotations

import sqlite3
import struct
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.records.deliverables import ReportedObject
from hullrecon.typing import Array

SRS_ID = 100_000  # our number of the local coordinate system, above those of EPSG
APPLICATION_ID, USER_VERSION = 0x47504B47, 10300  # "GPKG", version 1.3
TYPES = {int: "INTEGER", float: "DOUBLE", str: "TEXT"}
SCHEMA = """
CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT NOT NULL, srs_id INTEGER NOT NULL PRIMARY KEY, \
organization TEXT NOT NULL,
 organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT);
CREATE TABLE gpkg_contents (table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, \
identifier TEXT UNIQUE,
 description TEXT DEFAULT '', last_change DATETIME NOT NULL, min_x DOUBLE, min_y DOUBLE, \
max_x DOUBLE, max_y DOUBLE,
 srs_id INTEGER REFERENCES gpkg_spatial_ref_sys(srs_id));
CREATE TABLE gpkg_geometry_columns (table_name TEXT NOT NULL UNIQUE REFERENCES \
gpkg_contents(table_name),
 column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL, srs_id INTEGER NOT NULL REFERENCES \
gpkg_spatial_ref_sys(srs_id),
 z TINYINT NOT NULL, m TINYINT NOT NULL, PRIMARY KEY (table_name, column_name));
"""
WGS84 = (
    'GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],'
    'PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]]'
)


Fields = Mapping[str, int | float | str | None]


@dataclass(frozen=True, kw_only=True)
class Layer:
    """Features of one kind."""

    name: str
    description: str
    polygons: bool  # else points
    shapes: Sequence[Array]  # open rings (k, 2), or points (1, 2), in map coordinates
    fields: Sequence[Fields]  # of each shape
    types: Mapping[str, type]  # int, float or str of each field, in order


def geojson(layer: Layer, outside: OutsideMap, ids: Sequence[object]) -> dict[str, object]:
    """Write a layer of polygons as GeoJSON, with an id for each feature.

    Coordinates are metres of the map, not degrees. The member `crs` of the 2008 specification tells
    this to programs that read it.
    """
    features = []
    for number, ring, fields in zip(ids, layer.shapes, layer.fields, strict=True):
        corners = [*ring.round(5).tolist(), ring[0].round(5).tolist()]
        geometry = {"type": "Polygon", "coordinates": [corners]}
        properties = dict(fields)
        features.append(
            {"type": "Feature", "id": number, "properties": properties, "geometry": geometry}
        )
    return {
        "type": "FeatureCollection",
        "name": layer.name,
        "crs": {"type": "name", "properties": {"name": outside.wkt}},
        "features": features,
    }


def geopackage(layers: Sequence[Layer], outside: OutsideMap, t_ns: int) -> bytes:
    """Encode layers of a map as a GeoPackage.

    t_ns is the time of the dive's last pose. It is written as the file's time of change, so that
    equal runs give equal bytes.
    """
    changed = f"{np.datetime64(t_ns, 'ns').astype('datetime64[ms]')}Z"
    return geopackage_bytes(layers, outside.name, outside.wkt, changed)


def geopackage_bytes(layers: Sequence[Layer], crs_name: str, wkt: str, changed: str) -> bytes:
    """Encode layers as a GeoPackage whose time of last change is `changed` (ISO 8601)."""
    database = sqlite3.connect(":memory:")
    try:
        database.execute(f"PRAGMA application_id = {APPLICATION_ID}")
        database.execute(f"PRAGMA user_version = {USER_VERSION}")
        database.executescript(SCHEMA)
        systems = [
            ("Undefined Cartesian", -1, "NONE", -1, "undefined", None),
            ("Undefined geographic", 0, "NONE", 0, "undefined", None),
            ("WGS 84", 4326, "EPSG", 4326, WGS84, None),
            (crs_name, SRS_ID, "NONE", SRS_ID, wkt, "local, in metres"),
        ]
        database.executemany("INSERT INTO gpkg_spatial_ref_sys VALUES (?, ?, ?, ?, ?, ?)", systems)
        for layer in layers:
            _add_layer(database, layer, changed)
        database.commit()
        return bytes(database.serialize())
    finally:
        database.close()


def _add_layer(database: sqlite3.Connection, layer: Layer, changed: str) -> None:
    """Add a layer to a GeoPackage: its entry in the contents, its table, and the features."""
    corners = np.concatenate([np.zeros((0, 2)), *layer.shapes])
    box: list[float | None] = [None] * 4
    if len(corners):
        box = [*corners.min(axis=0).tolist(), *corners.max(axis=0).tolist()]
    entry = (layer.name, "features", layer.name, layer.description, changed, *box, SRS_ID)
    database.execute("INSERT INTO gpkg_contents VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)", entry)
    kind = "POLYGON" if layer.polygons else "POINT"
    database.execute(
        "INSERT INTO gpkg_geometry_columns VALUES (?, 'geom', ?, ?, 0, 0)",
        (layer.name, kind, SRS_ID),
    )
    fields = "".join(f', "{name}" {TYPES[type_name]}' for name, type_name in layer.types.items())
    key = "fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL"
    database.execute(f'CREATE TABLE "{layer.name}" ({key}, geom {kind}{fields})')
    marks = ", ".join("?" * (1 + len(layer.types)))
    names = ", ".join(["geom", *(f'"{name}"' for name in layer.types)])
    rows = [
        (geometry_blob(shape, layer.polygons), *(values[name] for name in layer.types))
        for shape, values in zip(layer.shapes, layer.fields, strict=True)
    ]
    database.executemany(f'INSERT INTO "{layer.name}" ({names}) VALUES ({marks})', rows)


def geometry_blob(shape: Array, polygon: bool) -> bytes:
    """Encode a shape, an open ring (k, 2) or a point (1, 2), as a GeoPackage geometry.

    polygon: whether it is a ring. The ring is closed here. The blob is a header, with the envelope
    for polygons, then WKB, little endian.
    """
    ring = np.vstack([shape, shape[:1]]) if polygon else shape
    head = b"GP" + struct.pack("<BBi", 0, 0b011 if polygon else 0b001, SRS_ID)
    if not polygon:
        return head + struct.pack("<BI2d", 1, 1, *ring[0])
    low, high = ring.min(axis=0), ring.max(axis=0)
    envelope = struct.pack("<4d", low[0], high[0], low[1], high[1])
    return (
        head
        + envelope
        + struct.pack("<BIII", 1, 3, 1, len(ring))
        + np.ascontiguousarray(ring, "<f8").tobytes()
    )


# Fields of an object's feature, with the names of objects.json, in metres.
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
    """Make a layer of the objects' outlines and one of their centers.

    Objects off the chart are left out. photos: numbers of the objects that have a photo file.
    """
    outlines = [_to_map(found.outline, chart, outside) for found in objects]
    centers = [_to_map((found.center,), chart, outside) for found in objects]
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


def _to_map(points: Sequence[Sequence[float]], chart: Chart, outside: OutsideMap) -> Array:
    """Transform points (n, 3) to map coordinates (k, 2), without those off the chart."""
    if not len(points):
        return np.zeros((0, 2))
    at = outside.to_map(chart.to_chart(np.array(points, float))[:, :2])
    return np.asarray(at[np.isfinite(at).all(axis=1)])
