# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""change.csv: one line an object or a stretch of bare hull, with units in its headings."""

from __future__ import annotations

from hullrecon.records.change import HullChange, SurfaceMove
from hullrecon.report.change.document import move_document, object_document
from hullrecon.report.export.csv_export import csv_text

# heading: member of change.json
COLUMNS = {
    "status": "status",
    "first_id": "first_id",
    "second_id": "second_id",
    "along_m": "along",
    "girth_m": "girth",
    "sigma_along_m": "sigma_along",
    "sigma_girth_m": "sigma_girth",
    "height_before_m": "height_before",
    "height_before_sigma_m": "height_before_sigma",
    "height_after_m": "height_after",
    "height_after_sigma_m": "height_after_sigma",
    "change_m": "change",
    "change_sigma_m": "change_sigma",
    "p_value": "p_value",
    "area_m2": "area",
    "address": "address",
}
MOVED = "surface moved"


def change_csv(change: HullChange) -> str:
    """Return the table's text."""
    rows = [object_document(row) for row in change.objects] + [_moved(row) for row in change.moves]
    return csv_text(
        {heading: [row.get(member) for row in rows] for heading, member in COLUMNS.items()}
    )


def _moved(row: SurfaceMove) -> dict[str, object]:
    document = move_document(row)
    return {
        **document,
        "status": MOVED,
        "change": document["move"],
        "change_sigma": document["move_sigma"],
    }
