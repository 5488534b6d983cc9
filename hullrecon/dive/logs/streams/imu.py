# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stack the readings of an IMU into a record: attitude, rates, accelerations of the vehicle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.heading import heading_by_rates
from hullrecon.dive.logs.lost_values import UNFILLED, is_false_attitude, is_held
from hullrecon.dive.logs.quaternion_forms import complete_quaternions
from hullrecon.dive.logs.samples import ImuSample, stamps
from hullrecon.dive.logs.two_sensors import refuse_two_sensors, windows
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.geometry import frames
from hullrecon.records.clock import format_time
from hullrecon.records.sensors import ImuSamples
from hullrecon.typing import Array, Ints, Mask

LEAST_ATTITUDES = 50  # readings that are no measurement if they are equal to the last digit
UNIT_QUATERNION = 0.05  # how far the length of an attitude's quaternion may be off 1
# Share by which the lengths of quaternions differ that were not scaled to 1, and share of them that
# are alike. Steps of whole numbers up to 1000 make 0.1 %; angles of a dive change by far more
ALIKE_QUATERNIONS, NEARLY_ALL = 0.005, 0.9
LEAST_UNIT = 0.1  # share of an IMU's quaternions that are of unit length; fewer are so by chance
GRAVITY_M_S2, NEAR_GRAVITY = 9.80665, 0.1  # by CIPM; share by which a vehicle moves it
LEAST_FELT_M_S2 = GRAVITY_M_S2 / 2  # median; where it is less, a filter has taken gravity off
MOST_FELT_M_S2 = 2 * GRAVITY_M_S2  # median; no vehicle is pushed like that for half of a dive
# not those of a message
ACCELERATIONS = {"g": GRAVITY_M_S2, "mg": 1e-3 * GRAVITY_M_S2, "cm/s2": 1e-2}
NED_FROM_ENU = Rotation.from_matrix(frames.NED_FROM_ENU)
FRD_FROM_FLU = Rotation.from_matrix(np.diag([1.0, -1.0, -1.0]))


@np.errstate(all="ignore")
def imu_samples(
    samples: Sequence[ImuSample],
    frame: str,
    notes: list[Finding],
    mount_deg: tuple[float, float, float] | None = None,
    rates_unit: str = "rad/s",
    heading: str = "orientation",
) -> ImuSamples:
    """Stack attitudes and rates of the vehicle in `global`, leaving out rows without an attitude.

    So are rows that only repeat the one before because the IMU hung up. Rates and accelerations
    that a driver filled with zeros become NaN, and gravity that a filter took off is put back.

    Parameters
    ----------
    samples : readings in order of time, all by an IMU or all by sensors inside the DVL
    frame : "ned" (body forward-starboard-down in north-east-down) or "enu" (body
        forward-port-up in east-north-up)
    notes : what was assumed or left out is added
    mount_deg : roll, pitch, yaw of the IMU in the vehicle, None where it has the vehicle's axes
    rates_unit : "rad/s" or "deg/s"
    heading : "orientation" or "rates": what the heading is taken from

    Raises
    ------
    InputError
        Most rows have no attitude, all have the same one, two IMUs share the topic, or the
        attitude is the DVL's and mount_deg is missing.
    """
    t_ns = stamps(samples)
    quaternion = np.array([s.quaternion for s in samples]).reshape(-1, 4)
    rates = np.array([s.rates for s in samples]).reshape(-1, 3)
    rates = np.radians(rates) if rates_unit == "deg/s" else rates
    acceleration = np.array([s.acceleration for s in samples]).reshape(-1, 3)
    quaternion = _of_unit_length(complete_quaternions(t_ns, quaternion, rates, notes), notes)
    good = _are_attitudes(t_ns, quaternion, rates, acceleration, notes)
    t_ns, quaternion = t_ns[good], quaternion[good]
    rates, acceleration = rates[good], acceleration[good]

    # what the driver did not fill in, or wrote in other units
    _refuse_unfilled(quaternion, rates)
    if len(rates) >= LEAST_ATTITUDES and not rates.any() and np.ptp(quaternion, axis=0).any():
        notes.append(Finding("rates-unfilled", {"count": len(rates)}, "imu"))
        rates = np.full_like(rates, np.nan)
    rotation = Rotation.from_quat(quaternion)
    _refuse_two_imus(rotation)
    acceleration = _in_m_s2(acceleration, notes)

    # from the IMU's axes to forward-starboard-down of the vehicle, in north-east-down
    if any(s.of_dvl for s in samples):
        mount_deg = _require_mount_of_dvl(mount_deg)
        notes.append(Finding("attitude-of-dvl", where="imu"))
    elif frame == "enu":
        rotation = NED_FROM_ENU * rotation * FRD_FROM_FLU.inv()
        rates, acceleration = rates * [1, -1, -1], acceleration * [1, -1, -1]
    if mount_deg is not None:
        vehicle_from_imu = Rotation.from_euler("ZYX", mount_deg[::-1], degrees=True)
        rotation = rotation * vehicle_from_imu.inv()
        rates, acceleration = vehicle_from_imu.apply(rates), vehicle_from_imu.apply(acceleration)

    # what a filter took off or made wrong
    acceleration = _with_gravity(acceleration, rotation, notes)
    if heading == "rates":
        rotation = _with_heading_of_rates(t_ns, rotation, rates, notes)
    return ImuSamples(
        t_ns=t_ns, quaternion=rotation.as_quat(), angular_velocity=rates, acceleration=acceleration
    )


