# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Stack samples into records: one set of units and conventions, NaN for lost values.

Assumptions and omissions are added to `notes`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.dvl_beams import (
    check_beams,
    choose_beams,
    put_ranges_right,
    range_scale_sigma,
    unit,
)
from hullrecon.dive.logs.heading import heading_by_rates
from hullrecon.dive.logs.lost_values import (
    UNFILLED,
    drop_false_beams,
    drop_lost_velocities,
    drop_ranges_at_limit,
    is_false_attitude,
    is_held,
)
from hullrecon.dive.logs.ping_spool import Images, KeepImages, bright_pixel
from hullrecon.dive.logs.samples import (
    DepthSample,
    DvlSample,
    ImuSample,
    JointSample,
    PressureSample,
    SonarSample,
    is_of_dvl,
)
from hullrecon.dive.logs.sonar_geometry import (
    choose_directions,
    image_in_ranges,
    pings_of_one_window,
)
from hullrecon.dive.logs.two_sensors import refuse_two_sensors, windows
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.records.clock import NS, format_time
from hullrecon.records.sensors import (
    DvlPings,
    ImuSamples,
    JointSamples,
    PressureSamples,
    SonarPings,
)
from hullrecon.typing import Array, Ints, Mask

LEAST_ATTITUDES = 50  # readings that are no measurement if they are equal to the last digit
UNIT_QUATERNION = 0.05  # how far the length of an attitude's quaternion may be off 1
# percentile of the pings' bright pixels that is scaled to white: a few pings are disturbed
BRIGHT_PINGS_PERCENT = 99.0
FASTEST_M_S = 15.0  # no vehicle at a hull is faster
FASTEST_MEDIAN_M_S = 4.0  # of a dive: a survey of a hull is ten times slower
# span of depths from the 5th to the 95th percentile; that of an enclosure's air is smaller
STILL_M = 0.15
HIGHEST_M = 1.0  # median height over the water, above which depths are wrong
HIGHEST_DECK_M = 6.0  # from which a vehicle is launched; zero pascal is 10 m above the water
# A depth is a spike where it differs from the median of so many readings around it by more than
# this distance and what a vehicle can sink or rise between the first and the last of them.
SPIKE_READINGS, SPIKE_M, FASTEST_DIVE_M_S = 5, 2.0, 4.0
DEEPEST_HULL_M = 40.0  # the largest ships draw 25 m
PASCALS = {"Pa": 1.0, "mbar": 1e2, "hPa": 1e2, "kPa": 1e3, "psi": 6894.757, "dbar": 1e4, "bar": 1e5}
METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "ft": 0.3048}
FARTHEST_MEDIAN_M = 100.0  # of the DVL's ranges at a hull: the instruments reach 50 to 200 m
# velocities that are needed to tell a rounding, and how exactly they lie on it, of its step
LEAST_ROUNDED, ON_GRID = 20, 1e-3
LEAST_LEVELS = 4  # different values; a simulated vehicle may go at few speeds
COARSEST_SHARE = 0.25  # of the median speed; a rounding by that turns its direction by 7 degrees
NEARLY_A_TURN = 1.5 * np.pi  # rad, farther than a servo turns from one reading to the next
WHOLE_TURN_DEG = 360.0
LEAST_UNIT = 0.1  # share of an IMU's quaternions that are of unit length; fewer are so by chance
METRES_A_SECOND = {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3}
GRAVITY_M_S2, NEAR_GRAVITY = 9.80665, 0.1  # by CIPM; share by which a vehicle moves it
LEAST_FELT_M_S2 = GRAVITY_M_S2 / 2  # median; where it is less, a filter has taken gravity off
ACCELERATIONS = {"g": GRAVITY_M_S2, "mg": 1e-3 * GRAVITY_M_S2}  # not those of a message
NED_FROM_ENU = Rotation.from_matrix([[0, 1, 0], [1, 0, 0], [0, 0, -1]])
FRD_FROM_FLU = Rotation.from_matrix(np.diag([1.0, -1.0, -1.0]))


