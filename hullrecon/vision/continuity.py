# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether one image of the upper camera goes on where another ends: how far images carry a path on
where the DVL is silent.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.rig import Rig
from hullrecon.typing import Array, Pixels
from hullrecon.vision.image_motion import single_camera_views
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pair_match import Reason

# that features move by: less is the noise of their places, in which a direction is found as well
STILL_PX = 1.0
MOST = 0.5  # of the image
CELLS = 4  # of the image along either side


def continuity(
    rig: Rig, read: Callable[[int], Pixels | None], max_features: int, min_inliers: int
) -> Callable[[int, int], bool]:
    """Return what tells of two images, by their rows, whether at least min_inliers features move as
    those of one rigid scene.

    Where they stand still they have to fill most of the image: a part of the vehicle that is in
    view stands still in open water too. read: an image (h, w, 3) RGB by its row, None where there
    is none. The two asked last are kept.
    """
    options = MatchOptions(min_inliers=min_inliers)
    matcher, view = single_camera_views(rig, read, max_features, options)
    camera = rig.camera_models[Camera.TOP]

    def goes_on(first: int, second: int) -> bool:
        found = matcher.match(view(first), view(second), None, (options.seed, first, second), True)
        if found.reason not in (Reason.MATCHED, Reason.NO_MOTION):
            return False
        before, after = view(first).xy[found.first], view(second).xy[found.second]
        moved_px = np.linalg.norm((after - before) * [camera.fx, camera.fy], axis=1)
        return bool(np.median(moved_px) > STILL_PX) or fills_most(after, camera)

    return goes_on


def fills_most(xy: Array, camera: CameraModel) -> bool:
    """Return whether points (n, 2), ideal coordinates, are spread over most of the image: by their
    scatter, which tells the area of a patch wherever it lies, and by the cells with a point, of
    which the rim of the image has few.
    """
    place = (xy * [camera.fx, camera.fy] + [camera.cx, camera.cy]) / [camera.width, camera.height]
    # Points that are even over a rectangle scatter by a twelfth of the square of its sides.
    area = 12 * np.sqrt(max(np.linalg.det(np.cov(place.T)), 0.0))
    cells = np.unique(np.clip((place * CELLS).astype(np.int64), 0, CELLS - 1), axis=0)
    return bool(area > MOST and len(cells) > MOST * CELLS**2)
