# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find sensors, mounts and clocks that contradict each other, in seconds and before a run."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.check.time_overlap import clock_gaps, shifted_streams
from hullrecon.dive.config.mounts import numbers_of
from hullrecon.dive.config.schema import DiveConfig
from hullrecon.dive.logs.streams.imu import LEAST_FELT_M_S2
from hullrecon.findings.finding import Finding
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

# Findings that are left out where a sensor was found to be wrong, as they are its consequences
COARSE = frozenset({"imu-upside-down", "imu-gravity-tilted", "ranges-above-water"})
ABOVE_WATER_M = 0.5  # a return that far above the surface is not of the hull under water
ABOVE_WATER_SHARE = 0.05  # of the returns; more are reported
APART_DEG = 50.0  # between where a camera and the DVL look
SAME_DEG = 5.0  # between two statements on how one sensor sits
UNPLACED_SHARE = 0.01  # of the DVL's velocities without an attitude; more are reported
UNPLACED_S = 10.0  # of readings under water without a velocity; more are reported
UNDER_WATER_M = 0.5  # a sensor deeper than that is no longer on deck
BASELINE_M = (0.01, 2.0)  # of a stereo rig on a vehicle
UPRIGHT, UPSIDE_DOWN = 0.9, -0.7  # cosine between gravity as measured and the vertical


def check_consistency(
    config: DiveConfig, records: SensorRecords, images: Mapping[str, ImageIndex]
) -> list[Finding]:
    """Report contradictions between sensors, mounts and clocks. Empty where there are none.

    Clocks that are apart are reported by ingest already, as an error. Sensors are then not
    compared.
    """
    streams = {**records.by_name(), **images}
    gaps = clock_gaps(streams)
    out = [finding for finding in gaps if finding.severity == "warning"]
    if len(out) < len(gaps):  # nothing compares sensors whose clocks are apart
        return out + _check_mounts(config)
    out += shifted_streams(streams)
    dvl, imu, pressure = records.dvl, records.imu, records.pressure
    if imu is not None:
        out += _check_gravity(imu, config.imu.frame)
        if len(imu.t_ns) == 1:
            out.append(Finding("imu-single-reading"))
    if dvl is not None and imu is not None and not images:
        out += _check_coverage(dvl, imu, pressure)
    if dvl is not None and imu is not None and pressure is not None:
        global_from_dvl = _global_from_dvl(config, dvl, imu, records.tray)
        out += _check_returns_below_water(dvl, pressure, global_from_dvl)
    return out + _check_mounts(config)


def check_mount_of_attitude(config: DiveConfig, tray: JointSamples | None) -> list[Finding]:
    """Compare imu.mount_deg with dvl.mount where attitude comes from the DVL's own sensors.

    Both keys then give the mount of one instrument, provided that no tray turns it.
    """
    if config.imu.mount_deg is None or tray is not None:
        return []
    by_imu = Rotation.from_euler("ZYX", config.imu.mount_deg[::-1], degrees=True)
    turn = by_imu.inv() * from_mount(config.dvl.mount).rotation
    degrees = float(np.degrees(turn.magnitude().max()))
    return [Finding("mounts-disagree", {"degrees": degrees})] if degrees > SAME_DEG else []


def _check_coverage(
    dvl: DvlPings, imu: ImuSamples, pressure: PressureSamples | None
) -> list[Finding]:
    """Report parts of a dive without images in which DVL or IMU is missing: the path ends there.

    Short parts are not reported.
    """
    heard_ns = dvl.t_ns[np.isfinite(dvl.velocity).all(axis=1)]
    if not len(heard_ns) or not len(imu.t_ns):
        return []
    out = []
    without = np.count_nonzero((heard_ns < imu.t_ns[0] - NS) | (heard_ns > imu.t_ns[-1] + NS))
    if without >= UNPLACED_SHARE * len(heard_ns):
        percent = 100 * without / len(heard_ns)
        out.append(Finding("velocities-without-attitude", {"percent": percent}))
    unheard_s = seconds_beyond(imu.t_ns, pressure, (int(heard_ns[0]), int(heard_ns[-1])))
    if unheard_s >= UNPLACED_S:
        out.append(Finding("imu-without-velocities", {"seconds": unheard_s}))
    return out