@dataclass(frozen=True)
class PressureModel:
    """The conversion from logged values to depth."""

    density: float  # kg/m3
    gravity: float  # m/s2
    atmosphere: float  # Pa
    z_axis: str | None = None  # "up" or "down", of logged depths; None: as their type has it
    unit: str | None = None  # of PASCALS or METRES; None: as the type has it


@dataclass(frozen=True)
class LogUnits:
    """The units of what was logged, as dive.toml gives them."""

    rates: str = "rad/s"
    velocity: str = "m/s"
    joints: Mapping[str, str] = field(default_factory=dict)  # by record ("tray", "sonar_tray")


@np.errstate(all="ignore")  # values of any size: what is absurd is left out below
def dvl_pings(
    samples: Sequence[DvlSample],
    beams: Array | None,
    sigma: float,
    notes: list[Finding],
    unit: str = "m/s",
) -> DvlPings:
    """Stack the pings of a DVL, with NaN for velocities and ranges that are lost or absurd.

    Ranges become metres along the beams, whatever they were logged as.

    Parameters
    ----------
    samples : pings in order of time
    beams : (b, 3) directions of dive.toml in `dvl`, for messages without; None: not given
    sigma : standard deviation of a velocity, m/s, where a message has none
    notes : what was assumed or left out is added
    unit : key of METRES_A_SECOND by which the logged velocities and their sigmas are converted

    Raises
    ------
    InputError
        Ranges along beams that nothing describes, values that only another unit explains, or
        pings of two DVLs.
    """
    # A ping with another number of beams than most keeps its velocity alone.
    counts = Counter(len(s.ranges) for s in samples if len(s.ranges)).most_common(1)
    width = counts[0][0] if counts else 0
    ranges = np.full((len(samples), width), np.nan)
    for row, sample in enumerate(samples):
        if len(sample.ranges) == width:
            ranges[row] = sample.ranges
    ranges[~((ranges > 0) & np.isfinite(ranges))] = np.nan  # no return
    ranges = drop_false_beams(drop_ranges_at_limit(ranges, notes), notes)
    if width and not np.isfinite(ranges).any():
        notes.append(Finding("ranges-all-lost", where="dvl"))
        ranges, width = ranges[:, :0], 0
    # A whole log is refused before single absurd velocities are dropped: it is judged by all.
    scale = METRES_A_SECOND[unit]
    velocity = scale * np.array([s.velocity for s in samples]).reshape(-1, 3)
    velocity[~np.isfinite(velocity).all(axis=1)] = np.nan
    notes += _describe_not_over_ground(samples)
    speed = np.linalg.norm(velocity, axis=1)
    _refuse_fast(speed, unit)
    _refuse_coarse(velocity, speed)
    absurd = speed > FASTEST_M_S
    if absurd.any():
        velocity[absurd] = np.nan
        values = {"count": int(absurd.sum()), "limit_m_s": FASTEST_M_S}
        notes.append(Finding("velocities-absurd", values, "dvl"))
    given = scale * np.array([s.sigma for s in samples])
    t_ns = _times(samples)
    velocity, given = drop_lost_velocities(t_ns, velocity, given, ranges, notes)
    cut = windows(velocity[np.isfinite(velocity).all(axis=1)])
    refuse_two_sensors("dvl", np.linalg.norm(cut - cut[:, :1], axis=2), "m/s")
    directions = choose_beams(samples, beams, width, notes)
    # Ranges logged as distances along the DVL's axis become distances along the beams.
    along_axis = np.array([s.along_axis for s in samples], bool)
    along_beams = ranges[along_axis] / directions[:, 2]
    ranges[along_axis] = np.where(np.isfinite(along_beams) & (along_beams > 0), along_beams, np.nan)
    altitude = np.array([s.altitude for s in samples])
    ranges, mended = put_ranges_right(directions, ranges, altitude)
    _refuse_far(ranges)
    notes += mended + check_beams(directions, ranges, altitude)
    by_hand = any(s.by_hand for s in samples)
    scale_sigma, unconfirmed = range_scale_sigma(directions, ranges, altitude, by_hand)
    notes += unconfirmed
    return DvlPings(
        t_ns=t_ns,
        velocity=velocity,
        velocity_sigma=np.where(np.isfinite(given) & (given > 0), given, sigma),
        ranges=ranges,
        beams=directions,
        range_scale_sigma=np.array(scale_sigma),
    )


