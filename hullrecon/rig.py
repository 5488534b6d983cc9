# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The rig: where every sensor sits on the vehicle, how well that is known, and its poses on a path.

A camera or the DVL is fixed to the tray, which turns about y of the vehicle at `tray_origin`:
vehicle_from_sensor = Trans(tray origin) Ry(tray angle) tray_from_sensor (docs/concepts.md).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from hullrecon.dive.config import schema
from hullrecon.dive.config.mounts import numbers_of
from hullrecon.dive.config.schema import RIG_KEYS
from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses, from_mount, tray_poses
from hullrecon.records.solution import Mounts
from hullrecon.records.trajectory import Returns, VehiclePath, VehicleTrack
from hullrecon.typing import Array, Ints

HELD_SIGMA = 1e-6  # m or rad: of a coordinate whose sigma dive.toml gives as zero
HEADING_DRIFT, DEPTH_BIAS = 1, 4  # places among the errors of navigation
LEAST_ERROR_SIGMA = 1e-9  # of an error of navigation that dive.toml gives as zero

TraySensor: TypeAlias = Camera | Literal["tray", "dvl"]
Section = TypeVar("Section")


def _nan(*shape: int) -> Array:
    return np.full(shape, np.nan)


@dataclass(frozen=True, kw_only=True)
class RigPriors:
    """Priors of the mounts and of systematic errors of the sensors, by the dive package.

    A value that was not given is NaN, which the solver refuses.
    """

    # (6, 6) square root of the information on log(nominal^-1 @ mount); None: the mount is held
    tray_from_dvl: Array | None = None
    tray_from_top: Array | None = None
    top_from_bottom: Array | None = None
    # (3,) m: of the DVL's position on the tray. Images, ranges and odometry observe where camera
    # and DVL are relative to each other, but not a shift of both. So the DVL's position is held in
    # the solve.
    dvl_position_sigma_m: Array = field(default_factory=lambda: _nan(3))
    tray_sigma_rad: float = np.nan
    # (6,): DVL scale, heading drift rad/s, roll and pitch bias rad, depth bias m, tray backlash rad
    navigation_sigma: Array = field(default_factory=lambda: _nan(6))
    density_sigma: float = np.nan  # of the water, relative: scales the error of all depths alike
    pixel_sigma_px: float = np.nan
    # px rms over the image of top and bottom camera, of the displacement of pixels that the
    # calibrations leave uncorrected; 0: none
    calibration_sigma_px: tuple[float, float] = (0.0, 0.0)
    range_sigma_m: float = np.nan


@dataclass(frozen=True, kw_only=True)
class DvlPoints:
    """Ends of m DVL beams, in the frame of the path."""

    points: Array  # (m, 3) m
    directions: Array  # (m, 3) unit vectors along the beams


