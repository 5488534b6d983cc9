# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What may be wrong with a sensor: each hypothesis holds the records with its fault taken off.

Comparisons are made again with them (suspects.py). Nothing here judges.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.streams import FRD_FROM_FLU, METRES, NED_FROM_ENU, PASCALS
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.rotations import mount_angles_deg
from hullrecon.navigation.suspects.comparisons import Flow, Sensor
from hullrecon.records.clock import NS
from hullrecon.records.sensors import (
    DvlPings,
    ImuSamples,
    JointSamples,
    PressureSamples,
    SensorRecords,
)
from hullrecon.typing import Array, Ints, Mask

# Units in which readings may have been logged in place of Pa, m, m/s
PASCAL = {u: pa for u, pa in PASCALS.items() if u not in ("Pa", "mbar")}
METRES_PER_SECOND = {"cm/s": 0.01, "mm/s": 0.001, "ft/s": 0.3048, "kn": 0.514444}
RADIANS_A_SECOND = {
    "deg/s": np.pi / 180,
    "mdeg/s": np.pi / 180e3,
    "mrad/s": 1e-3,
    "rpm": np.pi / 30,
}
# by which a length may be too short or too long: steps that the comparisons tolerate
FACTORS = [*np.geomspace(0.5, 0.93, 10), *np.geomspace(1.07, 2.0, 10)]
SIZES = (0.25, 0.5, 2.0, 4.0)  # of a calibration's pictures over those logged: reduced ones
RADIAL = [s * k for k in np.arange(0.05, 0.65, 0.05) for s in (1, -1)]  # of k1, as tolerated
WATER = 1.333  # refractive index of water: a calibration made in air has focal lengths that short
REPEATED = 4  # pings with one velocity to the last digit: noise of 1 mm/s makes two of them rare
# between the clocks of two sensors, as far as navigation/clocks searches, in steps that the depth
# comparison tolerates near zero
LATE_S = [s * late for late in (*np.arange(0.25, 5.0, 0.25), *range(5, 61)) for s in (1, -1)]

TURN_STEP_DEG = 5  # of a DVL about its axis, an IMU about the vehicle's: comparisons tolerate it
FASTEST = 0.03  # rate of a clock that is doubted: quartz is right to 1e-4, a wrong divider is not
UPRIGHT = 0.7  # mean cosine of the tilt, above which a vehicle is not on its side
FAR_S = 5.0  # beyond which the clock of a camera is not doubted

Stream = TypeVar("Stream")


@dataclass(frozen=True, kw_only=True)
class Hypothesis:
    """A fault of one sensor."""

    sensor: Sensor
    fault: str  # the second of a key of FAULTS of hullrecon/findings/sensors.py, "clock" or "rate"
    value: str  # which unit, which axes
    mended: SensorRecords  # with the fault taken off; without the sensor where nothing mends it
    exact: bool = False  # the mended readings can be used
    flows: Sequence[Flow] | None = None  # of the images, where the camera is at fault
    late_s: float = 0.0  # of a clock's stamps, of the last where it runs fast


def hypotheses(
    records: SensorRecords,
    sensors: Set[Sensor],
    atmosphere_m: float,
    flows: Sequence[Flow] = (),
    camera: CameraModel | None = None,
) -> Iterator[Hypothesis]:
    """List what may be wrong with some sensors of a dive, one fault at a time.

    Parameters
    ----------
    records, sensors
        The dive, and who is suspected.
    atmosphere_m
        The air's pressure in metres of water, which was taken off.
    flows, camera
        Of the images, and by which calibration.
    """
    dvl, imu, pressure, tray = records.dvl, records.imu, records.pressure, records.tray
    if Sensor.PRESSURE in sensors and pressure is not None:
        yield from _of_pressure(records, pressure, atmosphere_m)
    if Sensor.DVL in sensors and dvl is not None:
        yield from _of_dvl(records, dvl)
    if Sensor.RATES in sensors and imu is not None:
        yield from _of_rates(records, imu)
    if imu is not None and sensors & {Sensor.ATTITUDE, Sensor.ACCELERATION}:
        yield from _of_attitude(records, imu)
    if Sensor.TRAY in sensors and tray is not None:
        yield from _of_tray(records, tray)
    if Sensor.CAMERA in sensors:
        yield from _of_camera(records, flows, camera)