def _describe_not_over_ground(samples: Sequence[DvlSample]) -> list[Finding]:
    """Report the velocities that a DVL measured relative to something else than the ground."""
    code, count = "velocities-not-over-ground", len(samples)
    others = Counter(s.not_over_ground for s in samples if s.not_over_ground)
    return [
        Finding(code, {"lost": lost, "count": count, "what": what}, "dvl")
        for what, lost in sorted(others.items())
    ]


def _refuse_far(ranges: Array) -> None:
    """Raise InputError for ranges (n, b), m, that only another unit explains."""
    known = ranges[np.isfinite(ranges)]
    median = float(np.median(known)) if len(known) else 0.0
    if median > FARTHEST_MEDIAN_M:
        raise InputError(
            f"half of the DVL's ranges are {median:.4g} m or more, as none along a hull is: are "
            "they in centimetres or millimetres?",
            where="dvl",
            remedy="log them in metres, or leave the ranges away",
        )


def _refuse_coarse(velocity: Array, speed: Array) -> None:
    """Raise InputError for velocities (n, 3), m/s, rounded so that they lose their direction.

    They are where all are multiples of one step, and the step is more than COARSEST_SHARE of the
    median speed. Too few velocities, or different values, are accepted.

    Parameters
    ----------
    velocity : (n, 3) m/s, NaN where lost
    speed : (n,) their lengths
    """
    levels = np.unique(np.abs(velocity[np.isfinite(velocity)]))
    moving = speed[speed > 0]
    if len(moving) < LEAST_ROUNDED or len(levels) < LEAST_LEVELS:
        return
    step = float(np.diff(levels).min())
    rounded = np.abs(levels / step - np.round(levels / step)).max() < ON_GRID
    median = float(np.median(moving))
    if rounded and step > COARSEST_SHARE * median:
        raise InputError(
            f"its velocities are rounded to {step:.3g} m/s, half of them are {median:.3g} m/s or "
            "less",
            where="dvl",
            remedy="log or write them with more digits",
        )


