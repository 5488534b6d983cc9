# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The chart of a bent hull without a CAD model: a general cylinder, unrolled.

A survey around a bilge, a keel or a stem turns by more than a plane can show without stretching.
Such a hull is nearly straight in one direction and bent in the other. The chart is a cylinder over
a plane curve, the profile. One of its coordinates is the arc length on the profile.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, make_smoothing_spline
from scipy.sparse.csgraph import minimum_spanning_tree, shortest_path

from hullrecon.geometry.charts.plane_chart import SHIP_AXES_IN_G, PlaneChart
from hullrecon.geometry.neighbours import nearest
from hullrecon.typing import Array

MOST_STRETCH = 1.1  # stretch of a map on a plane, beyond which the hull is unrolled
FEW = 0.02  # share of cells that may be stretched more, as structures have steep sides
CELL_M = 0.2  # side of the cells in which points are averaged
NEIGHBOURS = 12  # cells to which a normal is fitted
# Least width of the neighbours, as a share of their length: on a line they give no normal
LEAST_WIDTH = 0.2
FEWEST = 50  # least number of cells that show the hull's shape
NEAR_CELLS = 2.5  # largest distance, in cells, of neighbours on the profile
SMOOTH_M = 0.3  # shorter bends of the profile are smoothed away
STEP_M = 0.1  # between the profile's knots
ROUNDS = 6  # times that the profile is smoothed, and arc lengths are measured on it again
NEWTON_STEPS = 8  # steps from the nearest knot to the foot of a point
LEAST_TURN = 0.3  # lower limit of a Newton step's divisor, 1 - height / radius of curvature


@dataclass(frozen=True)
class _Profile:
    """A smooth plane curve as a function of its arc length, straight beyond its ends."""

    arc: Array  # (k,) m, arc lengths of the knots, ascending
    knots: Array  # (k, 2) m

    @cached_property
    def _curve(self) -> CubicSpline:
        return CubicSpline(self.arc, self.knots)

    def at(self, arc: Array) -> tuple[Array, Array, Array]:
        """Compute points, unit tangents and curvature vectors (n, 2) at arc lengths (n,) m.

        Beyond its ends the curve goes on straight.
        """
        inside = np.clip(arc, self.arc[0], self.arc[-1])
        beyond = arc - inside
        slope = self._curve(inside, 1)
        speed = np.linalg.norm(slope, axis=1, keepdims=True)
        tangent = slope / speed
        bend = np.where((beyond == 0)[:, None], self._curve(inside, 2) / speed**2, 0.0)
        return self._curve(inside) + tangent * beyond[:, None], tangent, bend

    def foot(self, points: Array) -> tuple[Array, Array]:
        """Project points (n, 2) onto the curve, by Newton steps from the nearest knot.

        Returns the arc lengths (n,) m of their feet, and their heights (n,) m to the left of it.
        """
        arc = self.arc[nearest(self.knots, points, 1)[1][:, 0]]
        for _ in range(NEWTON_STEPS):
            foot, tangent, bend = self.at(arc)
            off = points - foot
            # Beyond the centre of curvature a point has no foot, and the divisor is not positive.
            # It is kept above LEAST_TURN, so that steps stay short there.
            turn = np.maximum(1.0 - (off * bend).sum(axis=1), LEAST_TURN)
            arc = arc + (off * tangent).sum(axis=1) / turn
        foot, tangent, _ = self.at(arc)
        return arc, ((points - foot) * _left_of(tangent)).sum(axis=1)


