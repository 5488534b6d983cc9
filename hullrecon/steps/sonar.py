# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Poses of the imaging sonar at its pings, for the steps that use it."""

from __future__ import annotations

import numpy as np

from hullrecon.errors import StageError
from hullrecon.geometry.poses import Poses
from hullrecon.records.sensors import JointSamples
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.rig import Rig
from hullrecon.typing import Ints


def sonar_poses(
    rig: Rig, track: VehicleTrack, t_ns: Ints, joint: str | None, samples: JointSamples | None
) -> Poses:
    """Compute the sonar's poses at ping times (n,) in the track's frame: result_from_sonar (n).

    The servo's angle is interpolated, and held before its first and after its last reading. Raises
    StageError if the servo was not logged. `joint`: name of the sonar's servo, None if the sonar is
    fixed. `samples`: angles of the servo, None if they were not logged.
    """
    angle = np.zeros(len(t_ns))
    if joint is not None:
        if samples is None or not len(samples.t_ns):
            raise StageError(f"the joint {joint} is not in the log", where="sonar.joint")
        angle = np.interp(t_ns - t_ns[0], samples.t_ns - t_ns[0], samples.angle)
    return rig.sonar_poses(track.vehicle_at(t_ns), angle)
