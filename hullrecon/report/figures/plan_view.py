# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The plan of the dive on the hull's chart as SVG: hull seen, path, objects, uncertainty."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from hullrecon.report.content.phrases import count, with_sigma
from hullrecon.report.figures.hull_map import Extent, HullMap, SigmaEllipse
from hullrecon.report.figures.map_pictures import ground_png
from hullrecon.report.figures.style import picture_uri
from hullrecon.report.survey import Survey
from hullrecon.typing import Array

LEFT, TOP, WIDTH, FOOT = 62.0, 14.0, 960.0, 92.0  # margins and width of the plan, SVG units
TALLEST = 2 * WIDTH  # largest height, for a narrow strip from keel to waterline


@dataclass(frozen=True, kw_only=True)
class Mark:
    """An object on the plan."""

    label: str
    along: float  # m
    girth: float
    text: str  # shown where the pointer rests
    ellipse: SigmaEllipse | None = None  # as in ChartedObject


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What the plan shows."""

    extent: Extent
    path: Array  # (n, 2) of the vehicle on the chart, NaN rows break the line
    path_sigma: tuple[float, float]  # along and girth, m
    marks: Sequence[Mark]
    ground: bytes | None = None  # PNG of the hull seen
    frame_spacing_m: float | None = None
    across: str = "girth"  # what the second coordinate is called

    @property
    def scale(self) -> float:
        """Units of the plan per metre."""
        return min(WIDTH / self.extent.size[0], TALLEST / self.extent.size[1])

    @property
    def width(self) -> float:
        return self.extent.size[0] * self.scale

    @property
    def height(self) -> float:
        return self.extent.size[1] * self.scale

    def x(self, along: float) -> float:
        """Convert a distance along the hull, m, to x in the drawing."""
        share = along - self.extent.along[0]
        return LEFT + (self.extent.size[0] - share if self.extent.flips[0] else share) * self.scale

    def y(self, girth: float) -> float:
        """Convert a girth, m, to y in the drawing, which grows downwards."""
        share = (girth - self.extent.girth[0]) * self.scale
        return TOP + (share if self.extent.flips[1] else self.height - share)


def survey_plan(survey: Survey, view: HullMap) -> str:
    """Draw the plan of a survey as SVG: the path, the hull seen, and the objects."""
    in_hull = survey.is_in_hull_frame
    chart, across = (
        ("the hull's chart", "girth") if in_hull else ("the survey's own chart", "across")
    )
    along_m, girth_m = view.extent.size
    title = (
        f"Plan of the dive on {chart}, {along_m:.1f} m along by {girth_m:.1f} m {across}: "
        f"path of the vehicle, hull seen, {count(len(view.objects), 'object')}."
    )
    hull = survey.facts.hull
    marks = []
    for placed in view.objects:
        found, (along, girth) = placed.found, placed.at.tolist()
        height = with_sigma(found.height, found.height_sigma, "m")
        text = f"Object {found.id}: height {height}, {found.address}"
        marks.append(
            Mark(label=str(found.id), along=along, girth=girth, text=text, ellipse=placed.ellipse)
        )
    plan = Plan(
        extent=view.extent,
        path=view.path,
        path_sigma=survey.track.sigma_on_chart(view.chart),
        marks=marks,
        ground=ground_png(view.found, view.extent) if view.found is not None else None,
        across=across,
        frame_spacing_m=hull.frame_spacing if hull is not None and in_hull else None,
    )
    return plan_svg(plan, title)


def plan_svg(plan: Plan, title: str) -> str:
    """Draw the plan as SVG, at most WIDTH by TALLEST inside its frame."""
    body = [_ground(plan), *_ticks(plan), _path(plan), *(_mark(mark, plan) for mark in plan.marks)]
    body += [_scale_bar(plan), _sigma_bar(plan)]
    box = f"0 0 {LEFT + WIDTH + 46:.0f} {TOP + plan.height + FOOT:.0f}"
    return (
        f'<svg class="plan" viewBox="{box}" role="img" aria-label="{escape(title, quote=True)}" '
        f'xmlns="http://www.w3.org/2000/svg"><title>{escape(title)}</title>{"".join(body)}</svg>'
    )


def _ground(plan: Plan) -> str:
    """Draw the background: water, and the picture of the hull seen."""
    box = f'x="{LEFT}" y="{TOP}" width="{plan.width:.1f}" height="{plan.height:.1f}"'
    frame = f'<rect {box} class="sea"/>'
    if plan.ground is None:
        return frame
    return f'{frame}<image {box} preserveAspectRatio="none" href="{picture_uri(plan.ground)}"/>'


def nice_step(span_m: float, most: int = 10) -> float:
    """Choose a step of 1, 2 or 5 times a power of ten, at least a span divided by `most`."""
    raw = span_m / most
    power = 10.0 ** math.floor(math.log10(raw))
    return next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= raw * (1 - 1e-9))


def nice_below(span_m: float) -> float:
    """Choose the largest 1, 2 or 5 times a power of ten that fits into a span."""
    power = 10.0 ** math.floor(math.log10(span_m))
    return max(m * power for m in (1.0, 2.0, 5.0) if m * power <= span_m * (1 + 1e-9))


def _ticks(plan: Plan) -> list[str]:
    """Draw grid lines with their distances, and along the ship also the numbers of its frames."""
    step = nice_step(max(plan.extent.size))
    frames = step / (plan.frame_spacing_m or step)
    digits = max(1, math.ceil(-math.log10(frames)))  # so many that no two frames read alike
    foot, right, parts = TOP + plan.height, LEFT + plan.width, []
    for value in _multiples(plan.extent.along, step):
        x = f"{plan.x(value):.1f}"
        parts.append(f'<line x1="{x}" x2="{x}" y1="{TOP}" y2="{foot:.1f}" class="grid"/>')
        parts.append(f'<text x="{x}" y="{foot + 17:.1f}" class="tick mid">{value:g} m</text>')
        if plan.frame_spacing_m:
            frame = f"fr {value / plan.frame_spacing_m:.{digits}f}"
            parts.append(f'<text x="{x}" y="{foot + 33:.1f}" class="tick mid">{frame}</text>')
    for value in _multiples(plan.extent.girth, step):
        y = plan.y(value)
        parts.append(f'<line x1="{LEFT}" x2="{right:.1f}" y1="{y:.1f}" y2="{y:.1f}" class="grid"/>')
        parts.append(f'<text x="{LEFT - 7}" y="{y + 4:.1f}" class="tick end">{value:g} m</text>')
    return parts


def _multiples(span: tuple[float, float], step: float) -> list[float]:
    """List the multiples of a step within a span."""
    first, last = math.ceil(span[0] / step), math.floor(span[1] / step)
    return [round(k * step, 9) for k in range(first, last + 1)]


def _path(plan: Plan) -> str:
    """Draw the vehicle's path, interrupted off the chart, with its start and end."""
    pieces, pen = [], "M"  # of SVG: M moves to a point, L draws a line to it
    for along, girth in plan.path:
        if not np.isfinite(along + girth):
            pen = "M"
            continue
        pieces.append(f"{pen}{plan.x(along):.1f} {plan.y(girth):.1f}")
        pen = "L"
    good = plan.path[np.isfinite(plan.path).all(axis=1)]
    if not len(good):
        return ""
    dots = []
    for (along, girth), name in ((good[0], "start"), (good[-1], "end")):
        x, y = plan.x(along), plan.y(girth)
        dots.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" class="{name}"/>')
        dots.append(f'<text x="{x + 8:.1f}" y="{y - 7:.1f}" class="tick halo">{name}</text>')
    return f'<path d="{"".join(pieces)}" class="path"/>' + "".join(dots)