def _of_pressure(
    records: SensorRecords, pressure: PressureSamples, air_m: float
) -> Iterator[Hypothesis]:
    """Vary the pressure: units, scales, gauge pressure, sign, no reading at all, clocks."""
    depth = pressure.depth
    # the usual readings first: of those that explain as much, the first counts
    readings = {
        **{("unit", unit): pa * (depth + air_m) - air_m for unit, pa in PASCAL.items()},
        **{("unit", unit): metre * depth for unit, metre in METRES.items() if metre != 1},
        **{("scale", f"{factor:.2f}"): factor * depth for factor in FACTORS},
        **{("gauge", unit): pa * (depth + air_m) for unit, pa in {"Pa": 1.0, **PASCAL}.items()},
        ("sign", ""): -depth,
    }
    for (fault, value), mended in readings.items():
        held = replace(records, pressure=replace(pressure, depth=mended))
        yield Hypothesis(sensor=Sensor.PRESSURE, fault=fault, value=value, mended=held, exact=True)
    gone = replace(records, pressure=None)
    yield Hypothesis(sensor=Sensor.PRESSURE, fault="constant", value="", mended=gone, exact=True)
    for clock in _clocks(pressure.t_ns):
        yield clock.of(Sensor.PRESSURE, replace(records, pressure=clock.on(pressure)))


def _of_dvl(records: SensorRecords, dvl: DvlPings) -> Iterator[Hypothesis]:
    """Vary the DVL: units, scales, axes and turns of its velocity, its ranges, beams, and clock."""
    frozen = repeated(dvl.velocity)
    readings = {
        **{
            ("unit", unit): (factor * dvl.velocity, True)
            for unit, factor in METRES_PER_SECOND.items()
        },
        **{("scale", f"{f:.2f}"): (f * dvl.velocity, False) for f in FACTORS},
        **{("axes", name): (dvl.velocity @ turn.T, False) for name, turn in signed_axes()},
    }
    for angle in range(-175, 180, TURN_STEP_DEG):  # by right angles: "axes"
        if angle % 90:
            turn = Rotation.from_euler("z", angle, degrees=True)
            readings["turn", f"{angle:d}"] = turn.apply(dvl.velocity), False
    if frozen.any():
        readings["repeated", ""] = (np.where(frozen[:, None], np.nan, dvl.velocity), True)
    for (fault, value), (velocity, exact) in readings.items():
        held = replace(records, dvl=replace(dvl, velocity=velocity))
        yield Hypothesis(sensor=Sensor.DVL, fault=fault, value=value, mended=held, exact=exact)
    for value, factor in {**METRES, **{f"{f:.2f}": f for f in FACTORS}}.items():
        held = replace(records, dvl=replace(dvl, ranges=factor * dvl.ranges))
        if factor != 1:
            yield Hypothesis(sensor=Sensor.DVL, fault="ranges", value=value, mended=held)
    for order in itertools.permutations(range(4)) if dvl.ranges.shape[1] == 4 else ():
        held = replace(records, dvl=replace(dvl, ranges=dvl.ranges[:, order]))
        if order != (0, 1, 2, 3):
            value = ", ".join(str(beam + 1) for beam in order)
            yield Hypothesis(sensor=Sensor.DVL, fault="beams", value=value, mended=held)
    for clock in _clocks(dvl.t_ns):
        yield clock.of(Sensor.DVL, replace(records, dvl=clock.on(dvl)))


def _of_rates(records: SensorRecords, imu: ImuSamples) -> Iterator[Hypothesis]:
    """Vary the IMU's rates: units and axes, also both at once."""
    degree = np.pi / 180
    readings = {("unit", unit): f * imu.angular_velocity for unit, f in RADIANS_A_SECOND.items()}
    for name, turn in signed_axes():
        readings["axes", name] = imu.angular_velocity @ turn.T
        readings["axes", f"{name}, deg/s"] = degree * imu.angular_velocity @ turn.T
    for (fault, value), rates in readings.items():
        held = replace(records, imu=replace(imu, angular_velocity=rates))
        yield Hypothesis(sensor=Sensor.RATES, fault=fault, value=value, mended=held, exact=True)


