# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Hypotheses of what is wrong with a sensor, each with the records as they would be without it.

Comparisons are repeated with these records in suspects.py, which judges the hypotheses.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.streams.imu import FRD_FROM_FLU, NED_FROM_ENU
from hullrecon.dive.logs.streams.pressure import DEEPEST_HULL_M, METRES, PASCALS
from hullrecon.dive.logs.turns import scale_between, turns_within_seconds
from hullrecon.findings.adjustment import WATER
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.rotations import mount_angles_deg
from hullrecon.navigation.sensors.servo import FEW_READINGS, LEAST_TRAVEL_RAD, has_moved
from hullrecon.navigation.suspects.comparisons.comparison import Comparison, Sensor
from hullrecon.navigation.suspects.comparisons.images import Flow
from hullrecon.navigation.suspects.comparisons.motions import Motions, compare
from hullrecon.records.clock import NS
from hullrecon.records.sensors import (
    DvlPings,
    ImuSamples,
    JointSamples,
    PressureSamples,
    SensorRecords,
)
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Mask

# Units in which readings may have been logged in place of Pa, m, m/s
PASCAL = {u: pa for u, pa in PASCALS.items() if u not in ("Pa", "mbar")}
PASCAL |= {"0.1 mbar": 10.0}  # whole numbers of an MS5837, which its drivers pass on
METRES_PER_SECOND = {
    "cm/s": 0.01,
    "mm/s": 0.001,
    "ft/s": 0.3048,
    "kn": 0.514444,
    "km/h": 1 / 3.6,
    "mph": 0.44704,
}
RADIANS_A_SECOND = {
    "deg/s": np.pi / 180,
    "mdeg/s": np.pi / 180e3,
    "mrad/s": 1e-3,
    "rpm": np.pi / 30,
}
# factors by which a length may be wrong, in steps so small that a comparison agrees at the nearest
FACTORS = [*np.geomspace(0.5, 0.93, 10), *np.geomspace(1.07, 2.0, 10)]
OFFSET_M_S = 0.3  # sigma of a constant error of a DVL's velocity that is tried
OFFSET_STEPS = 2  # of its fit: what a tilt of the DVL makes of the velocity changes with it
SIZES = (0.25, 0.5, 2.0, 4.0)  # of a calibration's pictures over those logged, which were resized
# changes of k1, in steps so small that a comparison agrees at the nearest
RADIAL = [s * k for k in np.arange(0.05, 0.65, 0.05) for s in (1, -1)]
REPEATED = 4  # pings with one velocity to the last digit: noise of 1 mm/s makes two of them rare
# By which stamps may be late (negative: early), as far as navigation/clocks searches. Near zero the
# steps are so small that the comparison of depths agrees at the nearest
LATE_S = [s * late for late in (*np.arange(0.25, 5.0, 0.25), *range(5, 61)) for s in (1, -1)]

# between two turns that are tried, of a DVL about its axis or an IMU about the vehicle's; small
# enough for comparisons to agree at the nearest
TURN_STEP_DEG = 5
FASTEST = 0.03  # largest error of a clock's rate: quartz is right to 1e-4, a wrong divider is not
UPRIGHT = 0.7  # mean cosine of the tilt, above which a vehicle is not on its side
FAR_S = 5.0  # largest offset of a camera's clock that is tried

Stream = TypeVar("Stream")


@dataclass(frozen=True, kw_only=True)
class Hypothesis:
    """A fault of one sensor."""

    sensor: Sensor
    fault: str  # the second of a key of FAULTS of hullrecon/findings/sensors.py, "clock" or "rate"
    value: str  # which unit, which axes
    # with the fault corrected, or without the sensor where that is impossible
    mended: SensorRecords
    exact: bool = False  # the corrected readings can be used, as the correction is known exactly
    flows: Sequence[Flow] | None = None  # corrected features, where the camera is at fault
    # by which the stamps are late (the last one, where the clock runs fast); negative: early
    late_s: float = 0.0
    faults: int = 1  # that are corrected at once


