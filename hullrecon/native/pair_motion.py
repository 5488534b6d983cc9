# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What features that two nodes share say of the motion between the nodes: second_from_first (4, 4)
of their leading cameras.

Its six unknowns are (translation in second's axes, rotation vector on the right). Images are in
ideal coordinates, NaN where a camera did not see the feature.
"""

from __future__ import annotations

from dataclasses import dataclass

from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints, Mask


def squared_reprojections(camera_from_points: Array, points: Array, xy: Array) -> Array:
    """Return (s, n): squared distance in the image of points (n, 3) under each of (s, 4, 4) from xy
    (n, 2); inf behind the camera, 0 where not seen. Raises InputError for shapes that do not fit.
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
    """Return normal matrix (6, 6), gradient (6,) and summed squared error of the motion, of those
    points that count.

    points (n, 3): triangulated in one node by a rig of that baseline; xy (n, 2): where the camera
    camera_from_node (4, 4) of the other node saw them; backward: the motion carries them with its
    inverse; counts (n,). Residuals are whitened by an image's own error and that of the point's
    depth, z^2 sqrt(2) / baseline for each unit of error in the image. Raises InputError for shapes
    that do not fit.
    """
    import hullrecon._native as _native

    found: tuple[Array, Array, float] = _native.normal_of_reprojections(
        motion, points, xy, camera_from_node, backward, baseline_m, counts
    )
    return found


@dataclass(frozen=True, kw_only=True)
class StereoRows:
    """residual (m, 8) of m features in the leading and the bottom camera of the first node, then of
    the second, two rows each, with derivatives by the points (m, 8, 3), the motion (m, 8, 6) and
    the calibration (m, 8, 12); rows not seen are zero.
    """

    residual: Array
    by_point: Array
    by_motion: Array
    by_calibration: Array


@dataclass(frozen=True, kw_only=True)
class ReducedFeatures(Rows):
    """Of m features, their points eliminated: information (m, 6, 6), gradient (m, 6); cost (m,),
    the sum of squares at the best points; freedom (m,): rows seen, less three; and what brings the
    points along with a step of the motion: point_inverse (m, 3, 3), point_gradient (m, 3),
    point_by_motion (m, 6, 3).
    """

    information: Array
    gradient: Array
    cost: Array
    freedom: Ints
    point_inverse: Array
    point_gradient: Array
    point_by_motion: Array


def linearise_stereo(
    motion: Array, bottom_from_top: Array, field: float, points: Array, seen: Array
) -> StereoRows:
    """Return the residuals of features with their derivatives.

    points (m, 3) in the first leading camera; seen (m, 8): as residual; field: of the unknowns of
    the calibration the first six are an error of T_ct_cb, (translation, rotation vector) in the top
    camera's axes, the others one of the disparity, as 1, x, y, x2, xy, y2 of the place in the
    leading image in units of field. Raises InputError for shapes that do not fit.
    """
    import hullrecon._native as _native

    return StereoRows(**_native.linearise_stereo(motion, bottom_from_top, field, points, seen))


def reduce_stereo(
    motion: Array, bottom_from_top: Array, points: Array, seen: Array
) -> ReducedFeatures:
    """Return the features of `linearise_stereo` with their points eliminated. Raises InputError for
    shapes that do not fit.
    """
    import hullrecon._native as _native

    return ReducedFeatures(**_native.reduce_stereo(motion, bottom_from_top, points, seen))
