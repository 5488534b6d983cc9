# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Objects of two surveys side by side: which are one, and which are new, gone, grown or shrunk."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hullrecon.change.difference import ChangedRegion, Difference, measure, top_of, well_seen
from hullrecon.change.offset import offset_sigma
from hullrecon.change.options import ChangeOptions
from hullrecon.change.relief import Relief
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.charts.lattice import Lattice
from hullrecon.geometry.charts.tangents import tangents_at
from hullrecon.geometry.poses import Poses, identity
from hullrecon.records.change import HullSurvey, ObjectChange, Status, SurveyOffset
from hullrecon.records.deliverables import ReportedObject
from hullrecon.typing import Array, Mask

GATE = 13.8  # chi-square, 2 degrees of freedom, 0.1 %
MIDDLE_SHARE = 0.1  # of an object's size: how far its middle may be drawn elsewhere, of two surveys
MIDDLE_M = 0.02
THERE_SHARE = 0.5  # of a structure's height: what stood so high before was there before
SEEN_SHARE = 0.5  # of a footprint that must have been looked at


@dataclass(frozen=True, kw_only=True)
class _MovedObject:
    """An object in the first survey's frame: center (3,), its footprint (a, g) on the lattice, and
    its outline (k, 2).
    """

    found: ReportedObject
    center: Array
    along_girth: Array
    outline: Array
    footprint: Mask

    @property
    def side(self) -> float:
        """Return 1 for what is raised, -1 for a recess."""
        return 1.0 if self.found.height >= 0 else -1.0


@dataclass(frozen=True, kw_only=True)
class ObjectComparison:
    """What objects are compared on."""

    chart: Chart
    lattice: Lattice
    offset: SurveyOffset
    difference: Difference
    options: ChangeOptions
    places: int


def compare_objects(
    first: HullSurvey, second: HullSurvey, regions: Sequence[ChangedRegion], on: ObjectComparison
) -> tuple[ObjectChange, ...]:
    """Return all objects of both surveys and the regions that changed without one, what changed
    most first.
    """
    before = [_move_object(found, on, identity()) for found in first.objects]
    after = [_move_object(found, on, on.offset.first_from_second) for found in second.objects]
    pairs = match_objects(before, after, on)
    rows: list[ObjectChange] = []
    for region in regions:
        for a, b in _at(_nearest(region, before, on), _nearest(region, after, on), pairs):
            rows.append(
                _describe_change(
                    region, None if a is None else before[a], None if b is None else after[b], on
                )
            )
    rows = _join_parts(rows)
    known = ({row.first_id for row in rows}, {row.second_id for row in rows})
    left = [(a, pairs.get(a)) for a in range(len(before))] + [
        (None, b) for b in range(len(after)) if b not in pairs.values()
    ]
    compared = len(left)
    for a, b in left:
        one, other = (None if a is None else before[a], None if b is None else after[b])
        if (one and one.found.id in known[0]) or (other and other.found.id in known[1]):
            continue
        rows.append(_describe_rest(one, other, compared, on))
    order = {
        "new": 0,
        "gone": 0,
        "grown": 1,
        "shrunk": 1,
        "uncertain": 2,
        "not seen before": 3,
        "not seen again": 3,
        "unchanged": 4,
    }
    return tuple(sorted(rows, key=lambda row: (order[row.status], -abs(row.change))))


def _at(a: int | None, b: int | None, pairs: dict[int, int]) -> list[tuple[int | None, int | None]]:
    """Return the objects of the first and of the second survey that changed where a region overlaps
    these two: a pair of one object, or what stands there in one survey only.
    """
    back = {second: first for first, second in pairs.items()}
    if a is not None and b is not None and pairs.get(a) != b:
        alone: list[tuple[int | None, int | None]] = [(a, None)] if a not in pairs else []
        alone += [(None, b)] if b not in back else []
        return alone or [(a, pairs[a])]
    return [
        (
            a if a is not None or b is None else back.get(b),
            b if b is not None or a is None else pairs.get(a),
        )
    ]


def match_objects(
    before: Sequence[_MovedObject], after: Sequence[_MovedObject], on: ObjectComparison
) -> dict[int, int]:
    """Return which object of the second survey is which of the first's: the best pairs by
    chi-square of their places, both raised or both sunken, inside the gate.
    """
    candidates = sorted(_candidates(before, after, on))
    pairs: dict[int, int] = {}
    for _, a, b in candidates:
        if a not in pairs and b not in pairs.values():
            pairs[a] = b
    return pairs


