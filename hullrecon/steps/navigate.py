# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""navigate: the vehicle's path by dead reckoning, or by the stereo cameras where there is no DVL."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from hullrecon.artifacts.graph.stage import Context, Stage, load_arrays
from hullrecon.dive.images.store import CAMERAS, ImageStore
from hullrecon.dive.logs.readers.plain import PlainLog
from hullrecon.errors import StageError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import from_mount
from hullrecon.navigation.dead_reckoning.dead_reckon import Logs, Navigated, dead_reckon, usable_frames
from hullrecon.navigation.options import NavigateOptions
from hullrecon.navigation.stereo_odometry.stereo_frame import StereoFrame, StereoRig, stereo_frame
from hullrecon.navigation.stereo_odometry.stereo_path import Aids, Views, stereo_navigate
from hullrecon.navigation.vehicle import Vehicle
from hullrecon.records.sensors import DvlPings, ImageIndex, ImuSamples, JointSamples, PressureSamples
from hullrecon.records.serialisation import from_arrays, to_arrays

Record = TypeVar("Record")
HOUR_S = 3600.0
USES = (
    "tray.origin", "tray.sigma_deg", "imu.sigma_roll_pitch_deg", "imu.heading_drift_deg_per_hour", "imu.bias_sigma_deg",
    "pressure.origin", "pressure.sigma_m", "pressure.bias_sigma_m", "dvl.mount", "dvl.mount_sigma", "dvl.scale_sigma",
    "dvl.sigma_range", "camera.top.mount", "camera.top.sigma_px", "camera.bottom.pose_in_top", "camera.bottom.pose_sigma",
    "logs",
)  # fmt: skip
SUFFIXES = frozenset((".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".ppm", ".tif", ".tiff"))


@dataclass(frozen=True)
class PairReader:
    """Makes a stereo frame of two rows in the cameras' indices."""

    top: ImageStore
    bottom: ImageStore
    rig: StereoRig
    features: int

    def __call__(self, top: int, bottom: int) -> StereoFrame:
        return stereo_frame(self.top.read(top), self.bottom.read(bottom), self.rig, self.features)


def external(settings: Mapping[str, Any], package: Path) -> list[Path]:
    """Images that lie in the package as files; read again for visual odometry."""
    tables = [PlainLog(package / name, package) for name in settings["logs"].files if (package / name).is_dir()]
    return sorted(file for table in tables for file in table.named_files() if file.suffix.lower() in SUFFIXES)


def run(context: Context) -> None:
    if (context.inputs["ingest"] / "dvl.npz").exists():
        _write(context, _by_dvl(context), "dvl")
    elif all((context.inputs["ingest"] / f"images_{camera}.npz").exists() for camera in CAMERAS):
        _write(context, _by_stereo(context), "stereo")
    else:
        raise StageError(
            "nothing tells how the vehicle moved",
            where="no DVL and no stereo cameras were logged",
            remedy="name the DVL's topic in [topics], or both cameras with their calibration",
        )


def _by_dvl(context: Context) -> Navigated:
    ingest = context.inputs["ingest"]
    dvl, imu = _record(ingest, "dvl", DvlPings), _record(ingest, "imu", ImuSamples)
    if dvl is None:
        raise StageError("the DVL's log is empty", where="navigate", remedy="check the topic and the span of the log")
    if imu is None:
        what = "the DVL's velocities have no heading: no IMU was logged"
        raise StageError(what, where="navigate", remedy="name the IMU's topic in [topics]")
    logs = Logs(
        dvl,
        imu,
        _record(ingest, "pressure", PressureSamples),
        _record(ingest, "tray", JointSamples),
        _record(ingest, "images_camera_top", ImageIndex),
        _record(ingest, "images_camera_bottom", ImageIndex),
    )
    return dead_reckon(logs, vehicle_of(context.settings), context.parameters, context.settings["dvl.sigma_range"])


def _by_stereo(context: Context) -> Navigated:
    ingest, settings = context.inputs["ingest"], context.settings
    cameras = json.loads((ingest / "cameras.json").read_text())
    sigma_rad = float(np.radians(np.max(settings["camera.bottom.pose_sigma"][3:])))
    top, bottom = (CameraModel(**cameras[name]) for name in ("top", "bottom"))
    rig = StereoRig(
        top, bottom, from_mount(settings["camera.bottom.pose_in_top"]), settings["camera.top.sigma_px"], 2 * sigma_rad * top.fx
    )
    upper, lower = (ImageStore(ingest, context.source, camera) for camera in CAMERAS)
    reader = PairReader(upper, lower, rig, context.parameters.stereo_features)
    views = Views(usable_frames(upper.index), usable_frames(lower.index), reader, from_mount(settings["camera.top.mount"]))
    aids = Aids(
        _record(ingest, "imu", ImuSamples), _record(ingest, "pressure", PressureSamples), _record(ingest, "tray", JointSamples)
    )
    return stereo_navigate(
        views, aids, rig, vehicle_of(settings), context.parameters, lambda pairs: context.progress(pairs, "stereo pairs")
    )


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
    for name in ("trajectory", "error_model", "odometry", "attitude"):
        context.out.arrays(f"{name}.npz", to_arrays(getattr(found, name)))
    if len(found.returns.t_ns):
        context.out.arrays("returns.npz", to_arrays(found.returns))
    context.out.json(
        "navigation.json", {"source": source, "nodes": len(found.trajectory.t_ns), **found.facts, "remarks": found.remarks}
    )
    for sentence in found.remarks:
        context.warn(sentence)


STAGE = Stage(
    name="navigate",
    summary="compute the dead-reckoned trajectory",
    inputs=("ingest",),
    parameters=NavigateOptions,
    version=2,
    run=run,
    uses=USES,
    external=external,
)
