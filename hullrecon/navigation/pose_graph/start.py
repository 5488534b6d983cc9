# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where the pose graph's solve begins: dead reckoning, and along the images' own directions where the DVL was silent.

There dead reckoning goes straight on, whatever the vehicle does. A link of one camera says the direction and not the length of
a step: from a start that goes the wrong way after a turn, such links end in a wrong minimum.
"""

from __future__ import annotations

import numpy as np

from hullrecon.estimation.rig_priors import Rig
from hullrecon.geometry.poses import Poses, from_matrix, tray_poses
from hullrecon.records.links import CameraLinks
from hullrecon.records.trajectory import Odometry, Trajectory
from hullrecon.typing import Array

UNKNOWN_SHARE = 0.3  # sigma of a step over its length: beyond it the images know better where it goes


def path_along_links(trajectory: Trajectory, odometry: Odometry, links: CameraLinks, rig: Rig) -> Poses:
    """Return T_g_v (n) of dead reckoning, in which a step that odometry knows badly has the direction and turn of the link
    across it, and its own length."""
    reckoned = trajectory.poses()
    n = len(reckoned)
    walked_m2 = np.zeros(n)
    np.add.at(walked_m2, odometry.second, odometry.covariance[:, [0, 1, 2], [0, 1, 2]].max(axis=1))
    walked_m2 = np.cumsum(walked_m2)
    vehicle_from_camera = _vehicle_from_cameras(trajectory, rig, links)
    if vehicle_from_camera is None:
        return reckoned
    from_first, from_second = vehicle_from_camera
    camera_first, camera_second = reckoned[links.first] @ from_first, reckoned[links.second] @ from_second
    step = camera_second.inverse() @ camera_first
    length = np.linalg.norm(step.translation, axis=1)
    sigma = np.sqrt(walked_m2[links.second] - walked_m2[links.first])
    badly = ~links.scaled & (sigma > UNKNOWN_SHARE * length)
    if not badly.any():
        return reckoned
    direction = links.translation / np.linalg.norm(links.translation, axis=1, keepdims=True)
    seen = Poses(links.quaternion, direction * length[:, None])  # second_from_first
    moved = (from_first @ seen.inverse() @ from_second.inverse()).matrix()
    nearest: dict[int, int] = {}  # row of the link from the nearest node before, by its second node
    for row in np.flatnonzero(badly)[np.argsort(links.first[badly], kind="stable")]:
        nearest[int(links.second[row])] = int(row)
    return from_matrix(_compose(reckoned, moved, links, nearest))


def _compose(reckoned: Poses, moved: Array, links: CameraLinks, nearest: dict[int, int]) -> Array:
    """Return T_g_v (n, 4, 4): from node to node as reckoned, but along the links (m, 4, 4) of `nearest`."""
    steps = (reckoned[:-1].inverse() @ reckoned[1:]).matrix()
    out = reckoned.matrix()
    for k in range(1, len(out)):
        row = nearest.get(k)
        out[k] = out[k - 1] @ steps[k - 1] if row is None else out[links.first[row]] @ moved[row]
    return out


def _vehicle_from_cameras(trajectory: Trajectory, rig: Rig, links: CameraLinks) -> tuple[Poses, Poses] | None:
    """Return T_v_c (m) of the leading cameras at the links' first and second nodes; None without a camera."""
    top, bottom = rig.T_s_ct, rig.T_ct_cb
    if top is None or len(links) == 0:
        return None
    ends = []
    for k, node in enumerate((links.first, links.second)):
        mount = np.repeat(top.nominal.matrix(), len(node), axis=0)
        if bottom is not None:
            mount[links.bottom[:, k]] = (top.nominal @ bottom.nominal).matrix()[0]
        ends.append(tray_poses(rig.tray_origin, trajectory.tray[node]) @ from_matrix(mount))
    return ends[0], ends[1]