def _of_unit_length(quaternion: Array, notes: list[Finding]) -> Array:
    """Scale a quaternion's readings (n, 4) to unit length where nearly all have one other length.

    That is so where a driver passes on an instrument's whole numbers. All others are returned
    unchanged, also Euler angles in their place, whose length changes. notes: the length is added.
    """
    length = np.linalg.norm(quaternion, axis=1)
    length = length[np.isfinite(length) & (length > 0)]
    usual = float(np.median(length)) if len(length) >= LEAST_ATTITUDES else 1.0
    alike = np.abs(length / usual - 1) < ALIKE_QUATERNIONS
    if abs(usual - 1) < UNIT_QUATERNION or alike.mean() < NEARLY_ALL:
        return quaternion
    notes.append(Finding("quaternions-scaled", {"length": usual}, "imu"))
    return quaternion / usual


def _are_attitudes(
    t_ns: Ints, quaternion: Array, rates: Array, acceleration: Array, notes: list[Finding]
) -> Mask:
    """Find the readings (n,) whose attitude was measured, and is not only repeated.

    Parameters
    ----------
    t_ns : (n,)
    quaternion : (n, 4) as logged; other lengths than 1 are no attitude
    rates, acceleration : (n, 3) as logged. An IMU that hung up repeats them as well
    notes : how many readings lack an attitude, or repeat one, is added

    Raises
    ------
    InputError
        Most rows have no attitude.
    """
    length = np.linalg.norm(quaternion, axis=1)
    good = (np.abs(length - 1) < UNIT_QUATERNION) & ~is_false_attitude(quaternion)
    if len(good) and np.count_nonzero(good) < LEAST_UNIT * len(good):
        raise _no_attitude(length, int(np.count_nonzero(good)))
    if not good.all():
        lacking = {"lacking": int(np.count_nonzero(~good)), "count": len(good)}
        notes.append(Finding("attitudes-lacking", lacking, "imu"))
    held = good & is_held(t_ns, quaternion, rates, acceleration)
    if held.any():
        start = format_time(int(t_ns[held][0]))
        notes.append(Finding("attitudes-held", {"held": int(held.sum()), "start": start}, "imu"))
    return np.asarray(good & ~held)


def _refuse_two_imus(rotation: Rotation) -> None:
    """Raise InputError where orientations (n) jump between two in turn, as of two sensors."""
    cut = windows(rotation.as_quat())
    cosine = np.abs((cut * cut[:, :1]).sum(axis=2))  # of half the angle between two orientations
    refuse_two_sensors("imu", 2 * np.degrees(np.arccos(np.minimum(cosine, 1))), "degrees")


def _with_heading_of_rates(
    t_ns: Ints, rotation: Rotation, rates: Array, notes: list[Finding]
) -> Rotation:
    """Replace the heading of orientations (n) by that of the rates (n, 3), rad/s, and note it."""
    found = heading_by_rates(t_ns, rotation, rates)
    hourly = {"drift": found.drift_rad_s, "sigma": found.drift_sigma_rad_s}
    values = {f"{name}_deg_h": 3600 * np.degrees(rate) for name, rate in hourly.items()}
    swing = {"swing_deg": float(np.degrees(found.swing_rad))}
    notes.append(Finding("heading-of-rates", {**values, **swing}, "imu"))
    return found.rotation


def _no_attitude(length: Array, unit: int) -> InputError:
    """Make the error for an IMU few of whose quaternions are of length 1.

    length: (n,) of all quaternions. unit: how many of them are of length 1.
    """
    given = length[np.isfinite(length) & (length > 0)]
    how = "they are lost, all zero, or marked as not measured by their covariance"
    if 2 * len(given) > len(length):
        how = f"half of them are {np.median(given):.3g} long or more: are they angles?"
    return InputError(
        f"the IMU's messages hold no attitude: {unit or 'none'} of {len(length)} quaternions "
        f"{'is' if unit == 1 else 'are'} of length 1; {how}",
        where="imu",
        remedy="log an IMU that gives orientation as a quaternion x, y, z, w",
    )


