# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What changed between two dives, in a line."""

from __future__ import annotations

import math

from hullrecon.records.change import CHANGED, HullChange, ObjectChange, SurfaceMove
from hullrecon.report.content.phrases import count, join, length, with_minus, with_sigma

MOVED = "stretch of bare hull moved"


def verdict(change: HullChange) -> str:
    """Return one line: between which dives, and what changed."""
    return f"{change.first} to {change.second}: {outcome(change)}"


def outcome(change: HullChange) -> str:
    """Return what changed, of how much hull, and how small a change would have stood out there."""
    number = {status: sum(row.status == status for row in change.objects) for status in CHANGED}
    parts = [f"{n} {status}" for status, n in number.items() if n]
    parts += (
        [count(len(change.moves), MOVED, "stretches of bare hull moved")] if change.moves else []
    )
    what = join(parts) if parts else "no change"
    unseen = sum(row.status.startswith("not seen") for row in change.objects)
    left = f", {count(unseen, 'object')} where only one dive looked" if unseen else ""
    unsure = sum(row.status == "uncertain" for row in change.objects)
    left += (
        f", {count(unsure, 'object')} that one dive lists and the other neither shows nor excludes"
        if unsure
        else ""
    )
    if not math.isfinite(change.detectable_m):
        return f"{what}{left}; no hull was seen well enough by both dives"
    return (
        f"{what}{left}; {change.area_both:.1f} m² compared, in half of which a structure whose height changed by"
        f" {length(change.detectable_m)} would stand out"
    )


def object_sentence(row: ObjectChange) -> str:
    """Return what became of one object, in a line."""
    name = _name(row)
    where = f" at {row.address}" if row.address else ""
    if row.status in ("grown", "shrunk"):
        return f"{row.status}: {name}{where}, height {_signed(row.change, row.change_sigma)}"
    gone = row.status == "gone"
    height, sigma = (
        (row.height_before, row.height_before_sigma)
        if gone
        else (row.height_after, row.height_after_sigma)
    )
    size = with_sigma(1000 * abs(height), 1000 * sigma, "mm")
    return f"{row.status}: {name}{where}, {'recess' if height < 0 else 'height'} {size}"


def move_sentence(row: SurfaceMove) -> str:
    """Return what bare hull did, in a line."""
    where = f" at {row.address}" if row.address else ""
    return f"moved: {row.area:.2f} m² of bare hull{where}, {_signed(row.move, row.move_sigma)} along the normal"


def _name(row: ObjectChange) -> str:
    """Return what an object is called: by its number in the second dive, where that has it."""
    if row.second_id is not None:
        return f"object {row.second_id}"
    return "a structure" if row.first_id is None else f"object {row.first_id} of the first dive"


def _signed(value: float, sigma: float) -> str:
    return with_minus(f"{1000 * value:+.0f} ± {1000 * sigma:.0f} mm")
