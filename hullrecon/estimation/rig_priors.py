# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The rig as an unknown: every mount with its prior, and the sigmas of what is systematic in
navigation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from hullrecon.dive.config import schema
from hullrecon.dive.config.mounts import numbers_of
from hullrecon.geometry import poses
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array

RIG_SECTIONS = ("tray", "imu", "pressure", "dvl", "camera.top", "camera.bottom")

Section = TypeVar("Section")


@dataclass(frozen=True)
class Mount:
    """A motion's nominal value (batch of one) and its prior: sqrt_information (6, 6) on
    log(nominal^-1 . x); None: held.
    """

    nominal: Poses
    sqrt_information: Array | None


@dataclass(frozen=True, kw_only=True)
class Rig:
    """How the sensors sit on the vehicle, and how sure that is. Angles in radians, lengths in
    metres.

    dvl_position_sigma (3,): of the DVL's position on the tray where it is held (zero where it is an
    unknown). Images, ranges and odometry resolve where camera and DVL are to each other; a shift of
    both on the tray is seen by nothing, so one is held. density_sigma: of the water's density,
    relative: an error that all depths share in proportion. navigation_sigma (6,): prior sigmas of
    DVL scale, heading drift rad/s, roll and pitch bias, depth bias, tray backlash.
    """

    tray_origin: Array
    tray_sigma: float
    pressure_origin: Array
    tray_from_dvl: Mount
    dvl_position_sigma: Array
    tray_from_top: Mount | None
    top_from_bottom: Mount | None
    top: CameraModel | None
    bottom: CameraModel | None
    sigma_px: float
    sigma_range: float
    density_sigma: float
    navigation_sigma: Array


def mount_prior(mount: tuple[float, ...], sigma: tuple[float, ...]) -> Mount:
    """Return the prior of a mount of dive.toml: sigmas in metres and degrees of a small rotation
    vector, in the parent frame.
    """
    nominal = poses.from_mount(mount)
    sigmas = np.array(sigma) * np.r_[np.ones(3), np.full(3, np.pi / 180)]
    if not sigmas.any():
        return Mount(nominal, None)
    to_parent = nominal.rotation.as_matrix()[0]
    rows = np.kron(np.eye(2), to_parent) / np.maximum(sigmas, 1e-6)[:, None]
    return Mount(nominal, rows)


def rig_priors_from_settings(
    settings: Mapping[str, object],
    cameras: Mapping[Camera, CameraModel],
    free_dvl_position: bool = False,
) -> Rig:
    """Return the rig of a dive from the sections of dive.toml named in RIG_SECTIONS, None where not
    carried.
    """
    tray, imu = _section(settings, "tray", schema.Tray), _section(settings, "imu", schema.Imu)
    pressure, dvl = (
        _section(settings, "pressure", schema.Pressure),
        _section(settings, "dvl", schema.Dvl),
    )
    top = (
        None
        if settings["camera.top"] is None
        else _section(settings, "camera.top", schema.CameraTop)
    )
    bottom = (
        None
        if settings["camera.bottom"] is None
        else _section(settings, "camera.bottom", schema.CameraBottom)
    )
    degree = np.pi / 180
    held = np.zeros(3) if free_dvl_position else np.array(dvl.mount_sigma[:3])
    dvl_sigma = dvl.mount_sigma if free_dvl_position else (1e-6, 1e-6, 1e-6, *dvl.mount_sigma[3:])
    sigma = [
        dvl.scale_sigma,
        imu.heading_drift_deg_per_hour * degree / 3600,
        imu.bias_sigma_deg * degree,
    ]
    sigma += [imu.bias_sigma_deg * degree, pressure.bias_sigma_m, tray.sigma_deg * degree]
    return Rig(
        tray_origin=np.array(numbers_of(tray.origin)),
        tray_sigma=tray.sigma_deg * degree,
        pressure_origin=np.array(numbers_of(pressure.origin)),
        tray_from_dvl=mount_prior(numbers_of(dvl.mount), dvl_sigma),
        dvl_position_sigma=held,
        tray_from_top=mount_prior(numbers_of(top.mount), top.mount_sigma) if top else None,
        top_from_bottom=mount_prior(numbers_of(bottom.pose_in_top), bottom.pose_sigma)
        if bottom and top
        else None,
        top=cameras.get(Camera.TOP),
        bottom=cameras.get(Camera.BOTTOM),
        sigma_px=top.sigma_px if top else 1.0,
        sigma_range=dvl.sigma_range,
        density_sigma=pressure.density_sigma / pressure.density,
        navigation_sigma=np.maximum(sigma, 1e-9),
    )


def _section(settings: Mapping[str, object], name: str, kind: type[Section]) -> Section:
    found = settings[name]
    if not isinstance(found, kind):
        raise TypeError(f"section {name} is {found!r}, where {kind.__name__} is expected")
    return found
