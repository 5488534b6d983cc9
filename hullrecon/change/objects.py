# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Objects of two surveys compared: which are the same, new, gone, grown or shrunk."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hullrecon.change.difference import (
    ChangedRegion,
    Difference,
    measure_change,
    top_of,
    well_seen,
)
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

# Largest chi-square of the distance between two objects that may be one: 99.9 % of chi-square with
# two degrees of freedom
GATE = 13.8
# Sigma of an object's centre between two surveys: a share of its size, and at least this
MIDDLE_SHARE = 0.1
MIDDLE_M = 0.02
THERE_SHARE = 0.5  # least ratio of the heights of two surveys that both have the structure
SEEN_SHARE = (
    0.5  # least share of a footprint that a survey must have seen to say that nothing is there
)


@dataclass(frozen=True, kw_only=True)
class _MovedObject:
    """An object in the first survey's frame."""

    found: ReportedObject
    center: Array  # (3,) m in M
    along_girth: Array  # (2,) m, of its center on the chart; NaN off it
    outline: Array  # (k, 2) m along and in girth; (0, 2): none on the chart
    footprint: Mask  # (a, g) on the lattice

    @property
    def sign(self) -> float:
        """+1 for a raised object, -1 for a recess."""
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

    First each region that changed is explained by the objects there. Then all other objects are
    compared at their own tops. The rows are sorted by status, then by size of the change.

    Parameters
    ----------
    first, second
        The surveys, with the objects that each reported.
    regions
        Regions in which structures changed.
    context
        Difference of the surveys, chart and options.
    """
    before = [_move_object(found, context, identity()) for found in first.objects]
    after = [
        _move_object(found, context, context.offset.first_from_second) for found in second.objects
    ]
    # First the objects at places where the hull changed.
    pairs = match_objects(before, after, context)
    rows: list[ObjectChange] = []
    for region in regions:
        for a, b in _objects_at(
            _object_under(region, before, context), _object_under(region, after, context), pairs
        ):
            old = None if a is None else before[a]
            new = None if b is None else after[b]
            rows.append(_explain_change(region, old, new, context))
    rows = _join_parts(rows)
    # Then the pairs and single objects at which no change was found.
    known = ({row.first_id for row in rows}, {row.second_id for row in rows})
    remaining = [(a, pairs.get(a)) for a in range(len(before))] + [
        (None, b) for b in range(len(after)) if b not in pairs.values()
    ]
    compared = len(remaining)
    for a, b in remaining:
        old = None if a is None else before[a]
        new = None if b is None else after[b]
        if (old and old.found.id in known[0]) or (new and new.found.id in known[1]):
            continue
        rows.append(_compare_at_top(old, new, compared, context))
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
    """Decide which objects a changed region is about: a matched pair, or objects of one survey.

    Parameters
    ----------
    a
        Object of the first survey under the region, None without an object.
    b
        Object of the second survey under it, None without one.
    pairs
        For objects of the first survey the matched one of the second: they are one object.

    Returns
    -------
    objects
        Pairs (object of the first survey, of the second), each None where there is none.
    """
    back = {second: first for first, second in pairs.items()}
    if a is not None and b is not None and pairs.get(a) != b:
        # Two different objects. Those that have no partner elsewhere came or went here.
        alone: list[tuple[int | None, int | None]] = [(a, None)] if a not in pairs else []
        alone += [(None, b)] if b not in back else []
        return alone or [(a, pairs[a])]
    # One object, with its partner, which the region may not overlap, or none.
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

    Returned is the row of the second survey by that of the first. Objects without a partner are
    left out. Raised objects match raised objects, recesses match recesses. The best pairs are taken
    first.
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

    The distance is measured along the hull and in girth. Its sigma holds that of both centres and
    of the offset between the surveys.
    """
    for a, old in enumerate(before):
        if not np.isfinite(old.along_girth).all():
            continue
        tangents = [axis[0] for axis in tangents_at(context.chart, old.center[None])]
        # The two centres' own sigma, the offset's, and how far they lie apart: along, and in girth
        for b, new in enumerate(after):
            size = max(*old.found.extent, *new.found.extent)
            if old.sign != new.sign or np.linalg.norm(old.center - new.center) > 2 * size + 0.5:
                continue
            own = np.hypot(MIDDLE_M, MIDDLE_SHARE * size)
            shared = offset_sigma(context.offset, np.stack([old.center] * 2), np.stack(tangents))
            difference = np.array([axis @ (new.center - old.center) for axis in tangents])
            chi_square = float((difference**2 / (own**2 + shared**2)).sum())
            if np.isfinite(chi_square) and chi_square <= GATE:
                yield chi_square, a, b


def _move_object(found: ReportedObject, context: ObjectComparison, motion: Poses) -> _MovedObject:
    """Move an object by a rigid motion, and project it onto the chart.

    Without an outline on the chart, its footprint is a disc of its extent. It is empty off the
    chart.
    """
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


