# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find by how much the clock of DVL or pressure sensor is off, however far, from vertical motion.

The DVL's velocity, turned by the attitude, is how fast the depth grows. Both are compared at all
time offsets at once, by correlations of their products (docs/methods.md, Clocks). Offsets here are
what has to be added to the stamps: positive where these are early.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.fft import irfft, rfft
from scipy.spatial.transform import Rotation

from hullrecon.dive.check.time_overlap import HOUR_S, clock_gaps, shifted_streams
from hullrecon.dive.config.mounts import numbers_of
from hullrecon.dive.config.schema import DiveConfig
from hullrecon.findings.finding import Finding
from hullrecon.geometry.poses import Poses, from_mount
from hullrecon.geometry.robust import GAIN
from hullrecon.records.clock import NS, seconds
from hullrecon.records.sensors import SensorRecords
from hullrecon.typing import Array, Ints, Mask

STEP_S = 0.1  # of the grid on which motions are compared
SMOOTH_S = 2.0  # over which velocities are averaged, and depths differ
PAUSE_S = 2.0  # between readings, across which nothing is interpolated
LEAST_S = 15.0  # of motion that both measured
LEAST_SHARE = 0.5  # of the shorter record, that both measured
OTHER_S = 10.0  # between the best offset and the others that it has to be better than
LEAST_CORRELATION = 0.7
GAIN_OF_FEW = 9.0  # as GAIN, where few offsets are possible: three sigmas
FAR_S = 60.0  # the step navigate finds smaller offsets
SAME_S = 30.0  # from whole hours; the rest of the offset is found by the step navigate
SHIFTED_S = 2.0  # between what the ends of logs and motion tell; operators start logs by hand
LONGEST_S = 12 * HOUR_S  # of a log; a dive is four hours at most, and the grid has to fit in memory
INDEPENDENT_S = 2.0  # readings so far apart have independent errors and swell


def add_motion(
    findings: Sequence[Finding], config: DiveConfig, records: SensorRecords
) -> list[Finding]:
    """Add the offset that the vertical motion tells to findings of clocks that are apart.

    Findings about which the motion gives no information, and all others, are returned unchanged.
    """
    tray, pressure = (np.array(numbers_of(s.origin)) for s in (config.tray, config.pressure))
    level = level_of(records, tray, pressure, from_mount(numbers_of(config.dvl.mount)))
    return [
        _with_offset_by_motion(finding, records, level)
        if finding.code == "clocks-apart"
        else finding
        for finding in findings
    ]


def _with_offset_by_motion(
    finding: Finding, records: SensorRecords, level: Level | None
) -> Finding:
    """Replace a finding's offset by that of the motion, if the motion determines one.

    An offset near the hours that the finding suspects is that of a time zone: the hours are then
    taken as exact.
    """
    early_s = offset_by_motion(finding.where, records, level)
    if early_s is None:
        return finding
    hours, given_s = finding.values["hours"], finding.values["given_s"]
    assert isinstance(given_s, float)
    assert isinstance(hours, float | None)
    of_zone = hours is not None and abs(early_s - hours * HOUR_S) < SAME_S
    whole_s = given_s + (hours * HOUR_S if hours is not None and of_zone else round(early_s, 2))
    new_values = {"offset_s": whole_s, "hours": hours if of_zone else None, "by_motion": True}
    return replace(finding, values={**finding.values, **new_values})


def motions_apart(records: SensorRecords, level: Level | None) -> list[Finding]:
    """Report that the motions of DVL and pressure sensor agree only at an offset of FAR_S or more.

    By their stamps the two were read at the same time, so nothing else shows a wrong clock. Clocks
    whose sensors were not are reported elsewhere. Empty where the motion gives no information.
    """
    dvl_early_s = offset_by_motion("dvl", records, level)
    gaps = clock_gaps(records.by_name())
    is_reported = any(gap.severity == "error" for gap in gaps)
    if dvl_early_s is None or abs(dvl_early_s) < FAR_S or is_reported:
        return []
    return [Finding("motions-apart", {"seconds": round(dvl_early_s, 2)})]