def _refuse_fast(speed: Array, unit: str) -> None:
    """Raise InputError for speeds (n,), m/s, that only another unit explains.

    unit: of METRES_A_SECOND, by which they were converted. The error names the units that fit.
    """
    known = speed[np.isfinite(speed)]
    median = float(np.median(known)) if len(known) > 2 else 0.0
    if median <= FASTEST_MEDIAN_M_S:
        return
    logged = median / METRES_A_SECOND[unit]
    others = [
        f'"{other}" ({logged * METRES_A_SECOND[other]:.2g} m/s)'
        for other in METRES_A_SECOND
        if logged * METRES_A_SECOND[other] <= FASTEST_MEDIAN_M_S
    ]
    raise InputError(
        f"half of the DVL's velocities are {median:.3g} m/s or more, as no vehicle at a hull moves",
        where="dvl.velocity_unit",
        remedy=f"give their unit: {' or '.join(others)}" if others else "see what the topic holds",
    )


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
    quaternion = np.array([s.quaternion for s in samples]).reshape(-1, 4)
    length = np.linalg.norm(quaternion, axis=1)
    good = (np.abs(length - 1) < UNIT_QUATERNION) & ~is_false_attitude(quaternion)
    if len(samples) and np.count_nonzero(good) < LEAST_UNIT * len(samples):
        raise _no_attitude(length, int(np.count_nonzero(good)))
    if not good.all():
        lacking = {"lacking": int(np.count_nonzero(~good)), "count": len(good)}
        notes.append(Finding("attitudes-lacking", lacking, "imu"))
    rates = np.array([s.rates for s in samples]).reshape(-1, 3)
    acceleration = np.array([s.acceleration for s in samples]).reshape(-1, 3)
    held = good & is_held(_times(samples), quaternion, rates, acceleration)
    if held.any():
        start = format_time(int(_times(samples)[held][0]))
        notes.append(Finding("attitudes-held", {"held": int(held.sum()), "start": start}, "imu"))
        good &= ~held
    rates, acceleration = rates[good], acceleration[good]
    rates = np.radians(rates) if rates_unit == "deg/s" else rates
    _refuse_unfilled(quaternion[good], rates)
    if len(rates) >= LEAST_ATTITUDES and not rates.any() and np.ptp(quaternion[good], axis=0).any():
        notes.append(Finding("rates-unfilled", {"count": len(rates)}, "imu"))
        rates = np.full_like(rates, np.nan)
    rotation = Rotation.from_quat(quaternion[good])
    # jumps between two orientations in turn show two sensors
    cut = windows(rotation.as_quat())
    cosine = np.abs((cut * cut[:, :1]).sum(axis=2))  # of half the angle between two orientations
    refuse_two_sensors("imu", 2 * np.degrees(np.arccos(np.minimum(cosine, 1))), "degrees")
    acceleration = _in_m_s2(acceleration, notes)
    if any(s.of_dvl for s in samples):
        mount_deg = _require_mount_of_dvl(mount_deg)
        notes.append(Finding("attitude-of-dvl", where="imu"))
    elif frame == "enu":
        # world and body axes: to north-east-down on the left, from forward-starboard-down on the
        # right
        rotation = NED_FROM_ENU * rotation * FRD_FROM_FLU.inv()
        rates, acceleration = rates * [1, -1, -1], acceleration * [1, -1, -1]
    if mount_deg is not None:
        vehicle_from_imu = Rotation.from_euler("ZYX", mount_deg[::-1], degrees=True)
        rotation = rotation * vehicle_from_imu.inv()
        rates, acceleration = vehicle_from_imu.apply(rates), vehicle_from_imu.apply(acceleration)
    acceleration = _with_gravity(acceleration, rotation, notes)
    t_ns = _times(samples)[good]
    if heading == "rates":
        found = heading_by_rates(t_ns, rotation, rates)
        rotation = found.rotation
        hourly = {"drift": found.drift_rad_s, "sigma": found.drift_sigma_rad_s}
        values = {f"{name}_deg_h": 3600 * np.degrees(rate) for name, rate in hourly.items()}
        swing = {"swing_deg": float(np.degrees(found.swing_rad))}
        notes.append(Finding("heading-of-rates", {**values, **swing}, "imu"))
    return ImuSamples(
        t_ns=t_ns, quaternion=rotation.as_quat(), angular_velocity=rates, acceleration=acceleration
    )


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
    """Convert accelerations (n, 3) to m/s2 where their median size is that of gravity in g or mg.

    Others are returned unchanged.
    """
    size = np.linalg.norm(acceleration, axis=1)
    known = size[np.isfinite(size)]
    felt = float(np.median(known)) if len(known) else 0.0
    for name, scale in ACCELERATIONS.items():
        if abs(felt * scale - GRAVITY_M_S2) < NEAR_GRAVITY * GRAVITY_M_S2:
            notes.append(Finding("accelerations-in-unit", {"unit": name, "median": felt}, "imu"))
            return scale * acceleration
    return acceleration


def _with_gravity(acceleration: Array, rotation: Rotation, notes: list[Finding]) -> Array:
    """Put gravity back into accelerations that a filter has taken it off, by the orientation.

    Accelerations whose median is near that of gravity are returned unchanged.

    Parameters
    ----------
    acceleration : (n, 3) m/s2, in the vehicle, as an accelerometer feels it
    rotation : (n,) from the vehicle to `global`
    notes : what was changed is added

    Returns
    -------
    acceleration (n, 3), NaN where a driver filled in zeros
    """
    felt = rotation.apply(acceleration)  # in `global`, where gravity adds up and motion does not
    known = np.isfinite(felt).all(axis=1)
    if not known.any():
        return acceleration
    if len(felt) >= LEAST_ATTITUDES and not felt[known].any():
        notes.append(Finding("accelerations-unfilled", {"count": int(known.sum())}, "imu"))
        return np.full_like(acceleration, np.nan)
    mean = float(np.linalg.norm(np.median(felt[known], axis=0)))
    if mean >= LEAST_FELT_M_S2:
        return acceleration
    notes.append(Finding("gravity-taken-off", {"felt_m_s2": mean}, "imu"))
    # z of `global` is down, and an accelerometer at rest feels the push upward
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


