# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What changed between two dives in words: a line, sentences, a chapter of report or page."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from hullrecon.records.change import (
    CHANGED,
    HullChange,
    ObjectChange,
    SurfaceMove,
    SurveyOffset,
)
from hullrecon.report.content.phrases import (
    count,
    join,
    length,
    probability,
    with_minus,
    with_sigma,
)

GATE = 1e-3  # p-value of an offset below which a hull pose is worse than its covariance says

MOVED = "stretch of bare hull moved"


@dataclass(frozen=True, kw_only=True)
class ChangeRow:
    """One object of either dive, in words."""

    status: str  # "new", "gone", "grown" and so on, as in ObjectChange
    changed: bool
    first: str  # its number in the first dive, a dash if it has none
    second: str  # the same in the second dive
    address: str
    before: str  # height in the first dive, mm, with its sigma
    after: str  # the same in the second dive
    change: str  # of the height, mm, with its sigma
    chance: str  # probability of such a difference if nothing changed


@dataclass(frozen=True, kw_only=True)
class ChangeChapter:
    """The texts of the chapter."""

    first: str  # name of the first dive
    second: str
    outcome: str  # the verdict without the dives' names
    verdict: str
    lines: tuple[str, ...]  # a sentence a change
    rows: tuple[ChangeRow, ...]
    moves: tuple[tuple[str, str], ...]  # sentence of each stretch of bare hull that moved, p-value
    offset: str  # of the second dive relative to the first
    area_first: str  # m² of the map that the first dive covers
    area_second: str
    area_both: str
    detectable: str  # smallest change of height that stands out in half of the area
    places: str  # number of places at which a change was looked for


def change_chapter(change: HullChange) -> ChangeChapter:
    """Write the texts of the chapter on what changed."""
    return ChangeChapter(
        first=change.first,
        second=change.second,
        outcome=outcome(change),
        verdict=verdict(change),
        lines=(
            *(object_sentence(row) for row in change.changed()),
            *(move_sentence(row) for row in change.moves),
        ),
        rows=tuple(_change_row(row) for row in change.objects),
        moves=tuple((move_sentence(row), probability(row.p_value)) for row in change.moves),
        offset=offset_sentence(change.offset),
        area_first=f"{change.area_first:.1f} m²",
        area_second=f"{change.area_second:.1f} m²",
        area_both=f"{change.area_both:.1f} m²",
        detectable=length(change.detectable_m),
        places=f"{change.places:,}",
    )


def offset_sentence(offset: SurveyOffset) -> str:
    """Say how the second dive was moved onto the first, and whether the hull poses predict it."""
    at = offset.first_from_second.apply(offset.center[None])[0] - offset.center
    turn = np.degrees(np.linalg.norm(offset.first_from_second.rotation.as_rotvec()[0]))
    sigma = np.sqrt(np.diag(offset.covariance))[:3]
    expected = np.sqrt(np.diag(offset.prior_covariance))[:3]
    numbers = ", ".join(
        f"{axis} {with_minus(f'{1000 * v:+.0f}')} ± {1000 * max(s, 0.0005):.0f} mm"
        for axis, v, s in zip("xyz", at, sigma, strict=True)
    )
    prior = ", ".join(f"{1000 * s:.0f}" for s in expected)
    gate = (
        "as their hull poses foresaw"
        if is_predicted(offset)
        else "farther than their hull poses foresaw"
    )
    return (
        f"To lie on the first dive the second was moved by {numbers}, in the middle of what it"
        f" saw, and turned by {turn:.2f}° ({gate}: one sigma {prior} mm, chi-square"
        f" {offset.chi_square:.1f} of 6). This is no change of the hull and was taken off: each"
        " dive knows its place on the CAD model no better."
    )


def is_predicted(offset: SurveyOffset) -> bool:
    """Decide whether the hull poses of both dives, with their covariances, predict the offset."""
    return offset.p_value >= GATE


def _change_row(row: ObjectChange) -> ChangeRow:
    """Write the row of an object in the chapter's table."""
    return ChangeRow(
        status=row.status,
        changed=row.status in CHANGED,
        first=_number(row.first_id),
        second=_number(row.second_id),
        address=row.address,
        before=_millimetres(row.height_before, row.height_before_sigma),
        after=_millimetres(row.height_after, row.height_after_sigma),
        change=_millimetres(row.change, row.change_sigma),
        chance=probability(row.p_value),
    )


def _number(number: int | None) -> str:
    return "–" if number is None else str(number)


def _millimetres(value: float, sigma: float) -> str:
    """Write a value and its sigma, both m, in millimetres. A dash where the value is unknown."""
    if not np.isfinite(value):
        return "–"
    known = f" ± {1000 * sigma:.0f}" if np.isfinite(sigma) else ""
    return f"{with_minus(f'{1000 * value:.0f}')}{known}"


def verdict(change: HullChange) -> str:
    """Say in a line what changed between which dives."""
    return f"{change.first} to {change.second}: {outcome(change)}"


def outcome(change: HullChange) -> str:
    """Summarise what changed, the area compared, and the smallest change detectable there."""
    number = {status: sum(row.status == status for row in change.objects) for status in CHANGED}
    parts = [f"{n} {status}" for status, n in number.items() if n]
    if change.moves:
        parts.append(count(len(change.moves), MOVED, "stretches of bare hull moved"))
    what = join(parts) if parts else "no change"
    unseen = sum(row.status.startswith("not seen") for row in change.objects)
    left = f", {count(unseen, 'object')} where only one dive looked" if unseen else ""
    unsure = sum(row.status == "uncertain" for row in change.objects)
    if unsure:
        left += f", {count(unsure, 'object')} that one dive lists"
        left += " and the other neither shows nor excludes"
    if not math.isfinite(change.detectable_m):
        return f"{what}{left}; no hull was seen well enough by both dives"
    return (
        f"{what}{left}; {change.area_both:.1f} m² compared, in half of which a structure whose"
        f" height changed by {length(change.detectable_m)} would stand out"
    )


def object_sentence(row: ObjectChange) -> str:
    """Say in a line what became of an object."""
    name = _name(row)
    where = f" at {row.address}" if row.address else ""
    if row.status in ("grown", "shrunk"):
        return f"{row.status}: {name}{where}, height {_signed(row.change, row.change_sigma)}"
    height, sigma = row.height_after, row.height_after_sigma
    if row.status == "gone":
        height, sigma = row.height_before, row.height_before_sigma
    size = with_sigma(1000 * abs(height), 1000 * sigma, "mm")
    return f"{row.status}: {name}{where}, {'recess' if height < 0 else 'height'} {size}"


def move_sentence(row: SurfaceMove) -> str:
    """Say in a line how bare hull moved."""
    where = f" at {row.address}" if row.address else ""
    move = _signed(row.move, row.move_sigma)
    return f"moved: {row.area:.2f} m² of bare hull{where}, {move} along the normal"


def _name(row: ObjectChange) -> str:
    """Call an object by its number in the second dive, if that has it."""
    if row.second_id is not None:
        return f"object {row.second_id}"
    return "a structure" if row.first_id is None else f"object {row.first_id} of the first dive"


def _signed(value: float, sigma: float) -> str:
    return with_minus(f"{1000 * value:+.0f} ± {1000 * sigma:.0f} mm")