def mend_shifted(
    records: SensorRecords, level: Level | None
) -> tuple[SensorRecords, list[Finding]]:
    """Correct the stamps of a DVL or pressure sensor that is seconds late, or early, throughout.

    Both ends of its log have to be late by the same time beside all others, and the motions of the
    two sensors have to agree better at that offset than as stamped. Otherwise the records are
    returned unchanged. One sensor is corrected at most.

    Returns
    -------
    the records, and a finding of what was corrected
    """
    for shifted in shifted_streams(records.by_name()):
        late_s = shifted.values["seconds"]
        assert isinstance(late_s, float)
        # Only two offsets are possible: none, or the one that the ends of the log show.
        early_s = offset_by_motion(shifted.where, records, level, (0.0, -late_s))
        if early_s is None or abs(early_s + late_s) > SHIFTED_S:
            continue
        stream = getattr(records, shifted.where)
        moved = replace(stream, t_ns=stream.t_ns + round(early_s * NS))
        finding = Finding("stream-moved", {"seconds": -early_s}, shifted.where)
        return replace(records, **{shifted.where: moved}), [finding]
    return records, []


@dataclass(frozen=True, kw_only=True)
class Level:
    """How DVL and pressure sensor were oriented to the vertical, by attitude and tray."""

    t_ns: Ints  # (n,)
    down: Array  # (n, 3) unit vectors down, in the DVL's frame
    below: Array  # (n,) m, of the DVL below the pressure sensor


def level_of(
    records: SensorRecords, tray_origin: Array, pressure_origin: Array, tray_from_dvl: Poses
) -> Level | None:
    """Compute the vertical in the DVL's frame, and how far the DVL was below the pressure sensor.

    None where no attitude was read.

    Parameters
    ----------
    records : attitudes of the IMU, and angles of the tray if it turned
    tray_origin, pressure_origin : (3,) m, in the vehicle
    tray_from_dvl : mount of the DVL on the tray
    """
    imu, tray = records.imu, records.tray
    if imu is None or len(imu.t_ns) < 2:
        return None
    angle = np.zeros(len(imu.t_ns))
    if tray is not None and len(tray.t_ns):
        angle = np.interp(imu.t_ns, tray.t_ns, tray.angle)
    turned = Rotation.from_euler("y", angle[:, None])
    # from the pressure sensor to the DVL, m, in the vehicle
    lever = tray_origin - pressure_origin + turned.apply(tray_from_dvl.translation)
    global_from_vehicle = Rotation.from_quat(imu.quaternion)
    # z of `global`, which points down, in the DVL's frame; the lever's part along it is how much
    # deeper the DVL is
    down = (global_from_vehicle * turned * tray_from_dvl.rotation).inv().apply([0.0, 0.0, 1.0])
    below = global_from_vehicle.apply(lever)[:, 2]
    return Level(t_ns=imu.t_ns, down=np.asarray(down), below=np.asarray(below))