def seconds_beyond(t_ns: Ints, pressure: PressureSamples | None, span_ns: tuple[int, int]) -> float:
    """Measure how many seconds a sensor was read under water outside of a span.

    This is the time for which another sensor is missing. Time on deck does not count, as nothing is
    missing there. Without a pressure sensor all of the time counts.

    Parameters
    ----------
    t_ns : (n,) stamps of the sensor, in order
    pressure : tells when the vehicle was under water
    span_ns : first and last instant of the span
    """
    wet = np.ones(len(t_ns), bool)
    if pressure is not None and len(pressure.t_ns):
        wet = np.interp(t_ns, pressure.t_ns, pressure.depth) > UNDER_WATER_M
    is_outside = (t_ns[:-1] < span_ns[0]) | (t_ns[1:] > span_ns[1])
    return float(np.diff(t_ns)[is_outside & wet[:-1] & wet[1:]].sum()) / NS


def _check_gravity(imu: ImuSamples, frame: str) -> list[Finding]:
    """Report an IMU whose measured acceleration is not opposite to gravity.

    Accelerations are in `vehicle`, and are turned into `global` (z down) by the IMU's own
    orientation. At rest they then point up, with the size of gravity. Where they point down, the
    orientation follows the other convention of `imu.frame`. Nothing is reported for accelerations
    that hold no gravity. frame: `imu.frame` of dive.toml, ned or enu.
    """
    felt = Rotation.from_quat(imu.quaternion).apply(imu.acceleration)
    felt = felt[np.isfinite(felt).all(axis=1)]
    if not len(felt) or np.linalg.norm(np.median(felt, axis=0)) < LEAST_FELT_M_S2:
        return []
    # cosine between the measured acceleration and the upward vertical, 1 where all is well
    up = -float(np.median(felt[:, 2])) / float(np.linalg.norm(np.median(felt, axis=0)))
    if up < UPSIDE_DOWN:
        other = "enu" if frame == "ned" else "ned"
        return [Finding("imu-upside-down", {"frame": frame, "other": other})]
    if up < UPRIGHT:
        return [Finding("imu-gravity-tilted", {"degrees": float(np.degrees(np.arccos(up)))})]
    return []


def _check_returns_below_water(
    dvl: DvlPings, pressure: PressureSamples, global_from_dvl: Rotation
) -> list[Finding]:
    """Report DVL returns that would lie above the water's surface: a mount or a sensor is wrong.

    Their depth is that of the pressure sensor, plus the vertical part of the range along the beam.
    Nothing is reported for less than ABOVE_WATER_SHARE of them.
    """
    seen = np.isfinite(dvl.ranges)
    if not seen.any():
        return []
    depth_m = np.interp(dvl.t_ns, pressure.t_ns, pressure.depth)
    along_beam = np.nan_to_num(dvl.ranges)[:, :, None] * dvl.beams
    below = [global_from_dvl.apply(along_beam[:, b])[:, 2] for b in range(along_beam.shape[1])]
    end_depth_m = depth_m[:, None] + np.stack(below, axis=1)
    share = float((end_depth_m[seen] < -ABOVE_WATER_M).mean())
    if share < ABOVE_WATER_SHARE:
        return []
    return [Finding("ranges-above-water", {"percent": 100 * share})]


def _check_mounts(config: DiveConfig) -> list[Finding]:
    """Report a top camera that looks elsewhere than the DVL, and an implausible stereo baseline."""
    out = []
    top, bottom = config.camera.top, config.camera.bottom
    if top is not None:
        axes = [
            from_mount(numbers_of(mount)).rotation.apply([0.0, 0.0, 1.0])[0]
            for mount in (config.dvl.mount, top.mount)
        ]
        degrees = float(np.degrees(np.arccos(np.clip(axes[0] @ axes[1], -1, 1))))
        if degrees > APART_DEG:
            out.append(Finding("camera-dvl-apart", {"degrees": degrees}))
    if bottom is not None:
        baseline_m = float(np.linalg.norm(numbers_of(bottom.pose_in_top)[:3]))
        if not BASELINE_M[0] <= baseline_m <= BASELINE_M[1]:
            out.append(Finding("baseline-implausible", {"metres": baseline_m}))
    return out


def _global_from_dvl(
    config: DiveConfig, dvl: DvlPings, imu: ImuSamples, tray: JointSamples | None
) -> Rotation:
    """Compute the DVL's attitude at each ping from the nearest IMU reading and the tray's angle.

    Without a tray its angle is taken as zero.
    """
    row = nearest(imu.t_ns, dvl.t_ns)
    angle = np.zeros(len(dvl.t_ns))
    if tray is not None and len(tray.t_ns):
        angle = np.interp(dvl.t_ns, tray.t_ns, tray.angle)
    global_from_vehicle = Rotation.from_quat(imu.quaternion[row])
    vehicle_from_tray = Rotation.from_euler("y", angle[:, None])
    tray_from_dvl = from_mount(numbers_of(config.dvl.mount)).rotation
    return global_from_vehicle * vehicle_from_tray * tray_from_dvl