@dataclass(frozen=True, kw_only=True)
class Conventions:
    """What dive.toml says of a vehicle's sensors."""

    imu_frame: str = "ned"  # or "enu"
    imu_mount_deg: tuple[float, float, float] | None = None  # roll, pitch, yaw in the vehicle
    tray_positive: str = "up"  # or "down"
    tray_offset_deg: float = 0.0

    @property
    def vehicle_from_imu(self) -> Rotation:
        """The mount of the IMU, with its axes forward, starboard, down."""
        angles = (self.imu_mount_deg or (0.0, 0.0, 0.0))[::-1]
        return Rotation.from_euler("ZYX", angles, degrees=True)

    @property
    def logged_from_vehicle(self) -> Rotation:
        """The turn from the vehicle's axes to those that the IMU logs in."""
        turned = self.vehicle_from_imu.inv()
        return turned if self.imu_frame == "ned" else FRD_FROM_FLU.inv() * turned

    @property
    def global_from_logged(self) -> Rotation:
        """The turn from the global axes that the IMU logs in to those of `global`."""
        return Rotation.identity() if self.imu_frame == "ned" else NED_FROM_ENU

    def logged(self, attitude: Rotation) -> Rotation:
        """Turn attitudes (n,) of the vehicle back into the orientations that were logged."""
        return self.global_from_logged.inv() * attitude * self.logged_from_vehicle.inv()

    def read(self, logged: Rotation) -> Rotation:
        """Turn logged orientations (n,) into attitudes, as `imu_samples` does."""
        return self.global_from_logged * logged * self.logged_from_vehicle


BY_DEFAULT = Conventions()


def hypotheses(
    records: SensorRecords,
    sensors: Set[Sensor],
    atmosphere_m: float,
    rig: Rig,
    flows: Sequence[Flow] = (),
    given: Conventions = BY_DEFAULT,
) -> Iterator[Hypothesis]:
    """Yield what may be wrong with some sensors of a dive, one fault at a time.

    Parameters
    ----------
    records
        The dive.
    sensors
        Those that are suspected.
    atmosphere_m
        The air's pressure in metres of water, which was subtracted from the pressure.
    rig
        Mount of the DVL, and calibration of the upper camera.
    flows
        Features of neighbouring images.
    given
        What dive.toml says of the sensors.
    """
    dvl, imu, pressure, tray = records.dvl, records.imu, records.pressure, records.tray
    if Sensor.PRESSURE in sensors and pressure is not None:
        yield from _pressure_faults(records, pressure, atmosphere_m)
    if Sensor.DVL in sensors and dvl is not None:
        yield from _dvl_faults(records, dvl)
        yield from _dvl_mounts(records, dvl, rig.tray_from_dvl.rotation[0])
        yield from _dvl_offset(records, dvl, rig, flows)
    if Sensor.RATES in sensors and imu is not None:
        yield from _rate_faults(records, imu)
    if imu is not None and sensors & {Sensor.ATTITUDE, Sensor.ACCELERATION}:
        yield from _imu_faults(records, imu, given)
    if Sensor.TRAY in sensors and tray is not None:
        yield from _tray_faults(records, tray)
    if Sensor.CAMERA in sensors:
        yield from _camera_faults(records, flows, rig.top)


def _pressure_faults(
    records: SensorRecords, pressure: PressureSamples, air_m: float
) -> Iterator[Hypothesis]:
    """Yield faults of the pressure: units, scales, gauge pressure, sign, constant readings, clock.

    Each holds the records with the depth, m, as it would be without the fault. The fault of
    constant readings leaves the sensor out, which would explain anything: `suspects.py` tries it
    only where the readings stand still.

    air_m: the air's pressure in metres of water, which was taken off the absolute pressure.
    """
    depth = pressure.depth
    # the usual interpretations first: of those that explain as much, the first counts
    interpretations = {
        **{("unit", unit): pa * (depth + air_m) - air_m for unit, pa in PASCAL.items()},
        **{("unit", unit): metre * depth for unit, metre in METRES.items() if metre != 1},
        **{("scale", f"{factor:.2f}"): factor * depth for factor in FACTORS},
        **{("gauge", unit): pa * (depth + air_m) for unit, pa in {"Pa": 1.0, **PASCAL}.items()},
        ("sign", ""): -depth,
    }
    for (fault, value), corrected in interpretations.items():
        # a unit by which the vehicle was deeper than any hull is not the right one
        if fault in ("unit", "gauge") and np.median(corrected) > DEEPEST_HULL_M:
            continue
        mended = replace(records, pressure=replace(pressure, depth=corrected))
        yield Hypothesis(
            sensor=Sensor.PRESSURE, fault=fault, value=value, mended=mended, exact=True
        )
    # exact: nothing is lost with readings without information
    without = replace(records, pressure=None)
    yield Hypothesis(sensor=Sensor.PRESSURE, fault="constant", value="", mended=without, exact=True)
    for clock in _clock_faults(pressure.t_ns):
        yield clock.hypothesis(Sensor.PRESSURE, replace(records, pressure=clock.correct(pressure)))


