# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""change.json (docs/deliverables.md)."""

from __future__ import annotations

import math

import numpy as np

from hullrecon.geometry.charts.outside_map import OutsideMap
from hullrecon.records.change import HullChange, ObjectChange, SurfaceMove, SurveyOffset
from hullrecon.report.change.verdict import verdict
from hullrecon.typing import Array


def change_document(change: HullChange, outside: OutsideMap) -> dict[str, object]:
    """Return change.json."""
    return {
        "schema": 1,
        "verdict": verdict(change),
        "first": change.first,
        "second": change.second,
        "frame": outside.frame,
        "offset": offset_document(change.offset),
        "coverage": {
            "both_m2": _number(change.area_both, 4),
            "first_m2": _number(change.area_first, 4),
            "second_m2": _number(change.area_second, 4),
            "detectable_m": _number(change.detectable_m, 4),
            "places": change.places,
        },
        "objects": [object_document(row) for row in change.objects],
        "surface_moves": [move_document(row) for row in change.moves],
        "map": {
            "along_from_x": outside.x_sign,
            "girth_from_y": outside.y_sign,
            "name": outside.name,
            "wkt": outside.wkt,
        },
    }


def offset_document(offset: SurveyOffset) -> dict[str, object]:
    """Return where the second dive lies in the first one's frame: numbers that are no change of the
    hull.
    """
    motion = offset.first_from_second
    at_center = motion.apply(offset.center[None])[0] - offset.center
    return {
        "center": _numbers(offset.center),
        "translation_m": _numbers(at_center),
        "rotation_rad": _numbers(motion.rotation.as_rotvec()[0], 6),
        "covariance": [[float(f"{v:.6g}") for v in row] for row in offset.covariance],
        "prior_covariance": [[float(f"{v:.6g}") for v in row] for row in offset.prior_covariance],
        "chi_square": _number(offset.chi_square, 2),
        "p_value": float(f"{offset.p_value:.3g}"),
    }


def object_document(row: ObjectChange) -> dict[str, object]:
    """Return one object of either dive; what is not known is null."""
    return {
        "status": row.status,
        "first_id": row.first_id,
        "second_id": row.second_id,
        "center": _numbers(row.center),
        "along": _number(row.along_girth[0]),
        "girth": _number(row.along_girth[1]),
        "sigma_along": _number(row.sigma[0]),
        "sigma_girth": _number(row.sigma[1]),
        "sigma_normal": _number(row.sigma[2]),
        "height_before": _number(row.height_before),
        "height_after": _number(row.height_after),
        "height_before_sigma": _number(row.height_before_sigma),
        "height_after_sigma": _number(row.height_after_sigma),
        "change": _number(row.change),
        "change_sigma": _number(row.change_sigma),
        "p_value": None if not math.isfinite(row.p_value) else float(f"{row.p_value:.3g}"),
        "area": _number(row.area, 4),
        "address": row.address,
    }


def move_document(row: SurfaceMove) -> dict[str, object]:
    """Return one stretch of bare hull that moved."""
    return {
        "along": _number(row.along_girth[0]),
        "girth": _number(row.along_girth[1]),
        "move": _number(row.move),
        "move_sigma": _number(row.move_sigma),
        "p_value": float(f"{row.p_value:.3g}"),
        "area": _number(row.area, 4),
        "address": row.address,
    }


def _number(value: float, digits: int = 5) -> float | None:
    return round(float(value), digits) if math.isfinite(value) else None


def _numbers(values: Array, digits: int = 5) -> list[float]:
    return [round(float(v), digits) for v in np.asarray(values)]