@dataclass(frozen=True)
class CylinderChart:
    """A general cylinder as chart, in the frame of its points (g)."""

    origin: Array  # (3,) m
    axes: Array  # (3, 3) rows along, girth, outward, as the plane through the survey has them
    bent: int  # the coordinate that follows the profile: 0 along, 1 girth
    arc: Array  # (k,) m of the profile's knots, growing, 0 at the origin's foot
    profile: Array  # (k, 2) m, the knots along axes[bent] and outward from the origin

    @property
    def ship_axes(self) -> Array:
        """See `Chart`."""
        return SHIP_AXES_IN_G

    @property
    def along_of_origin(self) -> float:
        """See `Chart`."""
        return float(self.to_chart(np.zeros((1, 3)))[0, 0])

    @cached_property
    def _profile(self) -> _Profile:
        return _Profile(self.arc, self.profile)

    def to_chart(self, points: Array) -> Array:
        """Compute along, girth and offset (n, 3) m of points (n, 3) m.

        Points are projected onto the profile. The other coordinate is straight.
        """
        local = (np.atleast_2d(np.asarray(points, float)) - self.origin) @ self.axes.T
        out = np.full(local.shape, np.nan)
        known = np.isfinite(local).all(axis=1)
        out[known, self.bent], out[known, 2] = self._profile.foot(local[known][:, [self.bent, 2]])
        out[known, 1 - self.bent] = local[known, 1 - self.bent]
        return out

    def from_chart(self, along_girth: Array) -> tuple[Array, Array]:
        """Find the points and outward normals (n, 3) at along and girth (n, 2) m.

        One of the two coordinates is the arc length on the profile.
        """
        at = np.atleast_2d(np.asarray(along_girth, float))
        points, normals = np.full((len(at), 3), np.nan), np.full((len(at), 3), np.nan)
        known = np.isfinite(at).all(axis=1)
        local, outward = np.zeros((known.sum(), 3)), np.zeros((known.sum(), 3))
        local[:, [self.bent, 2]], tangent, _ = self._profile.at(at[known, self.bent])
        local[:, 1 - self.bent] = at[known, 1 - self.bent]
        outward[:, [self.bent, 2]] = _left_of(tangent)
        points[known], normals[known] = self.origin + local @ self.axes, outward @ self.axes
        return points, normals

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        """Collect the arrays that `from_arrays` reads."""
        return {
            "kind": np.asarray("cylinder"),
            "origin": self.origin,
            "axes": self.axes,
            "bent": np.asarray(self.bent),
            "arc": self.arc,
            "profile": self.profile,
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[np.generic]]) -> CylinderChart:
        """Rebuild the chart from the arrays of `to_arrays`."""
        origin, axes, arc, profile = (
            np.asarray(arrays[name], float) for name in ("origin", "axes", "arc", "profile")
        )
        return cls(origin, axes, int(arrays["bent"]), arc, profile)


def unroll(points: Array, sensors: Array, plane: PlaneChart) -> CylinderChart | None:
    """Fit a general cylinder where a plane would stretch the map.

    Parameters
    ----------
    points
        Points (n, 3) m on the hull, in the plane's frame.
    sensors
        Positions (s, 3) m of the sensors that saw them. They show which side is outside.
    plane
        The plane fitted to the points, whose origin and directions the cylinder keeps.

    Returns
    -------
    CylinderChart or None
        None where a plane is good enough, or where points are too few to tell.
    """
    cells = _average_in_cells(points[np.isfinite(points).all(axis=1)])
    if len(cells) < FEWEST:
        return None
    cells, normal = _fit_normals(cells, sensors)
    # A plane stretches hull by one over the cosine between the two normals
    if (normal @ plane.axes[2] < 1.0 / MOST_STRETCH).sum() <= FEW * len(cells):
        return None
    axes, bent = _straight_and_bent(normal, plane)
    across = [bent, 2]
    in_section = ((cells - plane.origin) @ axes.T)[:, across]
    profile = _fit_profile(in_section, (normal @ axes.T)[:, across])
    chart = CylinderChart(plane.origin, axes, bent, _arc(profile), profile)
    return replace(chart, arc=chart.arc - chart.to_chart(plane.origin)[0, bent])


def _average_in_cells(points: Array) -> Array:
    """Average points (n, d) in cells of CELL_M, so that denser legs do not count more."""
    _, cell, count = np.unique(
        np.floor(points / CELL_M), axis=0, return_inverse=True, return_counts=True
    )
    sums = [np.bincount(cell.reshape(-1), column) for column in points.T]
    return np.stack(sums, axis=1) / count[:, None]


def _fit_normals(cells: Array, sensors: Array) -> tuple[Array, Array]:
    """Fit a plane to the neighbours of each cell: unit normals towards the nearest sensor.

    Returns cells and normals (k, 3), without the cells whose neighbours lie on a line.

    cells (n, 3), sensors (s, 3): positions, m.
    """
    # The direction of least spread of the neighbours is the normal. On a line there are two such.
    around = cells[nearest(cells, cells, NEIGHBOURS)[1]]
    around = around - around.mean(axis=1, keepdims=True)
    spread, direction = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))
    known = spread[:, 1] > LEAST_WIDTH**2 * spread[:, 2]
    cells, normal = cells[known], direction[known, :, 0]
    toward = sensors[nearest(sensors, cells, 1)[1][:, 0]] - cells
    inward = (normal * toward).sum(axis=1) < 0
    return cells, np.where(inward[:, None], -normal, normal)