def _in_m_s2(acceleration: Array, notes: list[Finding]) -> Array:
    """Convert an acceleration (n, 3) to m/s2 where its median length is gravity in another unit.

    The unit is one of ACCELERATIONS, or counts, whose factor follows from gravity. All others are
    returned unchanged.
    """
    size = np.linalg.norm(acceleration, axis=1)
    known = size[np.isfinite(size)]
    median = float(np.median(known)) if len(known) else 0.0
    unit, scale = min(
        ACCELERATIONS.items(), key=lambda named: abs(median * named[1] - GRAVITY_M_S2)
    )
    if abs(median * scale - GRAVITY_M_S2) > NEAR_GRAVITY * GRAVITY_M_S2:
        if median < MOST_FELT_M_S2:
            return acceleration
        unit, scale = "counts", GRAVITY_M_S2 / median
    notes.append(Finding("accelerations-in-unit", {"unit": unit, "median": median}, "imu"))
    return scale * acceleration


def _with_gravity(acceleration: Array, rotation: Rotation, notes: list[Finding]) -> Array:
    """Put gravity back into accelerations that a filter has taken it off, by the orientation.

    Accelerations whose median is near that of gravity are returned unchanged.

    Parameters
    ----------
    acceleration : (n, 3) m/s2, in the vehicle, as an accelerometer measures it
    rotation : (n,) from the vehicle to `global`
    notes : what was changed is added

    Returns
    -------
    acceleration (n, 3), NaN where a driver filled in zeros
    """
    # in `global`, where gravity adds up and motion does not
    measured = rotation.apply(acceleration)
    known = np.isfinite(measured).all(axis=1)
    if not known.any():
        return acceleration
    if len(measured) >= LEAST_ATTITUDES and not measured[known].any():
        notes.append(Finding("accelerations-unfilled", {"count": int(known.sum())}, "imu"))
        return np.full_like(acceleration, np.nan)
    if not is_without_gravity(measured[known]):
        return acceleration
    mean = float(np.linalg.norm(np.median(measured[known], axis=0)))
    notes.append(Finding("gravity-taken-off", {"felt_m_s2": mean}, "imu"))
    # z of `global` is down, and an accelerometer at rest measures an acceleration upward
    return np.asarray(acceleration - rotation.inv().apply([0.0, 0.0, GRAVITY_M_S2]))


def _refuse_unfilled(quaternion: Array, rates: Array) -> None:
    """Raise InputError where all orientations are equal and were not measured.

    They are the default of a message, or they stay equal while the rates are not zero. Those of a
    simulated vehicle at rest are accepted.

    Parameters
    ----------
    quaternion : (n, 4) x, y, z, w
    rates : (n, 3) rad/s
    """
    if len(quaternion) < LEAST_ATTITUDES or (quaternion != quaternion[0]).any():
        return
    turns = bool((np.nan_to_num(rates) != 0).any())
    if turns or np.array_equal(np.abs(quaternion[0]), UNFILLED):
        shown = ", ".join(f"{value:g}" for value in quaternion[0])
        why = "which is the default of a message that is not filled in"
        if turns:
            why = "while its rates are not zero"
        raise InputError(
            f"the IMU's orientation is the same, ({shown}), in all {len(quaternion)} readings, "
            f"{why}",
            remedy="log an IMU that gives orientation, or the topic of the filter that computes it",
        )


def _require_mount_of_dvl(
    mount_deg: tuple[float, float, float] | None,
) -> tuple[float, float, float]:
    """Require `mount_deg`: a DVL's own attitude is that of the DVL, not of the vehicle."""
    if mount_deg is None:
        raise InputError(
            "the only attitude is that of the DVL's own sensors, and nothing says how the DVL sits "
            "in the vehicle",
            where="imu.mount_deg",
            remedy="give roll, pitch, yaw of the frame dvl there: [0, 0, 0] where it looks down "
            "with its x forward, [0, 90, 0] where it looks ahead",
        )
    return mount_deg


def is_without_gravity(acceleration: Array) -> bool:
    """Tell whether a filter has taken gravity off accelerations (n, 3), m/s2, turned into `global`.

    Gravity adds up there, and motion does not. Where it is in each reading but not in their median,
    the orientation is wrong, or changes its convention amid the dive.
    """
    if np.linalg.norm(np.median(acceleration, axis=0)) >= LEAST_FELT_M_S2:
        return False
    felt = float(np.median(np.linalg.norm(acceleration, axis=1)))
    return abs(felt - GRAVITY_M_S2) > NEAR_GRAVITY * GRAVITY_M_S2
