# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Objects of two surveys compared: which are the same, new, gone, grown or shrunk."""

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
MIDDLE_SHARE = 0.1  # of an object's size, by which its middle may differ between two surveys
MIDDLE_M = 0.02
THERE_SHARE = 0.5  # of a structure's height, which the other survey must reach to have it too
SEEN_SHARE = 0.5  # of a footprint that must have been looked at


@dataclass(frozen=True, kw_only=True)
class _MovedObject:
    """An object in the first survey's frame."""

    found: ReportedObject
    center: Array  # (3,)
    along_girth: Array  # of its center on the chart
    outline: Array  # (k, 2)
    footprint: Mask  # (a, g) on the lattice

    @property
    def side(self) -> float:
        """1 for a raised object, -1 for a recess."""
        return 1.0 if self.found.height >= 0 else -1.0


@dataclass(frozen=True, kw_only=True)
class ObjectComparison:
    """The surveys' difference, on which objects are compared."""

    chart: Chart
    lattice: Lattice
    offset: SurveyOffset
    difference: Difference
    options: ChangeOptions
    places: int  # number of places of the hull that were tested


def compare_objects(
    first: HullSurvey,
    second: HullSurvey,
    regions: Sequence[ChangedRegion],
    context: ObjectComparison,
) -> tuple[ObjectChange, ...]:
    """Compare the objects of both surveys, and regions that changed without an object.

    The rows are sorted by status, then by size of the change.
    """
    before = [_move_object(found, context, identity()) for found in first.objects]
    after = [
        _move_object(found, context, context.offset.first_from_second) for found in second.objects
    ]
    # First what stands where the hull changed.
    pairs = match_objects(before, after, context)
    rows: list[ObjectChange] = []
    for region in regions:
        for a, b in _objects_at(
            _nearest(region, before, context), _nearest(region, after, context), pairs
        ):
            old = None if a is None else before[a]
            new = None if b is None else after[b]
            rows.append(_describe_change(region, old, new, context))
    rows = _join_parts(rows)
    # Then the pairs and single objects at which no change was found.
    known = ({row.first_id for row in rows}, {row.second_id for row in rows})
    left = [(a, pairs.get(a)) for a in range(len(before))] + [
        (None, b) for b in range(len(after)) if b not in pairs.values()
    ]
    compared = len(left)
    for a, b in left:
        old = None if a is None else before[a]
        new = None if b is None else after[b]
        if (old and old.found.id in known[0]) or (new and new.found.id in known[1]):
            continue
        rows.append(_describe_rest(old, new, compared, context))
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


def _objects_at(
    a: int | None, b: int | None, pairs: dict[int, int]
) -> list[tuple[int | None, int | None]]:
    """Resolve which objects a changed region belongs to: a matched pair, or objects of one survey.

    Parameters
    ----------
    a
        Object of the first survey under the region, None without an object.
    b
        Object of the second survey.
    pairs
        Matched objects, second by first.
    """
    back = {second: first for first, second in pairs.items()}
    if a is not None and b is not None and pairs.get(a) != b:
        # two objects that are not one: those without a partner elsewhere came or went here
        alone: list[tuple[int | None, int | None]] = [(a, None)] if a not in pairs else []
        alone += [(None, b)] if b not in back else []
        return alone or [(a, pairs[a])]
    # one object, or none: with its partner, which the region may have missed
    return [
        (
            a if a is not None or b is None else back.get(b),
            b if b is not None or a is None else pairs.get(a),
        )
    ]


def match_objects(
    before: Sequence[_MovedObject], after: Sequence[_MovedObject], context: ObjectComparison
) -> dict[int, int]:
    """Pair objects of both surveys by the chi-square of their distance, inside the gate.

    Raised objects match raised objects, recesses match recesses. The best pairs are taken first.
    """
    candidates = sorted(_candidates(before, after, context))
    pairs: dict[int, int] = {}
    for _, a, b in candidates:
        if a not in pairs and b not in pairs.values():
            pairs[a] = b
    return pairs


def _candidates(
    before: Sequence[_MovedObject], after: Sequence[_MovedObject], context: ObjectComparison
) -> Iterator[tuple[float, int, int]]:
    """Yield the pairs (chi-square, row before, row after) that may be one object by their distance.

    The distance is measured along the hull and in girth. Its sigma is that of both middles and of
    the offset between the surveys.
    """
    for a, old in enumerate(before):
        if not np.isfinite(old.along_girth).all():
            continue
        tangents = [axis[0] for axis in tangents_at(context.chart, old.center[None])]
        for b, new in enumerate(after):
            size = max(*old.found.extent, *new.found.extent)
            if old.side != new.side or np.linalg.norm(old.center - new.center) > 2 * size + 0.5:
                continue
            own = np.hypot(MIDDLE_M, MIDDLE_SHARE * size)
            shared = offset_sigma(context.offset, np.stack([old.center] * 2), np.stack(tangents))
            gap = np.array([axis @ (new.center - old.center) for axis in tangents])
            chi_square = float((gap**2 / (own**2 + shared**2)).sum())
            if np.isfinite(chi_square) and chi_square <= GATE:
                yield chi_square, a, b


