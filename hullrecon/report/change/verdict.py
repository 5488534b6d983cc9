# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What changed between two dives, in a line."""

from __future__ import annotations

from hullrecon.records.change import CHANGED, HullChange, ObjectChange, SurfaceMove
from hullrecon.report.content.phrases import count, join, length, with_minus

MOVED = "stretch of bare hull moved"


def verdict(change: HullChange) -> str:
    """Return one line: what changed, of how much, and how small a change would have been found."""
    number = {status: sum(row.status == status for row in change.objects) for status in CHANGED}
    parts = [f"{n} {status}" for status, n in number.items() if n]
    parts += [count(len(change.moves), MOVED, "stretches of bare hull moved")] if change.moves else []
    what = join(parts) if parts else "no change"
    unseen = sum(row.status.startswith("not seen") for row in change.objects)
    left = f", {count(unseen, 'object')} where only one dive looked" if unseen else ""
    unsure = sum(row.status == "uncertain" for row in change.objects)
    left += f", {count(unsure, 'object')} that one dive lists and the other neither shows nor excludes" if unsure else ""
    return (
        f"{change.first} to {change.second}: {what}{left}; {change.area_both:.1f} m2 compared, structures that changed by"
        f" {length(change.detectable_m)} or more are found"
    )


def object_sentence(row: ObjectChange) -> str:
    """Return what became of one object, in a line."""
    name = f"object {row.second_id if row.second_id is not None else row.first_id}" if _is_listed(row) else "a structure"
    where = f" at {row.address}" if row.address else ""
    if row.status in ("grown", "shrunk"):
        return f"{row.status}: {name}{where}, height {_signed(row.change, row.change_sigma)}"
    height = row.height_before if row.status == "gone" else row.height_after
    return f"{row.status}: {name}{where}, {'recess' if height < 0 else 'height'} {length(abs(height))}"


def move_sentence(row: SurfaceMove) -> str:
    """Return what bare hull did, in a line."""
    where = f" at {row.address}" if row.address else ""
    return f"moved: {row.area:.2f} m2 of bare hull{where}, {_signed(row.move, row.move_sigma)} along the normal"


def _is_listed(row: ObjectChange) -> bool:
    return row.first_id is not None or row.second_id is not None


def _signed(value: float, sigma: float) -> str:
    return with_minus(f"{1000 * value:+.0f} ± {1000 * sigma:.0f} mm")
