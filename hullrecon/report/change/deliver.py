# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""All files of a comparison of two dives."""

from __future__ import annotations

import json

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.records.change import HullChange
from hullrecon.report.change.document import change_document
from hullrecon.report.change.layers import change_geojson, change_gpkg, change_layers
from hullrecon.report.change.map import change_png
from hullrecon.report.change.page import change_page
from hullrecon.report.change.table import change_csv


def change_files(change: HullChange, outside: OutsideMap, t_ns: int) -> dict[str, bytes]:
    """Return the bytes of document, table, layers and map by their names; t_ns: time of the second
    dive's last pose.
    """
    layers = change_layers(change, outside)
    return {
        "change.csv": change_csv(change).encode(),
        "change.geojson": _json(change_geojson(layers, outside)),
        "change.gpkg": change_gpkg(layers, outside, t_ns),
        "change.png": change_png(change, outside),
        "change.json": _json(change_document(change, outside)),
    }


def comparison_files(change: HullChange, outside: OutsideMap, t_ns: int) -> dict[str, bytes]:
    """Return the same files and a page of them; change.json is the last: where it lies, all do."""
    files = change_files(change, outside, t_ns)
    document = files.pop("change.json")
    return {
        **files,
        "change.html": change_page(change, files["change.png"]).encode(),
        "change.json": document,
    }


def _json(value: object) -> bytes:
    return (json.dumps(value, indent=1, allow_nan=False, ensure_ascii=False) + "\n").encode()