def _straight_and_bent(normal: Array, plane: PlaneChart) -> tuple[Array, int]:
    """Find the cylinder's axes (3, 3), and which coordinate is bent, 0 along or 1 girth.

    normal: (n, 3) of the surveyed hull. plane: the plane that fits it best.

    The straight direction of a cylinder is perpendicular to all its normals. It is along, or girth
    where it is steep, as at a stem.
    """
    straight = np.linalg.eigh(normal.T @ normal)[1][:, 0]
    kept = int(abs(straight @ SHIP_AXES_IN_G[2]) > np.cos(np.radians(45.0)))
    # In the direction of the plane's axis, unless the two are nearly perpendicular
    share = straight @ plane.axes[kept]
    straight = straight * np.sign(share if abs(share) > 0.5 else straight[np.argmax(abs(straight))])
    outward = plane.axes[2] - straight * (plane.axes[2] @ straight)
    outward = outward / np.linalg.norm(outward)
    # Left-handed, as every chart: along x girth = -outward
    if kept == 0:
        return np.stack([straight, np.cross(straight, outward), outward]), 1
    return np.stack([np.cross(outward, straight), straight, outward]), 0


def _fit_profile(points: Array, outward: Array) -> Array:
    """Fit a smooth curve, knots (k, 2), to points (n, 2), with outward (n, 2) to its left.

    Smoothing and arc lengths depend on each other, so they are computed in turns.
    """
    arc = _first_arc(points)
    for _ in range(ROUNDS):
        knots = _smooth_curve(points, arc)
        arc = _Profile(_arc(knots), knots).foot(points)[0]
    profile = _Profile(_arc(knots), knots)
    left = _left_of(profile.at(profile.foot(points)[0])[1])
    if (left * outward).sum() < 0:
        knots = knots[::-1]
    return np.ascontiguousarray(knots)


def _first_arc(points: Array) -> Array:
    """Estimate the arc length (n,) m of points (n, 2) along the curve on which they lie.

    The fit of the profile starts from it. On a hull that turns by more than a right angle, no
    straight axis would order the points. It is the shortest path from one end of the curve in a
    graph of the points' cells. Near cells are connected, and gaps are bridged by the edges of the
    minimum spanning tree. The cell farthest from an arbitrary cell is an end.
    """
    cells = _average_in_cells(points)
    apart = np.linalg.norm(cells[:, None] - cells[None], axis=2)
    bridges = minimum_spanning_tree(apart).toarray()
    steps = np.where((apart <= NEAR_CELLS * CELL_M) | (bridges > 0) | (bridges.T > 0), apart, 0.0)
    from_any = shortest_path(steps, indices=0)
    from_end = shortest_path(steps, indices=int(np.argmax(from_any)))
    return np.asarray(from_end[nearest(cells, points, 1)[1][:, 0]])


def _smooth_curve(points: Array, arc: Array) -> Array:
    """Fit a smoothing spline to points (n, 2) over arc lengths (n,): knots (k, 2) STEP_M apart.

    Structures on the hull and noise of the points must not bend the chart.
    """
    # Medians of pieces STEP_M long, the spline through them, and points even in its own arc length
    bins = np.floor(arc / STEP_M)
    at = np.unique(bins)
    middle = np.array([np.median(np.c_[arc, points][bins == b], axis=0) for b in at])
    # Of points STEP_M apart, this stiffness lets bends of SMOOTH_M pass
    stiffness = SMOOTH_M**4 / STEP_M
    fine = np.linspace(middle[0, 0], middle[-1, 0], 4 * len(at) + 1)
    curve = np.stack(
        [
            make_smoothing_spline(middle[:, 0], column, lam=stiffness)(fine)
            for column in middle[:, 1:].T
        ],
        axis=1,
    )
    length = _arc(curve)
    even = np.linspace(0.0, length[-1], max(4, int(np.ceil(length[-1] / STEP_M))))
    return np.stack([np.interp(even, length, column) for column in curve.T], axis=1)


def _arc(curve: Array) -> Array:
    """Measure the length (k,) m along a polyline (k, 2)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))])


def _left_of(tangent: Array) -> Array:
    """Turn tangents (n, 2) by a quarter turn to the left: from the profile outward."""
    return np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
