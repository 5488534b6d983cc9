# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The chart of a dive without a CAD model: a plane fitted to the surveyed points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.errors import InputError
from hullrecon.geometry.robust import NORMAL_MAD
from hullrecon.typing import Array, Mask

SHIP_AXES_IN_G = np.diag([1.0, -1.0, -1.0])  # rows forward, port, up: z of g is down
ROUNDS = 5  # of fitting and leaving outliers out
TRIALS = 200  # random planes through three points
# A plane is level, not steep, if its normal is within 30 degrees of the vertical
STEEP = np.cos(np.radians(30.0))


@dataclass(frozen=True)
class PlaneChart:
    """A plane as chart, in the frame of its points (g)."""

    origin: Array  # (3,) m
    axes: Array  # (3, 3) rows along, girth, outward normal, with along x girth = -normal

    @property
    def ship_axes(self) -> Array:
        """See `Chart`."""
        return SHIP_AXES_IN_G

    @property
    def along_of_origin(self) -> float:
        """See `Chart`."""
        return float(-self.origin @ self.axes[0])

    def to_chart(self, points: Array) -> Array:
        """Project points onto the plane. See `Chart.to_chart`."""
        return np.asarray((np.atleast_2d(points) - self.origin) @ self.axes.T)

    def from_chart(self, along_girth: Array) -> tuple[Array, Array]:
        """Compute the points (n, 3) of the plane at along and girth (n, 2) m, and its normals."""
        at = np.atleast_2d(np.asarray(along_girth, float))
        points = self.origin + at @ self.axes[:2]
        normals = np.tile(self.axes[2], (len(at), 1))
        normals[~np.isfinite(at).all(axis=1)] = np.nan
        return points, normals

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        """Collect the arrays that `from_arrays` reads."""
        return {"kind": np.asarray("plane"), "origin": self.origin, "axes": self.axes}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[np.generic]]) -> PlaneChart:
        """Rebuild the chart from the arrays of `to_arrays`."""
        return cls(np.asarray(arrays["origin"], float), np.asarray(arrays["axes"], float))


def fit_plane_chart(points: Array, toward: Array, up: Array) -> PlaneChart:
    """Fit a plane to points (n, 3) in g, robustly.

    A least-median plane is the start. Then the principal plane is fitted to points within 3 robust
    sigma of the last plane, repeatedly.

    Parameters
    ----------
    points
        (n, 3) m. NaN points are left out.
    toward
        Point (3,) on the side to which the normal points.
    up
        Upward direction (3,) in the points' frame, in which girth grows on a steep plane.

    Raises
    ------
    InputError
        With fewer than three finite points.
    """
    usable = points[np.isfinite(points).all(axis=1)]
    if len(usable) < 3:
        raise InputError("a plane needs three points", where=f"{len(usable)} given")
    kept = usable[_inliers(_least_median_plane(usable))]
    for _ in range(ROUNDS):
        center, directions = _principal(kept)
        kept = usable[_inliers((usable - center) @ directions[2])]
    center, directions = _principal(kept)
    normal = directions[2] if (toward - center) @ directions[2] >= 0 else -directions[2]
    girth = _girth_axis(normal, directions[0], up / np.linalg.norm(up))
    # Left-handed, as every chart: along x girth = -normal
    return PlaneChart(center, np.stack([np.cross(normal, girth), girth, normal]))


def _inliers(off: Array) -> Mask:
    """Tell which offsets (n,) m from a plane are within 3 robust sigma of their median.

    The three nearest to the median always are.
    """
    away = np.abs(off - np.median(off))
    return np.asarray(
        away <= max(3 * NORMAL_MAD * float(np.median(away)), float(np.sort(away)[2]), 1e-9)
    )


def _least_median_plane(points: Array) -> Array:
    """Compute the heights (n,) of points over the least-median plane, of TRIALS random ones.

    Each of these goes through three of the points. Zeros where all triples lie on a line.
    """
    corner = points[np.random.default_rng(0).integers(0, len(points), (TRIALS, 3))]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    size = np.linalg.norm(normal, axis=1)
    normal = normal[size > 1e-12] / size[size > 1e-12, None]
    if not len(normal):
        return np.zeros(len(points))
    some = points[np.linspace(0, len(points) - 1, min(len(points), 2000)).astype(int)]
    # How far each plane lies from zero along its normal. Some of the points are enough to judge it.
    level = np.einsum("ni,ni->n", corner[size > 1e-12, 0], normal)
    best = int(np.argmin(np.median(np.abs(some @ normal.T - level), axis=0)))
    return np.asarray(points @ normal[best] - level[best])


def _principal(points: Array) -> tuple[Array, Array]:
    """Compute the mean (3,) and principal directions of points (n, 3): rows (3, 3), longest first.

    The largest component of each is made positive, as an eigenvector's sign is arbitrary.
    """
    center = points.mean(axis=0)
    _, vectors = np.linalg.eigh((points - center).T @ (points - center))
    rows = vectors.T[::-1]
    signs = np.sign(rows[np.arange(3), np.argmax(np.abs(rows), axis=1)])
    return center, rows * signs[:, None]


def _girth_axis(normal: Array, longest: Array, up: Array) -> Array:
    """Choose the unit vector of girth in a plane.

    It points uphill if the plane is steep, otherwise across the survey's longest direction.
    """
    rough = up if abs(normal @ up) < STEEP else np.cross(longest, normal)
    flat = rough - normal * (rough @ normal)
    return np.asarray(flat / np.linalg.norm(flat))
