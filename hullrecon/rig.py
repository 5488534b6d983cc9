# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Where every sensor sits on the vehicle: from a path of the vehicle to poses of cameras, DVL and
sonar, in batches.

T_v_s = Trans(tray origin) Ry(tray angle); cameras and DVL are fixed to the tray (docs/concepts.md).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from hullrecon.dive.config.mounts import numbers_of
from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses, from_mount, tray_poses
from hullrecon.records.solution import Mounts
from hullrecon.records.trajectory import Returns, VehiclePath
from hullrecon.typing import Array

# The keys of dive.toml that a rig is made of: what a step declares to be handed them.
RIG_KEYS = (
    "tray.origin", "pressure.origin", "dvl.mount", "camera.top.mount", "camera.bottom.pose_in_top",
    "sonar.origin", "sonar.mount",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class DvlPoints:
    """Ends of m DVL beams. points (m, 3) m and unit directions (m, 3) in the frame of the path."""

    points: Array
    directions: Array


@dataclass(frozen=True, kw_only=True)
class SensorRig:
    """Lever arms (3,) m in the vehicle frame, mounts as batches of one, and the cameras' models.

    Mounts are None where the sensor was not carried. sonar_joint_from_sonar: the sonar on its own
    servo, which turns about y at sonar_origin.
    """

    tray_origin: Array
    pressure_origin: Array
    tray_from_dvl: Poses
    tray_from_top: Poses | None = None
    top_from_bottom: Poses | None = None
    sonar_origin: Array | None = None
    servo_from_sonar: Poses | None = None
    camera_models: Mapping[Camera, CameraModel] = field(default_factory=dict)

    @property
    def cameras(self) -> tuple[Camera, ...]:
        """Return the cameras that have a mount and a model, top first."""
        mounted = {Camera.TOP: self.tray_from_top, Camera.BOTTOM: self.top_from_bottom}
        return tuple(c for c in Camera if mounted[c] is not None and c in self.camera_models)

    def tray_from(self, camera: Camera) -> Poses:
        """Return T_s_ct or T_s_cb. Raises InputError for a camera without a mount."""
        if self.tray_from_top is None or (camera is Camera.BOTTOM and self.top_from_bottom is None):
            raise InputError(
                f"the {camera} camera has no mount",
                where=camera.section,
                remedy="give its mount in dive.toml",
            )
        if camera is Camera.BOTTOM and self.top_from_bottom is not None:
            return self.tray_from_top @ self.top_from_bottom
        return self.tray_from_top

    def tray_poses(self, path: VehiclePath) -> Poses:
        """Return T_x_s (n) along a path of the vehicle in frame x."""
        return path.poses @ tray_poses(self.tray_origin, path.tray)

    def camera_poses(self, path: VehiclePath, camera: Camera) -> Poses:
        """Return T_x_c (n) of a camera along a path in frame x. Raises InputError for a camera
        without a mount.
        """
        return self.tray_poses(path) @ self.tray_from(camera)

    def dvl_poses(self, path: VehiclePath) -> Poses:
        """Return T_x_d (n) along a path in frame x."""
        return self.tray_poses(path) @ self.tray_from_dvl

    def dvl_points(self, returns: Returns, path: VehiclePath) -> DvlPoints:
        """Return where the beams ended, given the vehicle at the nodes in frame x.

        The vehicle's motion, and the tray's, between node and ping are in the returns.
        """
        at_ping = VehiclePath(
            poses=path.poses[returns.node] @ Poses(returns.quaternion, returns.translation),
            tray=path.tray[returns.node] + returns.tray_offset,
        )
        dvl = self.dvl_poses(at_ping)
        return DvlPoints(
            points=dvl.apply(returns.beam * returns.range_m[:, None]),
            directions=np.asarray(dvl.rotation.apply(returns.beam)),
        )

    def sonar_poses(self, vehicle: Poses, joint_rad: ArrayLike) -> Poses:
        """Return T_x_o (n) of the sonar: vehicle T_x_v (n) and the angle of the sonar's servo (n,)
        at its pings.

        Raises InputError where no sonar was described.
        """
        if self.sonar_origin is None or self.servo_from_sonar is None:
            raise InputError(
                "the sonar has no mount", where="sonar", remedy="describe the sonar in dive.toml"
            )
        return vehicle @ tray_poses(self.sonar_origin, joint_rad) @ self.servo_from_sonar

    def with_mounts(self, mounts: Mounts) -> SensorRig:
        """Return the rig with its mounts as adjusted; those that were not adjusted stay."""
        return replace(
            self,
            tray_from_dvl=mounts.tray_from_dvl,
            tray_from_top=mounts.tray_from_top or self.tray_from_top,
            top_from_bottom=mounts.top_from_bottom or self.top_from_bottom,
        )


def rig_from_settings(
    settings: Mapping[str, object], camera_models: Mapping[Camera, CameraModel] | None = None
) -> SensorRig:
    """Return the rig of a dive from the values of dive.toml by dotted key (RIG_KEYS), None or
    absent where not carried.
    """

    def mount(key: str) -> Poses | None:
        return None if settings.get(key) is None else from_mount(numbers_of(settings[key]))

    def origin(key: str) -> Array | None:
        return None if settings.get(key) is None else np.array(numbers_of(settings[key]))

    def or_zero(value: Array | None) -> Array:
        return np.zeros(3) if value is None else value

    tray_from_dvl = mount("dvl.mount")
    return SensorRig(
        tray_origin=or_zero(origin("tray.origin")),
        pressure_origin=or_zero(origin("pressure.origin")),
        tray_from_dvl=from_mount(np.zeros(6)) if tray_from_dvl is None else tray_from_dvl,
        tray_from_top=mount("camera.top.mount"),
        top_from_bottom=mount("camera.bottom.pose_in_top"),
        sonar_origin=origin("sonar.origin"),
        servo_from_sonar=mount("sonar.mount"),
        camera_models=camera_models or {},
    )