def offset_by_motion(
    sensor: str,
    records: SensorRecords,
    level: Level | None,
    among_s: Sequence[float] = (),
) -> float | None:
    """Estimate what to add to the stamps of "dvl" or "pressure", s, by the motion of both.

    It is the time offset at which the DVL's vertical velocity agrees best with the rate of the
    depth. All other sensors are taken to be on one time base, so that the attitude belongs to the
    one of the two whose clock is right. None where the vehicle hardly went up or down, where a
    sensor or the attitude is missing, and for logs longer than LONGEST_S.

    Parameters
    ----------
    sensor : "dvl" or "pressure", whose clock is in doubt; None is returned for any other
    records : velocities of the DVL and depths of the pressure sensor
    level : how both sensors were oriented to the vertical
    among_s : if given, only offsets within SHIFTED_S of one of these are possible
    """
    dvl, pressure = records.dvl, records.pressure
    if sensor not in ("dvl", "pressure") or dvl is None or pressure is None or level is None:
        return None
    heard = np.isfinite(dvl.velocity).all(axis=1)
    if min(heard.sum(), len(pressure.t_ns)) < 2:
        return None
    spans = (dvl.t_ns[heard], pressure.t_ns)
    if any(t_ns[-1] - t_ns[0] > LONGEST_S * NS for t_ns in spans):
        return None
    begin = {"dvl": int(dvl.t_ns[heard][0]), "pressure": int(pressure.t_ns[0])}
    velocity, is_heard = _on_grid(dvl.t_ns[heard], dvl.velocity[heard], begin["dvl"])
    velocity = _running_mean(velocity)
    # grid of the attitude: that of the sensor whose clock is right
    at = begin["pressure" if sensor == "dvl" else "dvl"]
    depth, is_read = _on_grid(pressure.t_ns, pressure.depth[:, None], begin["pressure"])
    count = len(depth) if sensor == "dvl" else len(velocity)
    down, is_level = _on_grid(level.t_ns, level.down, at, count)
    below, _ = _on_grid(level.t_ns, level.below[:, None], at, count)
    # A lag counts from the beginning of one record to that of the other. The offset of the stamps
    # is the lag plus the delay, by the stamps, with which the pressure sensor began.
    if sensor == "dvl":
        # depth of the DVL itself, as it is the one that the velocity is of
        rate, is_sunk = _rate(depth + below, is_read & is_level)
        later_s = (begin["pressure"] - begin["dvl"]) / NS
        lags_s = [offset_s - later_s for offset_s in among_s]
        lag_s = _best_lag(down, rate, is_sunk, velocity, is_heard, lags_s)
        return None if lag_s is None else lag_s + later_s
    rate, is_sunk = _rate(depth, is_read)
    # how fast the DVL sinks beside the pressure sensor, as vehicle and tray turn
    swept, is_swept = _rate(below, is_level)
    sinking = (down * velocity).sum(axis=1) - swept
    ones = np.ones((len(rate), 1))
    later_s = (begin["pressure"] - begin["dvl"]) / NS
    lags_s = [-offset_s - later_s for offset_s in among_s]
    lag_s = _best_lag(ones, rate, is_sunk, sinking[:, None], is_heard & is_swept, lags_s)
    return None if lag_s is None else -(lag_s + later_s)


def _on_grid(
    t_ns: Ints, values: Array, start_ns: int, count: int | None = None
) -> tuple[Array, Mask]:
    """Interpolate readings on a grid of STEP_S, and tell where they are known.

    Parameters
    ----------
    t_ns : (n,) stamps, in order
    values : (n, k) what was read
    start_ns : time of the first point of the grid
    count : number of points of the grid; None: up to the last reading

    Returns
    -------
    values (count, k), and mask (count,), False outside the readings and in pauses longer than
    PAUSE_S
    """
    t_s = seconds(t_ns, start_ns)
    if count is None:
        count = max(1, int(t_s[-1] / STEP_S) + 1)
    at_s = STEP_S * np.arange(count)
    columns = [np.interp(at_s, t_s, column) for column in values.T]
    after = np.clip(np.searchsorted(t_s, at_s), 1, len(t_s) - 1)
    near = (t_s[after] - t_s[after - 1] <= PAUSE_S) & (at_s >= t_s[0]) & (at_s <= t_s[-1])
    return np.stack(columns, axis=1), np.asarray(near, bool)