@np.errstate(all="ignore")
def pressure_samples(
    samples: Sequence[PressureSample | DepthSample],
    model: PressureModel,
    notes: list[Finding],
    compared: bool = False,
) -> PressureSamples | None:
    """Stack the depths of one sensor, positive down. None where no reading is finite.

    Depths higher above the water than any deck, and spikes, are dropped.

    Parameters
    ----------
    samples : readings in order of time
    model : constants and units by which a reading becomes a depth
    notes : findings of what was assumed or dropped are added
    compared : whether another sensor tells how the vehicle sank, so that a wrong unit of pressure
        is found later; depths above the water are then returned, not refused

    Raises
    ------
    InputError
        Half of the depths lie above the water, two units fit the numbers, or two sensors share the
        topic.
    """
    if any(is_of_dvl(s) for s in samples):
        notes.append(Finding("depth-of-dvl", where="pressure"))
    depth = np.array([_depth_m(s, model) for s in samples])
    good = np.isfinite(depth)
    notes += _describe_lost("pressure", good)
    if not good.any():
        return None
    depth = depth[good]
    cut = windows(depth)
    away = "leave topics.pressure (or pressure.csv) away"
    refuse_two_sensors("pressure", np.abs(cut - cut[:, :1]), "m", away)
    _refuse_unclear_numbers([s for s, known in zip(samples, good, strict=True) if known], model)
    if np.median(depth) < -HIGHEST_M:
        if compared and (model.unit or "Pa") in PASCALS and isinstance(samples[0], PressureSample):
            return PressureSamples(t_ns=_times(samples)[good], depth=depth)
        raise _above_water([s for s, is_good in zip(samples, good, strict=True) if is_good], model)
    in_water = depth > -HIGHEST_DECK_M
    if not in_water.all():
        values = {"lost": int((~in_water).sum()), "count": len(depth), "limit_m": HIGHEST_DECK_M}
        notes.append(Finding("depths-above-water", values, "pressure"))
    t_ns, depth = _times(samples)[good][in_water], depth[in_water]
    spikes = _are_spikes(t_ns, depth)
    if spikes.any():
        counts = {"spikes": int(spikes.sum()), "count": len(depth)}
        notes.append(Finding("depths-spikes", counts, "pressure"))
    return PressureSamples(t_ns=t_ns[~spikes], depth=depth[~spikes])


def _are_spikes(t_ns: Ints, depth: Array) -> Mask:
    """Find depths (n,), m, that a vehicle cannot have reached from the readings around them.

    Each is compared with the median of SPIKE_READINGS around it. The threshold grows with the
    noise, so that depths in a wrong unit, whose noise is metres, are not all spikes.
    """
    if len(depth) < SPIKE_READINGS:
        return np.zeros(len(depth), bool)
    off = np.abs(depth - median_filter(depth, SPIKE_READINGS, mode="mirror"))
    rows, half = np.arange(len(depth)), SPIKE_READINGS // 2
    after, before = t_ns[np.minimum(rows + half, rows[-1])], t_ns[np.maximum(rows - half, 0)]
    # what a vehicle can sink or rise between the first and the last of them, m
    way = FASTEST_DIVE_M_S * (after - before) / NS
    noise = float(np.median(np.abs(np.diff(depth))))
    return np.asarray(off > np.maximum(SPIKE_M + way, 10 * noise))


def _refuse_unclear_numbers(
    samples: Sequence[PressureSample | DepthSample], model: PressureModel
) -> None:
    """Raise InputError for depths without a unit that may be hectopascals or centimetres.

    A centimetre of water is a hectopascal: motion does not tell them apart. Only numbers that are
    depths of a hull in both units are refused.
    """
    if model.unit is not None or isinstance(samples[0], PressureSample):
        return
    fitting = []
    for name in ("hPa", "cm"):
        depth = [_depth_m(s, replace(model, unit=name)) for s in samples]
        low, high = np.percentile(depth, [5, 95])
        if low < -HIGHEST_M or high > DEEPEST_HULL_M:
            return
        fitting.append(f'"{name}" ({low:.1f} to {high:.1f} m deep then)')
    raise InputError(
        "the depths are hundreds of metres: they are a pressure in hectopascals or centimetres of "
        "water, which change alike",
        where="pressure.unit",
        remedy=f"give pressure.unit = {' or '.join(fitting)}",
    )


