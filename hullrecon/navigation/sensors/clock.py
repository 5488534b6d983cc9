# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stamps that can be trusted: sorted, each once."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hullrecon.typing import Ints

Stream = TypeVar("Stream")


def in_order(record: Stream, name: str) -> tuple[Stream, list[str]]:
    """Return a stream's record in time order without repeated stamps (the first of equals stays),
    and what was done, as sentences.
    """
    stamps: Ints = record.t_ns  # type: ignore[attr-defined]
    n = len(stamps)
    order = np.argsort(stamps, kind="stable")
    keep = order[np.concatenate([[True], np.diff(stamps[order]) > 0])] if n else order
    if np.array_equal(keep, np.arange(n)):
        return record, []
    back, repeated = int((np.diff(stamps) < 0).sum()), n - len(keep)
    rows = {f.name: getattr(record, f.name) for f in fields(record)}  # type: ignore[arg-type]
    kept = {name: value[keep] for name, value in rows.items() if _by_row(value, n, name)}
    notes = [f"{back} times its clock ran backwards; sorted"] * (back > 0)
    notes += [f"{repeated} repeated stamps; the first of each was kept"] * (repeated > 0)
    return replace(record, **kept), [f"{name}: {note}" for note in notes]  # type: ignore[type-var]


def _by_row(value: NDArray[np.generic], n: int, name: str) -> bool:
    """Return whether a field has a row a stamp; tables of the instrument (beams, directions, bins)
    do not.
    """
    return name not in ("beams", "directions", "range_m") and value.shape[:1] == (n,)
