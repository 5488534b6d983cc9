# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tables whose columns say their unit and meaning: the CSV, and csv-metadata.json beside it (CSV on
the Web, W3C).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hullrecon.report.export.csv_export import csv_text

QUDT = "http://qudt.org/vocab/unit/"
UNITS = {"m": "M", "rad": "RAD", "s": "SEC", "m2": "M2", "m3": "M3"}  # names of QUDT


@dataclass(frozen=True, kw_only=True)
class Column:
    """A column of a table. name: without its unit; unit: "" for numbers without one and for words;
    words: whether its cells are.
    """

    name: str
    unit: str
    meaning: str
    values: Sequence[object]
    words: bool = False

    @property
    def heading(self) -> str:
        """Return what the table's first row calls it: the name, and its unit where it has one
        (`sigma_x_m`).
        """
        return f"{self.name}_{self.unit}" if self.unit else self.name


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table and what a row of it is."""

    file: str
    title: str
    columns: Sequence[Column]

    @property
    def csv(self) -> str:
        """Return the file's text."""
        return csv_text({column.heading: column.values for column in self.columns})


def csv_metadata(tables: Sequence[Table]) -> Mapping[str, object]:
    """Return csv-metadata.json: a group of tables, each with name, unit, meaning and type of its
    columns.
    """
    return {
        "@context": "http://www.w3.org/ns/csvw",
        "tables": [
            {
                "url": table.file,
                "dc:title": table.title,
                "tableSchema": {"columns": [_entry(c) for c in table.columns]},
            }
            for table in tables
        ],
    }


def _entry(column: Column) -> dict[str, str]:
    entry = {
        "name": column.heading,
        "titles": column.heading,
        "datatype": "string" if column.words else "number",
        "dc:description": column.meaning,
    }
    return entry | (
        {"unit": column.unit, "qudt:hasUnit": QUDT + UNITS[column.unit]} if column.unit else {}
    )
