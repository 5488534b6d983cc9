# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The motion between two nodes by features that they share, in C++.

The motion is second_from_first (4, 4) of their leading cameras. Its six unknowns are (translation
in the second camera's axes, rotation vector on the right). Image coordinates are ideal, x/z and
y/z, and NaN where a camera did not observe the feature.
"""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints, Mask


def squared_reprojections(camera_from_points: Array, points: Array, xy: Array) -> Array:
    """Compute squared reprojection errors (s, n) of points for each of s motions.

    inf where a point is behind the camera, 0 where it was not observed. Raises InputError for
    shapes that do not fit.

    Parameters
    ----------
    camera_from_points
        (s, 4, 4) motions.
    points
        (n, 3).
    xy
        (n, 2) observations, NaN where there is none.
    """
    from hullrecon.native.compiled import native  # loads the solver's libraries

    squared: Array = native.squared_reprojections(camera_from_points, points, xy)
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

    Residuals are whitened by the error of an observation in the image and by that of the point's
    depth, which is z^2 sqrt(2) / baseline for a unit error in the image. Raises InputError for
    shapes that do not fit.

    Parameters
    ----------
    motion
        (4, 4) second_from_first.
    points
        (n, 3) triangulated in one node.
    xy
        (n, 2) ideal coordinates at which a camera of the other node observed them.
    camera_from_node
        (4, 4) of that camera.
    backward
        The points are of the second node, and the inverse of the motion is applied to them.
    baseline_m
        Of the stereo rig that triangulated them.
    counts
        (n,) points that are summed.
    """
    from hullrecon.native.compiled import native

    found: tuple[Array, Array, float] = native.normal_of_reprojections(
        motion, points, xy, camera_from_node, backward, baseline_m, counts
    )
    return found


@dataclass(frozen=True, kw_only=True)
class StereoRows:
    """Residuals of m features in both cameras of two nodes, with derivatives."""

    # (m, 8) leading and bottom camera of the first node, then of the second, x and y each; zero
    # where the feature was not observed
    residual: Array
    by_point: Array  # (m, 8, 3) derivative by the feature's point
    by_motion: Array  # (m, 8, 6) derivative by the motion
    by_calibration: Array  # (m, 8, 12) derivative by the calibration


@dataclass(frozen=True, kw_only=True)
class ReducedFeatures(Rows):
    """m features with their points eliminated."""

    information: Array  # (m, 6, 6)
    gradient: Array  # (m, 6)
    cost: Array  # (m,) sum of squared residuals at the best points
    freedom: Ints  # (m,) redundancy: observed rows, less the three coordinates of the point
    # (m, 3, 3) inverse of the point's information. By this and the next two, the change of the
    # points follows from a step of the motion
    point_inverse: Array
    point_gradient: Array  # (m, 3)
    point_by_motion: Array  # (m, 6, 3)


def linearise_stereo(
    motion: Array, bottom_from_top: Array, field: float, points: Array, seen: Array
) -> StereoRows:
    """Compute the residuals of features in two stereo nodes, with their derivatives.

    The calibration has twelve unknowns. Six are an error of top_from_bottom: translation, then
    rotation vector, in the top camera's axes. Six are an error of the disparity: the coefficients
    of 1, x, y, x^2, xy, y^2 of the position in the leading image. Raises InputError for shapes that
    do not fit.

    Parameters
    ----------
    motion, bottom_from_top
        (4, 4).
    field
        Unit of x and y in that polynomial.
    points
        (m, 3) in the first leading camera.
    seen
        (m, 8) observations, in the order of the residuals.
    """
    from hullrecon.native.compiled import native

    return StereoRows(**native.linearise_stereo(motion, bottom_from_top, field, points, seen))


def reduce_stereo(
    motion: Array, bottom_from_top: Array, points: Array, seen: Array
) -> ReducedFeatures:
    """Eliminate the points of features, so that information on the motion alone is left.

    Parameters are those of `linearise_stereo`. Raises InputError for shapes that do not fit.
    """
    from hullrecon.native.compiled import native

    return ReducedFeatures(**native.reduce_stereo(motion, bottom_from_top, points, seen))
