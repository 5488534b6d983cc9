# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Faults of the IMU: of its rates, its orientation, its accelerations, or of all of it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.heading import LEAST_RATES, heading_by_rates
from hullrecon.dive.logs.streams.imu import FRD_FROM_FLU, NED_FROM_ENU
from hullrecon.dive.logs.turns import scale_between, turns_within_seconds
from hullrecon.navigation.suspects.comparisons.comparison import Sensor
from hullrecon.navigation.suspects.faults.axes import (
    TURN_STEP_DEG,
    Conventions,
    mounts_on_side,
    multiply_both_sides,
    orientations_of_other_axes,
    signed_axes,
    uprightness,
)
from hullrecon.navigation.suspects.faults.clock import clock_faults
from hullrecon.navigation.suspects.faults.hypothesis import Hypothesis
from hullrecon.records.sensors import ImuSamples, SensorRecords
from hullrecon.typing import Array

# rad/s of each unit in which rates may have been logged instead
RADIANS_A_SECOND = {
    "deg/s": np.pi / 180,
    "mdeg/s": np.pi / 180e3,
    "mrad/s": 1e-3,
    "rpm": np.pi / 30,
}
LEAST_SWING_RAD = np.radians(0.5)  # of a heading about that of the rates: filters leave as much
# Share of the rows of a comparison that agree whatever was logged, once the heading is the rates'
BY_RATES = {"turn": 1 / 3, "heading": 1.0}
UPRIGHT = 0.7  # mean cosine of the tilt, above which a vehicle is not on its side


def rate_faults(records: SensorRecords, imu: ImuSamples) -> Iterator[Hypothesis]:
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


def imu_faults(records: SensorRecords, imu: ImuSamples, given: Conventions) -> Iterator[Hypothesis]:
    """Yield faults of the IMU: conventions of orientation and acceleration, mount, clock.

    Wrong are the orientation alone, the axes of the whole instrument, or the accelerations alone.
    """
    yield from _swinging_heading(records, imu)
    yield from _orientation_faults(records, imu, given)
    for clock in clock_faults(imu.t_ns):
        yield clock.hypothesis(Sensor.ATTITUDE, replace(records, imu=clock.correct(imu)))
    yield from _turned_instruments(records, imu)
    yield from _left_handed(records, imu, given)
    yield from _acceleration_faults(records, imu, given)


def _swinging_heading(records: SensorRecords, imu: ImuSamples) -> Iterator[Hypothesis]:
    """Yield a heading that swings about the integral of the rates, as a compass does near steel.

    Nothing is yielded where the rates do not tell the heading: where too few were logged, one of
    them stands still to the last digit, or a wrong scale of theirs explains the difference.
    """
    known = np.isfinite(imu.angular_velocity).all(axis=1)
    if known.mean() < LEAST_RATES or (np.ptp(imu.angular_velocity[known], axis=0) == 0).any():
        return
    found = heading_by_rates(imu.t_ns, Rotation.from_quat(imu.quaternion), imu.angular_velocity)
    if found.swing_beyond_scale() < LEAST_SWING_RAD:
        return
    steady = replace(imu, quaternion=found.rotation.as_quat())
    yield Hypothesis(
        sensor=Sensor.ATTITUDE,
        fault="heading",
        value=f"{np.degrees(found.swing_rad):.1f}",
        mended=replace(records, imu=steady),
        exact=True,
        untested=BY_RATES,
        heading_drift_sigma_rad_s=found.drift_sigma_rad_s,
    )


def _orientation_faults(
    records: SensorRecords, imu: ImuSamples, given: Conventions
) -> Iterator[Hypothesis]:
    """Yield orientations written in another order, in other frames, with other signs or axes."""
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
    quaternions |= {("axes", name): turned for name, turned in orientations_of_other_axes(attitude)}
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


def _turned_instruments(records: SensorRecords, imu: ImuSamples) -> Iterator[Hypothesis]:
    """Yield an IMU whose axes are all turned.

    They are those of the other convention, or it is mounted turned about the vehicle's z, or on its
    side.
    """
    attitude = Rotation.from_quat(imu.quaternion)
    # a rotation of the global axes, and imu_from_vehicle
    bodies = {
        ("frame", "all axes"): (NED_FROM_ENU, FRD_FROM_FLU),
        ("frame", "vehicle's axes"): (Rotation.identity(), FRD_FROM_FLU),
    }
    for angle in range(TURN_STEP_DEG - 180, 181, TURN_STEP_DEG):
        if angle:
            imu_from_vehicle = Rotation.from_euler("z", -angle, degrees=True)
            bodies["mount", f"{angle:d}"] = Rotation.identity(), imu_from_vehicle
    for name, vehicle_from_imu in mounts_on_side():
        # Else the vehicle would lie on its side: it is not the IMU that is mounted otherwise
        if uprightness(attitude * vehicle_from_imu.inv()) > UPRIGHT:
            bodies["body", name] = Rotation.identity(), vehicle_from_imu.inv()
    for (fault, value), (rotation, imu_from_vehicle) in bodies.items():
        axes = imu_from_vehicle.as_matrix()
        body = replace(
            imu,
            quaternion=multiply_both_sides(rotation, attitude.as_quat(), imu_from_vehicle),
            angular_velocity=imu.angular_velocity @ axes,
            acceleration=imu.acceleration @ axes,
        )
        mended = replace(records, imu=body)
        yield Hypothesis(sensor=Sensor.ATTITUDE, fault=fault, value=value, mended=mended)


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


def _acceleration_faults(
    records: SensorRecords, imu: ImuSamples, given: Conventions
) -> Iterator[Hypothesis]:
    """Yield accelerations with the other sign, in other axes, or along the global axes."""
    attitude = Rotation.from_quat(imu.quaternion)
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
