# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find what contradicts itself in a dive before an hour of work, not after."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.check.messages import Stream
from hullrecon.dive.config.mounts import numbers_of
from hullrecon.dive.config.schema import DiveConfig
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import from_mount
from hullrecon.records.clock import NS, nearest
from hullrecon.records.sensors import (
    DvlPings,
    ImageIndex,
    ImuSamples,
    JointSamples,
    PressureSamples,
    SensorRecords,
)
from hullrecon.typing import Ints

ABOVE_WATER_M = 0.5  # a return that far above the surface is not of the hull under water
MUCH = 0.05  # share of returns above water
APART_DEG = 50.0  # between where a camera and the DVL look
SAME_DEG = 5.0  # between two statements on how one sensor sits
UNPLACED_SHARE = 0.01  # of the DVL's velocities without an attitude, from which on it is said
UNPLACED_S = 10.0  # of readings under water without a velocity, from which on it is said
UNDER_WATER_M = 0.5  # a sensor deeper than that is no longer on deck
SLOW = 0.02  # m/s; below, depth's rate says nothing about the DVL


def check_consistency(
    config: DiveConfig, records: SensorRecords, images: Mapping[str, ImageIndex]
) -> list[str]:
    """Return a sentence for each contradiction between sensors, mounts and clocks; none where all
    fits.
    """
    out = _check_clocks({**records.by_name(), **images})
    dvl, imu, pressure = records.dvl, records.imu, records.pressure
    if imu is not None:
        out += _check_gravity(imu, config.imu.frame)
        if len(imu.t_ns) == 1:
            out.append("the IMU gave a single reading, which tells no attitude")
    if dvl is not None and imu is not None and not images:
        out += _check_reckoned(dvl, imu, pressure)
    if dvl is not None and imu is not None and pressure is not None:
        global_from_dvl = _global_from_dvl(config, dvl, imu, records.tray)
        out += _check_returns_below_water(dvl, pressure, global_from_dvl)
        out += _check_depth_rate(dvl, pressure, global_from_dvl)
    return out + _check_mounts(config)


def describe_start_offset(records: SensorRecords, images: Mapping[str, ImageIndex]) -> list[str]:
    """Return how much later or earlier than the first DVL ping the first image is; nothing without
    both.
    """
    top = images.get(Camera.TOP.key)
    if records.dvl is None or top is None:
        return []
    seconds = (int(top.t_ns[0]) - int(records.dvl.t_ns[0])) / NS
    side = "after" if seconds >= 0 else "before"
    return [f"the first camera image is {abs(seconds):.1f} s {side} the first DVL ping"]


def check_mount_of_attitude(config: DiveConfig, tray: JointSamples | None) -> list[str]:
    """Return a sentence where imu.mount_deg and dvl.mount place the DVL's axes differently, on a
    tray that does not turn.

    For a dive whose attitude is that of the DVL's own sensors: both keys are of one instrument.
    """
    if config.imu.mount_deg is None or tray is not None:
        return []
    by_imu = Rotation.from_euler("ZYX", config.imu.mount_deg[::-1], degrees=True)
    apart = float(
        np.degrees((by_imu.inv() * from_mount(config.dvl.mount).rotation).magnitude().max())
    )
    if apart <= SAME_DEG:
        return []
    return [
        f"imu.mount_deg and dvl.mount turn the DVL's axes {apart:.0f} degrees apart, and both say how the one DVL sits in the "
        "vehicle: is one of them wrong?"
    ]


def _check_clocks(streams: Mapping[str, Stream]) -> list[str]:
    """Return a sentence for each stream that does not overlap in time with the longest one. A
    single reading, as of a joint that stands still, says nothing about a clock.
    """
    spans = {
        name: (int(s.t_ns[0]), int(s.t_ns[-1])) for name, s in streams.items() if len(s.t_ns) > 1
    }
    if not spans:
        return []
    main = max(spans, key=lambda name: spans[name][1] - spans[name][0])
    low, high = spans[main]
    apart = {name: max(start - high, low - end) / NS for name, (start, end) in spans.items()}
    return [
        f"{name} and {main} do not overlap in time: one of the clocks is off by {seconds:.1f} s or more"
        for name, seconds in apart.items()
        if seconds > 0
    ]


def _check_reckoned(dvl: DvlPings, imu: ImuSamples, pressure: PressureSamples | None) -> list[str]:
    """Return a sentence where DVL or IMU were lost for a part of a dive without images: the path
    ends there.
    """
    heard_ns = dvl.t_ns[np.isfinite(dvl.velocity).all(axis=1)]
    if not len(heard_ns) or not len(imu.t_ns):
        return []
    out = []
    without = np.count_nonzero((heard_ns < imu.t_ns[0] - NS) | (heard_ns > imu.t_ns[-1] + NS))
    if without >= UNPLACED_SHARE * len(heard_ns):
        share = 100 * without / len(heard_ns)
        out.append(
            f"{share:.0f} % of the DVL's velocities lie where no attitude was read: a run cannot use them"
        )
    unheard_s = seconds_beyond(imu.t_ns, pressure, (int(heard_ns[0]), int(heard_ns[-1])))
    if unheard_s >= UNPLACED_S:
        out.append(
            f"the IMU was read for {unheard_s:.1f} s under water before the first or after the last velocity of the DVL: "
            "no image tells where the vehicle was then, and a run leaves that part out"
        )
    return out


