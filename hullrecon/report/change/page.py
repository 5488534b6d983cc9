# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""change.html: what changed, on one self-contained page."""

from __future__ import annotations

import base64

import numpy as np

from hullrecon.records.change import CHANGED, HullChange, ObjectChange
from hullrecon.report.change.verdict import move_sentence, object_sentence, verdict
from hullrecon.report.content.page import render_template
from hullrecon.report.content.phrases import length, probability, with_minus

GATE = 1e-3  # an offset less likely than this says that a hull pose is worse than it claims


def change_page(change: HullChange, png: bytes) -> str:
    """Return the HTML; png: the map, which is held in it."""
    context = {
        "change": change,
        "verdict": verdict(change),
        "lines": [object_sentence(row) for row in change.changed()] + [move_sentence(row) for row in change.moves],
        "rows": [_row(row) for row in change.objects],
        "moves": [(move_sentence(row), probability(row.p_value)) for row in change.moves],
        "offset": offset_sentence(change),
        "map": "data:image/png;base64," + base64.b64encode(png).decode(),
        "detectable": length(change.detectable_m),
    }
    return render_template("change.html", context)


def offset_sentence(change: HullChange) -> str:
    """Return where the second dive lay beside the first, and whether their hull poses foresaw it."""
    offset = change.offset
    at = offset.first_from_second.apply(offset.center[None])[0] - offset.center
    sigma = np.sqrt(np.diag(offset.covariance))[:3]
    expected = np.sqrt(np.diag(offset.prior_covariance))[:3]
    numbers = ", ".join(
        f"{axis} {with_minus(f'{1000 * v:+.0f}')} ± {1000 * max(s, 0.0005):.0f} mm"
        for axis, v, s in zip("xyz", at, sigma, strict=True)
    )
    prior = ", ".join(f"{1000 * s:.0f}" for s in expected)
    gate = "as their hull poses foresaw" if offset.p_value >= GATE else "farther than their hull poses foresaw"
    return (
        f"The second dive was placed on the CAD model {numbers} beside the first ({gate}: one sigma {prior} mm, chi-square"
        f" {offset.chi_square:.1f} of 6). This is no change of the hull and was taken off."
    )


def _row(row: ObjectChange) -> dict[str, str]:
    return {
        "status": row.status,
        "changed": "yes" if row.status in CHANGED else "",
        "first": "–" if row.first_id is None else str(row.first_id),
        "second": "–" if row.second_id is None else str(row.second_id),
        "address": row.address,
        "before": _millimetres(row.height_before),
        "after": _millimetres(row.height_after),
        "change": f"{_millimetres(row.change)} ± {_millimetres(row.change_sigma)}" if np.isfinite(row.change) else "–",
        "p": probability(row.p_value),
    }


def _millimetres(value: float) -> str:
    return with_minus(f"{1000 * value:.0f}") if np.isfinite(value) else "–"
