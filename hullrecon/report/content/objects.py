# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""objects.csv."""

from __future__ import annotations

from collections.abc import Sequence

from hullrecon.records.deliverables import ReportedObject
from hullrecon.report.export.csv_export import csv_text


def objects_csv(objects: Sequence[ReportedObject]) -> str:
    """Return one line an object: metres, square and cubic metres, as in objects.json."""
    columns: dict[str, list[object]] = {"id": [o.id for o in objects]}
    columns |= {f"center_{axis}": [o.center[k] for o in objects] for k, axis in enumerate("xyz")}
    columns |= {f"normal_{axis}": [o.normal[k] for o in objects] for k, axis in enumerate("xyz")}
    columns |= {f"extent_{k + 1}": [o.extent[k] for o in objects] for k in range(2)}
    columns |= {
        "height": [o.height for o in objects],
        "height_sigma": [o.height_sigma for o in objects],
        "deviation": [o.deviation for o in objects],
        "area": [o.area for o in objects],
        "volume": [o.volume for o in objects],
        "views": [o.views for o in objects],
        "p_value": [o.p_value for o in objects],
        "address": [o.address for o in objects],
        "images": [len(o.images) for o in objects],
    }
    return csv_text({name: [_cell(value) for value in values] for name, values in columns.items()})


def _cell(value: object) -> object:
    return f"{value:.6g}" if isinstance(value, float) else value