def _dvl_faults(records: SensorRecords, dvl: DvlPings) -> Iterator[Hypothesis]:
    """Yield faults of the DVL: of its velocity, its ranges, the order of its beams, its clock.

    The velocity may have another unit, scale or axes, be turned about the DVL's axis, or be
    repeated by the driver.
    """
    frozen = repeated(dvl.velocity)
    # velocity (n, 3) by fault and value, and whether it can be used
    interpretations = {
        **{
            ("unit", unit): (factor * dvl.velocity, True)
            for unit, factor in METRES_PER_SECOND.items()
        },
        **{("scale", f"{f:.2f}"): (f * dvl.velocity, False) for f in FACTORS},
        # turned axes are those of a DVL that sits otherwise, mirrored ones a driver's
        **{
            ("axes", name): (dvl.velocity @ turn.T, is_mirrored(turn))
            for name, turn in signed_axes()
        },
    }
    for angle in range(-175, 180, TURN_STEP_DEG):  # turns by right angles are among "axes"
        if angle % 90:
            turn = Rotation.from_euler("z", angle, degrees=True)
            interpretations["turn", f"{angle:d}"] = turn.apply(dvl.velocity), False
    if frozen.any():
        interpretations["repeated", ""] = (np.where(frozen[:, None], np.nan, dvl.velocity), True)
    for (fault, value), (velocity, exact) in interpretations.items():
        mended = replace(records, dvl=replace(dvl, velocity=velocity))
        yield Hypothesis(sensor=Sensor.DVL, fault=fault, value=value, mended=mended, exact=exact)
    yield from _other_axes(records, dvl)
    for value, factor in {**METRES, **{f"{f:.2f}": f for f in FACTORS}}.items():
        mended = replace(records, dvl=replace(dvl, ranges=factor * dvl.ranges))
        if factor != 1:
            yield Hypothesis(sensor=Sensor.DVL, fault="ranges", value=value, mended=mended)
    for order in itertools.permutations(range(4)) if dvl.ranges.shape[1] == 4 else ():
        mended = replace(records, dvl=replace(dvl, ranges=dvl.ranges[:, order]))
        if order != (0, 1, 2, 3):
            value = ", ".join(str(beam + 1) for beam in order)
            yield Hypothesis(sensor=Sensor.DVL, fault="beams", value=value, mended=mended)
    for clock in _clock_faults(dvl.t_ns):
        yield clock.hypothesis(Sensor.DVL, replace(records, dvl=clock.correct(dvl)))


def _dvl_mounts(
    records: SensorRecords, dvl: DvlPings, tray_from_dvl: Rotation
) -> Iterator[Hypothesis]:
    """Yield mounts of a DVL that looks to another side: it is turned about the tray's z axis.

    Its beams turn with its velocity. Turns about the tray's own axis, y, are left out: they cannot
    be distinguished from a tray whose zero is off.
    """
    for angle in range(TURN_STEP_DEG - 180, 181, TURN_STEP_DEG):
        if angle:
            turn = Rotation.from_euler("z", angle, degrees=True)
            own = tray_from_dvl.inv() * turn * tray_from_dvl
            whole = replace(dvl, velocity=own.apply(dvl.velocity), beams=own.apply(dvl.beams))
            mended = replace(records, dvl=whole)
            yield Hypothesis(sensor=Sensor.DVL, fault="mount", value=f"{angle:d}", mended=mended)


