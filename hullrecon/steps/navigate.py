# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""navigate: the vehicle's path by dead reckoning, or by the stereo cameras where there is no DVL."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from hullrecon.artifacts.stage import Context, Stage, load_arrays
from hullrecon.dive.records import DvlPings, ImageIndex, ImuSamples, JointSamples, PressureSamples, from_arrays, to_arrays
from hullrecon.errors import StageError
from hullrecon.geometry.poses import from_mount
from hullrecon.navigation.navigate import Logs, Navigated, dead_reckon
from hullrecon.navigation.options import NavigateOptions
from hullrecon.navigation.vehicle import Vehicle

Record = TypeVar("Record")
HOUR_S = 3600.0
USES = (
    "tray.origin", "tray.sigma_deg", "imu.sigma_roll_pitch_deg", "imu.heading_drift_deg_per_hour", "imu.bias_sigma_deg",
    "pressure.origin", "pressure.sigma_m", "pressure.bias_sigma_m", "dvl.mount", "dvl.mount_sigma", "dvl.scale_sigma",
    "dvl.sigma_range",
)  # fmt: skip


def run(context: Context) -> None:
    ingest = context.inputs["ingest"]
    dvl, imu = _record(ingest, "dvl", DvlPings), _record(ingest, "imu", ImuSamples)
    if dvl is None:
        raise StageError("no DVL was logged", where="navigate", remedy="name its topic in [topics]")
    if imu is None:
        raise StageError(
            "the DVL's velocities have no heading: no IMU was logged",
            where="navigate",
            remedy="name the IMU's topic in [topics]",
        )
    logs = Logs(
        dvl,
        imu,
        _record(ingest, "pressure", PressureSamples),
        _record(ingest, "tray", JointSamples),
        _record(ingest, "images_camera_top", ImageIndex),
        _record(ingest, "images_camera_bottom", ImageIndex),
    )
    found = dead_reckon(logs, vehicle_of(context.settings), context.parameters, context.settings["dvl.sigma_range"])
    _write(context, found, "dvl")


def vehicle_of(settings: Mapping[str, Any]) -> Vehicle:
    """Mounts and sigmas in metres and radians, from the dotted keys of `USES`."""
    mount_sigma = np.array(settings["dvl.mount_sigma"], float)
    mount_sigma[3:] = np.radians(mount_sigma[3:])
    return Vehicle(
        tray_origin=np.array(settings["tray.origin"], float),
        pressure_origin=np.array(settings["pressure.origin"], float),
        T_s_d=from_mount(settings["dvl.mount"]),
        sigma_mount=mount_sigma,
        sigma_scale=settings["dvl.scale_sigma"],
        sigma_drift=float(np.radians(settings["imu.heading_drift_deg_per_hour"]) / HOUR_S),
        sigma_tilt_bias=float(np.radians(settings["imu.bias_sigma_deg"])),
        sigma_depth_bias=settings["pressure.bias_sigma_m"],
        sigma_tray=float(np.radians(settings["tray.sigma_deg"])),
        sigma_tilt=float(np.radians(settings["imu.sigma_roll_pitch_deg"])),
        sigma_depth=settings["pressure.sigma_m"],
    )


def _record(ingest: Path, name: str, kind: type[Record]) -> Record | None:
    """A record that ingest left with at least one row, or None."""
    path = ingest / f"{name}.npz"
    if not path.exists():
        return None
    arrays = load_arrays(path)
    return from_arrays(kind, arrays) if len(arrays["t_ns"]) else None


def _write(context: Context, found: Navigated, source: str) -> None:
    for name in ("trajectory", "odometry", "returns", "attitude"):
        context.out.arrays(f"{name}.npz", to_arrays(getattr(found, name)))
    context.out.json(
        "navigation.json", {"source": source, "nodes": len(found.trajectory.t_ns), **found.facts, "remarks": found.remarks}
    )
    for sentence in found.remarks:
        context.warn(sentence)


STAGE = Stage(
    name="navigate",
    summary="reckon the vehicle's path",
    inputs=("ingest",),
    parameters=NavigateOptions,
    version=1,
    run=run,
    uses=USES,
)
