# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The card of one object on the page: its numbers with their sigmas, and its picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hullrecon.records.deliverables import ReportedObject
from hullrecon.report.content.object_images import Crop
from hullrecon.report.content.phrases import count, length, probability, with_sigma
from hullrecon.report.figures.plan_view import nice_below
from hullrecon.report.survey import Survey

CardContext = Mapping[str, object]


def card_context(found: ReportedObject, survey: Survey, crop: Crop | None) -> CardContext:
    """Write the texts of an object's card, with its picture.

    A value without a sigma is written alone: it was counted, not measured.
    """
    rows = [
        ("Height above the hull around it", with_sigma(found.height, found.height_sigma, "m")),
        ("Extent along the hull, in girth", " × ".join(_extents(found))),
        (
            "Area, volume",
            f"{_scaled(found.area, found.area_sigma, 1e4, 'cm²')}, "
            f"{_scaled(found.volume, found.volume_sigma, 1e3, 'l')}",
        ),
    ]
    if found.open_edge:
        open_edge = f"{100 * found.open_edge:.0f} %"
        words = f"{open_edge}: it may be larger, as the sigmas of its size say"
        rows.append(("Outline beyond which nothing was measured", words))
    if found.deviation is not None:
        distance = with_sigma(found.deviation, found.deviation_sigma, "m")
        rows.append(("Largest distance to the CAD model", distance))
    if found.along is not None and found.girth is not None:
        along = with_sigma(found.along, found.sigma_along, "m")
        girth = with_sigma(found.girth, found.sigma_girth, "m")
        axes = "Along, girth" if survey.is_in_hull_frame else "Along, across"
        rows.append((axes, f"{along}, {girth}"))
    if found.depth is not None:
        depth = with_sigma(found.depth, found.depth_sigma, "m")
        rows.append(("Depth below the water surface", depth))
    sigmas = found.position_sigma or (None, None, None)
    center = ", ".join(
        with_sigma(c, s, "").strip() for c, s in zip(found.center, sigmas, strict=True)
    )
    rows += [
        ("Centre (x, y, z)", f"{center} m in {survey.track.frame}"),
        ("More than half of its top seen in", count(found.views, "view")),
        ("False-alarm probability, anywhere in the survey", probability(found.p_value)),
    ]
    return {
        "id": found.id,
        "kind": "Protrusion" if found.height >= 0 else "Recess",
        "address": found.address,
        "rows": rows,
        "crop": crop and crop_context(crop, found),
    }


@dataclass(frozen=True, kw_only=True)
class ObjectCell:
    """A cell of the table of objects."""

    text: str
    value: float | None = None  # by which the table is sorted, None for words


@dataclass(frozen=True, kw_only=True)
class ObjectRows:
    """The table of objects."""

    headings: Sequence[str]
    rows: Sequence[tuple[int, Sequence[ObjectCell]]]  # cells by each object's number


def object_rows(survey: Survey) -> ObjectRows:
    """Tabulate the objects. Columns that no object fills (a depth, a side) are left out."""
    across = "Girth" if survey.is_in_hull_frame else "Across"
    cells = {found.id: _cells(found, across) for found in survey.findings.objects or ()}
    headings = next(iter(cells.values()), {})
    names = [n for n in headings if any(row[n].text != "–" for row in cells.values())]
    rows = [(number, [row[name] for name in names]) for number, row in cells.items()]
    return ObjectRows(headings=names, rows=rows)


def _cells(found: ReportedObject, across: str) -> dict[str, ObjectCell]:
    """Write an object's cells of the table, by heading."""
    area = _scaled(found.area, found.area_sigma, 1e4, "cm²")
    return {
        "No.": ObjectCell(text=str(found.id), value=found.id),
        "Kind": ObjectCell(text="protrusion" if found.height >= 0 else "recess"),
        "Height": _number(found.height, found.height_sigma, "m"),
        "Area": ObjectCell(text=area, value=found.area),
        "Along": _number(found.along, found.sigma_along, "m"),
        across: _number(found.girth, found.sigma_girth, "m"),
        "Depth": _number(found.depth, found.depth_sigma, "m"),
        "False alarm": ObjectCell(text=probability(found.p_value), value=found.p_value),
    }


def _number(value: float | None, sigma: float | None, unit: str) -> ObjectCell:
    if value is None:
        return ObjectCell(text="–")
    return ObjectCell(text=with_sigma(value, sigma, unit), value=value)


def _extents(found: ReportedObject) -> list[str]:
    sigmas = found.extent_sigma or (None, None)
    return [with_sigma(size, sigma, "m") for size, sigma in zip(found.extent, sigmas, strict=True)]


def _scaled(value: float, sigma: float | None, factor: float, unit: str) -> str:
    return with_sigma(factor * value, None if sigma is None else factor * sigma, unit)


def crop_context(crop: Crop, found: ReportedObject) -> CardContext:
    """Prepare an object's picture for the template, with outline, scale bar and source."""
    seconds, rest = divmod(crop.t_ns, 10**9)
    stamp = str(np.datetime64(seconds, "s")).replace("T", " ")
    bar = nice_below(0.35 * crop.width / crop.pixels_per_m)
    return {
        "crop": crop,
        "points": " ".join(f"{u:.1f},{v:.1f}" for u, v in crop.outline),
        "bar_px": bar * crop.pixels_per_m,
        "bar": length(bar),
        "source": f"{crop.camera.key}, image {crop.row}, {stamp}.{rest // 10**6:03d} UTC",
        "alt": f"Object {found.id} in an image of {crop.camera.key}, with its outline.",
    }
