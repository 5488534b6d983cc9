# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tables as dataclasses of columns, from which rows are selected."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, ClassVar, Self

from hullrecon.typing import Ints, Mask


class Rows:
    """A dataclass whose fields are columns: one row for each measurement."""

    SHARED: ClassVar[frozenset[str]] = frozenset()  # fields that hold for all rows, no columns

    def __len__(self) -> int:
        """Count the rows."""
        return len(getattr(self, self._columns()[0]))

    def take(self, rows: Ints | Mask | slice) -> Self:
        """Select rows of every column. Columns left empty stay so."""
        kept = {name: _take(getattr(self, name), rows) for name in self._columns()}
        return replace(self, **kept)  # type: ignore[type-var]  # any dataclass

    def _columns(self) -> list[str]:
        names = [field.name for field in fields(self)]  # type: ignore[arg-type]  # any dataclass
        return [name for name in names if name not in self.SHARED]


def _take(column: Any, rows: Ints | Mask | slice) -> Any:
    if isinstance(column, Rows):
        return column.take(rows)
    return column[rows] if len(column) else column