def _mark(mark: Mark, plan: Plan) -> str:
    """Draw an object as a numbered circle with its ellipse, linked to its card."""
    x, y = plan.x(mark.along), plan.y(mark.girth)
    ellipse = "" if mark.ellipse is None else _ellipse(mark.ellipse, x, y, plan)
    return (
        f'<a href="#object-{escape(mark.label)}"><g><title>{escape(mark.text)}</title>{ellipse}'
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="11" class="object"/>'
        f'<text x="{x:.1f}" y="{y + 4.5:.1f}" class="label">{escape(mark.label)}</text></g></a>'
    )


def _ellipse(ellipse: SigmaEllipse, x: float, y: float, plan: Plan) -> str:
    """Draw a sigma ellipse of the chart about a point x, y of the plan, as SVG.

    SVG's y grows downwards, so the ellipse's angle is reversed.
    """
    flips = plan.extent.flips
    along, girth = math.cos(ellipse.angle_rad), math.sin(ellipse.angle_rad)
    angle = math.degrees(math.atan2(girth if flips[1] else -girth, -along if flips[0] else along))
    rx, ry = (plan.scale * half for half in ellipse.half_axes)
    turn = f'transform="rotate({angle:.1f} {x:.1f} {y:.1f})"'
    return f'<ellipse cx="{x:.1f}" cy="{y:.1f}" rx="{rx:.1f}" ry="{ry:.1f}" {turn} class="sigma"/>'


def _scale_bar(plan: Plan) -> str:
    """Draw a bar of a round length below the plan, on the left."""
    metres = nice_step(WIDTH / plan.scale, 5)
    y, length = TOP + plan.height + 58, metres * plan.scale
    text = f'<text x="{LEFT + length + 8:.1f}" y="{y + 4:.1f}" class="tick">{metres:g} m</text>'
    bar = f"M{LEFT} {y - 5:.1f}v10M{LEFT} {y:.1f}h{length:.1f}m0 -5v10"
    return f'<path d="{bar}" class="bar"/>{text}'


def _sigma_bar(plan: Plan) -> str:
    """Draw a bar from minus to plus one sigma of the vehicle's position along, with both numbers.

    Empty if it is not known.
    """
    along, girth = plan.path_sigma
    if not math.isfinite(along + girth):
        return ""
    y, right = TOP + plan.height + 58, LEFT + WIDTH
    reach = min(along * plan.scale, WIDTH / 3)
    across = "in girth" if plan.across == "girth" else plan.across
    text = f"one sigma of the vehicle: {along:.3f} m along, {girth:.3f} m {across}"
    bar = f"M{right - 2 * reach:.1f} {y - 5:.1f}v10m0 -5h{2 * reach:.1f}m0 -5v10"
    return (
        f'<path d="{bar}" class="bar sigma-bar"/>'
        f'<text x="{right:.1f}" y="{y + 22:.1f}" class="tick end">{text}</text>'
    )
