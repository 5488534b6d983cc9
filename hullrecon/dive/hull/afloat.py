# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Tell whether a ship's first guess of its pose lets it float."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.findings.finding import Finding
from hullrecon.geometry.charts.section_casting import AXES
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses, to_mount
from hullrecon.typing import Array

HEIGHT_SIGMA_M = 0.3  # of the height of hull.pose where pose_sigma is not given
SUNK_SIGMAS = 3.0


def find_sunk(
    mesh: Mesh, ship_axes: Array, guess: Poses, guess_sigma_m: Array | None
) -> Finding | None:
    """Report a CAD model that lies wholly under the water, as one upside down does.

    Nothing is reported where its top is above the water, or may be by the sigma of its height. The
    finding proposes the pose turned by 180 degrees about its length.

    Parameters
    ----------
    mesh
        In M.
    ship_axes
        Rows forward, port, up (3, 3) in M, along M's own axes, as the package's guess has them.
    guess
        Guess of the hull pose T_g_M, a batch of one.
    guess_sigma_m
        Sigma (3,) of its translation, in M's axes. None where not given.
    """
    upward = int(np.abs(ship_axes[2]).argmax())
    sigma_m = HEIGHT_SIGMA_M if guess_sigma_m is None else float(guess_sigma_m[upward])
    depth_m = guess.apply(mesh.vertices)[:, 2]
    top_m, bottom_m = float(depth_m.min()), float(depth_m.max())
    if top_m <= SUNK_SIGMAS * sigma_m:
        return None
    over = Rotation.from_rotvec(np.pi * np.round(ship_axes[0]))
    turned = Poses((guess.rotation * over).as_quat(), guess.translation)
    pose = to_mount(turned)
    values = {"top_m": top_m, "bottom_m": bottom_m, "up": AXES[upward], "pose": pose}
    return Finding("hull-under-water", values)
