# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a stereo pose that was written by another convention explains matches of the images.

Programs give the pose of the second camera in the first or the inverse, matrices by rows or by
columns, angles in degrees or radians. Each of these is a reading of the pose without anything to
fit: one that explains the images as well as a free pose does is what was meant.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array
from hullrecon.vision.pairs.two_view import essential_of
from hullrecon.vision.stereo.lens_hypotheses import Lenses, epipolar_error_px

KEY = "camera.bottom.pose_in_top"
MOST_MATCHES = 300  # by which readings are judged, evenly from all
AXES = "xyz"
AS_GOOD = 1.2  # median error of a reading over the best one's
MOST = 2  # that are listed: cameras that look the same way have several readings that are one


@dataclass(frozen=True, kw_only=True)
class Reading:
    """What a pose of the bottom camera may have been meant as."""

    words: str  # "with ..."
    remedy: str  # what to write in its place
    top_from_bottom: Poses
    exchanged: bool = False  # the cameras are


def fitting_readings(
    lenses: Lenses, given: Poses, top_px: Array, bottom_px: Array, limit_px: float
) -> list[Reading]:
    """List the readings of a pose that bring matches onto their lines, before both cameras.

    They are as good as the best.

    Parameters
    ----------
    lenses
        Of the top and the bottom camera.
    given
        top_from_bottom as written, a batch of one.
    top_px, bottom_px
        (n, 2) matches as seen.
    limit_px
        Median distance from the epipolar lines that a reading may leave.
    """
    rows = np.unique(np.linspace(0, len(top_px) - 1, MOST_MATCHES).astype(np.int64))
    seen = top_px[rows], bottom_px[rows]
    found = []
    for one in _readings(given):
        motion = one.top_from_bottom.inverse().matrix()[0]
        own = lenses[::-1] if one.exchanged else lenses
        error_px = epipolar_error_px(own, essential_of(motion), seen)
        if error_px <= limit_px and _share_before(own, motion, seen) > 0.5:
            found.append((error_px, one))
    best_px = min((error_px for error_px, _ in found), default=0.0)
    return [one for error_px, one in found if error_px <= AS_GOOD * best_px][:MOST]


def _readings(given: Poses) -> Iterator[Reading]:
    """List what the pose may have been meant as: inverse, other signs, orders, units."""
    rotation, shift = given.rotation, given.translation
    yield Reading(
        words="with the two cameras swapped",
        remedy="exchange the topics and calibrations of camera_top and camera_bottom",
        top_from_bottom=given.inverse(),
        exchanged=True,
    )
    yield Reading(
        words=f"with {KEY} inverted", remedy=f"invert {KEY}", top_from_bottom=given.inverse()
    )
    yield Reading(
        words="with the bottom camera on the other side of the top one",
        remedy=f"turn the signs of x, y and z of {KEY}",
        top_from_bottom=Poses(rotation.as_quat(), -shift),
    )
    for sign, also in ((1.0, ""), (-1.0, ", and turn the signs of x, y and z")):
        yield Reading(
            words="with the bottom camera turned the other way",
            remedy=f"invert the rotation of {KEY} (its matrix is transposed){also}",
            top_from_bottom=Poses(rotation.inv().as_quat(), sign * shift),
        )
    for first, second in ((0, 1), (0, 2), (1, 2)):
        exchanged = shift.copy()
        exchanged[:, [first, second]] = shift[:, [second, first]]
        pair = f"{AXES[first]} and {AXES[second]}"
        yield Reading(
            words=f"with {pair} of {KEY} exchanged",
            remedy=f"exchange {pair} of {KEY}",
            top_from_bottom=Poses(rotation.as_quat(), exchanged),
        )
    yaw_pitch_roll = rotation.as_euler("ZYX")
    yield Reading(
        words=f"with the angles of {KEY} in radians",
        remedy=f"give roll, pitch, yaw of {KEY} in degrees",
        top_from_bottom=Poses(
            Rotation.from_euler("ZYX", np.degrees(yaw_pitch_roll)).as_quat(), shift
        ),
    )
    yield Reading(
        words=f"with the angles of {KEY} in the other order",
        remedy=f"give the angles of {KEY} as roll, pitch, yaw",
        top_from_bottom=Poses(Rotation.from_euler("ZYX", yaw_pitch_roll[:, ::-1]).as_quat(), shift),
    )


def _share_before(lenses: Lenses, motion: Array, seen: tuple[Array, Array]) -> float:
    """Compute the share of matches that lie before both cameras. motion: bottom from top (4, 4)."""
    ideal = [lens.undistort(pixel) for lens, pixel in zip(lenses, seen, strict=True)]
    top, bottom = (np.column_stack([xy, np.ones(len(xy))]) for xy in ideal)
    turned = top @ motion[:3, :3].T
    # depths along both rays: depth_top * turned + shift = depth_bottom * bottom, by cross products
    across = np.cross(bottom, turned)
    size = np.maximum((across**2).sum(axis=1), 1e-300)
    depth_top = -(across * np.cross(bottom, motion[:3, 3])).sum(axis=1) / size
    depth_bottom = -(across * np.cross(turned, motion[:3, 3])).sum(axis=1) / size
    return float(((depth_top > 0) & (depth_bottom > 0)).mean())
