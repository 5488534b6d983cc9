# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tables whose columns say their unit and meaning: CSV, and csv-metadata.json (CSV on the Web)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

QUDT = "http://qudt.org/vocab/unit/"
UNITS = {"m": "M", "rad": "RAD", "s": "SEC", "m2": "M2", "m3": "M3"}  # names of QUDT


@dataclass(frozen=True, kw_only=True)
class Column:
    """A column of a table."""

    name: str  # without its unit
    unit: str  # "" for words and for numbers without a unit
    meaning: str
    values: Sequence[object]
    words: bool = False  # whether its cells are words

    @property
    def heading(self) -> str:
        """Heading in the first row: the name and, if there is one, the unit."""
        return f"{self.name}_{self.unit}" if self.unit else self.name


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table of a file. The title says what a row is."""

    file: str
    title: str
    columns: Sequence[Column]

    @property
    def csv(self) -> str:
        """The table as CSV."""
        return csv_text({column.heading: column.values for column in self.columns})


def csv_metadata(tables: Sequence[Table]) -> Mapping[str, object]:
    """Build csv-metadata.json: name, unit, meaning and type of the columns of tables."""
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
    if column.unit:
        entry |= {"unit": column.unit, "qudt:hasUnit": QUDT + UNITS[column.unit]}
    return entry


def seconds(t_ns: NDArray[np.int64]) -> list[str]:
    """Write times as seconds since 1970 with all nine decimals, which a float64 does not hold."""
    return [f"{t // 10**9}.{t % 10**9:09d}" for t in np.asarray(t_ns, np.int64).tolist()]


def numbers(values: NDArray[np.float64], form: str = ".9f") -> list[str]:
    """Format values as cells. A value that is not finite gives an empty cell."""
    return [format(v, form) if np.isfinite(v) else "" for v in np.asarray(values, float).tolist()]


def csv_text(table: Mapping[str, Sequence[object]]) -> str:
    """Write columns as CSV. Cells with a comma, a quote or a line end are quoted (RFC 4180)."""
    rows = zip(*table.values(), strict=True)
    return "\n".join([",".join(table), *(",".join(_cell(c) for c in row) for row in rows), ""])


def _cell(value: object) -> str:
    text = "" if value is None else str(value)
    return '"' + text.replace('"', '""') + '"' if any(c in text for c in ',"\n\r') else text