def _of_attitude(records: SensorRecords, imu: ImuSamples) -> Iterator[Hypothesis]:
    """Vary the IMU: conventions of its orientation, mount, axes of accelerations, clock."""
    # The orientation alone: written in another order, in other frames, with other signs or axes.
    attitude = Rotation.from_quat(imu.quaternion)
    angles = attitude.as_euler("ZYX")
    turned = {
        ("order", "inverse"): attitude.inv(),
        ("order", "w x y z"): Rotation.from_quat(imu.quaternion[:, [1, 2, 3, 0]]),
        ("order", "of roll and pitch exchanged"): Rotation.from_euler("ZYX", angles[:, [0, 2, 1]]),
        ("frame", "global axes"): NED_FROM_ENU * attitude,
        ("frame", "the orientation's axes alone"): NED_FROM_ENU * attitude * FRD_FROM_FLU,
        ("frame", "the vehicle's axes of the orientation alone"): attitude * FRD_FROM_FLU,
    }
    for signs in itertools.product([1.0, -1.0], repeat=3):
        name = " and ".join(
            n for n, s in zip(("yaw", "pitch", "roll"), signs, strict=True) if s < 0
        )
        if name:
            turned["sign", name] = Rotation.from_euler("ZYX", angles * signs)
    quaternions = {key: rotation.as_quat() for key, rotation in turned.items()}
    quaternions |= {("axes", name): turned for name, turned in _of_other_axes(attitude)}
    for (fault, value), quaternion in quaternions.items():
        held = replace(records, imu=replace(imu, quaternion=quaternion))
        yield Hypothesis(sensor=Sensor.ATTITUDE, fault=fault, value=value, mended=held)
    for clock in _clocks(imu.t_ns):
        yield clock.of(Sensor.ATTITUDE, replace(records, imu=clock.on(imu)))
    # The whole instrument: in the other convention, mounted turned about the vehicle's z, or on
    # its side.
    bodies = {
        ("frame", "all axes"): (NED_FROM_ENU, FRD_FROM_FLU),
        ("frame", "vehicle's axes"): (Rotation.identity(), FRD_FROM_FLU),
    }
    for angle in range(TURN_STEP_DEG - 180, 181, TURN_STEP_DEG):
        if angle:
            imu_from_vehicle = Rotation.from_euler("z", -angle, degrees=True)
            bodies["mount", f"{angle:d}"] = Rotation.identity(), imu_from_vehicle
    for name, vehicle_from_imu in _on_its_side():
        if _uprightness(attitude * vehicle_from_imu.inv()) > UPRIGHT:  # else a DVL sits otherwise
            bodies["body", name] = Rotation.identity(), vehicle_from_imu.inv()
    for (fault, value), (rotation, imu_from_vehicle) in bodies.items():
        axes = imu_from_vehicle.as_matrix()
        body = replace(
            imu,
            quaternion=_chained(rotation, attitude.as_quat(), imu_from_vehicle),
            angular_velocity=imu.angular_velocity @ axes,
            acceleration=imu.acceleration @ axes,
        )
        held = replace(records, imu=body)
        yield Hypothesis(sensor=Sensor.ATTITUDE, fault=fault, value=value, mended=held)
    # The accelerations alone.
    felt = {("sign", ""): -imu.acceleration}
    felt |= {("axes", name): imu.acceleration @ turn.T for name, turn in signed_axes()}
    for (fault, value), acceleration in felt.items():
        held = replace(records, imu=replace(imu, acceleration=acceleration))
        yield Hypothesis(
            sensor=Sensor.ACCELERATION, fault=fault, value=value, mended=held, exact=True
        )


