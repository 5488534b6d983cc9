# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tables as text: CSV with fixed formats, and the TUM trajectory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray


def seconds(t_ns: NDArray[np.int64]) -> list[str]:
    """Return seconds since 1970 with all nine decimals, which a float64 would not hold."""
    return [f"{t // 10**9}.{t % 10**9:09d}" for t in np.asarray(t_ns, np.int64).tolist()]


def numbers(values: NDArray[np.float64], form: str = ".9f") -> list[str]:
    """Return one text a value; a lost value is an empty cell."""
    return [format(v, form) if np.isfinite(v) else "" for v in np.asarray(values, float).tolist()]


def csv_text(table: Mapping[str, Sequence[object]]) -> str:
    """Return a CSV of columns; cells that hold a comma, a quote or a line end are quoted (RFC
    4180).
    """
    rows = zip(*table.values(), strict=True)
    return "\n".join([",".join(table), *(",".join(_cell(c) for c in row) for row in rows), ""])


def _cell(value: object) -> str:
    text = "" if value is None else str(value)
    return '"' + text.replace('"', '""') + '"' if any(c in text for c in ',"\n\r') else text