@dataclass(frozen=True, kw_only=True)
class Rig:
    """Mounts and calibrations of a dive's sensors. A mount is None where its sensor is absent."""

    tray_origin: Array  # (3,) m in the vehicle: where the tray's axis is
    pressure_origin: Array  # (3,) m in the vehicle
    tray_from_dvl: Poses  # this and the mounts below: batches of one
    tray_from_top: Poses | None = None
    top_from_bottom: Poses | None = None
    sonar_origin: Array | None = (
        None  # (3,) m in the vehicle: where the sonar's servo turns about y
    )
    servo_from_sonar: Poses | None = None
    camera_models: Mapping[Camera, CameraModel] = field(default_factory=dict)
    priors: RigPriors = field(default_factory=RigPriors)

    @property
    def cameras(self) -> tuple[Camera, ...]:
        """Cameras that have a mount and a calibration, top first."""
        mounted = {Camera.TOP: self.tray_from_top, Camera.BOTTOM: self.top_from_bottom}
        return tuple(c for c in Camera if mounted[c] is not None and c in self.camera_models)

    @property
    def top(self) -> CameraModel | None:
        """Calibration of the top camera."""
        return self.camera_models.get(Camera.TOP)

    @property
    def bottom(self) -> CameraModel | None:
        """Calibration of the bottom camera."""
        return self.camera_models.get(Camera.BOTTOM)

    @property
    def stereo_mount(self) -> Poses | None:
        """top_from_bottom of a rig whose bottom camera is calibrated, None for a single camera."""
        return self.top_from_bottom if Camera.BOTTOM in self.camera_models else None

    @property
    def baseline_m(self) -> float:
        """Distance of the cameras. 1 for a single camera, whose points have no scale."""
        return (
            1.0
            if self.stereo_mount is None
            else float(np.linalg.norm(self.stereo_mount.translation[0]))
        )

    def model(self, camera: Camera) -> CameraModel:
        """Return a camera's calibration. Raises ValueError for a bottom camera not carried."""
        if camera is Camera.BOTTOM and self.stereo_mount is None:
            raise ValueError("this rig has no bottom camera")
        return self.camera_models[camera]

    def focal_px(self, camera: Camera) -> float:
        """Return the camera's focal length in pixels, the mean of both axes."""
        model = self.model(camera)
        return 0.5 * (model.fx + model.fy)

    def from_top(self, camera: Camera) -> Array:
        """Return camera_from_top (4, 4): the identity for the top one and for a single camera."""
        if camera is Camera.TOP or self.stereo_mount is None:
            return np.eye(4)
        return np.asarray(self.stereo_mount.inverse().matrix()[0])

    def tray_from(self, sensor: TraySensor) -> Poses:
        """Return a sensor's mount on the tray. Raises InputError for a camera without a mount."""
        if not isinstance(sensor, Camera):
            return self.tray_from_dvl if sensor == "dvl" else from_mount(np.zeros(6))
        if self.tray_from_top is None or (sensor is Camera.BOTTOM and self.top_from_bottom is None):
            raise InputError(
                f"the {sensor} camera has no mount",
                where=sensor.section,
                remedy="give its mount in dive.toml",
            )
        if sensor is Camera.BOTTOM and self.top_from_bottom is not None:
            return self.tray_from_top @ self.top_from_bottom
        return self.tray_from_top

    def poses_along(self, path: VehiclePath, sensor: TraySensor) -> Poses:
        """Compute a sensor's poses (n,) along a path of the vehicle, in the path's frame.

        Raises InputError for a camera without a mount.
        """
        tray = path.poses @ tray_poses(self.tray_origin, path.tray)
        return tray if sensor == "tray" else tray @ self.tray_from(sensor)

    def image_poses(self, track: VehicleTrack, nodes: Ints, camera: Camera) -> Poses:
        """Compute the poses (m,) of a camera halfway through its exposures at nodes (m,)."""
        tray = self.poses_along(track.path[nodes], "tray")
        if track.exposures is not None:
            tray = tray @ track.exposures.take(nodes).motion(camera, 0.5)
        return tray @ self.tray_from(camera)

    def dvl_points(self, returns: Returns, path: VehiclePath) -> DvlPoints:
        """Compute where DVL beams end, in the frame of the path [Ozog2016 eq. 1.1].

        path: vehicle and tray at all nodes. The returns hold how both moved from node to ping.
        """
        at_ping = VehiclePath(
            poses=path.poses[returns.node] @ Poses(returns.quaternion, returns.translation),
            tray=path.tray[returns.node] + returns.tray_offset,
        )
        dvl = self.poses_along(at_ping, "dvl")
        return DvlPoints(
            points=dvl.apply(returns.beam * returns.range_m[:, None]),
            directions=np.asarray(dvl.rotation.apply(returns.beam)),
        )

    def sonar_poses(self, vehicle: Poses, servo_rad: ArrayLike) -> Poses:
        """Compute the sonar's poses (n,) from the vehicle's and its servo's angles (n,) at pings.

        Raises InputError where no sonar is described.
        """
        if self.sonar_origin is None or self.servo_from_sonar is None:
            raise InputError(
                "the sonar has no mount", where="sonar", remedy="describe the sonar in dive.toml"
            )
        return vehicle @ tray_poses(self.sonar_origin, servo_rad) @ self.servo_from_sonar

    def with_mounts(self, mounts: Mounts) -> Rig:
        """Replace the mounts by adjusted ones. Those that were not adjusted stay."""
        return replace(
            self,
            tray_from_dvl=mounts.tray_from_dvl,
            tray_from_top=mounts.tray_from_top or self.tray_from_top,
            top_from_bottom=mounts.top_from_bottom or self.top_from_bottom,
        )

    def with_priors(self, **priors: Array | float | None) -> Rig:
        """Replace some of the priors, by their names in RigPriors."""
        return replace(self, priors=replace(self.priors, **priors))  # type: ignore[arg-type]

    def with_wider_navigation(self, *, depth_bias_m: float, heading_drift_rad_s: float) -> Rig:
        """Add further sigmas, in squares, to the priors of two errors of navigation."""
        sigma = self.priors.navigation_sigma.copy()
        for place, added in ((DEPTH_BIAS, depth_bias_m), (HEADING_DRIFT, heading_drift_rad_s)):
            sigma[place] = np.hypot(sigma[place], added)
        return self.with_priors(navigation_sigma=sigma)

    @property
    def mounts(self) -> Mounts:
        """Mounts on the tray as the rig has them."""
        return Mounts(
            tray_from_dvl=self.tray_from_dvl,
            tray_from_top=self.tray_from_top,
            top_from_bottom=self.top_from_bottom,
        )