def _of_tray(records: SensorRecords, tray: JointSamples) -> Iterator[Hypothesis]:
    """Vary the tray's angles: units, zeros a quarter of a turn away, and signs."""
    degree = np.pi / 180
    for off_deg in (90, -90, 180):
        held = replace(records, tray=replace(tray, angle=tray.angle - degree * off_deg))
        yield Hypothesis(
            sensor=Sensor.TRAY, fault="zero", value=f"{off_deg:+d}", mended=held, exact=True
        )
    for fault, value, factor, exact in (
        ("unit", "deg", degree, True),
        ("unit", "rad", 1 / degree, True),
        ("sign", "", -1.0, False),
        ("sign", "deg", -degree, False),
    ):
        held = replace(records, tray=replace(tray, angle=factor * tray.angle))
        yield Hypothesis(sensor=Sensor.TRAY, fault=fault, value=value, mended=held, exact=exact)


def _of_camera(
    records: SensorRecords, flows: Sequence[Flow], camera: CameraModel | None
) -> Iterator[Hypothesis]:
    """Vary the camera: focal length, medium, turn and size of its pictures, lens, clock."""
    turns = {("focal", f"{factor:.2f}"): np.eye(2) / factor for factor in FACTORS}
    turns |= {("medium", f"{WATER:.2f}"): np.eye(2) / WATER}
    for name, turn in signed_axes():
        if turn[2, 2] == 1 and not turn[:2, 2].any() and not turn[2, :2].any():
            turns["picture", name[:5]] = turn[:2, :2]
    lenses = {name: partial(_turned, turn=turn) for name, turn in turns.items()}
    lenses |= {("distortion", f"{k1:+.2f}"): partial(_straightened, k1=k1) for k1 in RADIAL}
    if camera is not None:
        lenses |= {
            ("size", f"{size:g}"): partial(_resized, camera=camera, size=size) for size in SIZES
        }
    for (fault, value), lens in lenses.items():
        moved = [replace(flow, first=lens(flow.first), second=lens(flow.second)) for flow in flows]
        yield Hypothesis(
            sensor=Sensor.CAMERA, fault=fault, value=value, mended=records, flows=moved
        )
    first_ns = np.array([flow.t_ns[0] for flow in flows], np.int64)
    for clock in _clocks(first_ns, FAR_S):
        late_ns = (first_ns - clock.t_ns).tolist()
        moved = [
            replace(flow, t_ns=(flow.t_ns[0] - late, flow.t_ns[1] - late))
            for flow, late in zip(flows, late_ns, strict=True)
        ]
        yield replace(clock.of(Sensor.CAMERA, records), flows=moved)


def _uprightness(attitude: Rotation) -> float:
    """Compute the mean cosine of the tilt of orientations (n,) with x forward, z down."""
    return float(np.mean(attitude.apply([0.0, 0.0, 1.0])[:, 2]))


def _on_its_side() -> Iterator[tuple[str, Rotation]]:
    """List how an instrument may be mounted by right angles, its z not the vehicle's up or down.

    Each with its roll, pitch and yaw in the vehicle, deg.
    """
    for _, turn in signed_axes():
        if np.linalg.det(turn) > 0 and turn[2, 2] == 0:
            rotation = Rotation.from_matrix(turn)
            yield ", ".join(f"{angle:g}" for angle in mount_angles_deg(rotation)), rotation


def _of_other_axes(attitude: Rotation) -> Iterator[tuple[str, Array]]:
    """List what orientations may be of other axes: a vehicle's, global ones, or both.

    Exchanged components of a quaternion and frames that were chained in the wrong order are such.
    Of the global axes only the one that points down counts: nothing here tells the heading.
    Yields quaternions (n, 4).
    """
    turns = [("+x +y +z", np.eye(3)), *signed_axes()]
    proper = [(name, turn) for name, turn in turns if np.linalg.det(turn) > 0]
    own = {name: Rotation.from_matrix(turn) for name, turn in proper}
    downwards = {name[-2:]: name for name in reversed(own)}
    for inverse, logged in (("", attitude), (", and it is inverted", attitude.inv())):
        quaternion = logged.as_quat()
        for down, globally in downwards.items():
            for name, turn in own.items():
                if inverse or (down, name) != ("+z", "+x +y +z"):
                    turned = _chained(own[globally], quaternion, turn)
                    yield f"{name} for those of the vehicle, {down} downwards{inverse}", turned