def _depth_m(sample: PressureSample | DepthSample, model: PressureModel) -> float:
    """Convert a reading to metres below the water.

    A unit in dive.toml decides whether the number is a pressure or a depth, else its type does.
    """
    is_pressure = isinstance(sample, PressureSample)
    value = sample.pascal if isinstance(sample, PressureSample) else sample.height
    unit = model.unit or ("Pa" if is_pressure else "m")
    if unit in PASCALS:
        return (value * PASCALS[unit] - model.atmosphere) / (model.density * model.gravity)
    is_up_by_type = isinstance(sample, DepthSample) and sample.is_up
    is_up = is_up_by_type if model.z_axis is None else model.z_axis == "up"
    return -value * METRES[unit] if is_up else value * METRES[unit]


def _above_water(
    samples: Sequence[PressureSample | DepthSample], model: PressureModel
) -> InputError:
    """Make the error for depths that lie above the water, with the units that bring them below.

    It names the keys of dive.toml that may be wrong: the unit or the air pressure of a pressure,
    the direction in which a depth grows.
    """
    unit = model.unit or ("Pa" if isinstance(samples[0], PressureSample) else "m")
    height = -float(np.median([_depth_m(s, model) for s in samples]))
    what = f"half of the depths lie {height:.1f} m or more above the water"
    if unit not in PASCALS:
        other = "down" if samples[0].is_up else "up"  # type: ignore[union-attr]
        if model.z_axis is not None:
            other = "down" if model.z_axis == "up" else "up"
        remedy = (
            f'give pressure.z_axis = "{other}" where they grow so; a height above another level'
        )
        return InputError(what, where="pressure", remedy=f"{remedy} than the water is no depth")
    fitting = []
    for name in {scale: name for name, scale in PASCALS.items()}.values():  # hPa stands for mbar
        depth = [_depth_m(s, replace(model, unit=name)) for s in samples]
        low, high = np.percentile(depth, [5, 95])
        if low > -HIGHEST_M and high < DEEPEST_HULL_M:
            fitting.append(f'pressure.unit = "{name}" ({low:.1f} to {high:.1f} m deep then)')
    relative = "pressure.atmosphere = 0 for a pressure over that of the air"
    still_m = float(np.ptp(np.percentile([_depth_m(s, model) for s in samples], [5, 95])))
    if still_m < STILL_M:
        relative += (
            f"; readings that stay within {still_m:.2f} m may be the air's in an enclosure: then "
            "name another topic, or none"
        )
    return InputError(
        f"{what}, as no absolute pressure in {unit} does",
        where="pressure",
        remedy=f"give {', or '.join([*fitting, relative])}",
    )


@np.errstate(all="ignore")
def joint_samples(
    samples: Sequence[JointSample], record: str, name: str, notes: list[Finding], unit: str = "rad"
) -> JointSamples | None:
    """Stack the angles of one servo. None where no reading is finite.

    Readings that are not finite are dropped. Angles that begin anew after each turn are made to run
    on.

    Parameters
    ----------
    samples : readings of the servo in order of time
    record : "tray" or "sonar_tray", whose angles may go beyond a turn
    name : of the joint in the log
    notes : findings of what was changed or dropped are added
    unit : "rad" or "deg"

    Raises
    ------
    InputError
        A tray that would turn by more than a whole turn, or angles of two servos.
    """
    angle = np.array([s.angle for s in samples])
    angle = np.radians(angle) if unit == "deg" else angle
    good = np.isfinite(angle)
    notes += _describe_lost(f"joint {name}", good)
    if not good.any():
        return None
    largest_rad = float(np.abs(angle[good]).max())
    joined = _join_turns(angle[good], f"joint {name}", notes)
    cut = np.degrees(windows(joined))
    refuse_two_sensors(f"joint {name}", np.abs(cut - cut[:, :1]), "degrees")
    if largest_rad > 2 * np.pi and record == "tray":
        is_degrees = unit == "rad" and largest_rad <= WHOLE_TURN_DEG
        raise InputError(
            f"the angles of {name} reach {largest_rad:.1f} rad, more than a whole turn",
            where="tray.joint_unit",
            remedy='give tray.joint_unit = "deg" where they are degrees'
            if is_degrees
            else "log them in radians or degrees: they are neither (a servo's pulse or counts?)",
        )
    if largest_rad > 2 * np.pi:
        notes.append(Finding("angles-in-degrees", {"largest_rad": largest_rad}, f"joint {name}"))
    return JointSamples(t_ns=_times(samples)[good], angle=joined)


