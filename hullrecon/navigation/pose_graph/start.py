# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Make the pose graph's start: dead reckoning, and in outages of the DVL along the images.

In an outage dead reckoning goes straight on, whatever the vehicle does. A link of one camera gives
the direction of a step but not its length. If the start goes the wrong way after a turn, a solve
with such links ends in a wrong minimum.
"""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses, from_matrix, tray_poses
from hullrecon.records.links import CameraLinks
from hullrecon.records.trajectory import Odometry, Trajectory
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Mask

# Sigma of a step as a share of its length, and in m. Beyond both, the images know its direction
# better than odometry.
UNKNOWN_SHARE, UNKNOWN_M = 0.3, 0.02


def path_along_links(
    trajectory: Trajectory, odometry: Odometry, links: CameraLinks, rig: Rig
) -> Poses:
    """Turn badly known steps of dead reckoning into the direction that links measured.

    Only links without a length are used, where the odometry between their nodes is uncertain. The
    step takes the link's rotation and direction, and keeps the length of dead reckoning. Nodes
    after it follow. The path is that of dead reckoning where there is no such link.

    Returns
    -------
    Poses
        global_from_vehicle (n).
    """
    reckoned = trajectory.poses()
    bearings = np.flatnonzero(~links.scaled)  # rows of links without a length
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
    # steps whose direction the images know better than odometry
    badly = odometry.sigma_between(first, second) > np.maximum(UNKNOWN_SHARE * length, UNKNOWN_M)
    if not badly.any():
        return reckoned
    direction = links.translation[bearings] / np.linalg.norm(
        links.translation[bearings], axis=1, keepdims=True
    )
    second_from_first = Poses(links.quaternion[bearings], direction * length[:, None])
    # first vehicle from second vehicle, by way of their cameras
    moved = (from_first @ second_from_first.inverse() @ from_second.inverse()).matrix()
    # by second node: the nearest earlier node that a link joins to it, and the motion from there
    nearest: dict[int, tuple[int, Array]] = {}
    for row in np.flatnonzero(badly)[np.argsort(first[badly], kind="stable")]:
        nearest[int(second[row])] = int(first[row]), moved[row]
    return from_matrix(_chain_motions(reckoned, nearest))


def _chain_motions(reckoned: Poses, along: dict[int, tuple[int, Array]]) -> Array:
    """Chain motions to poses (n, 4, 4), so that a turned step takes all later nodes along.

    reckoned: poses whose steps are used. along: by node, an earlier node and the motion from there,
    which replaces the step.
    """
    steps = (reckoned[:-1].inverse() @ reckoned[1:]).matrix()
    out = reckoned.matrix()
    for k in range(1, len(out)):
        before, motion = along.get(k, (k - 1, steps[k - 1]))
        out[k] = out[before] @ motion
    return out


def _vehicle_from_camera(trajectory: Trajectory, rig: Rig, node: Ints, is_bottom: Mask) -> Poses:
    """Compute vehicle_from_camera (m) at nodes (m,), of the bottom camera where is_bottom (m,)."""
    mount = np.repeat(rig.tray_from(Camera.TOP).matrix(), len(node), axis=0)
    if rig.top_from_bottom is not None:
        mount[is_bottom] = rig.tray_from(Camera.BOTTOM).matrix()[0]
    return tray_poses(rig.tray_origin, trajectory.tray[node]) @ from_matrix(mount)