def _chained(first: Rotation, quaternion: Array, last: Rotation) -> Array:
    """Multiply quaternions (n, 4) with one rotation from the left and one from the right.

    Both at once are a matrix: hundreds of hypotheses turn each reading of an IMU.
    """
    x, y, z, w = first.as_quat()
    left = np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])
    x, y, z, w = last.as_quat()
    right = np.array([[w, z, -y, x], [-z, w, x, y], [y, -x, w, z], [-x, -y, -z, w]])
    return np.asarray(quaternion @ (left @ right).T)


@dataclass(frozen=True, kw_only=True)
class _Clock:
    """A fault of a clock, and the stamps without it."""

    fault: str  # "clock", "rate"
    value: str
    late_s: float  # of the stamps, of the last where it runs fast
    t_ns: Ints

    def of(self, sensor: Sensor, mended: SensorRecords) -> Hypothesis:
        return Hypothesis(
            sensor=sensor, fault=self.fault, value=self.value, mended=mended, late_s=self.late_s
        )

    def on(self, record: Stream) -> Stream:
        """Put a record on this clock."""
        return replace(record, t_ns=self.t_ns)  # type: ignore[type-var]


def _clocks(t_ns: Ints, farthest_s: float = np.inf) -> Iterator[_Clock]:
    """List what may be wrong with a sensor's clock, in the order of its stamps."""
    since_ns = t_ns - t_ns[:1]
    lasts_s = float(np.ptp(t_ns)) / NS if len(t_ns) else 0.0
    for late_s in (late_s for late_s in LATE_S if abs(late_s) < farthest_s):
        moved = t_ns - round(late_s * NS)
        yield _Clock(fault="clock", value=f"{late_s:g} s", late_s=late_s, t_ns=moved)
        if abs(late_s) < FASTEST * lasts_s:
            rate = late_s / lasts_s
            moved = t_ns - np.round(rate * since_ns).astype(np.int64)
            yield _Clock(fault="rate", value=f"{100 * rate:+.1f}", late_s=late_s, t_ns=moved)


def _turned(ideal: Array, turn: Array) -> Array:
    return np.asarray(ideal @ turn.T)


def _resized(ideal: Array, camera: CameraModel, size: float) -> Array:
    """Read the pixels (n, 2) by the calibration of pictures that are so many times as large."""
    fx, fy = camera.fx / size, camera.fy / size
    cx, cy = (camera.cx + 0.5) / size - 0.5, (camera.cy + 0.5) / size - 0.5
    return replace(camera, fx=fx, fy=fy, cx=cx, cy=cy).undistort(camera.distort(ideal))


def _straightened(ideal: Array, k1: float) -> Array:
    """Take off the distortion (n, 2) that a calibration misses."""
    return np.asarray(ideal * (1 - k1 * (ideal**2).sum(axis=1, keepdims=True)))


def signed_axes() -> list[tuple[str, Array]]:
    """List the 47 signed permutations of axes beside the identity, with their names."""
    out = []
    for order in itertools.permutations(range(3)):
        for signs in itertools.product([1.0, -1.0], repeat=3):
            turn = np.diag(signs) @ np.eye(3)[list(order)]
            if not np.array_equal(turn, np.eye(3)):
                axes = zip(signs, order, strict=True)
                name = " ".join(f"{'+' if s > 0 else '-'}{'xyz'[k]}" for s, k in axes)
                out.append((name, turn))
    return out


def repeated(velocity: Array) -> Mask:
    """Find the pings in runs of REPEATED or more with one velocity (n, 3) to the last digit."""
    same = np.concatenate([[False], (np.diff(velocity, axis=0) == 0).all(axis=1)])
    run = np.cumsum(~same)
    return np.asarray(np.bincount(run)[run] >= REPEATED)