def _candidates(
    before: Sequence[_MovedObject], after: Sequence[_MovedObject], on: ObjectComparison
) -> Iterator[tuple[float, int, int]]:
    for a, one in enumerate(before):
        if not np.isfinite(one.along_girth).all():
            continue
        tangents = [axis[0] for axis in tangents_at(on.chart, one.center[None])]
        for b, other in enumerate(after):
            size = max(*one.found.extent, *other.found.extent)
            if one.side != other.side or np.linalg.norm(one.center - other.center) > 2 * size + 0.5:
                continue
            own = np.hypot(MIDDLE_M, MIDDLE_SHARE * size)
            shared = offset_sigma(on.offset, np.stack([one.center] * 2), np.stack(tangents))
            gap = np.array([axis @ (other.center - one.center) for axis in tangents])
            chi_square = float((gap**2 / (own**2 + shared**2)).sum())
            if np.isfinite(chi_square) and chi_square <= GATE:
                yield chi_square, a, b


def _move_object(found: ReportedObject, on: ObjectComparison, motion: Poses) -> _MovedObject:
    """Return an object with its place after a motion."""
    center = motion.apply(np.array([found.center], float))[0]
    ring = motion.apply(np.array(found.outline, float)) if len(found.outline) else np.zeros((0, 3))
    outline = on.chart.to_chart(ring)[:, :2] if len(ring) else np.zeros((0, 2))
    outline = outline[np.isfinite(outline).all(axis=1)]
    at = on.chart.to_chart(center[None])[0, :2]
    footprint = on.lattice.polygon(outline)
    if not footprint.any() and np.isfinite(at).all():
        footprint = np.linalg.norm(on.lattice.points() - at, axis=-1) <= max(
            0.5 * max(found.extent), on.lattice.step_m
        )
    return _MovedObject(
        found=found, center=center, along_girth=at, outline=outline, footprint=footprint
    )


def _nearest(
    region: ChangedRegion, moved: Sequence[_MovedObject], on: ObjectComparison
) -> int | None:
    """Return the object that a region overlaps most, an edge's reach around it included."""
    from scipy.ndimage import binary_dilation

    wide = binary_dilation(
        region.cells, iterations=max(1, round(on.options.edge_m / on.options.cell_m))
    )
    shared = [int((wide & one.footprint).sum()) for one in moved]
    best = int(np.argmax(shared)) if shared else 0
    return best if shared and shared[best] >= 4 else None


def _describe_change(
    region: ChangedRegion,
    one: _MovedObject | None,
    other: _MovedObject | None,
    on: ObjectComparison,
) -> ObjectChange:
    """Return what became of a place that changed."""
    before, after = region.before, region.after
    if one is not None and other is not None:
        status: Status = "grown" if other.side * region.change > 0 else "shrunk"
        cells = (one.footprint | other.footprint) & on.difference.both
        at_top = _at_top(cells, other.side, on.places, on) if cells.any() else region
        if at_top.change * region.change > 0 and abs(at_top.change) >= on.options.min_change_m:
            region = replace(at_top, p_value=min(at_top.p_value, region.p_value))
    elif _stood_in_both(before, after):
        status = "grown" if abs(after) > abs(before) else "shrunk"
    elif other is not None or (one is None and abs(after) >= abs(before)):
        status = "new"
    else:
        status = "gone"
    row = _row(status, region, one, other, on)
    return _with_whole_height(row) if status in ("new", "gone") else row


def _with_whole_height(row: ObjectChange) -> ObjectChange:
    """Return what came or went with its whole height as change: the median over the top of a dome
    is less.
    """
    change, sigma = (
        row.height_after - row.height_before,
        np.hypot(row.height_before_sigma, row.height_after_sigma),
    )
    return (
        replace(row, change=change, change_sigma=float(sigma))
        if np.isfinite(change + sigma)
        else row
    )


def _stood_in_both(before: float, after: float) -> bool:
    """Return whether a structure with one of these heights stood in the other survey too."""
    return before * after > 0 and min(abs(before), abs(after)) >= THERE_SHARE * max(
        abs(before), abs(after)
    )


