# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""objects.csv."""

from __future__ import annotations

from collections.abc import Sequence

from hullrecon.records.deliverables import ReportedObject
from hullrecon.report.export.table import Column, Table


def objects_table(objects: Sequence[ReportedObject]) -> Table:
    """Make objects.csv (docs/deliverables.md): one row per object, as in objects.json."""
    columns = [_column("id", "", "number, as in objects.json", [o.id for o in objects])]
    for name, unit, meaning in (
        ("center", "m", "on the visible surface"),
        ("normal", "", "outward unit normal of the hull"),
    ):
        columns += [
            _column(f"{name}_{a}", unit, meaning, [getattr(o, name)[k] for o in objects])
            for k, a in enumerate("xyz")
        ]
    columns += [
        _column(
            f"extent_{k + 1}",
            "m",
            f"size {way} of the part above a quarter of the height",
            [o.extent[k] for o in objects],
        )
        for k, way in enumerate(("along the hull", "over the girth"))
    ]
    columns += [
        _column(name, unit, meaning, [getattr(o, name) for o in objects])
        for name, unit, meaning in _BEFORE
    ]
    columns.append(
        _column("address", "", "place in words", [o.address for o in objects], words=True)
    )
    columns.append(
        _column(
            "image_count", "", "images that objects.json lists", [len(o.images) for o in objects]
        )
    )
    columns += [
        _column(
            f"extent_{k + 1}_sigma",
            "m",
            "one sigma of the extent",
            [o.extent_sigma and o.extent_sigma[k] for o in objects],
        )
        for k in range(2)
    ]
    columns += [
        _column(
            f"position_sigma_{a}",
            "m",
            f"one sigma of the center along {a}",
            [o.position_sigma and o.position_sigma[k] for o in objects],
        )
        for k, a in enumerate("xyz")
    ]
    columns += [
        _column(name, unit, meaning, [getattr(o, name) for o in objects], words=name == "side")
        for name, unit, meaning in _ADDED
    ]
    return Table(file="objects.csv", title="structures on the hull", columns=columns)


_BEFORE = (
    ("height", "m", "above the hull around it, negative for a recess"),
    ("height_sigma", "m", "one sigma of the height"),
    ("deviation", "m", "largest signed distance to the CAD model"),
    ("area", "m2", "of the part above a quarter of the height"),
    ("volume", "m3", "of the same part, negative for a recess"),
    ("views", "", "images that show more than half of its top"),
    ("p_value", "", "probability that bare hull looks so anywhere in the survey"),
)
_ADDED = (
    ("deviation_sigma", "m", "one sigma of the deviation, the hull's position included"),
    ("area_sigma", "m2", "one sigma of the area"),
    ("volume_sigma", "m3", "one sigma of the volume"),
    ("open_edge", "", "share of the outline beyond which nothing was measured"),
    ("sigma_along", "m", "one sigma of the center along the hull"),
    ("sigma_girth", "m", "one sigma of the center in girth"),
    ("sigma_normal", "m", "one sigma of the center along the normal"),
    ("along", "m", "along the hull"),
    ("girth", "m", "girth from the keel, port positive"),
    ("side", "", "port, starboard or keel"),
    ("frame", "", "number of the ship's frame"),
    ("depth", "m", "of the center below the water surface"),
    ("depth_sigma", "m", "one sigma of the depth"),
)


def _column(
    name: str, unit: str, meaning: str, values: Sequence[object], words: bool = False
) -> Column:
    return Column(
        name=name,
        unit=unit,
        meaning=meaning,
        values=[_cell(value) for value in values],
        words=words,
    )


def _cell(value: object) -> object:
    return f"{value:.6g}" if isinstance(value, float) else value
