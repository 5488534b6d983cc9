# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stamps that can be trusted: sorted, each once; and the holes between them."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from hullrecon.typing import Array, Ints

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


def gaps(t_ns: Ints, longest_s: float) -> Ints:
    """Return start and end (m, 2) of the intervals between stamps that are longer than that."""
    long = np.flatnonzero(np.diff(t_ns) > longest_s * 1e9)
    return (
        np.stack([t_ns[long], t_ns[long + 1]], axis=1) if len(long) else np.zeros((0, 2), np.int64)
    )


def seconds(t_ns: Ints, start_ns: int) -> Array:
    """Return seconds since a start, exact to the nanosecond over a year."""
    return np.asarray((t_ns - start_ns) * 1e-9)
