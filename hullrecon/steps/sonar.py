# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Poses of the imaging sonar at its pings, for the steps that use it."""

from __future__ import annotations

import numpy as np

from hullrecon.artifacts.stage import StageSettings
from hullrecon.errors import StageError
from hullrecon.geometry.poses import Poses
from hullrecon.records.sensors import JointSamples, SonarPings
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.rig import Rig, rig_from_settings
from hullrecon.steps.artifacts import InputArtifacts
from hullrecon.steps.keys import SONAR_KEYS
from hullrecon.typing import Ints


def logged_pings(artifacts: InputArtifacts) -> SonarPings:
    """Take the pings that were read. Raises StageError without any."""
    pings = artifacts.ingest.sonar
    if pings is None:
        raise StageError("the log holds no sonar ping", where="mosaic-sonar")
    return pings


def ping_poses(artifacts: InputArtifacts, settings: StageSettings, track: VehicleTrack) -> Poses:
    """Compute the sonar's poses at its pings in the track's frame: result_from_sonar (n).

    Raises StageError if there is no ping, or the sonar's servo was not logged. `settings`: with the
    mounts that the log gives filled in.
    """
    rig = rig_from_settings({key: settings[key] for key in SONAR_KEYS})
    joint = settings.read_optional("sonar.joint", str)
    t_ns = logged_pings(artifacts).t_ns
    return sonar_poses(rig, track, t_ns, joint, artifacts.ingest.sonar_joint)


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