def _dvl_offset(
    records: SensorRecords, dvl: DvlPings, rig: Rig, flows: Sequence[Flow]
) -> Iterator[Hypothesis]:
    """Yield a DVL whose velocities are all off by the same, fitted to all that it contradicts."""
    motions = Motions(records, rig, flows)

    def residuals(offset: Array) -> dict[str, Comparison]:
        moved = replace(records, dvl=replace(dvl, velocity=dvl.velocity - offset))
        found = compare(Motions(moved, rig, flows, motions))
        return {one.kind: one for one in found if Sensor.DVL in one.sensors - one.unclear}

    off = np.zeros(3)
    for _ in range(OFFSET_STEPS):
        as_is, along = residuals(off), [residuals(off + axis) for axis in OFFSET_M_S * np.eye(3)]
        normal, right = np.eye(3), -off / OFFSET_M_S  # in OFFSET_M_S, the sigma of an offset
        for kind, one in as_is.items():
            moved = [other[kind].residual for other in along if kind in other]
            if len(moved) < 3 or any(len(residual) != len(one.residual) for residual in moved):
                continue
            design = (np.column_stack(moved) - one.residual[:, None]) / one.sigma[:, None]
            # errors that faultless sensors have are eliminated, each known to one sigma
            other = one.by_nuisance / one.sigma[:, None]
            inner = np.linalg.inv(other.T @ other + np.eye(other.shape[1]))
            left = design - other @ (inner @ (other.T @ design))
            normal += left.T @ design
            right -= left.T @ (one.residual / one.sigma)
        off = off + OFFSET_M_S * np.linalg.solve(normal, right)
    mended = replace(records, dvl=replace(dvl, velocity=dvl.velocity - off))
    value = ", ".join(f"{axis:+.2f}" for axis in off)
    yield Hypothesis(sensor=Sensor.DVL, fault="offset", value=value, mended=mended)


def _other_axes(records: SensorRecords, dvl: DvlPings) -> Iterator[Hypothesis]:
    """Yield a DVL that gives velocities along its beams, and one in left-handed axes."""
    if np.linalg.matrix_rank(dvl.beams[:3]) == 3:
        # three of the four velocities along the beams were logged as x, y, z
        for value, along in (("towards", -dvl.beams[:3]), ("away from", dvl.beams[:3])):
            velocity = dvl.velocity @ np.linalg.inv(along).T
            mended = replace(records, dvl=replace(dvl, velocity=velocity))
            yield Hypothesis(
                sensor=Sensor.DVL, fault="along", value=value, mended=mended, exact=True
            )
    for axis, name in enumerate("xyz"):
        mirror = np.where(np.arange(3) == axis, -1.0, 1.0)
        left = replace(dvl, velocity=mirror * dvl.velocity, beams=mirror * dvl.beams)
        mended = replace(records, dvl=left)
        yield Hypothesis(sensor=Sensor.DVL, fault="mirrored", value=name, mended=mended, exact=True)


def _rate_faults(records: SensorRecords, imu: ImuSamples) -> Iterator[Hypothesis]:
    """Yield faults of the IMU's rates: units, axes, both at once, a factor, a bias."""
    degree = np.pi / 180
    interpretations = {
        ("unit", unit): f * imu.angular_velocity for unit, f in RADIANS_A_SECOND.items()
    }
    for name, turn in signed_axes():
        interpretations["axes", name] = imu.angular_velocity @ turn.T
        interpretations["axes", f"{name}, deg/s"] = degree * imu.angular_velocity @ turn.T
    scale, bias = _fit_rates(imu)
    if scale is not None:
        interpretations["scale", f"{scale:.3g}"] = scale * imu.angular_velocity
    shown = ", ".join(f"{offset:.2g}" for offset in np.degrees(bias))
    interpretations["bias", shown] = imu.angular_velocity - bias
    for (fault, value), rates in interpretations.items():
        yield Hypothesis(
            sensor=Sensor.RATES,
            fault=fault,
            value=value,
            mended=replace(records, imu=replace(imu, angular_velocity=rates)),
            exact=True,
            faults=2 if value.endswith(", deg/s") else 1,
        )


def _fit_rates(imu: ImuSamples) -> tuple[float | None, Array]:
    """Fit a factor of the rates, and a bias (3,) rad/s, to turns of the orientation in a second.

    Each is fitted alone by least squares. The factor is None where rates and turns are not
    proportional, as where one of them does not change.
    """
    by_rates, turned, lasts_s = turns_within_seconds(
        imu.t_ns, Rotation.from_quat(imu.quaternion), imu.angular_velocity
    )
    if not len(lasts_s):
        return None, np.zeros(3)
    return scale_between(by_rates, turned), (by_rates - turned).sum(axis=0) / lasts_s.sum()


