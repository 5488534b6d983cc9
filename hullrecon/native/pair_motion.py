# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The motion between two nodes by features that they share: second_from_first (4, 4).

Of their leading cameras. Its six unknowns are (translation in second's axes, rotation vector on the
right). Images are in ideal coordinates, NaN where a camera did not see the feature.
"""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints, Mask


def squared_reprojections(camera_from_points: Array, points: Array, xy: Array) -> Array:
    """Compute squared distances in the image (s, n) of points (n, 3) from xy (n, 2).

    Under each of camera_from_points (s, 4, 4); inf behind the camera, 0 where not seen. Raises
    InputError for shapes that do not fit.
    """
    import hullrecon._native as _native  # compiled; loads the solver's libraries

    squared: Array = _native.squared_reprojections(camera_from_points, points, xy)
    return squared


def normal_of_reprojections(
    motion: Array,
    points: Array,
    xy: Array,
    camera_from_node: Array,
    backward: bool,
    baseline_m: float,
    counts: Mask,
) -> tuple[Array, Array, float]:
    """Sum the normal matrix (6, 6), gradient (6,) and squared error of a motion over points.

    Residuals are whitened by an image's own error and that of the point's depth, z^2 sqrt(2) /
    baseline for each unit of error in the image. Raises InputError for shapes that do not fit.

    Parameters
    ----------
    motion
        (4, 4) second_from_first.
    points
        (n, 3) triangulated in one node.
    xy
        (n, 2) where a camera of the other node saw them.
    camera_from_node
        (4, 4) of that camera.
    backward
        The motion carries the points with its inverse.
    baseline_m
        Of the rig that triangulated them.
    counts
        (n,) points that count.
    """
    import hullrecon._native as _native

    found: tuple[Array, Array, float] = _native.normal_of_reprojections(
        motion, points, xy, camera_from_node, backward, baseline_m, counts
    )
    return found


@dataclass(frozen=True, kw_only=True)
class StereoRows:
    """Residuals of m features in both cameras of two nodes, with derivatives."""

    # (m, 8) leading and bottom camera of the first node, then of the second, two rows each; zero
    # where not seen
    residual: Array
    by_point: Array  # (m, 8, 3)
    by_motion: Array  # (m, 8, 6)
    by_calibration: Array  # (m, 8, 12)


@dataclass(frozen=True, kw_only=True)
class ReducedFeatures(Rows):
    """m features with their points eliminated."""

    information: Array  # (m, 6, 6)
    gradient: Array  # (m, 6)
    cost: Array  # (m,) sum of squares at the best points
    freedom: Ints  # (m,) rows seen, less three
    # (m, 3, 3) this and the next two bring the points along with a step of the motion
    point_inverse: Array
    point_gradient: Array  # (m, 3)
    point_by_motion: Array  # (m, 6, 3)


def linearise_stereo(
    motion: Array, bottom_from_top: Array, field: float, points: Array, seen: Array
) -> StereoRows:
    """Compute the residuals of features with their derivatives.

    Raises InputError for shapes that do not fit.

    Parameters
    ----------
    motion, bottom_from_top
        (4, 4).
    field
        Unit of x and y, the place in the leading image, in the polynomial of the disparity. The
        calibration has twelve unknowns. Six are an error of top_from_bottom: translation, then
        rotation vector, in the top camera's axes. Six are an error of the disparity, the
        coefficients of 1, x, y, x^2, xy, y^2.
    points
        (m, 3) in the first leading camera.
    seen
        (m, 8) as the residual.
    """
    import hullrecon._native as _native

    return StereoRows(**_native.linearise_stereo(motion, bottom_from_top, field, points, seen))


def reduce_stereo(
    motion: Array, bottom_from_top: Array, points: Array, seen: Array
) -> ReducedFeatures:
    """Eliminate the points of the features of `linearise_stereo`.

    Raises InputError for shapes that do not fit.
    """
    import hullrecon._native as _native

    return ReducedFeatures(**_native.reduce_stereo(motion, bottom_from_top, points, seen))
