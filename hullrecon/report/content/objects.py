# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""objects.csv, and what a card says of an object."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hullrecon.report.export.csv_export import csv_text

_PLAIN = ("id", "height", "height_sigma", "deviation", "area", "volume", "views", "p_value", "address")
_SPREAD = {
    "center": ("center_x", "center_y", "center_z"),
    "normal": ("normal_x", "normal_y", "normal_z"),
    "extent": ("extent_1", "extent_2"),
}


def objects_csv(objects: Sequence[Mapping[str, Any]]) -> str:
    """One line an object: metres, square and cubic metres, as in objects.json."""
    table: dict[str, list[object]] = {"id": [o["id"] for o in objects]}
    for key, names in _SPREAD.items():
        for k, name in enumerate(names):
            table[name] = [_shown(o[key][k]) for o in objects]
    for key in _PLAIN[1:]:
        table[key] = [_shown(o.get(key)) for o in objects]
    table["images"] = [len(o.get("images") or []) for o in objects]
    return csv_text(table)


def _shown(value: object) -> object:
    return f"{value:.6g}" if isinstance(value, float) else value