def seconds_beyond(t_ns: Ints, pressure: PressureSamples | None, span_ns: tuple[int, int]) -> float:
    """Return how long a sensor was read (t_ns, in time order) before and after a span, s, and under
    water where a pressure says so: a logger that runs on deck misses nothing.
    """
    wet = np.ones(len(t_ns), bool)
    if pressure is not None and len(pressure.t_ns):
        wet = np.interp(t_ns, pressure.t_ns, pressure.depth) > UNDER_WATER_M
    away = (t_ns[:-1] < span_ns[0]) | (t_ns[1:] > span_ns[1])
    return float(np.diff(t_ns)[away & wet[:-1] & wet[1:]].sum()) / NS


def _check_gravity(imu: ImuSamples, frame: str) -> list[str]:
    """Compare the measured acceleration with what an accelerometer at rest feels: g upward, -g
    along z of `global`.
    """
    felt = Rotation.from_quat(imu.quaternion).apply(imu.acceleration)
    felt = felt[np.isfinite(felt).all(axis=1)]
    if not len(felt) or np.linalg.norm(np.median(felt, axis=0)) < 5.0:
        return []
    up = -float(np.median(felt[:, 2])) / float(np.linalg.norm(np.median(felt, axis=0)))
    other = "enu" if frame == "ned" else "ned"
    if up < -0.7:
        return [f'imu: gravity pulls upward with imu.frame = "{frame}"; is it "{other}"?']
    return (
        [
            f"imu: gravity is {np.degrees(np.arccos(up)):.0f} degrees off the vertical: is imu.frame right?"
        ]
        if up < 0.9
        else []
    )


def _check_returns_below_water(
    dvl: DvlPings, pressure: PressureSamples, global_from_dvl: Rotation
) -> list[str]:
    """Return a sentence where a share of MUCH or more of the DVL's returns would lie above the
    water.
    """
    depth = np.interp(dvl.t_ns, pressure.t_ns, pressure.depth)
    reach = np.nan_to_num(dvl.ranges)[:, :, None] * dvl.beams
    below = (
        depth[:, None]
        + np.stack(
            [global_from_dvl.apply(reach[:, b])[:, 2] for b in range(reach.shape[1])], axis=1
        )
        if reach.shape[1]
        else np.zeros((len(depth), 0))
    )
    seen = np.isfinite(dvl.ranges)
    share = float((below[seen] < -ABOVE_WATER_M).mean()) if seen.any() else 0.0
    if share < MUCH:
        return []
    return [
        f"{100 * share:.0f} % of the DVL's returns would lie above the water: are dvl.mount and the tray's angle right?"
    ]


def _check_depth_rate(
    dvl: DvlPings, pressure: PressureSamples, global_from_dvl: Rotation
) -> list[str]:
    """Compare the downward speed by the DVL with that by pressure over two seconds."""
    moved = np.isfinite(dvl.velocity).all(axis=1)
    if moved.sum() < 10 or len(pressure.t_ns) < 10:
        return []
    ahead, behind = (
        np.interp(dvl.t_ns + side * NS, pressure.t_ns, pressure.depth) for side in (1, -1)
    )
    truth = ((ahead - behind) / 2)[moved]
    down = global_from_dvl.apply(np.nan_to_num(dvl.velocity))[moved, 2]
    if truth.std() < SLOW:
        return []
    agreement = float(np.corrcoef(down, truth)[0, 1]) if down.std() > 0 else 0.0
    if agreement < -0.3:
        return [
            "the DVL's downward speed runs against that of the pressure sensor: is dvl.mount turned over?"
        ]
    if agreement < 0.3:
        return [
            "the DVL's downward speed does not follow that of the pressure sensor: are dvl.mount and its beams right?"
        ]
    return []


def _check_mounts(config: DiveConfig) -> list[str]:
    """Return a sentence where camera and DVL, which share the tray, look different ways, or the
    baseline is implausible.
    """
    out = []
    top, bottom = config.camera.top, config.camera.bottom
    if top is not None:
        looks = [
            from_mount(numbers_of(m)).rotation.apply([0.0, 0.0, 1.0])[0]
            for m in (config.dvl.mount, top.mount)
        ]
        apart = float(np.degrees(np.arccos(np.clip(looks[0] @ looks[1], -1, 1))))
        if apart > APART_DEG:
            out.append(
                f"camera.top looks {apart:.0f} degrees away from where the DVL looks: is one of the mounts wrong?"
            )
    if bottom is not None:
        baseline = float(np.linalg.norm(numbers_of(bottom.pose_in_top)[:3]))
        if not 0.01 <= baseline <= 2.0:
            out.append(
                f"the cameras are {baseline:.3f} m apart: is camera.bottom.pose_in_top in metres?"
            )
    return out


def _global_from_dvl(
    config: DiveConfig, dvl: DvlPings, imu: ImuSamples, tray: JointSamples | None
) -> Rotation:
    """Return R_g_d of each ping by the nearest attitude and the tray's angle."""
    row = nearest(imu.t_ns, dvl.t_ns)
    angle = (
        np.interp(dvl.t_ns, tray.t_ns, tray.angle)
        if tray is not None and len(tray.t_ns)
        else np.zeros(len(dvl.t_ns))
    )
    vehicle_from_tray = Rotation.from_euler("y", angle[:, None])
    return (
        Rotation.from_quat(imu.quaternion[row])
        * vehicle_from_tray
        * from_mount(numbers_of(config.dvl.mount)).rotation
    )
