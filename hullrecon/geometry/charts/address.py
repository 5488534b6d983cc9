# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Hull addresses: the position of a point on the hull in words, no finer than its sigma."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hullrecon.geometry.charts.chart import Chart
from hullrecon.typing import Array


@dataclass(frozen=True, kw_only=True)
class AddressSigma:
    """Sigmas of a position on the hull, m."""

    along: float  # along the hull
    girth: float  # in girth
    depth: float


def address(
    chart: Chart,
    points: ArrayLike,
    frame_spacing_m: float | None = None,
    depths_m: ArrayLike | None = None,
    sigma: AddressSigma | None = None,
) -> list[str]:
    """Describe the positions of points (n, 3) on the hull in words.

    'frames 52 to 53 (31.4 ± 0.3 m from AP), port, 2.31 ± 0.05 m girth from keel, 1.8 m below
    waterline'. Digits end where the sigma begins, and an uncertain frame is given as a range.
    Without a CAD model the address counts metres on the fitted plane.

    Parameters
    ----------
    chart, points
        The hull's chart, and points in its frame. One beyond the chart is "outside the hull chart".
    frame_spacing_m
        Distance between the ship's frames. None: no frame numbers are given.
    depths_m
        (n,) below the water surface, positive down. Left out where None or NaN.
    sigma
        Sigmas that hold for every point. None, where they are not known: all digits are given.
    """
    at = chart.to_chart(np.atleast_2d(np.asarray(points, float)))
    depths = (
        np.full(len(at), np.nan)
        if depths_m is None
        else np.broadcast_to(np.asarray(depths_m, float), len(at))
    )
    return [
        _words(row, depth, frame_spacing_m, is_hull_chart(chart), sigma)
        for row, depth in zip(at, depths, strict=True)
    ]


def is_hull_chart(chart: Chart) -> bool:
    """Tell whether a chart is that of a CAD model, with girth from the keel."""
    return str(chart.to_arrays().get("kind", "plane")) == "axis"


def side_of(girth_m: float, sigma_m: float = 0.0) -> str:
    """Name the side: port, starboard, or keel if the girth is within 5 mm or one sigma of it."""
    return "keel" if abs(girth_m) < max(0.005, sigma_m) else "port" if girth_m > 0 else "starboard"


def frame_words(along_m: float, spacing_m: float, sigma_m: float | None) -> str:
    """Name the ship's frame at a position along the hull, or the frames within one sigma of it."""
    frame, sigma = along_m / spacing_m, 0.0 if sigma_m is None else sigma_m / spacing_m
    if not math.isfinite(sigma) or sigma <= 0.25:
        return f"frame {frame:.{1 if sigma <= 0.1 else 0}f}"
    low, high = round(frame - sigma), round(frame + sigma)
    return f"frame {low}" if low == high else f"frames {low} to {high}"


def _words(
    at: Array, depth_m: float, spacing_m: float | None, hull: bool, sigma: AddressSigma | None
) -> str:
    """Write the address of one chart point.

    Parts of it that are unknown are left out: frame, depth, and the digits below a sigma.

    Parameters
    ----------
    at
        (3,) m: along, girth, offset.
    depth_m
        Depth below the waterline, NaN where unknown.
    spacing_m
        Distance between the ship's frames, None where unknown.
    hull
        Whether the chart is that of a CAD model.
    sigma
        Sigmas of the position, None where unknown.
    """
    along, girth = float(at[0]), float(at[1])
    along_sigma, girth_sigma = (None, None) if sigma is None else (sigma.along, sigma.girth)
    if not np.isfinite(at[:2]).all():
        parts = ["outside the hull chart"]
    elif not hull:
        parts = [
            f"{_metres(along, along_sigma, 2)} along",
            f"{_metres(girth, girth_sigma, 2)} across",
        ]
    else:
        station = f"{_metres(along, along_sigma, 1)} from AP"
        parts = [
            station
            if spacing_m is None
            else f"{frame_words(along, spacing_m, along_sigma)} ({station})"
        ]
        side = side_of(girth, girth_sigma or 0.0)
        parts += (
            [side]
            if side == "keel"
            else [side, f"{_metres(abs(girth), girth_sigma, 2)} girth from keel"]
        )
    if np.isfinite(depth_m):
        known = _metres(abs(depth_m), None if sigma is None else sigma.depth, 1)
        parts.append(f"{known} {'below' if depth_m >= 0 else 'above'} waterline")
    return ", ".join(parts)


def _metres(value: float, sigma: float | None, most: int) -> str:
    """Format a value, m, with as many decimals as its sigma has, at most `most`, and the sigma.

    A sigma that rounds to zero is left out.
    """
    if sigma is None or not math.isfinite(sigma):
        return f"{value:.{most}f} m"
    digits = min(most, max(0, -math.floor(math.log10(max(sigma, 1e-9)))))
    shown = f"{sigma:.{digits}f}"
    return f"{value:.{digits}f} m" if float(shown) == 0 else f"{value:.{digits}f} ± {shown} m"
