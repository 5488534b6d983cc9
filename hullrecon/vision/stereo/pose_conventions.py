# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a stereo pose that was written by another convention explains matches of the images.

Programs give the pose of the second camera in the first or the inverse, matrices by rows or by
columns, angles in degrees or radians. Each convention gives one other pose, with no number to fit.
If such a pose explains the images as well as a freely fitted one, its convention is what was meant.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses
from hullrecon.rows import spread_rows
from hullrecon.typing import Array
from hullrecon.vision.pairs.two_view import essential_of
from hullrecon.vision.stereo.lens_hypotheses import Lenses, epipolar_error_px

KEY = "camera.bottom.pose_in_top"
MOST_MATCHES = 300  # matches by which conventions are judged, taken evenly from all
AXES = "xyz"
AS_GOOD = 1.2  # largest ratio of the median error with a convention to that with the best one
MOST = 2  # conventions listed: with parallel cameras several of them give the same pose


@dataclass(frozen=True, kw_only=True)
class PoseConvention:
    """A convention by which the pose of the bottom camera may have been written."""

    words: str  # "with ..."
    remedy: str  # what to write instead
    top_from_bottom: Poses  # the pose if this was meant, a batch of one
    exchanged: bool = False  # the two cameras were confused


def fitting_conventions(
    lenses: Lenses, given: Poses, top_px: Array, bottom_px: Array, limit_px: float
) -> list[PoseConvention]:
    """List the other conventions of a pose that explain the matches, maybe none.

    With each, the matches are within limit_px of their epipolar lines in the median, most points
    lie in front of both cameras, and the error is at most AS_GOOD times that of the best one. At
    most MOST are listed.

    Parameters
    ----------
    lenses
        Lens models of the top and the bottom camera.
    given
        top_from_bottom as written, a batch of one.
    top_px, bottom_px
        Matches (n, 2), pixels in the raw images.
    limit_px
        Largest median distance from the epipolar lines.
    """
    rows = spread_rows(len(top_px), MOST_MATCHES)
    seen = top_px[rows], bottom_px[rows]
    found = []
    for one in _conventions(given):
        motion = one.top_from_bottom.inverse().matrix()[0]
        own = lenses[::-1] if one.exchanged else lenses
        error_px = epipolar_error_px(own, essential_of(motion), seen)
        if error_px <= limit_px and _share_in_front(own, motion, seen) > 0.5:
            found.append((error_px, one))
    best_px = min((error_px for error_px, _ in found), default=0.0)
    return [one for error_px, one in found if error_px <= AS_GOOD * best_px][:MOST]


def _conventions(given: Poses) -> Iterator[PoseConvention]:
    """Yield the conventions that the pose may follow: inverse, other signs, orders, units.

    given: top_from_bottom as written, a batch of one.
    """
    rotation, shift = given.rotation, given.translation
    yield PoseConvention(
        words="with the two cameras swapped",
        remedy="exchange the topics and calibrations of camera_top and camera_bottom",
        top_from_bottom=given.inverse(),
        exchanged=True,
    )
    yield PoseConvention(
        words=f"with {KEY} inverted", remedy=f"invert {KEY}", top_from_bottom=given.inverse()
    )
    yield PoseConvention(
        words="with the bottom camera on the other side of the top one",
        remedy=f"turn the signs of x, y and z of {KEY}",
        top_from_bottom=Poses(rotation.as_quat(), -shift),
    )
    for sign, also in ((1.0, ""), (-1.0, ", and turn the signs of x, y and z")):
        yield PoseConvention(
            words="with the bottom camera turned the other way",
            remedy=f"invert the rotation of {KEY} (its matrix is transposed){also}",
            top_from_bottom=Poses(rotation.inv().as_quat(), sign * shift),
        )
    for first, second in ((0, 1), (0, 2), (1, 2)):
        exchanged = shift.copy()
        exchanged[:, [first, second]] = shift[:, [second, first]]
        pair = f"{AXES[first]} and {AXES[second]}"
        yield PoseConvention(
            words=f"with {pair} of {KEY} exchanged",
            remedy=f"exchange {pair} of {KEY}",
            top_from_bottom=Poses(rotation.as_quat(), exchanged),
        )
    yaw_pitch_roll = rotation.as_euler("ZYX")
    yield PoseConvention(
        words=f"with the angles of {KEY} in radians",
        remedy=f"give roll, pitch, yaw of {KEY} in degrees",
        top_from_bottom=Poses(
            Rotation.from_euler("ZYX", np.degrees(yaw_pitch_roll)).as_quat(), shift
        ),
    )
    yield PoseConvention(
        words=f"with the angles of {KEY} in the other order",
        remedy=f"give the angles of {KEY} as roll, pitch, yaw",
        top_from_bottom=Poses(Rotation.from_euler("ZYX", yaw_pitch_roll[:, ::-1]).as_quat(), shift),
    )


def _share_in_front(lenses: Lenses, motion: Array, seen: tuple[Array, Array]) -> float:
    """Compute the share of matches whose points lie in front of both cameras.

    A pose with most of them behind is impossible, however near they are to their epipolar lines.
    motion: bottom from top (4, 4). seen: matches (n, 2) in raw pixels of both images.
    """
    ideal = [lens.undistort(pixel) for lens, pixel in zip(lenses, seen, strict=True)]
    top, bottom = (np.column_stack([xy, np.ones(len(xy))]) for xy in ideal)
    turned = top @ motion[:3, :3].T
    # depths along both rays: depth_top * turned + shift = depth_bottom * bottom, by cross products
    across = np.cross(bottom, turned)
    size = np.maximum((across**2).sum(axis=1), 1e-300)
    depth_top = -(across * np.cross(bottom, motion[:3, 3])).sum(axis=1) / size
    depth_bottom = -(across * np.cross(turned, motion[:3, 3])).sum(axis=1) / size
    return float(((depth_top > 0) & (depth_bottom > 0)).mean())
