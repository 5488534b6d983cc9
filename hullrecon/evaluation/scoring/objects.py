# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which structures were found, how high, and what was reported that is none."""

from __future__ import annotations

from typing import Any

import numpy as np

from hullrecon.evaluation.scoring.alignment import Motion, rms
from hullrecon.evaluation.scoring.truth import Truth

Object = dict[str, Any]


def judge_objects(found: list[Object], truth: Truth, motion: Motion) -> dict[str, Any]:
    """Detections are matched, after the trajectory's alignment, with the structure whose centre is nearest within reach."""
    moved = [{**d, "center": motion.apply(np.asarray(d["center"], float))} for d in found]
    structures, due = truth.structures(), truth.due()
    painted = [o for o in truth.objects if o.get("painted")]
    matched = [(d, _match(d, structures)) for d in moved]
    false = [d for d, o in matched if o is None]
    hit = {o["id"] for _, o in matched if o is not None}
    best = {o["id"]: _closest_height(o, matched) for o in due if o["id"] in hit}
    errors = [abs(d["height"] - o["height"]) for d, o in best.values()]
    return {
        "reported": len(found),
        "reported_twice": len(matched) - len(false) - len(hit),
        "due": len(due),
        "recall": len(best) / max(1, len(due)),
        "false_reports": len(false),
        "false_on_paint": sum(_match(d, painted) is not None for d in false),
        "height_error_median_m": float(np.median(errors)) if errors else float("nan"),
        "height_error_worst_m": max(errors, default=float("nan")),
        "missed": [o["id"] for o in due if o["id"] not in hit],
        "lesser_structures_found": sum(o["id"] in hit and o not in due for o in structures),
        "height_error_over_sigma": _over_sigma(list(best.values())),
    }


def delivered_of(structure: Object, found: list[Object], truth: Truth, motion: Motion) -> Object | None:
    """The detection of that structure, the one with the most images when there are several; None when it was missed."""
    moved = [{**d, "center": motion.apply(np.asarray(d["center"], float))} for d in found]
    own = [d for d in moved if (o := _match(d, truth.structures())) is not None and o["id"] == structure["id"]]
    return max(own, key=lambda d: (d["views"], d["area"]), default=None)


def reach_m(structure: Object) -> float:
    """How far a detection's centre may lie from the structure's."""
    return 0.10 + 0.5 * float(max(structure["extent"]))


def _match(detection: Object, structures: list[Object]) -> Object | None:
    gaps = [float(np.linalg.norm(np.subtract(detection["center"], o["center"]))) for o in structures]
    near = [(gap, k) for k, gap in enumerate(gaps) if gap <= reach_m(structures[k])]
    return structures[min(near)[1]] if near else None


def _closest_height(structure: Object, matched: list[tuple[Object, Object | None]]) -> tuple[Object, Object]:
    own = [d for d, o in matched if o is not None and o["id"] == structure["id"]]
    return min(own, key=lambda d: abs(d["height"] - structure["height"])), structure


def _over_sigma(pairs: list[tuple[Object, Object]]) -> float:
    """RMS of the heights' errors in their own sigma."""
    ratios = [(d["height"] - o["height"]) / d["height_sigma"] for d, o in pairs if d.get("height_sigma")]
    return rms(np.array(ratios))