def _move_object(found: ReportedObject, context: ObjectComparison, motion: Poses) -> _MovedObject:
    """Place an object on the chart after a motion."""
    center = motion.apply(np.array([found.center], float))[0]
    ring = motion.apply(np.array(found.outline, float)) if len(found.outline) else np.zeros((0, 3))
    outline = context.chart.to_chart(ring)[:, :2] if len(ring) else np.zeros((0, 2))
    outline = outline[np.isfinite(outline).all(axis=1)]
    at = context.chart.to_chart(center[None])[0, :2]
    footprint = context.lattice.polygon(outline)
    if not footprint.any() and np.isfinite(at).all():
        footprint = np.linalg.norm(context.lattice.points() - at, axis=-1) <= max(
            0.5 * max(found.extent), context.lattice.step_m
        )
    return _MovedObject(
        found=found, center=center, along_girth=at, outline=outline, footprint=footprint
    )


def _nearest(
    region: ChangedRegion, moved: Sequence[_MovedObject], context: ObjectComparison
) -> int | None:
    """Find the object that a region overlaps most, with a margin for edges.

    None if they share fewer than four cells.
    """
    from scipy.ndimage import binary_dilation

    wide = binary_dilation(
        region.cells, iterations=max(1, round(context.options.edge_m / context.options.cell_m))
    )
    shared = [int((wide & candidate.footprint).sum()) for candidate in moved]
    best = int(np.argmax(shared)) if shared else 0
    return best if shared and shared[best] >= 4 else None


def _describe_change(
    region: ChangedRegion,
    old: _MovedObject | None,
    new: _MovedObject | None,
    context: ObjectComparison,
) -> ObjectChange:
    """Describe what became of a place that changed.

    An object in both surveys, or relief of similar height in both, has grown or shrunk. Else it is
    new or gone.
    """
    before, after = region.before, region.after
    if old is not None and new is not None:
        status: Status = "grown" if new.side * region.change > 0 else "shrunk"
        cells = (old.footprint | new.footprint) & context.difference.both
        # The object's top tells its change best: its edges may be drawn differently in each survey.
        # The region has shown already that something changed, so its p-value stands if smaller.
        at_top = _at_top(cells, new.side, context.places, context) if cells.any() else region
        if at_top.change * region.change > 0 and abs(at_top.change) >= context.options.min_change_m:
            region = replace(at_top, p_value=min(at_top.p_value, region.p_value))
    elif _stood_in_both(before, after):
        status = "grown" if abs(after) > abs(before) else "shrunk"
    elif new is not None or (old is None and abs(after) >= abs(before)):
        status = "new"
    else:
        status = "gone"
    row = _row(status, region, old, new, context)
    return _with_whole_height(row) if status in ("new", "gone") else row


