# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compare two sensors by a motion that both measured (docs/methods.md, Suspects).

- pressure and DVL: the change of depth against the integral of the DVL's vertical velocity,
- rates and attitude: the integral of an IMU's rates against the turn of its orientation,
- attitude and acceleration: what an accelerometer feels at rest points up, opposite to gravity,
- acceleration and DVL: the integral of the IMU's acceleration, less gravity, against the change of
  the DVL's velocity,
- images and DVL: the motion of features against that of a hull at the DVL's range, seen by a camera
  that moves by the DVL's velocity and turns by the attitude,
- DVL's velocity and ranges: the hull, which does not move, as seen by a DVL that moves and turns.

Each comparison is a table of residuals with their sigmas. Errors that faultless sensors have too (a
mount's tilt, a scale) are nuisances: the table holds the change of the residuals by one sigma of
each, and `Comparison.chi2` fits them. Stamps are taken as they are: clocks are compared in
navigation/clocks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence, Set
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.streams import GRAVITY_M_S2
from hullrecon.geometry.poses import Poses, interpolate, tray_poses
from hullrecon.geometry.robust import robust_sigma
from hullrecon.geometry.rotations import cross
from hullrecon.navigation.clocks.comparisons import (
    felt_in_global,
    hull_normals,
    is_still,
    velocity_felt,
)
from hullrecon.navigation.dead_reckoning.integral import Integral, integral
from hullrecon.navigation.sensors.servo import servo
from hullrecon.navigation.sensors.smoothing import local_line
from hullrecon.navigation.suspects.views import fit_turns
from hullrecon.records.clock import NS, period, seconds
from hullrecon.records.sensors import DvlPings, ImuSamples, PressureSamples, SensorRecords
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints

# sigmas of the features' motion: a share of each motion, a share that all have in common (range,
# curvature), and rad
FLOW_SHARE, FLOW_SCALE, FLOW_RAD = 0.05, 0.03, 0.003
VIEW_RAD = np.radians(0.2)  # sigma of a turn between two images by the attitude, and by a good lens
# lengths of the windows in which depth, turns, distance and velocity are compared
SUNK_S, TURNED_S, NEARED_S, CHANGED_S = 3.0, 1.0, 2.0, 1.0
LEAST_WINDOWS, MOST_WINDOWS = 4, 2000
LONGEST_GAP_S = 1.5  # between two readings of a window
SMOOTH_S = 0.4  # sigma of the weights by which depth, ranges and velocities are smoothed
# One sigma of errors that faultless sensors have:
TILT_RAD = np.radians(2.0)  # between DVL and IMU: mounts as measured by hand, backlash of a tray
SCALE = 0.015  # of a DVL and of the water's density together
LATE_S = 0.15  # between two sensors' clocks; larger offsets are judged in navigation/clocks
RATE_BIAS_RAD_S, RATE_SHARE = 0.01, 0.05  # of a MEMS gyroscope: bias, and scale with axes
ALONG_1_M = 0.05  # curvature of a hull along its length
RELIEF_M, RELIEF_RAD = 0.03, 0.03  # plates, weld seams and curvature within a window
LEVELS = np.linspace(0.25, 0.75, 5)  # quantiles of the depth that are compared with the surface
HIGHEST_M, SURFACE_SIGMA_M = 1.0, 0.3  # a sensor above the surface, and the day's air pressure
GRAVITY_SIGMA = 1.0  # m/s2, of a median over the dive
# m/s2 by a MEMS accelerometer's bias and by roll and pitch (half a degree); m/s by vibration of
# thrusters in a window; m between the IMU and the vehicle's origin
FELT_BIAS_M_S2, CHANGED_SIGMA_M_S, IMU_LEVER_M = 0.1, 0.02, 0.2
CHANGED_SHARE = 0.05  # of an accelerometer's scale and axes
DEPTH_SIGMA_M = 0.005  # of a change of depth by two smoothed readings, at least
ROUGH_SHARE = 0.4  # of LATE_S, by which the lags of two smoothed sensors differ from time to time
# What decides:
CLIP = 4.0  # sigmas at which a residual is clipped
SHARED = 0.8  # squared correlation from which on one signal is a scaled copy of the other
GAIN = 25.0  # of chi-square above its mean: five sigmas, as in navigation/clocks
# of chi-square over the rows: 1.2 at most on 17 faultless dives, 3.3 to 11 with faults
MISFIT = 2.0


class Sensor(StrEnum):
    """What may be wrong: a sensor, or one of the signals of an IMU."""

    PRESSURE = "pressure"
    DVL = "DVL"
    RATES = "IMU's rates"
    ATTITUDE = "IMU's orientation"
    ACCELERATION = "IMU's acceleration"
    TRAY = "tray's angle"
    CAMERA = "camera"


# sensors that the comparisons with images depend on
SEEN = frozenset({Sensor.CAMERA, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY})


@dataclass(frozen=True, kw_only=True)
class Flow:
    """Features of a rigid scene in two images of the upper camera."""

    t_ns: tuple[int, int]  # stamps of the images
    first: Array  # (m, 2) ideal coordinates
    second: Array  # (m, 2)

    @cached_property
    def rays(self) -> Array:
        """Build the rays (m, 3) to the features of the first image, with z = 1."""
        return np.column_stack([self.first, np.ones(len(self.first))])

    @cached_property
    def shift(self) -> Array:
        """Compute the median motion (2,) of the features."""
        return np.asarray(np.median(self.second - self.first, axis=0))


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Residuals of two sensors' measurements of one motion."""

    kind: str  # "level", "turn", "gravity", "push", "depth", "flow", "view", "range", "hull"
    sensors: frozenset[Sensor]
    residual: Array  # (n,)
    sigma: Array  # (n,)
    nuisance: Array  # (n, k) change of the residual by one sigma of each error that is no fault
    first: Array  # (n,) the motion by the sensor that is compared
    second: Array  # (n,) the same motion by the others
    # True of a coarse comparison: agreement speaks for its sensors, but it accuses one of a wrong
    # sign only
    vouches: bool = False
    opposite: Array | None = None  # (n,) the residual if the first sensor had the other sign

    @property
    def accuses(self) -> bool:
        """Tell whether the residuals show that a sensor is wrong."""
        return self.is_reversed or (self.is_contradiction and not self.vouches)

    @property
    def is_contradiction(self) -> bool:
        """Tell whether the residuals are larger than those of faultless sensors.

        Their chi-square is too large, or the nuisances would have to be, or a sign is reversed.
        """
        remaining, nuisances = self._fit
        rows, chi2 = len(self.residual), _clipped_chi2(remaining)
        beyond = chi2 - rows > GAIN and chi2 > MISFIT * rows
        return beyond or bool((nuisances**2).sum() > GAIN) or self.is_reversed

    @property
    def is_reversed(self) -> bool:
        """Tell whether the motions agree far better with the opposite sign.

        The size of the noise is taken as unknown: the ratio of the two sums of squares decides.
        """
        if self.opposite is None:
            return False
        as_is, other = self._squares(self.residual), self._squares(self.opposite)
        rows = len(self.residual) - self.nuisance.shape[1]
        return bool(rows * np.log((as_is + 1e-9) / (other + 1e-9)) > GAIN)

    def _squares(self, residual: Array) -> float:
        """Sum the squares of residuals, in sigmas, after a fit of the nuisances."""
        z, design = residual / self.sigma, self.nuisance / self.sigma[:, None]
        prior = np.eye(design.shape[1])
        remaining = z - design @ np.linalg.solve(design.T @ design + prior, design.T @ z)
        return float(remaining @ remaining)

    @property
    def misfit(self) -> float:
        """Compute the rms of the residuals as a share of that of the motion.

        The fitted nuisances (mount, scale) are taken off first, unless they would have to be larger
        than those of faultless sensors.
        """
        motion = np.maximum(np.abs(self.first), np.abs(self.second))
        remaining, nuisances = self._fit
        error = self.residual if (nuisances**2).sum() > GAIN else remaining * self.sigma
        error = np.minimum(np.abs(error), motion)
        return _rms(error) / max(_rms(motion), 1e-12)

    @property
    def stands_still(self) -> bool:
        """Tell whether the first sensor measures almost none of the motion that the others measure.

        One that measures the motion in another unit, and so a small but correlated signal, does not
        stand still.
        """
        product = (self.first @ self.second) ** 2
        is_scaled = product > SHARED * (self.first @ self.first) * (self.second @ self.second)
        return is_still(self.first, self.second) and not is_scaled

    @property
    def chi2(self) -> float:
        """Sum the squares of clipped residuals and of the fitted nuisances, in sigmas."""
        remaining, nuisances = self._fit
        return _clipped_chi2(remaining) + float((nuisances**2).sum())

    @cached_property
    def _fit(self) -> tuple[Array, Array]:
        """Fit the nuisances by reweighted least squares, with their priors.

        Returns
        -------
        tuple
            Remaining residuals (n,) and nuisances (k,), both in sigmas.
        """
        z, design = self.residual / self.sigma, self.nuisance / self.sigma[:, None]
        remaining: Array = z
        nuisances: Array = np.zeros(design.shape[1])
        weight: Array = np.ones(len(z))
        for _ in range(3):  # Huber's weights, so that clipped residuals do not pull
            normal = design.T @ (weight[:, None] * design) + np.eye(design.shape[1])
            nuisances = np.asarray(np.linalg.solve(normal, design.T @ (weight * z)), float)
            remaining = np.asarray(z - design @ nuisances)
            weight = np.asarray(np.minimum(1.0, CLIP / np.maximum(np.abs(remaining), 1e-9)), float)
        return np.asarray(remaining), np.asarray(nuisances)


def _clipped_chi2(residual: Array) -> float:
    """Sum the squares of residuals (n,), in sigmas, each clipped at CLIP."""
    return float(np.square(np.minimum(np.abs(residual), CLIP)).sum())


# Sensors whose readings each kind of comparison depends on, the quickest to compute first.
DEPENDS_ON = {
    "level": {Sensor.PRESSURE},
    "gravity": {Sensor.ACCELERATION, Sensor.ATTITUDE},
    "turn": {Sensor.RATES, Sensor.ATTITUDE},
    "depth": {Sensor.PRESSURE, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY},
    "range": {Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY},
    "hull": {Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY},
    "push": {Sensor.ACCELERATION, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY},
    "flow": {Sensor.CAMERA, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY},
    "view": {Sensor.CAMERA, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY},
}
OF_TRACK = {kind for kind, sensors in DEPENDS_ON.items() if Sensor.DVL in sensors}


class Motions:
    """What the records of a dive tell of its motion, each part computed when it is first asked for.

    A hypothesis changes the readings of one sensor only. Parts that depend on none of the changed
    readings are taken from the motions `before`, so that they are not computed for each hypothesis.

    Parameters
    ----------
    records, rig
        The dive.
    flows
        Features of neighbouring images.
    before
        Motions by the records that a hypothesis changed into these. None without a hypothesis.
    """

    def __init__(
        self,
        records: SensorRecords,
        rig: Rig,
        flows: Sequence[Flow] = (),
        before: Motions | None = None,
    ) -> None:
        self.records, self.rig, self.flows, self._before = records, rig, flows, before

    @cached_property
    def turn(self) -> Comparison | None:
        """Compare the IMU's rates and orientation. None without enough readings.

        It depends on times between readings only: a hypothesis that moves all stamps of the IMU by
        the same offset leaves it unchanged.
        """
        imu, before = self.records.imu, self._before
        if imu is None or len(imu.t_ns) < 2:
            return None
        if before is not None and before.records.imu is not None and self._has_same(_turn_readings):
            before_ns = before.records.imu.t_ns
            if np.array_equal(imu.t_ns - imu.t_ns[0], before_ns - before_ns[0]):
                return before.turn
        return compare_rates(imu)

    @cached_property
    def track(self) -> Track | None:
        """Integrate the DVL's velocity in the axes of `global`. None where `track_of` gives none.

        Where the attitude at the pings is unchanged, only the velocity is integrated anew.
        """
        dvl, before = self.records.dvl, None if self._before is None else self._before.track
        if dvl is None or before is None or not self._has_same(_attitude_readings):
            return track_of(self.records, self.rig)
        if self._has_same(_velocity_readings):
            return before
        if not np.array_equal(_rows_with_velocity(self.records), before.rows):
            return track_of(self.records, self.rig)
        return before.with_velocity(dvl.velocity[before.rows])

    @cached_property
    def felt(self) -> Integral | None:
        """Integrate the accelerations, less gravity, at seconds since the start of the track.

        None without a track, without accelerations, or where gravity was taken off.
        """
        track, imu = self.track, self.records.imu
        if track is None or imu is None:
            return None
        if self._before is not None and self._has_same(_acceleration_readings):
            before = self._before.track
            if before is not None and before.t_ns[0] == track.t_ns[0]:
                return self._before.felt
        return velocity_felt(imu, int(track.t_ns[0]))

    @cached_property
    def depth(self) -> SmoothedDepth | None:
        """Smooth the pressure sensor's depth at the pings of the track.

        None without a track, or where too few windows have both.
        """
        track, pressure = self.track, self.records.pressure
        if track is None or pressure is None:
            return None
        if self._before is not None and self._has_same(_depth_readings):
            before = self._before.track
            if before is not None and np.array_equal(before.t_ns, track.t_ns):
                return self._before.depth
        return smooth_depth(pressure, track.t_ns)

    @cached_property
    def hull(self) -> HullPlanes | None:
        """Fit planes of hull to the DVL's ranges. None without a DVL."""
        dvl = self.records.dvl
        if self._before is not None and self._has_same(_range_readings):
            return self._before.hull
        return None if dvl is None else hull_planes(dvl)

    @cached_property
    def views(self) -> Views | None:
        """Predict what pairs of images show.

        None without a track, without planes of hull, or with too few pairs.
        """
        dvl, hull, track = self.records.dvl, self.hull, self.track
        if dvl is None or hull is None or track is None:
            return None
        return views_of(dvl.t_ns, hull, self.rig, self.flows, track)

    def _has_same(self, readings: Callable[[SensorRecords], Sequence[object]]) -> bool:
        """Tell whether the records hold the same arrays as those before.

        Identity is tested, not equality, as that takes no time. readings: lists the arrays that
        count, as `_turn_readings` does.
        """
        if self._before is None:
            return False
        now, before = readings(self.records), readings(self._before.records)
        return len(now) == len(before) and all(a is b for a, b in zip(now, before, strict=True))


def _turn_readings(records: SensorRecords) -> Sequence[object]:
    """List the readings, beside stamps, that the comparison of rates and attitude depends on."""
    return () if records.imu is None else (records.imu.quaternion, records.imu.angular_velocity)


def _acceleration_readings(records: SensorRecords) -> Sequence[object]:
    """List the readings that the integral of the accelerations in `global` depends on."""
    imu = records.imu
    return () if imu is None else (imu.t_ns, imu.quaternion, imu.acceleration)


def _velocity_readings(records: SensorRecords) -> Sequence[object]:
    return () if records.dvl is None else (records.dvl.velocity,)


def _range_readings(records: SensorRecords) -> Sequence[object]:
    return () if records.dvl is None else (records.dvl.ranges,)


def _depth_readings(records: SensorRecords) -> Sequence[object]:
    return () if records.pressure is None else (records.pressure.t_ns, records.pressure.depth)


def _attitude_readings(records: SensorRecords) -> Sequence[object]:
    """List the readings that the attitude of the DVL at its pings depends on."""
    dvl, imu = records.dvl, records.imu
    if dvl is None or imu is None:
        return ()
    return dvl.t_ns, imu.t_ns, imu.quaternion, records.tray


def compare(motions: Motions, kinds: Set[str] = DEPENDS_ON.keys()) -> list[Comparison]:
    """Make the comparisons of some kinds for which the dive has enough readings and motion."""
    found: list[Comparison | None] = []
    imu, dvl, pressure = motions.records.imu, motions.records.dvl, motions.records.pressure
    if pressure is not None and "level" in kinds:
        found.append(compare_level(pressure))
    if "turn" in kinds:
        found.append(motions.turn)
    if imu is not None and "gravity" in kinds:
        found.append(compare_gravity(imu))
    track = motions.track if kinds & OF_TRACK else None
    if track is None or dvl is None:
        return [one for one in found if one is not None]
    if "depth" in kinds and motions.depth is not None:
        found.append(compare_depth(motions.depth, track))
    if "push" in kinds and motions.felt is not None:
        found.append(compare_acceleration(motions.felt, track))
    if "flow" in kinds and motions.views is not None:
        found.append(compare_flow(motions.views))
    if "view" in kinds and motions.views is not None:
        found.append(compare_view(motions.views))
    if kinds & {"range", "hull"} and motions.hull is not None:
        found += compare_ranges(dvl.t_ns, motions.hull, track)
    return [one for one in found if one is not None]


def compare_rates(imu: ImuSamples) -> Comparison | None:
    """Compare the turns of an IMU's orientation with the integrals of its rates.

    None where too few windows have both.
    """
    known = np.isfinite(imu.angular_velocity).all(axis=1)
    t_ns, rates = imu.t_ns[known], imu.angular_velocity[known]
    windows = _cut_windows(t_ns, TURNED_S)
    if len(windows) < LEAST_WINDOWS:
        return None
    t_s = seconds(t_ns, int(t_ns[0]))
    by_rates = _over(integral(t_s, rates).total, windows)
    attitude = Rotation.from_quat(imu.quaternion[known])
    turn = (attitude[windows[:, 0]].inv() * attitude[windows[:, 1]]).as_rotvec()
    # White noise of the orientation, from the steps between readings that the rates do not explain,
    # or from the scatter of the turns themselves if that is less.
    step = (attitude[:-1].inv() * attitude[1:]).as_rotvec() - 0.5 * (
        rates[1:] + rates[:-1]
    ) * np.diff(t_s)[:, None]
    white = min(robust_sigma(step.ravel()), robust_sigma(np.diff(turn, axis=0).ravel()))
    lag = np.abs(rates[windows[:, 1]] - rates[windows[:, 0]]) * LATE_S
    sigma = np.sqrt(white**2 + RELIEF_RAD**2 / 100 + (RATE_SHARE * turn) ** 2 + lag**2)
    lasts = (t_s[windows[:, 1]] - t_s[windows[:, 0]])[:, None, None]
    return Comparison(
        kind="turn",
        sensors=frozenset({Sensor.RATES, Sensor.ATTITUDE}),
        residual=(turn - by_rates).ravel(),
        sigma=sigma.ravel(),
        nuisance=(RATE_BIAS_RAD_S * lasts * np.eye(3)).reshape(-1, 3),
        first=by_rates.ravel(),
        second=turn.ravel(),
    )


def compare_gravity(imu: ImuSamples) -> Comparison | None:
    """Compare the median acceleration with that at rest, which is -g along z of `global`.

    None without accelerations, or where gravity was taken off.
    """
    _, felt = felt_in_global(imu)
    if not len(felt):
        return None
    median, at_rest = np.median(felt, axis=0), np.array([0.0, 0.0, -GRAVITY_M_S2])
    return Comparison(
        kind="gravity",
        sensors=frozenset({Sensor.ACCELERATION, Sensor.ATTITUDE}),
        residual=median - at_rest,
        sigma=np.full(3, GRAVITY_SIGMA),
        nuisance=np.zeros((3, 0)),
        first=median,
        second=at_rest,
    )


def compare_acceleration(felt: Integral, track: Track) -> Comparison | None:
    """Compare the change of the DVL's velocity with the integral of the IMU's accelerations.

    Nuisances are the bias of the accelerometer and a time offset. None where too few windows have
    both, or where there is hardly anything but gravity.

    felt: integral of the accelerations in `global`, less gravity, at seconds since the start of the
    track.
    """
    t_s = track.way.t_s
    windows = _cut_windows(track.t_ns, CHANGED_S, (t_s >= felt.t_s[0]) & (t_s <= felt.t_s[-1]))
    if len(windows) < LEAST_WINDOWS:
        return None
    integrated = felt.at(t_s)
    swept = local_line(t_s, track.lever, t_s, SMOOTH_S)[1]
    by_dvl, by_imu = (
        _over(local_line(t_s, speed, t_s, SMOOTH_S)[0], windows)
        for speed in (track.way.signal - swept, integrated)
    )
    if is_still(by_imu, by_dvl):
        return None  # gravity alone, as of a filter that gives the vertical of its attitude
    slope = local_line(t_s, integrated, t_s, SMOOTH_S)[1]
    late = LATE_S * _over(slope, windows)
    turn = track.global_from_vehicle[windows[:, 0]].inv()
    spun = IMU_LEVER_M * (turn * track.global_from_vehicle[windows[:, 1]]).magnitude()
    lasts = np.asarray(_over(t_s, windows))[:, None, None]
    biased = FELT_BIAS_M_S2 * lasts * track.global_from_vehicle[windows[:, 0]].as_matrix()
    sigma = np.hypot(CHANGED_SIGMA_M_S, spun)[:, None] * np.ones(3)
    return Comparison(
        kind="push",
        sensors=frozenset({Sensor.ACCELERATION, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY}),
        residual=(by_dvl - by_imu).ravel(),
        sigma=np.hypot(sigma, CHANGED_SHARE * by_imu).ravel(),
        nuisance=np.concatenate([biased.reshape(-1, 3), late.reshape(-1, 1)], axis=1),
        first=by_dvl.ravel(),
        second=by_imu.ravel(),
    )


@dataclass(frozen=True, kw_only=True)
class Track:
    """The path and attitude of the DVL at the pings with a velocity."""

    rows: Ints  # (n,) rows of these pings among all pings
    t_ns: Ints  # (n,)
    global_from_dvl: Rotation  # (n,)
    global_from_vehicle: Rotation  # (n,)
    way: Integral  # (n, 3) m, path: the integral of the velocity in `global`
    lever: Array  # (n, 3) m, from pressure sensor to DVL in `global`

    @cached_property
    def sunk_by_tilt(self) -> Array:
        """Compute how much deeper (n, 3), m, the path would be if the DVL were tilted by TILT_RAD.

        The columns are for a tilt about each of its axes.
        """
        # A tilt about the axis a adds (R (a x v))_z = a . (v x r) to the velocity downwards. Here v
        # is the velocity in the DVL's axes, R is global_from_dvl, and r its last row.
        rotation = self.global_from_dvl.as_matrix()
        own = np.einsum("nij,ni->nj", rotation, self.way.signal)
        turned = integral(self.way.t_s, cross(own, rotation[:, 2])).total
        return np.asarray(TILT_RAD * turned)

    def with_velocity(self, velocity: Array) -> Track:
        """Replace the path by the integral of another velocity (n, 3), in the DVL's axes.

        The pings and their attitude stay, as under a hypothesis of the velocity alone.
        """
        way = integral(self.way.t_s, self.global_from_dvl.apply(velocity))
        return replace(self, way=way)


def track_of(records: SensorRecords, rig: Rig) -> Track | None:
    """Integrate the DVL's velocity in the axes of `global`.

    None without DVL or IMU, or where hardly any velocity was measured while the IMU was read.
    """
    dvl, imu = records.dvl, records.imu
    if dvl is None or imu is None or len(imu.t_ns) < 2:
        return None
    rows = _rows_with_velocity(records)
    if len(rows) < LEAST_WINDOWS:
        return None
    t_ns = dvl.t_ns[rows]
    held = Poses(imu.quaternion, np.zeros((len(imu.t_ns), 3)))
    global_from_vehicle = interpolate(imu.t_ns, held, t_ns).rotation
    tray = tray_poses(rig.tray_origin, servo(records.tray, int(t_ns[0])).angle_at(t_ns))
    global_from_dvl = global_from_vehicle * tray.rotation * rig.tray_from_dvl.rotation
    velocity = global_from_dvl.apply(dvl.velocity[rows])
    at = tray.apply(np.tile(rig.tray_from_dvl.translation, (len(t_ns), 1)))
    return Track(
        rows=rows,
        t_ns=t_ns,
        global_from_dvl=global_from_dvl,
        global_from_vehicle=global_from_vehicle,
        way=integral(seconds(t_ns, int(t_ns[0])), velocity),
        lever=np.asarray(global_from_vehicle.apply(at - rig.pressure_origin)),
    )


def _rows_with_velocity(records: SensorRecords) -> Ints:
    """List the rows of the pings that have a velocity and lie within the IMU's record."""
    dvl, imu = records.dvl, records.imu
    if dvl is None or imu is None:
        return np.zeros(0, np.int64)
    inside = (dvl.t_ns >= imu.t_ns[0]) & (dvl.t_ns <= imu.t_ns[-1])
    return np.flatnonzero(inside & np.isfinite(dvl.velocity).all(axis=1))


@dataclass(frozen=True, kw_only=True)
class SmoothedDepth:
    """The depth by the pressure sensor at the pings of a track, smoothed."""

    windows: Ints  # (m, 2) first and last row of each window in which changes are compared
    depth: Array  # (n,) m
    sigma: float  # m, noise of a smoothed depth


def smooth_depth(pressure: PressureSamples, ping_ns: Ints) -> SmoothedDepth | None:
    """Smooth the pressure sensor's depth at the pings of a track.

    None where too few windows have both. ping_ns (n,): stamps of the track.
    """
    read = np.isfinite(pressure.depth)
    read_ns, depth = pressure.t_ns[read], pressure.depth[read]
    if len(read_ns) < LEAST_WINDOWS:
        return None
    windows = _cut_windows(ping_ns, SUNK_S, (ping_ns >= read_ns[0]) & (ping_ns <= read_ns[-1]))
    if len(windows) < LEAST_WINDOWS:
        return None
    start = int(ping_ns[0])
    read_s, t_s = seconds(read_ns, start), seconds(ping_ns, start)
    # White noise of a reading, from second differences. Smoothing reduces it to `sigma`.
    white = robust_sigma(np.diff(depth, n=2), about=0.0) / np.sqrt(6)
    return SmoothedDepth(
        windows=windows,
        depth=local_line(read_s, depth, t_s, SMOOTH_S)[0][:, 0],
        sigma=float(white * np.sqrt(period(read_s) / (2 * np.sqrt(np.pi) * SMOOTH_S))),
    )


def compare_depth(smoothed: SmoothedDepth, track: Track) -> Comparison:
    """Compare the change of the pressure sensor's depth with that of the DVL's path.

    Nuisances are a tilt of the DVL, a scale and a time offset.
    """
    windows = smoothed.windows
    sunk, way = _over(smoothed.depth, windows), _over(track.way.total, windows)
    late = LATE_S * _over(track.way.signal[:, 2], windows)
    return Comparison(
        kind="depth",
        sensors=frozenset({Sensor.PRESSURE, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY}),
        residual=sunk - way[:, 2] + _over(track.lever[:, 2], windows),
        sigma=np.sqrt(2 * smoothed.sigma**2 + DEPTH_SIGMA_M**2 + (ROUGH_SHARE * late) ** 2),
        nuisance=np.column_stack([_over(track.sunk_by_tilt, windows), SCALE * way[:, 2], late]),
        first=sunk,
        second=way[:, 2],
    )


def compare_ranges(ping_ns: Ints, hull: HullPlanes, track: Track) -> list[Comparison]:
    """Compare the hull that the DVL's ranges show with its velocity, and with the attitude.

    As the hull does not move, its distance changes by the velocity along its normal ("range"), and
    its normal keeps its direction in `global` ("hull"). Of the latter the part along the tray's
    axis is compared, which the tray's angle does not change. Both are coarse, as a hull is curved.

    Parameters
    ----------
    ping_ns
        Stamps of all pings.
    hull
        Planes of the pings that show one.
    track
        Path and attitude of the DVL.
    """
    common, rows, plane_rows = np.intersect1d(track.t_ns, ping_ns[hull.ping], return_indices=True)
    if len(common) < LEAST_WINDOWS:
        return []
    t_s = seconds(common, int(common[0]))
    planes = np.column_stack([hull.normal, hull.distance])[plane_rows]
    smooth, _ = local_line(t_s, planes, t_s, SMOOTH_S)
    normal = smooth[:, :3] / np.linalg.norm(smooth[:, :3], axis=1, keepdims=True)
    distance = smooth[:, 3]
    windows = _cut_windows(common, NEARED_S)
    if len(windows) < LEAST_WINDOWS:
        return []
    first, last = windows.T
    own = track.global_from_dvl[rows]
    seen, axis = own.apply(normal), track.global_from_vehicle[rows].apply([0.0, 1.0, 0.0])
    # The distance falls by the way along the normal, so that the sum of both changes is zero.
    way = _over(track.way.total[rows], windows)
    middle = 0.5 * (seen[first] + seen[last])
    nearer = _over(distance, windows) + (middle * way).sum(axis=1)
    # the same with the velocity along the DVL's axis reversed
    toward = track.global_from_dvl.inv().apply(track.way.signal) * [1.0, 1.0, -1.0]
    mirrored = integral(track.way.t_s, track.global_from_dvl.apply(toward)).total[rows]
    # In `global` the normal does not change. Along the tray's axis it holds no error of the tray.
    turned = ((seen[last] - seen[first]) * axis[first]).sum(axis=1)
    along = (way * axis[first]).sum(axis=1)
    return [
        Comparison(
            kind="range",
            sensors=frozenset({Sensor.DVL}),
            residual=nearer,
            sigma=np.full(len(nearer), RELIEF_M),
            nuisance=TILT_RAD * way,
            first=(middle * way).sum(axis=1),
            second=-_over(distance, windows),
            vouches=True,
            opposite=nearer + (middle * (_over(mirrored, windows) - way)).sum(axis=1),
        ),
        Comparison(
            kind="hull",
            sensors=frozenset({Sensor.ATTITUDE, Sensor.DVL}),
            residual=turned,
            sigma=np.full(len(turned), RELIEF_RAD),
            nuisance=ALONG_1_M * along[:, None],
            first=turned,
            second=_over(normal, windows)[:, 1],
            vouches=True,
            opposite=turned - 2 * _over(normal, windows)[:, 1],
        ),
    ]


@dataclass(frozen=True, kw_only=True)
class Views:
    """Pairs of images, with what DVL, attitude and tray predict for them."""

    flows: Sequence[Flow]  # n, the features of each pair
    path: Poses  # global_from_dvl (m) at the pings of the track
    path_ns: Ints  # (m,) stamps of the path
    dvl_from_top: Poses  # mount of the upper camera
    tray_axis: Array  # (3,) in the camera
    away: Array  # (n, 3) normals of the planes of hull, in the axes of the first camera
    depth: Array  # (n,) m, distance of the planes from the first camera

    @cached_property
    def second_from_first(self) -> Poses:
        """Compute the motions (n) of the upper camera by DVL, attitude and tray."""
        return self._motions_at(0)

    @cached_property
    def late(self) -> Array:
        """Compute the change of the turns, (n, 3) rad, if images were exposed LATE_S later."""
        later = self._motions_at(round(LATE_S * NS))
        return np.asarray((later.rotation * self.second_from_first.rotation.inv()).as_rotvec())

    def _motions_at(self, late_ns: int) -> Poses:
        """Compute second_from_first (n), with images exposed late_ns after their stamps."""
        at = np.array([flow.t_ns for flow in self.flows], np.int64) + late_ns
        top = interpolate(self.path_ns, self.path, at.T.ravel()) @ self.dvl_from_top
        return top[len(at) :].inverse() @ top[: len(at)]


def views_of(
    ping_ns: Ints, hull: HullPlanes, rig: Rig, flows: Sequence[Flow], track: Track
) -> Views | None:
    """Predict from DVL, attitude and tray what pairs of images show.

    That is how the upper camera moved between the two, and the plane of hull in front of it, from
    the nearest ping. None without a camera or with too few pairs.

    Parameters
    ----------
    ping_ns, hull
        Stamps of all pings, and planes of those that show one.
    rig
        Mounts of the sensors.
    flows
        Features of the pairs of images.
    track
        Path and attitude of the DVL.
    """
    flows = [f for f in flows if track.t_ns[0] <= f.t_ns[0] and f.t_ns[1] <= track.t_ns[-1]]
    if rig.tray_from_top is None or len(flows) < LEAST_WINDOWS:
        return None
    # the ping with a plane of hull that is nearest to each first image
    common, _, plane_rows = np.intersect1d(track.t_ns, ping_ns[hull.ping], return_indices=True)
    if len(common) < LEAST_WINDOWS:
        return None
    first_ns = np.array([flow.t_ns[0] for flow in flows], np.int64)
    near = plane_rows[np.abs(common[:, None] - first_ns).argmin(axis=0)]
    dvl_from_top = rig.tray_from_dvl.inverse() @ rig.tray_from_top
    return Views(
        flows=flows,
        path=Poses(track.global_from_dvl.as_quat(), track.way.total),
        path_ns=track.t_ns,
        dvl_from_top=dvl_from_top,
        tray_axis=rig.tray_from_top.rotation.inv().apply([0.0, 1.0, 0.0])[0],
        away=dvl_from_top.rotation.inv().apply(hull.normal[near]),
        depth=hull.distance[near] - hull.normal[near] @ dvl_from_top.translation[0],
    )


def compare_flow(views: Views) -> Comparison | None:
    """Compare the median motion of features with that predicted from DVL, attitude and tray.

    The features' rays are met with the plane of hull, and the points projected into the second
    image. None where too few pairs show the hull in front of the camera.
    """
    seen, predicted = [], []
    turned, moved = (
        views.second_from_first.rotation.as_matrix(),
        views.second_from_first.translation,
    )
    for k, flow in enumerate(views.flows):
        slope = flow.rays @ views.away[k]
        if views.depth[k] <= 0 or (slope <= 0).any():
            continue
        points = (flow.rays * (views.depth[k] / slope)[:, None]) @ turned[k].T + moved[k]
        if (points[:, 2] <= 0).any():
            continue
        predicted.append(np.median(points[:, :2] / points[:, 2:] - flow.first, axis=0))
        seen.append(flow.shift)
    if len(seen) < LEAST_WINDOWS:
        return None
    by_images, by_dvl = np.array(seen), np.array(predicted)
    size = np.linalg.norm(by_dvl, axis=1, keepdims=True) * np.ones(2)
    return Comparison(
        kind="flow",
        sensors=SEEN,
        residual=(by_images - by_dvl).ravel(),
        sigma=np.hypot(FLOW_SHARE * size, FLOW_RAD).ravel(),
        nuisance=FLOW_SCALE * by_dvl.reshape(-1, 1),
        first=by_images.ravel(),
        second=by_dvl.ravel(),
    )


def compare_view(views: Views) -> Comparison | None:
    """Compare the camera's turn that features show with the turn by attitude and tray.

    The motion compared includes that of the scene by the camera's displacement: with a wrong
    distortion, a displacement across the view looks in part like a turn. About the tray's axis the
    sigma is large, because of its backlash. None where too few pairs show the hull.
    """
    rows = np.flatnonzero(views.depth > 0)
    if len(rows) < LEAST_WINDOWS:
        return None
    moved, flows = views.second_from_first[rows], [views.flows[k] for k in rows.tolist()]
    turn, sigma = fit_turns(moved, [flow.first for flow in flows], [flow.second for flow in flows])
    backlash, lag = TILT_RAD * views.tray_axis, views.late[rows]
    shift = cross(np.array([0.0, 0.0, 1.0]), moved.translation) / views.depth[rows, None]
    predicted = moved.rotation.as_rotvec() + shift
    return Comparison(
        kind="view",
        sensors=SEEN - {Sensor.DVL},  # only the direction of its motion has an influence
        residual=turn.ravel(),
        sigma=np.sqrt(sigma**2 + VIEW_RAD**2 + backlash**2 + lag**2).ravel(),
        nuisance=np.zeros((turn.size, 0)),
        first=(predicted + turn).ravel(),
        second=predicted.ravel(),
    )


@dataclass(frozen=True, kw_only=True)
class HullPlanes:
    """Planes through the returns of each ping that has enough."""

    ping: Ints  # (n,) rows of the pings
    normal: Array  # (n, 3) in the DVL's frame, away from it
    distance: Array  # (n,) m


def hull_planes(dvl: DvlPings) -> HullPlanes:
    """Fit a plane to the returns of each ping that has enough, with its distance from the DVL."""
    t_ns, normal = hull_normals(dvl)
    if not len(t_ns):
        return HullPlanes(ping=t_ns, normal=normal, distance=np.zeros(0))
    ping = np.searchsorted(dvl.t_ns, t_ns)
    ends = dvl.ranges[ping][:, :, None] * dvl.beams
    distance = np.nanmedian((ends * normal[:, None]).sum(axis=2), axis=1)
    return HullPlanes(ping=ping, normal=normal, distance=distance)


def compare_level(pressure: PressureSamples) -> Comparison:
    """Compare quantiles of the depth with the water's surface: no vehicle dives above it."""
    read = pressure.depth[np.isfinite(pressure.depth)]
    depth = np.quantile(read, LEVELS) if len(read) else np.zeros(len(LEVELS))
    above = np.minimum(depth + HIGHEST_M, 0.0)
    return Comparison(
        kind="level",
        sensors=frozenset({Sensor.PRESSURE}),
        residual=above,
        sigma=np.full(len(LEVELS), SURFACE_SIGMA_M),
        nuisance=np.zeros((len(LEVELS), 0)),
        first=above,
        second=np.zeros(len(LEVELS)),
    )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else 0.0


def _cut_windows(t_ns: Ints, lasts_s: float, inside: Array | None = None) -> Ints:
    """Cut a record into consecutive windows, at most about MOST_WINDOWS, thinned evenly.

    Parameters
    ----------
    t_ns
        Stamps (n,).
    lasts_s
        Length of a window.
    inside
        Rows (n,) at which a window may begin or end.

    Returns
    -------
    Ints
        First and last row (m, 2) of windows without a gap longer than LONGEST_GAP_S.
    """
    if len(t_ns) < 2:
        return np.zeros((0, 2), np.int64)
    usable = np.ones(len(t_ns), bool) if inside is None else inside
    begin = np.arange(t_ns[0], t_ns[-1] - round(lasts_s * NS), round(lasts_s * NS))
    rows = np.searchsorted(t_ns, np.stack([begin, begin + round(lasts_s * NS)], axis=1))
    gaps = np.cumsum(np.concatenate([[0], np.diff(t_ns) > LONGEST_GAP_S * NS]))
    whole = (gaps[rows[:, 0]] == gaps[rows[:, 1]]) & (rows[:, 1] > rows[:, 0])
    rows = rows[whole & usable[rows].all(axis=1)]
    return np.asarray(rows[:: 1 + len(rows) // MOST_WINDOWS])


def _over(values: Array, windows: Ints) -> Array:
    """Compute how much a signal (n, ...) changes over windows (m, 2)."""
    return np.asarray(values[windows[:, 1]] - values[windows[:, 0]])
