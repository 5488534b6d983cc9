# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Turn samples into records: one set of units and conventions, NaN for lost values, remarks on what
was assumed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.dvl_beams import check_beams, choose_beams, unit
from hullrecon.dive.logs.ping_spool import Images, KeepImages, bright_pixel
from hullrecon.dive.logs.samples import (
    DepthSample,
    DvlSample,
    ImuSample,
    JointSample,
    PressureSample,
    SonarSample,
)
from hullrecon.dive.logs.sonar_geometry import (
    choose_directions,
    image_in_ranges,
    pings_of_one_window,
)
from hullrecon.errors import InputError
from hullrecon.records.sensors import (
    DvlPings,
    ImuSamples,
    JointSamples,
    PressureSamples,
    SonarPings,
)
from hullrecon.typing import Array, Ints, Mask

# ROS 2's default; as many alike, to the last digit, are no measurement
UNFILLED, LEAST_ATTITUDES = (0.0, 0.0, 0.0, 1.0), 50
# of pings have no brighter bright pixel than the one that is white: a few may be disturbed
BRIGHT_PINGS_PERCENT = 99.0
FASTEST = 15.0  # m/s; no vehicle at a hull is faster
NED_FROM_ENU = Rotation.from_matrix([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
FRD_FROM_FLU = Rotation.from_matrix(np.diag([1.0, -1.0, -1.0]))


@dataclass(frozen=True)
class PressureModel:
    density: float  # kg/m3
    gravity: float  # m/s2
    atmosphere: float  # Pa
    z_axis: str | None = None  # "up" or "down", of logged depths; None: as their type has it


@np.errstate(all="ignore")  # values of any size: what is absurd is left out below
def dvl_pings(
    samples: Sequence[DvlSample], beams: Array | None, sigma: float, remarks: list[str]
) -> DvlPings:
    """Return the pings. beams: those of dive.toml, for messages without (docs/configuration.md);
    sigma: m/s, where a message has none. Raises InputError for ranges along beams that nothing
    describes.
    """
    count = Counter(len(s.ranges) for s in samples if len(s.ranges)).most_common(1)
    width = count[0][0] if count else 0
    ranges = np.full((len(samples), width), np.nan)
    for row, sample in enumerate(samples):
        if len(sample.ranges) == width:
            ranges[row] = sample.ranges
    ranges[~(ranges > 0)] = np.nan
    if width and not np.isfinite(ranges).any():
        remarks.append("dvl: every range is lost; it measures no distance to the hull")
        ranges, width = ranges[:, :0], 0
    velocity = np.array([s.velocity for s in samples]).reshape(-1, 3)
    velocity[~np.isfinite(velocity).all(axis=1)] = np.nan
    absurd = np.linalg.norm(np.nan_to_num(velocity), axis=1) > FASTEST
    if absurd.any():
        velocity[absurd] = np.nan
        remarks.append(
            f"dvl: {absurd.sum()} velocities above {FASTEST:.0f} m/s were taken as lost (are they in mm/s?)"
        )
    given = np.array([s.sigma for s in samples])
    used = np.where(np.isfinite(given) & (given > 0), given, sigma)
    directions = choose_beams(samples, beams, width, remarks)
    along_axis = np.array([s.along_axis for s in samples], bool)
    along_beams = ranges[along_axis] / directions[:, 2]
    ranges[along_axis] = np.where(np.isfinite(along_beams) & (along_beams > 0), along_beams, np.nan)
    remarks += check_beams(directions, ranges, np.array([s.altitude for s in samples]))
    return DvlPings(
        t_ns=_times(samples),
        velocity=velocity,
        velocity_sigma=used,
        ranges=ranges,
        beams=directions,
    )


@np.errstate(all="ignore")
def imu_samples(
    samples: Sequence[ImuSample],
    frame: str,
    remarks: list[str],
    mount_deg: tuple[float, float, float] | None = None,
) -> ImuSamples:
    """Return attitudes and rates. frame: "ned" for body forward-starboard-down in north-east-down,
    "enu" for body forward-port-up in east-north-up; mount_deg: of the IMU in the vehicle. Rows
    without an attitude are left out. All samples are those of an IMU, or all of a DVL's own
    sensors.

    Raises InputError when no row has an attitude or all have one that is not filled in, and for a
    DVL's attitude without mount_deg.
    """
    quaternion = np.array([s.quaternion for s in samples]).reshape(-1, 4)
    length = np.linalg.norm(quaternion, axis=1)
    good = np.abs(length - 1) < 0.05
    if len(samples) and not good.any():
        raise InputError(
            "the IMU's messages hold no attitude (no unit quaternion)",
            remedy="log an IMU that gives orientation",
        )
    if not good.all():
        remarks.append(
            f"imu: {np.count_nonzero(~good)} of {len(good)} readings have no attitude and were left out"
        )
    rates = np.array([s.rates for s in samples]).reshape(-1, 3)[good]
    _refuse_unfilled(quaternion[good], rates)
    rotation = Rotation.from_quat(quaternion[good])
    acceleration = np.array([s.acceleration for s in samples]).reshape(-1, 3)[good]
    if any(s.of_dvl for s in samples):
        mount_deg = _mount_of_dvl(mount_deg, remarks)
    elif frame == "enu":
        rotation = NED_FROM_ENU * rotation * FRD_FROM_FLU.inv()
        rates, acceleration = rates * [1, -1, -1], acceleration * [1, -1, -1]
    if mount_deg is not None:
        vehicle_from_imu = Rotation.from_euler("ZYX", mount_deg[::-1], degrees=True)
        rotation = rotation * vehicle_from_imu.inv()
        rates, acceleration = vehicle_from_imu.apply(rates), vehicle_from_imu.apply(acceleration)
    return ImuSamples(
        t_ns=_times(samples)[good],
        quaternion=rotation.as_quat(),
        angular_velocity=rates,
        acceleration=acceleration,
    )


def _refuse_unfilled(quaternion: Array, rates: Array) -> None:
    """Raise InputError for orientations (n, 4) that are a constant that nobody has measured: a
    message's default, or one that stands still while the rates (n, 3) do not. A simulated vehicle
    at rest has neither.
    """
    if len(quaternion) < LEAST_ATTITUDES or (quaternion != quaternion[0]).any():
        return
    turns = bool((np.nan_to_num(rates) != 0).any())
    if turns or np.array_equal(np.abs(quaternion[0]), UNFILLED):
        shown = ", ".join(f"{value:g}" for value in quaternion[0])
        why = (
            "while its rates are not zero"
            if turns
            else "which is the default of a message that is not filled in"
        )
        raise InputError(
            f"the IMU's orientation is the same, ({shown}), in all {len(quaternion)} readings, {why}",
            remedy="log an IMU that gives orientation, or the topic of the filter that computes it",
        )


def _mount_of_dvl(
    mount_deg: tuple[float, float, float] | None, remarks: list[str]
) -> tuple[float, float, float]:
    """Return it: the attitude of the frame `dvl` says nothing of the vehicle's without it."""
    if mount_deg is None:
        raise InputError(
            "the only attitude is that of the DVL's own sensors, and nothing says how the DVL sits in the vehicle",
            where="imu.mount_deg",
            remedy="give roll, pitch, yaw of the frame dvl there: [0, 0, 0] where it looks down with its x forward, [0, 90, 0] "
            "where it looks ahead",
        )
    remarks.append(
        "imu: attitude comes from the DVL's own sensors; a compass beside a steel hull can be off by tens of degrees, which "
        "imu.heading_drift_deg_per_hour has to cover"
    )
    return mount_deg


def is_of_dvl(sample: object) -> bool:
    """Return whether a sample is an attitude or a depth by sensors inside of the DVL."""
    return isinstance(sample, ImuSample | DepthSample) and sample.of_dvl


def describe_left_aside(sensor: str, count: int) -> str:
    """Return a sentence on samples by the DVL's own sensors where the sensor ("imu", "pressure")
    was logged too.
    """
    what, other = ("attitudes", "the IMU") if sensor == "imu" else ("depths", "the pressure sensor")
    return f"{sensor}: {count} {what} by the DVL's own sensors were left aside for those of {other}"


@np.errstate(all="ignore")
def pressure_samples(
    samples: Sequence[PressureSample | DepthSample], model: PressureModel, remarks: list[str]
) -> PressureSamples | None:
    """Return the depth of the sensor, positive down; readings that are not finite are left out,
    None where all are. All samples are those of one sensor.
    """
    if any(is_of_dvl(s) for s in samples):
        remarks.append(
            "pressure: depth comes from the DVL's own sensor; pressure.origin is that sensor's"
        )
    depth = np.array([_depth(s, model) for s in samples])
    good = np.isfinite(depth)
    remarks += _describe_lost("pressure", good)
    if not good.any():
        return None
    depth = depth[good]
    if np.median(depth) < -1.0:
        advice = (
            "is pressure.z_axis right?"
            if isinstance(samples[0], DepthSample)
            else "is the pressure absolute and in pascal?"
        )
        remarks.append(
            f"pressure: the median depth is {np.median(depth):.1f} m, above the water: {advice}"
        )
    return PressureSamples(t_ns=_times(samples)[good], depth=depth)


def _depth(sample: PressureSample | DepthSample, model: PressureModel) -> float:
    if isinstance(sample, PressureSample):
        return (sample.pascal - model.atmosphere) / (model.density * model.gravity)
    is_up = sample.is_up if model.z_axis is None else model.z_axis == "up"
    return -sample.height if is_up else sample.height


@np.errstate(all="ignore")
def joint_samples(
    samples: Sequence[JointSample], name: str, remarks: list[str]
) -> JointSamples | None:
    """Return one servo's angle; readings that are not finite are left out, None where all are."""
    angle = np.array([s.angle for s in samples])
    good = np.isfinite(angle)
    remarks += _describe_lost(f"joint {name}", good)
    if not good.any():
        return None
    if np.abs(angle[good]).max() > 2 * np.pi:
        remarks.append(
            f"joint {name}: angles reach {np.abs(angle[good]).max():.1f} rad; are they in degrees?"
        )
    return JointSamples(t_ns=_times(samples)[good], angle=angle[good])


def _describe_lost(name: str, good: Mask) -> list[str]:
    """Return a sentence on readings (n,) that are not finite."""
    lost = int(np.count_nonzero(~good))
    return (
        [f"{name}: {lost} of {len(good)} readings are no finite numbers and were left out"]
        if lost
        else []
    )


def keep_in_memory(shape: tuple[int, int, int], images: Iterator[Images]) -> Images:
    """Return the images as one array."""
    kept = np.empty(shape, np.uint8)
    for row, image in zip(kept, images, strict=True):
        row[:] = image
    return kept


def leave_black(shape: tuple[int, int, int], images: Iterator[Images]) -> Images:
    """Return black images, which take no memory."""
    return np.broadcast_to(np.uint8(0), shape)


@np.errstate(all="ignore")
def sonar_pings(
    samples: Sequence[SonarSample],
    remarks: list[str],
    azimuth_deg: Array | None = None,
    keep: KeepImages = keep_in_memory,
    load: Callable[[SonarSample], SonarSample] = lambda sample: sample,
) -> SonarPings | None:
    """Return pings of the most common geometry, as 8 bits; None without any. azimuth_deg (beams,):
    of dive.toml, for logs that do not say where the beams point; keep: keeps the images; load:
    gives a ping with its image, where samples have another of the same shape and bright pixel.
    Raises InputError for beams that nothing describes.
    """
    kept, range_m = pings_of_one_window(samples, remarks)
    if not kept:
        return None
    directions = choose_directions(kept[0], azimuth_deg, remarks)
    scale = _scale_to_eight_bits(kept, remarks)
    shape = (len(kept), len(directions), len(range_m))
    image = keep(
        shape, (_eight_bits(image_in_ranges(load(sample), range_m), scale) for sample in kept)
    )
    return SonarPings(
        t_ns=_times(kept),
        image=image,
        directions=unit(directions),
        range_m=np.asarray(range_m, float),
    )


def _scale_to_eight_bits(samples: Sequence[SonarSample], remarks: list[str]) -> float | None:
    """Return the factor that brings the bright pixel of nearly all pings to 255; None where all
    pixels have 8 bits.
    """
    if all(sample.image.dtype == np.uint8 for sample in samples):
        return None
    bright = np.array([float(bright_pixel(sample.image)) for sample in samples])
    bright = bright[bright > 0]
    white = (
        float(np.percentile(bright, BRIGHT_PINGS_PERCENT, method="higher")) if len(bright) else 0.0
    )
    remarks.append(
        f"sonar: {samples[0].image.dtype} pixels were scaled to 8 bits, {white:g} and more to 255"
    )
    return 255.0 / white if white > 0 else 0.0


def _eight_bits(image: NDArray[np.generic], scale: float | None) -> NDArray[np.uint8]:
    if scale is None:
        return image.astype(np.uint8)
    return np.asarray(np.clip(np.nan_to_num(image.astype(float)) * scale, 0, 255).round(), np.uint8)


def _times(samples: Sequence[object]) -> Ints:
    return np.array([s.t_ns for s in samples], np.int64)  # type: ignore[attr-defined]