def rig_from_settings(
    settings: Mapping[str, object], camera_models: Mapping[Camera, CameraModel] | None = None
) -> Rig:
    """Build the rig, without priors, from values of dive.toml by dotted key (RIG_KEYS).

    A value is None or absent where its sensor was not carried.
    """

    def mount(key: str) -> Poses | None:
        return None if settings.get(key) is None else from_mount(numbers_of(settings[key]))

    def origin(key: str) -> Array | None:
        return None if settings.get(key) is None else np.array(numbers_of(settings[key]))

    def or_zero(value: Array | None) -> Array:
        return np.zeros(3) if value is None else value

    tray_from_dvl = mount("dvl.mount")
    return Rig(
        tray_origin=or_zero(origin("tray.origin")),
        pressure_origin=or_zero(origin("pressure.origin")),
        tray_from_dvl=from_mount(np.zeros(6)) if tray_from_dvl is None else tray_from_dvl,
        tray_from_top=mount("camera.top.mount"),
        top_from_bottom=mount("camera.bottom.pose_in_top"),
        sonar_origin=origin("sonar.origin"),
        servo_from_sonar=mount("sonar.mount"),
        camera_models=camera_models or {},
    )


def rig_with_priors(
    sections: Mapping[str, object], camera_models: Mapping[Camera, CameraModel]
) -> Rig:
    """Build the rig with its priors from sections of dive.toml.

    sections: by name, all of RIG_SECTIONS (dive/config/schema.py), so none of the sonar. A camera's
    section is None where it was not carried.
    """
    keys = {key: key.rpartition(".") for key in RIG_KEYS if not key.startswith("sonar")}
    values = {key: getattr(sections[part], name, None) for key, (part, _, name) in keys.items()}
    if sections["camera.top"] is None:  # the bottom camera's pose is relative to the top one
        values["camera.bottom.pose_in_top"] = None
    rig = rig_from_settings(values, camera_models)
    return replace(rig, priors=_collect_priors(sections, rig))


def _collect_priors(sections: Mapping[str, object], rig: Rig) -> RigPriors:
    """Collect the priors of mounts and sensor errors from dive.toml, degrees as radians."""
    tray, imu = _section(sections, "tray", schema.Tray), _section(sections, "imu", schema.Imu)
    pressure = _section(sections, "pressure", schema.Pressure)
    dvl = _section(sections, "dvl", schema.Dvl)
    top = bottom = None
    if rig.tray_from_top is not None:
        top = _section(sections, "camera.top", schema.CameraTop)
    if rig.top_from_bottom is not None:
        bottom = _section(sections, "camera.bottom", schema.CameraBottom)
    degree = np.pi / 180
    errors = [
        dvl.scale_sigma,
        imu.heading_drift_deg_per_hour * degree / 3600,
        imu.bias_sigma_deg * degree,
        imu.bias_sigma_deg * degree,
        pressure.bias_sigma_m,
        tray.sigma_deg * degree,
    ]
    return RigPriors(
        tray_from_dvl=mount_prior(
            rig.tray_from_dvl, (HELD_SIGMA, HELD_SIGMA, HELD_SIGMA, *dvl.mount_sigma[3:])
        ),
        tray_from_top=mount_prior(rig.tray_from_top, top.mount_sigma)
        if top is not None and rig.tray_from_top is not None
        else None,
        top_from_bottom=mount_prior(rig.top_from_bottom, bottom.pose_sigma)
        if bottom is not None and rig.top_from_bottom is not None
        else None,
        dvl_position_sigma_m=np.array(dvl.mount_sigma[:3]),
        tray_sigma_rad=tray.sigma_deg * degree,
        navigation_sigma=np.maximum(errors, LEAST_ERROR_SIGMA),
        density_sigma=pressure.density_sigma / pressure.density,
        pixel_sigma_px=top.sigma_px if top is not None else 1.0,
        calibration_sigma_px=(
            top.calibration_sigma_px if top is not None else 0.0,
            bottom.calibration_sigma_px if bottom is not None else 0.0,
        ),
        range_sigma_m=dvl.sigma_range,
    )


def mount_prior(mount: Poses, sigma: tuple[float, ...]) -> Array | None:
    """Compute the square root of the information (6, 6) on a mount, on log(nominal^-1 @ mount).

    None where all sigmas are zero: the mount is held.

    Parameters
    ----------
    mount
        Nominal mount, a batch of one.
    sigma
        Six sigmas of a small motion in the parent frame, as in dive.toml: m and degrees.
    """
    sigmas = np.array(sigma) * np.r_[np.ones(3), np.full(3, np.pi / 180)]
    if not sigmas.any():
        return None
    to_parent = mount.rotation.as_matrix()[0]
    return np.asarray(np.kron(np.eye(2), to_parent) / np.maximum(sigmas, HELD_SIGMA)[:, None])


def _section(sections: Mapping[str, object], name: str, kind: type[Section]) -> Section:
    """Look up a section of dive.toml, as decoded, and make sure of its kind."""
    found = sections[name]
    if not isinstance(found, kind):
        raise TypeError(f"section {name} is {found!r}, where {kind.__name__} is expected")
    return found
