# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Start the pose graph's solve: by dead reckoning, and along the images in outages of the DVL.

Dead reckoning goes straight on in an outage, whatever the vehicle does. A link of one camera gives
the direction and not the length of a step. From a start that goes the wrong way after a turn, such
links end in a wrong minimum.
"""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses, from_matrix, tray_poses
from hullrecon.records.links import CameraLinks
from hullrecon.records.trajectory import Odometry, Trajectory
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Mask

# Sigma of a step over its length, and by itself: beyond both the images know better where it goes.
UNKNOWN_SHARE, UNKNOWN_M = 0.3, 0.02


def path_along_links(
    trajectory: Trajectory, odometry: Odometry, links: CameraLinks, rig: Rig
) -> Poses:
    """Turn the steps of dead reckoning that odometry knows badly along the links across them.

    A step keeps its own length. Returns global_from_vehicle (n).
    """
    reckoned = trajectory.poses()
    bearings = np.flatnonzero(~links.scaled)
    if rig.tray_from_top is None or not len(bearings):
        return reckoned
    ends = [
        (links.first[bearings], links.bottom[bearings, 0]),
        (links.second[bearings], links.bottom[bearings, 1]),
    ]
    from_first, from_second = (
        _vehicle_from_camera(trajectory, rig, node, is_bottom) for node, is_bottom in ends
    )
    first, second = ends[0][0], ends[1][0]
    step = (reckoned[second] @ from_second).inverse() @ (reckoned[first] @ from_first)
    length = np.linalg.norm(step.translation, axis=1)
    badly = odometry.sigma_between(first, second) > np.maximum(UNKNOWN_SHARE * length, UNKNOWN_M)
    if not badly.any():
        return reckoned
    direction = links.translation[bearings] / np.linalg.norm(
        links.translation[bearings], axis=1, keepdims=True
    )
    second_from_first = Poses(links.quaternion[bearings], direction * length[:, None])
    moved = (from_first @ second_from_first.inverse() @ from_second.inverse()).matrix()
    # by node: the nearest node before it that a link joins to it, and the motion
    nearest: dict[int, tuple[int, Array]] = {}
    for row in np.flatnonzero(badly)[np.argsort(first[badly], kind="stable")]:
        nearest[int(second[row])] = int(first[row]), moved[row]
    return from_matrix(_compose(reckoned, nearest))


def _compose(reckoned: Poses, along: dict[int, tuple[int, Array]]) -> Array:
    """Chain motions to poses (n, 4, 4): those of `along` at its nodes, else those reckoned."""
    steps = (reckoned[:-1].inverse() @ reckoned[1:]).matrix()
    out = reckoned.matrix()
    for k in range(1, len(out)):
        before, motion = along.get(k, (k - 1, steps[k - 1]))
        out[k] = out[before] @ motion
    return out


def _vehicle_from_camera(trajectory: Trajectory, rig: Rig, node: Ints, is_bottom: Mask) -> Poses:
    """Look up vehicle_from_camera (m) of the leading cameras, the bottom one where is_bottom."""
    mount = np.repeat(rig.tray_from(Camera.TOP).matrix(), len(node), axis=0)
    if rig.top_from_bottom is not None:
        mount[is_bottom] = rig.tray_from(Camera.BOTTOM).matrix()[0]
    return tray_poses(rig.tray_origin, trajectory.tray[node]) @ from_matrix(mount)
