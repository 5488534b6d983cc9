# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Score reported objects: structures found, their heights, and false reports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hullrecon.evaluation.trajectory import Figures, rms
from hullrecon.evaluation.truth import TrueStructure, Truth
from hullrecon.geometry.poses import Poses
from hullrecon.records.deliverables import ReportedObject

Match = tuple[ReportedObject, TrueStructure | None]


def score_objects(found: Sequence[ReportedObject], truth: Truth, motion: Poses) -> Figures:
    """Score reported objects, each matched to the nearest true structure within reach.

    Heights are compared for structures that must be found (`Truth.due`). Of several reports of one
    structure, that with the nearest height is taken.

    `motion`: the rigid motion that aligns the delivered trajectory with the true one.
    """
    reports = [move_object(found_object, motion) for found_object in found]
    structures, due = truth.structures(), truth.due()
    painted = [o for o in truth.objects if o.painted]
    matches: list[Match] = [(report, _nearest(report, structures)) for report in reports]
    false = [report for report, true in matches if true is None]
    hit = {true.id for _, true in matches if true is not None}
    best = [(_closest_in_height(true, matches), true) for true in due if true.id in hit]
    errors = [abs(report.height - true.height) for report, true in best]
    return {
        "reported": len(found),
        "reported_twice": len(matches) - len(false) - len(hit),
        "due": len(due),
        "recall": len(best) / max(1, len(due)),
        "false_reports": len(false),
        "false_on_paint": sum(_nearest(report, painted) is not None for report in false),
        "height_error_median_m": float(np.median(errors)) if errors else float("nan"),
        "height_error_worst_m": max(errors, default=float("nan")),
        "missed": [true.id for true in due if true.id not in hit],
        "lesser_structures_found": sum(true.id in hit and true not in due for true in structures),
        "height_error_over_sigma": rms(
            np.array(
                [
                    (report.height - true.height) / report.height_sigma
                    for report, true in best
                    if report.height_sigma
                ]
            )
        ),
    }


def find_reported(
    structure: TrueStructure, found: Sequence[ReportedObject], truth: Truth, motion: Poses
) -> ReportedObject | None:
    """Find the object reported for a structure, or None if it was missed.

    Of several, the one seen in most images is chosen. motion: takes reported positions to those of
    the truth, a batch of one.
    """
    moved = [move_object(found_object, motion) for found_object in found]
    own = [
        d
        for d in moved
        if (o := _nearest(d, truth.structures())) is not None and o.id == structure.id
    ]
    return max(own, key=lambda d: (d.views, d.area), default=None)


def reach_m(structure: TrueStructure) -> float:
    """Compute the largest distance, m, of a report's centre from that of its structure.

    It is 10 cm and half of the structure's largest extent.
    """
    return 0.10 + 0.5 * max(structure.extent)


def move_object(found: ReportedObject, motion: Poses) -> ReportedObject:
    """Move a reported object by a rigid motion, a batch of one."""
    x, y, z = motion.apply([found.center])[0].tolist()
    return replace(found, center=(x, y, z))


def _nearest(found: ReportedObject, structures: Sequence[TrueStructure]) -> TrueStructure | None:
    """Find the structure nearest to a report. None if none is within its reach."""
    gaps = [float(np.linalg.norm(np.subtract(found.center, o.center))) for o in structures]
    near = [(gap, k) for k, gap in enumerate(gaps) if gap <= reach_m(structures[k])]
    return structures[min(near)[1]] if near else None


def _closest_in_height(structure: TrueStructure, matches: Sequence[Match]) -> ReportedObject:
    own = [d for d, o in matches if o is not None and o.id == structure.id]
    return min(own, key=lambda d: abs(d.height - structure.height))