def _object_under(
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


def _explain_change(
    region: ChangedRegion,
    old: _MovedObject | None,
    new: _MovedObject | None,
    context: ObjectComparison,
) -> ObjectChange:
    """Decide what became of the object at a region that changed.

    An object in both surveys, or relief of similar height in both, has grown or shrunk. Else it is
    new or gone. old, new: the object in either survey, None where it was not found. region: its
    change and heights are in m, outward positive.
    """
    before, after = region.before, region.after
    if old is not None and new is not None:
        status: Status = "grown" if new.sign * region.change > 0 else "shrunk"
        cells = (old.footprint | new.footprint) & context.difference.both
        # The object's top measures its change best: its edges may differ between surveys. That
        # something changed was shown by the region already: the smaller p-value is taken.
        at_top = _measure_top(cells, new.sign, context.places, context) if cells.any() else region
        if at_top.change * region.change > 0 and abs(at_top.change) >= context.options.min_change_m:
            region = replace(at_top, p_value=min(at_top.p_value, region.p_value))
    elif _is_in_both(before, after):
        status = "grown" if abs(after) > abs(before) else "shrunk"
    elif new is not None or (old is None and abs(after) >= abs(before)):
        status = "new"
    else:
        status = "gone"
    row = _row(status, region, old, new, context)
    return _with_whole_height(row) if status in ("new", "gone") else row


def _with_whole_height(row: ObjectChange) -> ObjectChange:
    """Take an object's whole height, before or after, as the change of one that came or went.

    The change as measured is the median over the top, which is less than the height of a dome.
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


def _is_in_both(before: float, after: float) -> bool:
    """Decide whether both surveys show a structure of similar height (m) and sign."""
    return before * after > 0 and min(abs(before), abs(after)) >= THERE_SHARE * max(
        abs(before), abs(after)
    )


def _compare_at_top(
    old: _MovedObject | None, new: _MovedObject | None, compared: int, context: ObjectComparison
) -> ObjectChange:
    """Compare an object at its own top, where no changed region was found.

    The search for regions corrects p-values for all places. Here they are corrected for the number
    of objects only, so that a change may still be found: an object of one survey is new or gone,
    one of both has grown or shrunk. Else it is unchanged, not seen in the other survey, or, if that
    survey saw the place but shows no such structure, uncertain.

    Parameters
    ----------
    old
        Object of the first survey, None without one.
    new
        Object of the second survey, None without one.
    compared
        Number of pairs and single objects, for which the p-value is corrected.
    context
        Difference of the surveys, chart and options.
    """
    there = [p for p in (old, new) if p is not None]
    footprint = np.logical_or.reduce([p.footprint for p in there])
    # An object that only one survey found, where the other one saw too little of the place
    unseen: Status | None = None
    if new is None and _seen_share(footprint, context.difference.second, context) < SEEN_SHARE:
        unseen = "not seen again"
    if old is None and _seen_share(footprint, context.difference.first, context) < SEEN_SHARE:
        unseen = "not seen before"
    cells = footprint & context.difference.both
    if unseen is not None or not cells.any():
        return _row(unseen or "unchanged", None, old, new, context)
    region = _measure_top(cells, there[0].sign, compared, context)
    certain = (
        region.p_value <= context.options.max_p_value
        and abs(region.change) >= context.options.min_change_m
    )
    if certain and len(there) == 1:
        return _explain_change(region, old, new, context)
    status: Status = "unchanged"
    if certain:
        status = "grown" if there[0].sign * region.change > 0 else "shrunk"
    elif len(there) == 1 and not _is_in_both(region.before, region.after):
        status = "uncertain"
    return _row(status, region, old, new, context)


def _measure_top(cells: Mask, sign: float, places: int, context: ObjectComparison) -> ChangedRegion:
    """Measure an object's change at cells that both surveys show as its top.

    At its edges the surveys may differ without a change. cells: (a, g) of the object. sign: +1 for
    a raised object, -1 for a recess. places: number of places, or of objects, that were tested.
    """
    tops = [
        top_of(relief.height, cells, sign)
        for relief in (context.difference.first, context.difference.second)
    ]
    both = tops[0] & tops[1]
    return measure_change(
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
    """Make the row of an object: position, outline, heights before and after, and the change.

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
    """Choose the height and its sigma, m: of the object, else of the surface at the region.

    A height without a sigma of its own gets the sigma of the change. surface: height of the survey
    at the region.
    """
    if moved is not None and moved.found.height_sigma is not None:
        return moved.found.height, moved.found.height_sigma
    sigma = np.nan if region is None or not np.isfinite(surface) else region.sigma
    return (surface if moved is None else moved.found.height), sigma


def _position_sigma(center: Array, moved: _MovedObject | None, context: ObjectComparison) -> Array:
    """Choose the sigmas (3,) m of a position along the hull, in girth and along the normal.

    They are the object's, else those that a hull pose gives the point `center` (3,). The covariance
    of a hull pose is half the offset's prior, which is the sum of both.
    """
    found = None if moved is None else moved.found
    if found is not None and None not in (found.sigma_along, found.sigma_girth, found.sigma_normal):
        return np.array([found.sigma_along, found.sigma_girth, found.sigma_normal], float)
    axes = [axis[0] for axis in tangents_at(context.chart, center[None])]
    # Charts are left-handed, so that girth x along points outward
    axes.append(np.cross(axes[1], axes[0]))
    # Derivatives of the point's position along each axis by translation and rotation of the hull.
    rows = np.concatenate(
        [np.stack(axes), np.cross(center - context.offset.center, np.stack(axes))], axis=1
    )
    return np.asarray(
        np.sqrt(0.5 * np.einsum("ni,ij,nj->n", rows, context.offset.prior_covariance, rows))
    )


def _join_parts(rows: Sequence[ObjectChange]) -> list[ObjectChange]:
    """Keep one row per object: of several regions at one object, that of the largest area.

    Rows of regions without an object are all kept.
    """
    kept: dict[object, ObjectChange] = {}
    for k, row in enumerate(rows):
        key = (row.first_id, row.second_id) if (row.first_id, row.second_id) != (None, None) else k
        if key not in kept or row.area > kept[key].area:
            kept[key] = row
    return list(kept.values())