def _running_mean(values: Array) -> Array:
    """Average values (n, k) on the grid over SMOOTH_S.

    The rate of the depth is a difference over that time (`_rate`), which is the same average.
    """
    width = round(SMOOTH_S / STEP_S)
    kernel = np.full(width + 1, 1.0 / width)
    kernel[[0, -1]] *= 0.5
    inside = slice(width // 2, width // 2 + len(values))
    return np.stack([np.convolve(column, kernel)[inside] for column in values.T], axis=1)


def _rate(depth: Array, known: Mask) -> tuple[Array, Mask]:
    """Differentiate a depth (n, 1) on the grid over SMOOTH_S: rate (n,), m/s, and where known."""
    half = round(SMOOTH_S / STEP_S / 2)
    rate = (np.roll(depth, -half) - np.roll(depth, half))[:, 0] / SMOOTH_S
    known = known & np.roll(known, half) & np.roll(known, -half)
    known[:half] = known[-half:] = False
    return rate, known


def _lagged(one: Array, other: Array) -> Array:
    """Correlate signals `one` (n,) and `other` (m,) by FFT, at all n + m - 1 lags from 1 - m on.

    scipy.signal has it, and takes half a second to load, for every command that reads a log.
    """
    count = len(one) + len(other) - 1
    size = 1 << count.bit_length()  # a power of two, which is fast
    spectrum = rfft(one, size) * rfft(other, size).conj()
    return np.asarray(np.roll(irfft(spectrum, size), len(other) - 1)[:count])


def _best_lag(
    fixed: Array,
    rate: Array,
    is_fixed: Mask,
    moving: Array,
    is_moving: Mask,
    among_s: Sequence[float],
) -> float | None:
    """Find the lag, s, at which the vertical velocity correlates best with the rate of the depth.

    The vertical velocity at a lag is the sum over k of the direction `fixed` times the velocity
    `moving`, whose grid is shifted by the lag. The correlation coefficient is computed at all lags
    by FFT. None unless it is high at the best lag, and chi-square is clearly lower there than at
    all lags OTHER_S or more away.

    Parameters
    ----------
    fixed : (n, k) vertical direction on one grid
    rate, is_fixed : (n,) rate of the depth on that grid, and where it and `fixed` are known
    moving, is_moving : (m, k) velocity on another grid, and where (m,) it is known. The lag is
        where this grid begins on the first one
    among_s : if given, only lags near these are possible, and less evidence is needed
    """
    # 1 where known, else 0: what is not known then adds nothing to a sum
    fixed_known, moving_known = is_fixed.astype(float), is_moving.astype(float)
    fixed, rate = fixed * fixed_known[:, None], rate * fixed_known
    moving = moving * moving_known[:, None]

    # The correlation of vertical velocity and rate at every lag, over the steps at which both are
    # known. Each sum over steps is itself a correlation of products, taken by FFT.
    axes = range(fixed.shape[1])
    count = np.maximum(_lagged(fixed_known, moving_known), 1.0)
    mean = sum(_lagged(fixed[:, i], moving[:, i]) for i in axes) / count
    square = sum(
        _lagged(fixed[:, i] * fixed[:, j], moving[:, i] * moving[:, j]) for i in axes for j in axes
    )
    mean_rate, square_rate = _lagged(rate, moving_known) / count, _lagged(rate**2, moving_known)
    product = sum(_lagged(fixed[:, i] * rate, moving[:, i]) for i in axes)
    scatter = (square / count - mean**2) * (square_rate / count - mean_rate**2)
    floor = 1e-6 * float(np.mean(rate**2)) ** 2
    correlation = (product / count - mean * mean_rate) / np.sqrt(
        np.maximum(scatter, max(floor, 1e-18))
    )
    least = max(LEAST_S / STEP_S, LEAST_SHARE * min(fixed_known.sum(), moving_known.sum()))
    # -1 where too few steps overlap. Below 1, so that the chi-square stays finite
    correlation = np.clip(np.where(count >= least, correlation, -1.0), -1.0, 0.999)
    if among_s:
        lags_s = STEP_S * (np.arange(len(correlation)) - (len(moving) - 1))
        away_s = np.abs(lags_s[:, None] - np.array(among_s))
        correlation = np.where(away_s.min(axis=1) <= SHIFTED_S, correlation, -1.0)
    # The best lag has to be far better than any other.
    best = int(np.argmax(correlation))
    apart = np.abs(np.arange(len(correlation)) - best) >= OTHER_S / STEP_S
    other = float(correlation[apart].max(initial=-1.0))
    if correlation[best] < LEAST_CORRELATION:
        return None
    # by how much chi-square is larger at any other offset
    independent = max(count[best] * STEP_S / INDEPENDENT_S - 1.0, 0.0)
    gain = independent * np.log((1 - max(other, 0.0) ** 2) / (1 - correlation[best] ** 2))
    if gain < (GAIN_OF_FEW if among_s else GAIN):
        return None
    # between the steps of the grid, by a parabola
    low, middle, high = (
        correlation[best - 1 : best + 2] if 0 < best < len(correlation) - 1 else (0.0, 1.0, 0.0)
    )
    bend = low - 2 * middle + high
    within = 0.5 * (low - high) / bend if bend < 0 else 0.0
    return float(STEP_S * (best + np.clip(within, -0.5, 0.5) - (len(moving) - 1)))