def _imu_faults(
    records: SensorRecords, imu: ImuSamples, given: Conventions
) -> Iterator[Hypothesis]:
    """Yield faults of the IMU: conventions of orientation and acceleration, mount, clock.

    Wrong are the orientation alone, the axes of the whole instrument, or the accelerations alone.
    """
    # The orientation alone: written in another order, in other frames, with other signs or axes.
    attitude = Rotation.from_quat(imu.quaternion)
    logged, angles = given.logged(attitude), attitude.as_euler("ZYX")
    turned = {
        ("order", "inverse"): given.read(logged.inv()),
        ("order", "w x y z"): given.read(Rotation.from_quat(logged.as_quat()[:, [1, 2, 3, 0]])),
        ("angle", "half"): given.read(Rotation.from_rotvec(2 * logged.as_rotvec())),
        ("angle", "twice"): given.read(Rotation.from_rotvec(logged.as_rotvec() / 2)),
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
    quaternions |= {
        ("axes", name): turned for name, turned in _orientations_of_other_axes(attitude)
    }
    for (fault, value), quaternion in quaternions.items():
        mended = replace(records, imu=replace(imu, quaternion=quaternion))
        yield Hypothesis(
            sensor=Sensor.ATTITUDE,
            fault=fault,
            value=value,
            mended=mended,
            # The others may turn the heading as well. Half of a doubled angle is not known beyond a
            # quarter of a turn
            exact=fault in ("order", "sign") or (fault, value) == ("angle", "half"),
        )
    for clock in _clock_faults(imu.t_ns):
        yield clock.hypothesis(Sensor.ATTITUDE, replace(records, imu=clock.correct(imu)))
    # The whole instrument: in the other convention, mounted turned about the vehicle's z, or on
    # its side. Each is a rotation of the global axes, and imu_from_vehicle.
    bodies = {
        ("frame", "all axes"): (NED_FROM_ENU, FRD_FROM_FLU),
        ("frame", "vehicle's axes"): (Rotation.identity(), FRD_FROM_FLU),
    }
    for angle in range(TURN_STEP_DEG - 180, 181, TURN_STEP_DEG):
        if angle:
            imu_from_vehicle = Rotation.from_euler("z", -angle, degrees=True)
            bodies["mount", f"{angle:d}"] = Rotation.identity(), imu_from_vehicle
    for name, vehicle_from_imu in _mounts_on_side():
        # Else the vehicle would lie on its side: it is not the IMU that is mounted otherwise
        if _uprightness(attitude * vehicle_from_imu.inv()) > UPRIGHT:
            bodies["body", name] = Rotation.identity(), vehicle_from_imu.inv()
    for (fault, value), (rotation, imu_from_vehicle) in bodies.items():
        axes = imu_from_vehicle.as_matrix()
        body = replace(
            imu,
            quaternion=_multiply_both_sides(rotation, attitude.as_quat(), imu_from_vehicle),
            angular_velocity=imu.angular_velocity @ axes,
            acceleration=imu.acceleration @ axes,
        )
        mended = replace(records, imu=body)
        yield Hypothesis(sensor=Sensor.ATTITUDE, fault=fault, value=value, mended=mended)
    yield from _left_handed(records, imu, given)
    # The accelerations alone.
    accelerations = {("sign", ""): -imu.acceleration}
    accelerations |= {("axes", name): imu.acceleration @ turn.T for name, turn in signed_axes()}
    # along the global axes that the IMU logs in
    own = given.logged_from_vehicle.apply(imu.acceleration)
    accelerations["global", ""] = attitude.inv().apply(given.global_from_logged.apply(own))
    for (fault, value), acceleration in accelerations.items():
        mended = replace(records, imu=replace(imu, acceleration=acceleration))
        yield Hypothesis(
            sensor=Sensor.ACCELERATION, fault=fault, value=value, mended=mended, exact=True
        )


def _left_handed(
    records: SensorRecords, imu: ImuSamples, given: Conventions
) -> Iterator[Hypothesis]:
    """Yield an IMU that logs all in left-handed axes, and one whose driver negates an axis of all.

    A mirror reverses the turns about the axes within it and keeps those about its normal. A driver
    that negates one component of each vector does the opposite.
    """
    axes, logged = given.logged_from_vehicle, given.logged(Rotation.from_quat(imu.quaternion))
    for axis, name in enumerate("xyz"):
        mirror = np.where(np.arange(3) == axis, -1.0, 1.0)
        for fault, turns in (("mirrored", -mirror), ("negated", mirror)):
            right = replace(
                imu,
                quaternion=given.read(
                    Rotation.from_quat(logged.as_quat() * [*turns, 1.0])
                ).as_quat(),
                angular_velocity=axes.inv().apply(axes.apply(imu.angular_velocity) * turns),
                acceleration=axes.inv().apply(axes.apply(imu.acceleration) * mirror),
            )
            yield Hypothesis(
                sensor=Sensor.ATTITUDE,
                fault=fault,
                value=name,
                mended=replace(records, imu=right),
                exact=True,
            )


def _tray_faults(records: SensorRecords, tray: JointSamples) -> Iterator[Hypothesis]:
    """Yield faults of the tray's angles: zeros off by eighths of a turn, units, signs, and both."""
    degree = np.pi / 180
    for off_deg in (90, -90, 180, 45, -45, 135, -135):
        angle = tray.angle - degree * off_deg
        for fault, sense in (("zero", 1), ("reversed", -1)):
            yield Hypothesis(
                sensor=Sensor.TRAY,
                fault=fault,
                value=f"{off_deg:+d}",
                mended=replace(records, tray=replace(tray, angle=sense * angle)),
                exact=fault == "zero",
                faults=1 if fault == "zero" else 2,
            )
    # In the right unit a servo that was moved turned by LEAST_TRAVEL_RAD or more, and by less than
    # a whole turn
    known = tray.angle[np.isfinite(tray.angle)]
    farthest_rad = float(np.abs(known).max(initial=0.0))
    span_rad = float(np.ptp(known)) if len(known) >= FEW_READINGS and has_moved(known) else np.inf
    for fault, value, factor, exact in (
        ("unit", "deg", degree, True),
        ("unit", "rad", 1 / degree, True),
        ("unit", "turns", 2 * np.pi, True),
        ("sign", "", -1.0, False),
        ("sign", "deg", -degree, False),
    ):
        if abs(factor) * span_rad < LEAST_TRAVEL_RAD or abs(factor) * farthest_rad > 2 * np.pi:
            continue
        mended = replace(records, tray=replace(tray, angle=factor * tray.angle))
        yield Hypothesis(
            sensor=Sensor.TRAY,
            fault=fault,
            value=value,
            mended=mended,
            exact=exact,
            faults=2 if (fault, value) == ("sign", "deg") else 1,
        )


def _camera_faults(
    records: SensorRecords, flows: Sequence[Flow], camera: CameraModel | None
) -> Iterator[Hypothesis]:
    """Yield faults of the camera: focal length, medium, turned or resized pictures, lens, clock.

    The features' ideal coordinates are recomputed as by the right calibration.
    """
    turns = {("focal", f"{factor:.2f}"): np.eye(2) / factor for factor in FACTORS}
    turns |= {("medium", f"{WATER:.2f}"): np.eye(2) / WATER}
    for name, turn in signed_axes():
        if turn[2, 2] == 1 and not turn[:2, 2].any() and not turn[2, :2].any():
            turns["picture", name[:5]] = turn[:2, :2]  # named by its first two axes
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
    for clock in _clock_faults(first_ns, FAR_S):
        late_ns = (first_ns - clock.t_ns).tolist()
        moved = [
            replace(flow, t_ns=(flow.t_ns[0] - late, flow.t_ns[1] - late))
            for flow, late in zip(flows, late_ns, strict=True)
        ]
        yield replace(clock.hypothesis(Sensor.CAMERA, records), flows=moved)


def _uprightness(attitude: Rotation) -> float:
    """Compute the mean cosine of the tilt of orientations (n,) with x forward, z down."""
    return float(np.mean(attitude.apply([0.0, 0.0, 1.0])[:, 2]))


def _mounts_on_side() -> Iterator[tuple[str, Rotation]]:
    """Yield how an instrument may be mounted by right angles with its z axis across the vehicle's.

    Yields
    ------
    tuple
        Roll, pitch and yaw of the instrument in the vehicle, deg, as text, and vehicle_from_imu.
    """
    for _, turn in signed_axes():
        if np.linalg.det(turn) > 0 and turn[2, 2] == 0:
            rotation = Rotation.from_matrix(turn)
            yield ", ".join(f"{angle:g}" for angle in mount_angles_deg(rotation)), rotation


def _orientations_of_other_axes(attitude: Rotation) -> Iterator[tuple[str, Array]]:
    """Yield orientations corrected for wrong axes of the vehicle, of `global`, or of both.

    Exchanged components of a quaternion, and rotations chained in the wrong order, have the same
    effect as wrong axes. Global axes that differ only in heading cannot be distinguished, so one
    set is tried for each axis that may point down.

    Yields
    ------
    tuple
        Name of the axes, and quaternions (n, 4).
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
                    turned = _multiply_both_sides(own[globally], quaternion, turn)
                    yield f"{name} for those of the vehicle, {down} downwards{inverse}", turned


def _multiply_both_sides(first: Rotation, quaternion: Array, last: Rotation) -> Array:
    """Multiply quaternions (n, 4) by one rotation from the left and one from the right.

    Both products are linear in the quaternion, so they are applied as one 4x4 matrix. This is
    faster than two products of rotations, and hundreds of hypotheses turn all readings of an IMU.
    """
    x, y, z, w = first.as_quat()
    left = np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])
    x, y, z, w = last.as_quat()
    right = np.array([[w, z, -y, x], [-z, w, x, y], [y, -x, w, z], [-x, -y, -z, w]])
    return np.asarray(quaternion @ (left @ right).T)


@dataclass(frozen=True, kw_only=True)
class _ClockFault:
    """A fault of a clock, and the stamps without it."""

    fault: str  # "clock" (offset) or "rate"
    value: str
    late_s: float  # by which the stamps are late (the last one, where the clock runs fast)
    t_ns: Ints  # corrected

    def hypothesis(self, sensor: Sensor, mended: SensorRecords) -> Hypothesis:
        """Make the hypothesis that a sensor has this fault."""
        return Hypothesis(
            sensor=sensor, fault=self.fault, value=self.value, mended=mended, late_s=self.late_s
        )

    def correct(self, record: Stream) -> Stream:
        """Replace a record's stamps by the corrected ones."""
        return replace(record, t_ns=self.t_ns)  # type: ignore[type-var]


def _clock_faults(t_ns: Ints, farthest_s: float = np.inf) -> Iterator[_ClockFault]:
    """Yield what may be wrong with a sensor's clock: offsets, and errors of its rate.

    t_ns (n,): stamps. farthest_s: larger offsets are not tried.
    """
    since_ns = t_ns - t_ns[:1]
    lasts_s = float(np.ptp(t_ns)) / NS if len(t_ns) else 0.0
    for late_s in (late_s for late_s in LATE_S if abs(late_s) < farthest_s):
        moved = t_ns - round(late_s * NS)
        yield _ClockFault(fault="clock", value=f"{late_s:g} s", late_s=late_s, t_ns=moved)
        if abs(late_s) < FASTEST * lasts_s:
            rate = late_s / lasts_s
            moved = t_ns - np.round(rate * since_ns).astype(np.int64)
            yield _ClockFault(fault="rate", value=f"{100 * rate:+.1f}", late_s=late_s, t_ns=moved)


def _turned(ideal: Array, turn: Array) -> Array:
    """Multiply ideal coordinates (n, 2) by a matrix (2, 2)."""
    return np.asarray(ideal @ turn.T)


def _resized(ideal: Array, camera: CameraModel, size: float) -> Array:
    """Recompute ideal coordinates (n, 2) for a calibration of pictures `size` times as large."""
    fx, fy = camera.fx / size, camera.fy / size
    cx, cy = (camera.cx + 0.5) / size - 0.5, (camera.cy + 0.5) / size - 0.5
    return replace(camera, fx=fx, fy=fy, cx=cx, cy=cy).undistort(camera.distort(ideal))


def _straightened(ideal: Array, k1: float) -> Array:
    """Remove radial distortion that a calibration misses from ideal coordinates (n, 2)."""
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


def is_mirrored(axes: Array) -> bool:
    """Tell whether axes (3, 3) are left-handed."""
    return bool(np.linalg.det(axes) < 0)


def repeated(velocity: Array) -> Mask:
    """Find pings in runs of REPEATED or more with the same velocity (n, 3) to the last digit."""
    same = np.concatenate([[False], (np.diff(velocity, axis=0) == 0).all(axis=1)])
    run = np.cumsum(~same)
    return np.asarray(np.bincount(run)[run] >= REPEATED)