def _join_turns(angle: Array, name: str, notes: list[Finding]) -> Array:
    """Let angles (n,) rad run on that are counted anew from 0 after each whole turn.

    Whole turns are then taken off all, so that their median lies within half a turn of 0. Angles
    without such jumps are returned unchanged. name: of the stream, for `notes`.
    """
    jumps = int(np.count_nonzero(np.abs(np.diff(angle)) > NEARLY_A_TURN))
    if not jumps:
        return angle
    notes.append(Finding("angles-wrap", {"jumps": jumps}, name))
    joined = np.unwrap(angle, discont=NEARLY_A_TURN)
    return np.asarray(joined - 2 * np.pi * np.round(np.median(joined) / (2 * np.pi)))


def _describe_lost(name: str, good: Mask) -> list[Finding]:
    lost = int(np.count_nonzero(~good))
    values = {"lost": lost, "count": len(good)}
    return [Finding("readings-not-finite", values, name)] if lost else []


def keep_in_memory(shape: tuple[int, int, int], images: Iterator[Images]) -> Images:
    """Stack the images into one array."""
    kept = np.empty(shape, np.uint8)
    for row, image in zip(kept, images, strict=True):
        row[:] = image
    return kept


def leave_black(shape: tuple[int, int, int], images: Iterator[Images]) -> Images:
    """Return black images that take no memory, in place of `keep_in_memory`.

    For calls that look at no image.
    """
    return np.broadcast_to(np.uint8(0), shape)


@np.errstate(all="ignore")
def sonar_pings(
    samples: Sequence[SonarSample],
    notes: list[Finding],
    azimuth_deg: Array | None = None,
    keep: KeepImages = keep_in_memory,
    load: Callable[[SonarSample], SonarSample] = lambda sample: sample,
) -> SonarPings | None:
    """Stack pings of the most common geometry as images of 8 bits. None without any.

    Pings of other windows and fans are dropped. All are scaled by one factor, so that their
    brightness stays comparable.

    Parameters
    ----------
    samples : pings in order of time
    notes : what was assumed or left out is added
    azimuth_deg : (beams,) of dive.toml, for logs that do not say where the beams point
    keep : stores the images, and returns them as one array
    load : reads the image of a ping back, where `samples` hold stand-ins (ping_spool)

    Raises
    ------
    InputError
        Nothing says where the beams point.
    """
    kept, range_m = pings_of_one_window(samples, notes)
    if not kept:
        return None
    directions = choose_directions(kept[0], azimuth_deg, notes)
    scale = _scale_to_eight_bits(kept, notes)
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


def _scale_to_eight_bits(samples: Sequence[SonarSample], notes: list[Finding]) -> float | None:
    """Find the factor that brings the bright pixel of nearly all pings to 255 at most.

    None where all pixels have 8 bits, 0 where all are black.
    """
    if all(sample.image.dtype == np.uint8 for sample in samples):
        return None
    bright = np.array([float(bright_pixel(sample.image)) for sample in samples])
    bright = bright[bright > 0]
    white = 0.0
    if len(bright):
        white = float(np.percentile(bright, BRIGHT_PINGS_PERCENT, method="higher"))
    values = {"dtype": str(samples[0].image.dtype), "white": white}
    notes.append(Finding("sonar-scaled", values, "sonar"))
    return 255.0 / white if white > 0 else 0.0


def _eight_bits(image: NDArray[np.generic], scale: float | None) -> NDArray[np.uint8]:
    if scale is None:
        return image.astype(np.uint8)
    return np.asarray(np.clip(np.nan_to_num(image.astype(float)) * scale, 0, 255).round(), np.uint8)


def _times(samples: Sequence[object]) -> Ints:
    return np.array([s.t_ns for s in samples], np.int64)  # type: ignore[attr-defined]
