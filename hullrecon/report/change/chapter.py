# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What changed between two dives, as the texts of a chapter of the report or of a page."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.records.change import CHANGED, HullChange, ObjectChange, SurveyOffset
from hullrecon.report.change.verdict import move_sentence, object_sentence, outcome, verdict
from hullrecon.report.content.phrases import length, probability, with_minus

GATE = 1e-3  # an offset less likely than this says that a hull pose is worse than it claims


@dataclass(frozen=True, kw_only=True)
class ChangeRow:
    """One object of either dive: what became of it, its numbers in both, where it is, heights and
    change in mm with their sigmas, and the chance that nothing changed.
    """

    status: str
    changed: bool
    first: str
    second: str
    address: str
    before: str
    after: str
    change: str
    chance: str


@dataclass(frozen=True, kw_only=True)
class ChangeChapter:
    """The texts. first, second: names of the dives; outcome: the verdict without them; lines: a
    sentence a change; moves: stretches of bare hull that moved, with the chance of each that
    nothing did; offset: how the dives lie beside each other; area_first, area_second, area_both: of
    the map that each covers and that both looked at, m²; detectable: a length; places: how many.
    """

    first: str
    second: str
    outcome: str
    verdict: str
    lines: tuple[str, ...]
    rows: tuple[ChangeRow, ...]
    moves: tuple[tuple[str, str], ...]
    offset: str
    area_first: str
    area_second: str
    area_both: str
    detectable: str
    places: str


def change_chapter(change: HullChange) -> ChangeChapter:
    """Return the texts on what changed."""
    return ChangeChapter(
        first=change.first,
        second=change.second,
        outcome=outcome(change),
        verdict=verdict(change),
        lines=(
            *(object_sentence(row) for row in change.changed()),
            *(move_sentence(row) for row in change.moves),
        ),
        rows=tuple(_row(row) for row in change.objects),
        moves=tuple((move_sentence(row), probability(row.p_value)) for row in change.moves),
        offset=offset_sentence(change.offset),
        area_first=f"{change.area_first:.1f} m²",
        area_second=f"{change.area_second:.1f} m²",
        area_both=f"{change.area_both:.1f} m²",
        detectable=length(change.detectable_m),
        places=f"{change.places:,}",
    )


def offset_sentence(offset: SurveyOffset) -> str:
    """Return how the second dive was moved to lie on the first, and whether their hull poses
    foresaw it.
    """
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
        if is_foreseen(offset)
        else "farther than their hull poses foresaw"
    )
    return (
        f"To lie on the first dive the second was moved by {numbers}, in the middle of what it saw, and turned by {turn:.2f}°"
        f" ({gate}: one sigma {prior} mm, chi-square {offset.chi_square:.1f} of 6). This is no change of the hull and was taken"
        " off: each dive knows its place on the CAD model no better."
    )


def is_foreseen(offset: SurveyOffset) -> bool:
    """Return whether the dives lie as near to each other as their hull poses say."""
    return offset.p_value >= GATE


def _row(row: ObjectChange) -> ChangeRow:
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
    if not np.isfinite(value):
        return "–"
    known = f" ± {1000 * sigma:.0f}" if np.isfinite(sigma) else ""
    return f"{with_minus(f'{1000 * value:.0f}')}{known}"
