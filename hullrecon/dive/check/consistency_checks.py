# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What does not fit together in a dive: seen before an hour of work, not after."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.config.schema import DiveConfig
from hullrecon.dive.logs.timeline import NS
from hullrecon.geometry.poses import from_mount
from hullrecon.records.sensors import DvlPings, ImageIndex, ImuSamples, JointSamples, PressureSamples
from hullrecon.typing import Ints

ABOVE_WATER_M = 0.5  # a return that far above the surface is none of the hull under water
MUCH = 0.05  # share of returns above water
ASTRAY_DEG = 50.0  # between where a camera and the DVL look
SLOW = 0.02  # m/s; below, depth's rate says nothing about the DVL


def suspicions(config: DiveConfig, records: Mapping[str, Any], images: Mapping[str, ImageIndex]) -> list[str]:
    """Sentences; none when all fits."""
    out = _clocks({**records, **images})
    if "imu" in records:
        out += _gravity(records["imu"], config.imu.frame)
    if {"dvl", "imu", "pressure"} <= records.keys():
        global_from_dvl = _global_from_dvl(config, records)
        out += _returns_above_water(config, records, global_from_dvl)
        out += _rate_of_depth(records["dvl"], records["pressure"], global_from_dvl)
    return out + _views(config)


def first_difference(records: Mapping[str, Any], images: Mapping[str, ImageIndex]) -> list[str]:
    """How the first image lies to the first DVL ping."""
    if "dvl" not in records or "camera_top" not in images:
        return []
    seconds = (int(images["camera_top"].t_ns[0]) - int(records["dvl"].t_ns[0])) / NS
    side = "after" if seconds >= 0 else "before"
    return [f"the first camera image is {abs(seconds):.1f} s {side} the first DVL ping"]


def _clocks(streams: Mapping[str, Any]) -> list[str]:
    """Streams that do not overlap in time with the longest one cannot be used together."""
    spans = {name: (int(s.t_ns[0]), int(s.t_ns[-1])) for name, s in streams.items() if s is not None and len(s.t_ns)}
    if not spans:
        return []
    main = max(spans, key=lambda name: spans[name][1] - spans[name][0])
    low, high = spans[main]
    apart = {name: max(start - high, low - end) / NS for name, (start, end) in spans.items()}
    return [
        f"{name} and {main} do not overlap in time: one of the clocks is off by {seconds:.1f} s or more"
        for name, seconds in apart.items()
        if seconds > 0
    ]  # fmt: skip


def _gravity(imu: ImuSamples, frame: str) -> list[str]:
    """An accelerometer at rest feels an upward push: -g along z of `global`."""
    felt = Rotation.from_quat(imu.quaternion).apply(imu.acceleration)
    felt = felt[np.isfinite(felt).all(axis=1)]
    if not len(felt) or np.linalg.norm(np.median(felt, axis=0)) < 5.0:
        return []
    up = -float(np.median(felt[:, 2])) / float(np.linalg.norm(np.median(felt, axis=0)))
    other = "enu" if frame == "ned" else "ned"
    if up < -0.7:
        return [f'imu: gravity pulls upward with imu.frame = "{frame}"; is it "{other}"?']
    return (
        [f"imu: gravity is {np.degrees(np.arccos(up)):.0f} degrees off the vertical: is imu.frame right?"] if up < 0.9 else []
    )


def _returns_above_water(config: DiveConfig, records: Mapping[str, Any], global_from_dvl: Rotation) -> list[str]:
    dvl, pressure = records["dvl"], records["pressure"]
    depth = np.interp(dvl.t_ns, pressure.t_ns, pressure.depth)
    reach = np.nan_to_num(dvl.ranges)[:, :, None] * dvl.beams
    below = depth[:, None] + np.stack([global_from_dvl.apply(reach[:, b])[:, 2] for b in range(reach.shape[1])], axis=1) \
        if reach.shape[1] else np.zeros((len(depth), 0))  # fmt: skip
    seen = np.isfinite(dvl.ranges)
    share = float((below[seen] < -ABOVE_WATER_M).mean()) if seen.any() else 0.0
    if share < MUCH:
        return []
    return [f"{100 * share:.0f} % of the DVL's returns would lie above the water: are dvl.mount and the tray's angle right?"]


def _rate_of_depth(dvl: DvlPings, pressure: PressureSamples, global_from_dvl: Rotation) -> list[str]:
    """Downward speed by the DVL against that by pressure, over two seconds."""
    moved = np.isfinite(dvl.velocity).all(axis=1)
    if moved.sum() < 10 or len(pressure.t_ns) < 10:
        return []
    ahead, behind = (np.interp(dvl.t_ns + side * NS, pressure.t_ns, pressure.depth) for side in (1, -1))
    truth = ((ahead - behind) / 2)[moved]
    down = global_from_dvl.apply(np.nan_to_num(dvl.velocity))[moved, 2]
    if truth.std() < SLOW:
        return []
    agreement = float(np.corrcoef(down, truth)[0, 1]) if down.std() > 0 else 0.0
    if agreement < -0.3:
        return ["the DVL's downward speed runs against that of the pressure sensor: is dvl.mount turned over?"]
    if agreement < 0.3:
        return ["the DVL's downward speed does not follow that of the pressure sensor: are dvl.mount and its beams right?"]
    return []


def _views(config: DiveConfig) -> list[str]:
    """Camera and DVL ride on one tray and look at one hull."""
    out = []
    top, bottom = config.camera.top, config.camera.bottom
    if top is not None:
        looks = [from_mount(m).rotation.apply([0.0, 0.0, 1.0])[0] for m in (config.dvl.mount, top.mount)]
        apart = float(np.degrees(np.arccos(np.clip(looks[0] @ looks[1], -1, 1))))
        if apart > ASTRAY_DEG:
            out.append(f"camera.top looks {apart:.0f} degrees away from where the DVL looks: is one of the mounts wrong?")
    if bottom is not None:
        baseline = float(np.linalg.norm(bottom.pose_in_top[:3]))
        if not 0.01 <= baseline <= 2.0:
            out.append(f"the cameras are {baseline:.3f} m apart: is camera.bottom.pose_in_top in metres?")
    return out


def _global_from_dvl(config: DiveConfig, records: Mapping[str, Any]) -> Rotation:
    """Of each ping, by the nearest attitude and tray angle."""
    dvl: DvlPings = records["dvl"]
    imu: ImuSamples = records["imu"]
    tray: JointSamples | None = records.get("tray")
    nearest = _nearest(imu.t_ns, dvl.t_ns)
    angle = np.interp(dvl.t_ns, tray.t_ns, tray.angle) if tray is not None and len(tray.t_ns) else np.zeros(len(dvl.t_ns))
    vehicle_from_tray = Rotation.from_euler("y", angle[:, None])
    return Rotation.from_quat(imu.quaternion[nearest]) * vehicle_from_tray * from_mount(config.dvl.mount).rotation


def _nearest(t_ns: Ints, wanted_ns: Ints) -> Ints:
    right = (
        np.clip(np.searchsorted(t_ns, wanted_ns), 1, max(1, len(t_ns) - 1)) if len(t_ns) > 1 else np.zeros(len(wanted_ns), int)
    )
    left = np.maximum(right - 1, 0)
    return np.where(np.abs(t_ns[left] - wanted_ns) <= np.abs(t_ns[right] - wanted_ns), left, right)