def _with_whole_height(row: ObjectChange) -> ObjectChange:
    """Take the whole height of what came or went as its change.

    The median over the top of a dome would be less.
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
    """Test whether a structure of similar height stood in both surveys."""
    return before * after > 0 and min(abs(before), abs(after)) >= THERE_SHARE * max(
        abs(before), abs(after)
    )


def _describe_rest(
    old: _MovedObject | None, new: _MovedObject | None, compared: int, context: ObjectComparison
) -> ObjectChange:
    """Test an object once more at its own top, where no changed region was found.

    The search over all places has to be strict. Here the p-value is corrected for the number of
    objects only, so a change may be found yet: an object of one survey is new or gone, one of both
    has grown or shrunk. Else it is unchanged, not seen in the other survey, or, where that survey
    saw its place but does not show it standing, uncertain.

    Parameters
    ----------
    old
        Object of the first survey, None without.
    new
        Object of the second survey, None without.
    compared
        Number of objects and pairs in either survey.
    """
    there = [p for p in (old, new) if p is not None]
    footprint = np.logical_or.reduce([p.footprint for p in there])
    unseen: Status | None = None
    if new is None and _seen_share(footprint, context.difference.second, context) < SEEN_SHARE:
        unseen = "not seen again"
    if old is None and _seen_share(footprint, context.difference.first, context) < SEEN_SHARE:
        unseen = "not seen before"
    cells = footprint & context.difference.both
    if unseen is not None or not cells.any():
        return _row(unseen or "unchanged", None, old, new, context)
    region = _at_top(cells, there[0].side, compared, context)
    certain = (
        region.p_value <= context.options.max_p_value
        and abs(region.change) >= context.options.min_change_m
    )
    if certain and len(there) == 1:
        return _describe_change(region, old, new, context)
    status: Status = "unchanged"
    if certain:
        status = "grown" if there[0].side * region.change > 0 else "shrunk"
    elif len(there) == 1 and not _stood_in_both(region.before, region.after):
        status = "uncertain"
    return _row(status, region, old, new, context)


def _at_top(cells: Mask, side: float, places: int, context: ObjectComparison) -> ChangedRegion:
    """Measure an object's change where both surveys have its top.

    Elsewhere its edges may be drawn differently.
    """
    tops = [
        top_of(relief.height, cells, side)
        for relief in (context.difference.first, context.difference.second)
    ]
    both = tops[0] & tops[1]
    return measure(
        context.difference,
        cells,
        both if both.any() else tops[0] | tops[1],
        places,
        context.options,
    )


def _seen_share(footprint: Mask, relief: Relief, context: ObjectComparison) -> float:
    """Compute the share of a footprint at which a survey would have shown a structure."""
    return float(well_seen(relief, context.options)[footprint].mean()) if footprint.any() else 0.0


def _row(
    status: Status,
    region: ChangedRegion | None,
    old: _MovedObject | None,
    new: _MovedObject | None,
    context: ObjectComparison,
) -> ObjectChange:
    """Make the row of an object: place, outline, heights before and after, and the change.

    `region`: where the hull changed, None for an object at which it did not. `old`, `new`: the
    object in either survey, None where it was not found.
    """
    moved = new if new is not None else old
    surface = (np.nan, np.nan) if region is None else (region.before, region.after)
    before, after = (
        _height(p, height, region) for p, height in zip((old, new), surface, strict=True)
    )
    if moved is None:
        assert region is not None
        at = context.lattice.points()[region.top].mean(axis=0)
        center, outline = (
            context.chart.from_chart(at[None])[0][0],
            context.lattice.outline(region.cells),
        )
    else:
        at, center, outline = moved.along_girth, moved.center, moved.outline
    return ObjectChange(
        status=status,
        first_id=None if old is None else old.found.id,
        second_id=None if new is None else new.found.id,
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
        area=np.nan if region is None else float(region.cells.sum() * context.options.cell_m**2),
        sigma=_position_sigma(center, moved, context),
    )


def _height(
    moved: _MovedObject | None, surface: float, region: ChangedRegion | None
) -> tuple[float, float]:
    """Choose height and sigma, m, of the object, else of the surface there.

    Without a sigma of its own, a height has the sigma of the change.
    """
    if moved is not None and moved.found.height_sigma is not None:
        return moved.found.height, moved.found.height_sigma
    sigma = np.nan if region is None or not np.isfinite(surface) else region.sigma
    return (surface if moved is None else moved.found.height), sigma


def _position_sigma(center: Array, moved: _MovedObject | None, context: ObjectComparison) -> Array:
    """Choose one sigma (3,) m of a place along, in girth and along the normal.

    It is the object's, else that of a hull pose: half the offset's prior covariance, which is the
    sum of both hull poses'.
    """
    found = None if moved is None else moved.found
    if found is not None and None not in (found.sigma_along, found.sigma_girth, found.sigma_normal):
        return np.array([found.sigma_along, found.sigma_girth, found.sigma_normal], float)
    axes = [axis[0] for axis in tangents_at(context.chart, center[None])]
    axes.append(np.cross(axes[1], axes[0]))
    # how far a hull that moves and turns (6,) carries the place along each axis
    rows = np.concatenate(
        [np.stack(axes), np.cross(center - context.offset.center, np.stack(axes))], axis=1
    )
    return np.asarray(
        np.sqrt(0.5 * np.einsum("ni,ij,nj->n", rows, context.offset.prior_covariance, rows))
    )


def _join_parts(rows: Sequence[ObjectChange]) -> list[ObjectChange]:
    """Keep one row per object: of several changed parts, the largest."""
    kept: dict[object, ObjectChange] = {}
    for k, row in enumerate(rows):
        key = (row.first_id, row.second_id) if (row.first_id, row.second_id) != (None, None) else k
        if key not in kept or row.area > kept[key].area:
            kept[key] = row
    return list(kept.values())