def _describe_rest(
    one: _MovedObject | None, other: _MovedObject | None, compared: int, on: ObjectComparison
) -> ObjectChange:
    """Return what became of an object at which no region changed by more than any place of the hull
    may; compared: how many objects and pairs both surveys list. What one survey alone lists may be
    new or gone by that smaller number of places.
    """
    there = [p for p in (one, other) if p is not None]
    footprint = np.logical_or.reduce([p.footprint for p in there])
    unseen: Status | None = None
    if other is None and _seen_share(footprint, on.difference.second, on) < SEEN_SHARE:
        unseen = "not seen again"
    if one is None and _seen_share(footprint, on.difference.first, on) < SEEN_SHARE:
        unseen = "not seen before"
    cells = footprint & on.difference.both
    if unseen is not None or not cells.any():
        return _row(unseen or "unchanged", None, one, other, on)
    region = _at_top(cells, there[0].side, compared, on)
    certain = (
        region.p_value <= on.options.max_p_value and abs(region.change) >= on.options.min_change_m
    )
    if certain and len(there) == 1:
        return _describe_change(region, one, other, on)
    status: Status = "unchanged"
    if certain:
        status = "grown" if there[0].side * region.change > 0 else "shrunk"
    elif len(there) == 1 and not _stood_in_both(region.before, region.after):
        status = "uncertain"
    return _row(status, region, one, other, on)


def _at_top(cells: Mask, side: float, places: int, on: ObjectComparison) -> ChangedRegion:
    """Return what an object changed by where it was a top before and after: edges may be drawn
    elsewhere.
    """
    tops = [
        top_of(relief.height, cells, side) for relief in (on.difference.first, on.difference.second)
    ]
    both = tops[0] & tops[1]
    return measure(
        on.difference, cells, both if both.any() else tops[0] | tops[1], places, on.options
    )


def _seen_share(footprint: Mask, relief: Relief, on: ObjectComparison) -> float:
    """Return the share of a footprint at which a survey would have shown a structure."""
    return float(well_seen(relief, on.options)[footprint].mean()) if footprint.any() else 0.0


def _row(
    status: Status,
    region: ChangedRegion | None,
    one: _MovedObject | None,
    other: _MovedObject | None,
    on: ObjectComparison,
) -> ObjectChange:
    moved = other if other is not None else one
    surface = (np.nan, np.nan) if region is None else (region.before, region.after)
    before, after = (
        _height(p, height, region) for p, height in zip((one, other), surface, strict=True)
    )
    if moved is None:
        assert region is not None
        at = on.lattice.points()[region.top].mean(axis=0)
        center, outline = on.chart.from_chart(at[None])[0][0], on.lattice.outline(region.cells)
    else:
        at, center, outline = moved.along_girth, moved.center, moved.outline
    return ObjectChange(
        status=status,
        first_id=None if one is None else one.found.id,
        second_id=None if other is None else other.found.id,
        center=center,
        along_girth=at,
        outline=outline,
        height_before=before[0],
        height_after=after[0],
        height_before_sigma=before[1],
        height_after_sigma=after[1],
        change=np.nan if region is None else region.change,
        change_sigma=np.nan if region is None else region.sigma,
        p_value=np.nan if region is None else region.p_value,
        area=np.nan if region is None else float(region.cells.sum() * on.options.cell_m**2),
        sigma=_position_sigma(center, moved, on),
    )


def _height(
    moved: _MovedObject | None, surface: float, region: ChangedRegion | None
) -> tuple[float, float]:
    """Return a height and its sigma, m: as the survey lists its object; of one that it does not
    list, that of its surface, which is known no worse than the change.
    """
    if moved is not None and moved.found.height_sigma is not None:
        return moved.found.height, moved.found.height_sigma
    sigma = np.nan if region is None or not np.isfinite(surface) else region.sigma
    return (surface if moved is None else moved.found.height), sigma


def _position_sigma(center: Array, moved: _MovedObject | None, on: ObjectComparison) -> Array:
    """Return one sigma (3,) m of a place: as delivered with its object, else as the surveys' hull
    poses leave it.
    """
    found = None if moved is None else moved.found
    if found is not None and None not in (found.sigma_along, found.sigma_girth, found.sigma_normal):
        return np.array([found.sigma_along, found.sigma_girth, found.sigma_normal], float)
    axes = [axis[0] for axis in tangents_at(on.chart, center[None])]
    axes.append(np.cross(axes[1], axes[0]))
    rows = np.concatenate(
        [np.stack(axes), np.cross(center - on.offset.center, np.stack(axes))], axis=1
    )
    return np.asarray(
        np.sqrt(0.5 * np.einsum("ni,ij,nj->n", rows, on.offset.prior_covariance, rows))
    )


def _join_parts(rows: Sequence[ObjectChange]) -> list[ObjectChange]:
    """Return one row an object: of several parts of it that changed, the largest."""
    kept: dict[object, ObjectChange] = {}
    for k, row in enumerate(rows):
        key = (row.first_id, row.second_id) if (row.first_id, row.second_id) != (None, None) else k
        if key not in kept or row.area > kept[key].area:
            kept[key] = row
    return list(kept.values())
