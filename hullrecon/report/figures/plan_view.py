# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The plan of the dive on the hull's chart as SVG: hull seen, path of the vehicle, objects,
uncertainty.
"""

from __future__ import annotations

import math
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from hullrecon.report.figures.chart_map import Extent
from hullrecon.typing import Array

LEFT, TOP, WIDTH, FOOT = 62.0, 14.0, 960.0, 92.0
TALLEST = 2 * WIDTH  # of a hull seen in a narrow strip from keel to waterline


@dataclass(frozen=True, kw_only=True)
class SigmaEllipse:
    """Half axes in metres, and the angle (rad) of the first from along towards girth."""

    half_axes: tuple[float, float]
    angle_rad: float


def sigma_ellipse(covariance: Array) -> SigmaEllipse:
    """Return the one-sigma ellipse of a covariance (2, 2), m2, of along and girth."""
    variance, axes = np.linalg.eigh(covariance)
    half = np.sqrt(np.maximum(variance, 0.0))
    return SigmaEllipse(
        half_axes=(float(half[1]), float(half[0])),
        angle_rad=math.atan2(float(axes[1, 1]), float(axes[0, 1])),
    )


@dataclass(frozen=True, kw_only=True)
class Mark:
    """An object on the plan: along, girth in metres, a text for it, and the one-sigma ellipse of
    its own place, None where that is not known.
    """

    label: str
    along: float
    girth: float
    text: str
    ellipse: SigmaEllipse | None = None


@dataclass(frozen=True, kw_only=True)
class Plan:
    """path (n, 2) chart coordinates of the vehicle, NaN rows break the line; path_sigma: along and
    girth, metres; across: what the second coordinate is called.
    """

    extent: Extent
    path: Array
    path_sigma: tuple[float, float]
    marks: Sequence[Mark]
    ground: bytes | None = None
    frame_spacing_m: float | None = None
    across: str = "girth"


def plan_svg(plan: Plan, title: str) -> str:
    """Return one SVG, at most WIDTH by TALLEST inside its frame."""
    width_m, height_m = plan.extent.size
    scale = min(WIDTH / width_m, TALLEST / height_m)
    height = height_m * scale
    body = [_ground(plan, scale, height), *_ticks(plan, scale, height), _path(plan, scale, height)]
    body += [_mark(mark, plan, scale, height) for mark in plan.marks]
    body += [_scale_bar(scale, height), _sigma_bar(plan, scale, height)]
    box = f"0 0 {LEFT + WIDTH + 46:.0f} {TOP + height + FOOT:.0f}"
    return (
        f'<svg class="plan" viewBox="{box}" role="img" aria-label="{escape(title, quote=True)}" '
        f'xmlns="http://www.w3.org/2000/svg"><title>{escape(title)}</title>{"".join(body)}</svg>'
    )


def _x(along: float, plan: Plan, scale: float) -> float:
    share = along - plan.extent.along[0]
    return LEFT + (plan.extent.size[0] - share if plan.extent.flips[0] else share) * scale


def _y(girth: float, plan: Plan, scale: float, height: float) -> float:
    share = (girth - plan.extent.girth[0]) * scale
    return TOP + (share if plan.extent.flips[1] else height - share)


def _ground(plan: Plan, scale: float, height: float) -> str:
    width = plan.extent.size[0] * scale
    box = f'x="{LEFT}" y="{TOP}" width="{width:.1f}" height="{height:.1f}"'
    frame = f'<rect {box} class="sea"/>'
    if plan.ground is None:
        return frame
    data = b64encode(plan.ground).decode()
    return f'{frame}<image {box} preserveAspectRatio="none" href="data:image/png;base64,{data}"/>'


def nice_step(span_m: float, most: int = 10) -> float:
    """Return 1, 2 or 5 times a power of ten, so that a span has at most so many steps."""
    raw = span_m / most
    power = 10.0 ** math.floor(math.log10(raw))
    return next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= raw * (1 - 1e-9))


def nice_below(span_m: float) -> float:
    """Return the largest 1, 2 or 5 times a power of ten that fits into a span."""
    power = 10.0 ** math.floor(math.log10(span_m))
    return max(m * power for m in (1.0, 2.0, 5.0) if m * power <= span_m * (1 + 1e-9))


def _ticks(plan: Plan, scale: float, height: float) -> list[str]:
    step = nice_step(max(plan.extent.size))
    frames = step / (plan.frame_spacing_m or step)
    digits = max(1, math.ceil(-math.log10(frames)))  # so many that no two frames read alike
    parts = []
    for value in _multiples(plan.extent.along, step):
        x = _x(value, plan, scale)
        parts.append(
            f'<line x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{TOP + height:.1f}" class="grid"/>'
        )
        parts.append(
            f'<text x="{x:.1f}" y="{TOP + height + 17:.1f}" class="tick mid">{value:g} m</text>'
        )
        if plan.frame_spacing_m:
            frame = f"fr {value / plan.frame_spacing_m:.{digits}f}"
            parts.append(
                f'<text x="{x:.1f}" y="{TOP + height + 33:.1f}" class="tick mid">{frame}</text>'
            )
    right = LEFT + plan.extent.size[0] * scale
    for value in _multiples(plan.extent.girth, step):
        y = _y(value, plan, scale, height)
        parts.append(f'<line x1="{LEFT}" x2="{right:.1f}" y1="{y:.1f}" y2="{y:.1f}" class="grid"/>')
        parts.append(f'<text x="{LEFT - 7}" y="{y + 4:.1f}" class="tick end">{value:g} m</text>')
    return parts


def _multiples(span: tuple[float, float], step: float) -> list[float]:
    return [
        round(k * step, 9) for k in range(math.ceil(span[0] / step), math.floor(span[1] / step) + 1)
    ]


def _path(plan: Plan, scale: float, height: float) -> str:
    pieces, pen = [], "M"
    for along, girth in plan.path:
        if not np.isfinite(along + girth):
            pen = "M"
            continue
        pieces.append(f"{pen}{_x(along, plan, scale):.1f} {_y(girth, plan, scale, height):.1f}")
        pen = "L"
    good = plan.path[np.isfinite(plan.path).all(axis=1)]
    if not len(good):
        return ""
    ends = [(good[0], "start"), (good[-1], "end")]
    dots = [
        f'<circle cx="{_x(p[0], plan, scale):.1f}" cy="{_y(p[1], plan, scale, height):.1f}" r="5" class="{name}"/>'
        f'<text x="{_x(p[0], plan, scale) + 8:.1f}" y="{_y(p[1], plan, scale, height) - 7:.1f}" class="tick halo">{name}</text>'
        for p, name in ends
    ]
    return f'<path d="{"".join(pieces)}" class="path"/>' + "".join(dots)


def _mark(mark: Mark, plan: Plan, scale: float, height: float) -> str:
    x, y = _x(mark.along, plan, scale), _y(mark.girth, plan, scale, height)
    ellipse = "" if mark.ellipse is None else _ellipse(mark.ellipse, x, y, plan.extent.flips, scale)
    return (
        f'<a href="#object-{escape(mark.label)}"><g><title>{escape(mark.text)}</title>{ellipse}'
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="11" class="object"/>'
        f'<text x="{x:.1f}" y="{y + 4.5:.1f}" class="label">{escape(mark.label)}</text></g></a>'
    )


def _ellipse(
    ellipse: SigmaEllipse, x: float, y: float, flips: tuple[bool, bool], scale: float
) -> str:
    """Return the ellipse; SVG's y grows downwards, and so does its angle."""
    along, girth = math.cos(ellipse.angle_rad), math.sin(ellipse.angle_rad)
    angle = math.degrees(math.atan2(girth if flips[1] else -girth, -along if flips[0] else along))
    rx, ry = (scale * half for half in ellipse.half_axes)
    turn = f'transform="rotate({angle:.1f} {x:.1f} {y:.1f})"'
    return f'<ellipse cx="{x:.1f}" cy="{y:.1f}" rx="{rx:.1f}" ry="{ry:.1f}" {turn} class="sigma"/>'


def _scale_bar(scale: float, height: float) -> str:
    metres = nice_step(WIDTH / scale, 5)
    y = TOP + height + 58
    return (
        f'<path d="M{LEFT} {y - 5:.1f}v10M{LEFT} {y:.1f}h{metres * scale:.1f}m0 -5v10" class="bar"/>'
        f'<text x="{LEFT + metres * scale + 8:.1f}" y="{y + 4:.1f}" class="tick">{metres:g} m</text>'
    )


def _sigma_bar(plan: Plan, scale: float, height: float) -> str:
    along, girth = plan.path_sigma
    if not math.isfinite(along + girth):
        return ""
    y, right = TOP + height + 58, LEFT + WIDTH
    reach = min(along * scale, WIDTH / 3)
    text = f"one sigma of the vehicle: {along:.3f} m along, {girth:.3f} m {'in girth' if plan.across == 'girth' else plan.across}"
    return (
        f'<path d="M{right - 2 * reach:.1f} {y - 5:.1f}v10m0 -5h{2 * reach:.1f}m0 -5v10" class="bar sigma-bar"/>'
        f'<text x="{right:.1f}" y="{y + 22:.1f}" class="tick end">{text}</text>'
    )
