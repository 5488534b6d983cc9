# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compare two sensors by a motion that both measured (docs/methods.md, Suspects).

- pressure and DVL: the change of depth against the integral of the DVL's vertical velocity,
- rates and attitude: the integral of an IMU's rates against the turn of its orientation,
- attitude and acceleration: gravity points down,
- acceleration and DVL: the integral of what the IMU feels, less gravity, against the change of the
  DVL's velocity,
- images and DVL: the features' motion against that of a hull at the DVL's range, seen by a camera
  that moves by the DVL's velocity and turns by the attitude,
- DVL's velocity and ranges: the hull stands still where the DVL comes nearer to it or turns.

Each comparison is a table of residuals with their sigmas, and of what they would be for one sigma
of each error that a faultless sensor has (a mount's tilt, a scale): `Comparison.chi2` fits these.
Stamps are taken as they are: clocks are compared in navigation/clocks.
"""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.streams import GRAVITY_M_S2
from hullrecon.geometry.poses import Poses, interpolate, stacked, tray_poses
from hullrecon.geometry.robust import robust_sigma
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

# one sigma of the features' motion: of the whole, of all in common (range, curvature), and in rad
FLOW_SHARE, FLOW_SCALE, FLOW_RAD = 0.05, 0.03, 0.003
VIEW_RAD = np.radians(0.2)  # of a turn between two images by the attitude, and by a good lens
# of the windows in which motions are compared
SUNK_S, TURNED_S, NEARED_S, PUSHED_S = 3.0, 1.0, 2.0, 1.0
LEAST_WINDOWS, MOST_WINDOWS = 4, 2000
LONGEST_GAP_S = 1.5  # between two readings of a window
SMOOTH_S = 0.4  # of pressure and ranges
# One sigma of errors that faultless sensors have:
TILT_RAD = np.radians(2.0)  # between DVL and IMU: mounts as measured by hand, backlash of a tray
SCALE = 0.015  # of a DVL and of the water's density together
LATE_S = 0.15  # between two sensors' clocks, which navigation/clocks judges
RATE_BIAS_RAD_S, RATE_SHARE = 0.01, 0.05  # of a MEMS gyroscope: bias, scale and axes
ALONG_1_M = 0.05  # curvature of a hull along its length
RELIEF_M, RELIEF_RAD = 0.03, 0.03  # plates, weld seams and curvature within a window
LEVELS = np.linspace(0.25, 0.75, 5)  # quantiles of the depth that are held against the surface
HIGHEST_M, SURFACE_SIGMA_M = 1.0, 0.3  # a sensor at the surface, the day's air pressure
GRAVITY_SIGMA = 1.0  # m/s2, of a median over the dive
# m/s2 of a MEMS accelerometer's bias and of roll and pitch (half a degree), m/s of thrusters'
# vibration in a window, m between the IMU and the vehicle's origin
FELT_BIAS_M_S2, PUSHED_SIGMA_M_S, IMU_LEVER_M = 0.1, 0.02, 0.2
PUSHED_SHARE = 0.05  # of an accelerometer's scale and axes
DEPTH_SIGMA_M = 0.005  # of a change of depth: what two smoothed readings leave at least
ROUGH_SHARE = 0.4  # of LATE_S, by which the smoothing of two sensors differs from time to time
CLIP = 4.0  # sigmas, beyond which a residual costs no more
SHARED = 0.8  # of a signal's squares, that one which follows another has in common with it
GAIN = 25.0  # of chi-square beyond its mean: five sigmas, as in navigation/clocks
MISFIT = 2.0  # of chi-square by row: 1.2 at most on 17 faultless dives, 3.3 to 11 with faults


class Sensor(StrEnum):
    """What may be wrong: a sensor, or one of the signals of an IMU."""

    PRESSURE = "pressure"
    DVL = "DVL"
    RATES = "IMU's rates"
    ATTITUDE = "IMU's orientation"
    ACCELERATION = "IMU's acceleration"
    TRAY = "tray's angle"
    CAMERA = "camera"


SEEN = frozenset({Sensor.CAMERA, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY})


@dataclass(frozen=True, kw_only=True)
class Flow:
    """Features of a rigid scene in two images of the upper camera."""

    t_ns: tuple[int, int]
    first: Array  # (m, 2) ideal coordinates
    second: Array  # (m, 2)


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Residuals of two sensors' measurements of one motion."""

    kind: str  # "level", "turn", "gravity", "push", "depth", "flow", "view", "range", "hull"
    sensors: frozenset[Sensor]
    residual: Array  # (n,)
    sigma: Array  # (n,)
    nuisance: Array  # (n, k) change of the residual for one sigma of each error that is no fault
    first: Array  # (n,) the motion by the sensor that is compared
    second: Array  # (n,) the same by the others
    vouches: bool = False  # speaks for its sensors; too coarse to accuse one, but of a sign
    opposite: Array | None = None  # (n,) the residual if the first sensor had the other sign

    @property
    def accuses(self) -> bool:
        """Tell whether the residuals show that a sensor is wrong."""
        return self.is_reversed or (self.is_contradiction and not self.vouches)

    @property
    def is_contradiction(self) -> bool:
        """Tell whether the residuals are beyond what faultless sensors leave."""
        left, common = self._fit
        rows, chi2 = len(self.residual), _clipped(left)
        beyond = chi2 - rows > GAIN and chi2 > MISFIT * rows
        return beyond or bool((common**2).sum() > GAIN) or self.is_reversed

    @property
    def is_reversed(self) -> bool:
        """Tell whether the motions agree with the opposite sign, whatever the size of the noise."""
        if self.opposite is None:
            return False
        as_is, other = self._left(self.residual), self._left(self.opposite)
        rows = len(self.residual) - self.nuisance.shape[1]
        return bool(rows * np.log((as_is + 1e-9) / (other + 1e-9)) > GAIN)

    def _left(self, residual: Array) -> float:
        """Sum the squares that the nuisances leave of residuals, in sigmas."""
        z, design = residual / self.sigma, self.nuisance / self.sigma[:, None]
        prior = np.eye(design.shape[1])
        left = z - design @ np.linalg.solve(design.T @ design + prior, design.T @ z)
        return float(left @ left)

    @property
    def misfit(self) -> float:
        """Compute the rms of the residuals as a share of that of the motion.

        Errors that a faultless sensor may have (mount, scale) are taken off first, unless they
        would have to be larger than such errors are.
        """
        motion = np.maximum(np.abs(self.first), np.abs(self.second))
        left, common = self._fit
        left = self.residual if (common**2).sum() > GAIN else left * self.sigma
        left = np.minimum(np.abs(left), motion)
        return _rms(left) / max(_rms(motion), 1e-12)

    @property
    def stands_still(self) -> bool:
        """Tell whether the first sensor measures almost none of the motion that the others measure.

        A small share of the motion, as in another unit, is not nothing.
        """
        alike = (self.first @ self.second) ** 2
        is_share = alike > SHARED * (self.first @ self.first) * (self.second @ self.second)
        return is_still(self.first, self.second) and not is_share

    @property
    def chi2(self) -> float:
        """Sum the squares of clipped residuals and of the fitted nuisances, in sigmas."""
        left, common = self._fit
        return _clipped(left) + float((common**2).sum())

    @cached_property
    def _fit(self) -> tuple[Array, Array]:
        """Fit the nuisances (k,). Returns the residuals left (n,) and them, in sigmas."""
        z, design = self.residual / self.sigma, self.nuisance / self.sigma[:, None]
        left: Array = z
        common: Array = np.zeros(design.shape[1])
        weight: Array = np.ones(len(z))
        for _ in range(3):  # reweighted, so that clipped residuals do not pull
            normal = design.T @ (weight[:, None] * design) + np.eye(design.shape[1])
            common = np.asarray(np.linalg.solve(normal, design.T @ (weight * z)), float)
            left = np.asarray(z - design @ common)
            weight = np.asarray(np.minimum(1.0, CLIP / np.maximum(np.abs(left), 1e-9)), float)
        return np.asarray(left), np.asarray(common)


def _clipped(left: Array) -> float:
    return float(np.square(np.minimum(np.abs(left), CLIP)).sum())


# Sensors on whose readings each comparison rests, by its kind, the quickest first.
RESTS_ON = {
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
OF_TRACK = {kind for kind, sensors in RESTS_ON.items() if Sensor.DVL in sensors}


def compare(
    records: SensorRecords,
    rig: Rig,
    flows: Sequence[Flow] = (),
    kinds: Set[str] = RESTS_ON.keys(),
    track: Track | None = None,
    hull: HullPlanes | None = None,
) -> list[Comparison]:
    """Make the comparisons of some kinds for which the dive has readings and motion enough.

    track, hull: of the DVL, where they are known already.
    """
    found: list[Comparison | None] = []
    imu, dvl, pressure = records.imu, records.dvl, records.pressure
    if pressure is not None and "level" in kinds:
        found.append(compare_level(pressure))
    if imu is not None and len(imu.t_ns) > 1 and "turn" in kinds:
        found.append(compare_rates(imu))
    if imu is not None and "gravity" in kinds:
        found.append(compare_gravity(imu))
    if kinds & OF_TRACK and track is None:
        track = track_of(records, rig)
    if track is None or dvl is None:
        return [one for one in found if one is not None]
    if "depth" in kinds:
        found.append(compare_depth(records, track))
    if imu is not None and "push" in kinds:
        found.append(compare_push(imu, track))
    if kinds & {"flow", "view", "range", "hull"}:
        planes = hull_planes(dvl) if hull is None else hull
        views = views_of(dvl.t_ns, planes, rig, flows, track) if kinds & {"flow", "view"} else []
        found.append(compare_flow(views) if "flow" in kinds else None)
        found.append(compare_view(views) if "view" in kinds else None)
        if kinds & {"range", "hull"}:
            found += compare_ranges(dvl.t_ns, planes, track)
    return [one for one in found if one is not None]


def compare_rates(imu: ImuSamples) -> Comparison | None:
    """Compare the turns of an IMU's orientation with the integrals of its rates."""
    known = np.isfinite(imu.angular_velocity).all(axis=1)
    t_ns, rates = imu.t_ns[known], imu.angular_velocity[known]
    windows = _windows(t_ns, TURNED_S)
    if len(windows) < LEAST_WINDOWS:
        return None
    t_s = seconds(t_ns, int(t_ns[0]))
    by_rates = _over(integral(t_s, rates).total, windows)
    attitude = Rotation.from_quat(imu.quaternion[known])
    turn = (attitude[windows[:, 0]].inv() * attitude[windows[:, 1]]).as_rotvec()
    # White noise of the orientation: what the rates do not explain from reading to reading, or the
    # scatter of the turns themselves if that is less.
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
    """Compare the mean acceleration with gravity: at rest, -g along z of `global`.

    None without accelerations, or of a sensor that has gravity taken off.
    """
    _, felt = felt_in_global(imu)
    if not len(felt):
        return None
    mean, down = np.median(felt, axis=0), np.array([0.0, 0.0, -GRAVITY_M_S2])
    return Comparison(
        kind="gravity",
        sensors=frozenset({Sensor.ACCELERATION, Sensor.ATTITUDE}),
        residual=mean - down,
        sigma=np.full(3, GRAVITY_SIGMA),
        nuisance=np.zeros((3, 0)),
        first=mean,
        second=down,
    )


def compare_push(imu: ImuSamples, track: Track) -> Comparison | None:
    """Compare the change of the DVL's velocity with the integral of the IMU's accelerations.

    None without accelerations, or of a sensor that has gravity taken off or gives nothing else.
    """
    t_s, felt = track.way.t_s, velocity_felt(imu, int(track.t_ns[0]))
    if felt is None:
        return None
    windows = _windows(track.t_ns, PUSHED_S, (t_s >= felt.t_s[0]) & (t_s <= felt.t_s[-1]))
    if len(windows) < LEAST_WINDOWS:
        return None
    pushed = felt.at(t_s)
    swept = local_line(t_s, track.lever, t_s, SMOOTH_S)[1]
    by_dvl, by_imu = (
        _over(local_line(t_s, speed, t_s, SMOOTH_S)[0], windows)
        for speed in (track.way.signal - swept, pushed)
    )
    if is_still(by_imu, by_dvl):
        return None  # gravity alone: filtered, as the vertical of an attitude
    slope = local_line(t_s, pushed, t_s, SMOOTH_S)[1]
    late = LATE_S * _over(slope, windows)
    turn = track.global_from_vehicle[windows[:, 0]].inv()
    spun = IMU_LEVER_M * (turn * track.global_from_vehicle[windows[:, 1]]).magnitude()
    lasts = np.asarray(_over(t_s, windows))[:, None, None]
    biased = FELT_BIAS_M_S2 * lasts * track.global_from_vehicle[windows[:, 0]].as_matrix()
    sigma = np.hypot(PUSHED_SIGMA_M_S, spun)[:, None] * np.ones(3)
    return Comparison(
        kind="push",
        sensors=frozenset({Sensor.ACCELERATION, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY}),
        residual=(by_dvl - by_imu).ravel(),
        sigma=np.hypot(sigma, PUSHED_SHARE * by_imu).ravel(),
        nuisance=np.concatenate([biased.reshape(-1, 3), late.reshape(-1, 1)], axis=1),
        first=by_dvl.ravel(),
        second=by_imu.ravel(),
    )


@dataclass(frozen=True, kw_only=True)
class Track:
    """The path and attitude of the DVL at the pings with a velocity."""

    t_ns: Ints  # (n,)
    global_from_dvl: Rotation  # (n,)
    global_from_vehicle: Rotation  # (n,)
    way: Integral  # (n, 3) of the velocity in `global`, m
    lever: Array  # (n, 3) from pressure sensor to DVL in `global`

    @cached_property
    def sunk_by_tilt(self) -> Array:
        """Compute how much deeper the path would be of a DVL mounted with a tilt, (n, 3) m.

        The tilt is TILT_RAD, about each of its axes in turn.
        """
        own = self.global_from_dvl.inv().apply(self.way.signal)
        turned = [
            integral(self.way.t_s, self.global_from_dvl.apply(np.cross(axis, own))[:, 2]).total
            for axis in np.eye(3)
        ]
        return np.asarray(TILT_RAD * np.stack(turned, axis=1))


def track_of(records: SensorRecords, rig: Rig) -> Track | None:
    """Integrate the DVL's velocity in the axes of `global`. None without DVL or IMU."""
    dvl, imu = records.dvl, records.imu
    if dvl is None or imu is None or len(imu.t_ns) < 2:
        return None
    heard = np.isfinite(dvl.velocity).all(axis=1)
    heard &= (dvl.t_ns >= imu.t_ns[0]) & (dvl.t_ns <= imu.t_ns[-1])
    if heard.sum() < LEAST_WINDOWS:
        return None
    t_ns = dvl.t_ns[heard]
    held = Poses(imu.quaternion, np.zeros((len(imu.t_ns), 3)))
    global_from_vehicle = interpolate(imu.t_ns, held, t_ns).rotation
    tray = tray_poses(rig.tray_origin, servo(records.tray, int(t_ns[0])).angle_at(t_ns))
    global_from_dvl = global_from_vehicle * tray.rotation * rig.tray_from_dvl.rotation
    velocity = global_from_dvl.apply(dvl.velocity[heard])
    at = tray.apply(np.tile(rig.tray_from_dvl.translation, (len(t_ns), 1)))
    return Track(
        t_ns=t_ns,
        global_from_dvl=global_from_dvl,
        global_from_vehicle=global_from_vehicle,
        way=integral(seconds(t_ns, int(t_ns[0])), velocity),
        lever=np.asarray(global_from_vehicle.apply(at - rig.pressure_origin)),
    )


def compare_depth(records: SensorRecords, track: Track) -> Comparison | None:
    """Compare the change of the pressure sensor's depth with that of the DVL's path."""
    pressure = records.pressure
    if pressure is None:
        return None
    read = np.isfinite(pressure.depth)
    read_ns, depth = pressure.t_ns[read], pressure.depth[read]
    if len(read_ns) < LEAST_WINDOWS:
        return None
    inside = (track.t_ns >= read_ns[0]) & (track.t_ns <= read_ns[-1])
    windows = _windows(track.t_ns, SUNK_S, inside)
    if len(windows) < LEAST_WINDOWS:
        return None
    start = int(track.t_ns[0])
    read_s, t_s = seconds(read_ns, start), track.way.t_s
    # noise of a reading by second differences, and what smoothing leaves of it
    white = robust_sigma(np.diff(depth, n=2), about=0.0) / np.sqrt(6)
    left = white * np.sqrt(period(read_s) / (2 * np.sqrt(np.pi) * SMOOTH_S))
    smooth = local_line(read_s, depth, t_s, SMOOTH_S)[0][:, 0]
    way = _over(track.way.total, windows)
    sunk = _over(smooth, windows) - way[:, 2] + _over(track.lever[:, 2], windows)
    rate = track.way.signal[:, 2]
    late = LATE_S * _over(rate, windows)
    return Comparison(
        kind="depth",
        sensors=frozenset({Sensor.PRESSURE, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY}),
        residual=sunk,
        sigma=np.sqrt(2 * left**2 + DEPTH_SIGMA_M**2 + (ROUGH_SHARE * late) ** 2),
        nuisance=np.column_stack([_over(track.sunk_by_tilt, windows), SCALE * way[:, 2], late]),
        first=_over(smooth, windows),
        second=way[:, 2],
    )


def compare_ranges(ping_ns: Ints, hull: HullPlanes, track: Track) -> list[Comparison]:
    """Compare the hull that the DVL's ranges show with its velocity, and with the attitude.

    The hull stands still: it comes nearer by the velocity along its normal, and its normal turns
    across the tray's axis by the attitude alone. ping_ns: of all pings.
    """
    common, rows, of = np.intersect1d(track.t_ns, ping_ns[hull.ping], return_indices=True)
    if len(common) < LEAST_WINDOWS:
        return []
    t_s = seconds(common, int(common[0]))
    planes = np.column_stack([hull.normal, hull.distance])[of]
    smooth, _ = local_line(t_s, planes, t_s, SMOOTH_S)
    normal = smooth[:, :3] / np.linalg.norm(smooth[:, :3], axis=1, keepdims=True)
    distance = smooth[:, 3]
    windows = _windows(common, NEARED_S)
    if len(windows) < LEAST_WINDOWS:
        return []
    first, last = windows.T
    own = track.global_from_dvl[rows]
    seen, axis = own.apply(normal), track.global_from_vehicle[rows].apply([0.0, 1.0, 0.0])
    # By the velocity the distance falls by the way along the normal. Nothing should be left.
    way = _over(track.way.total[rows], windows)
    middle = 0.5 * (seen[first] + seen[last])
    nearer = _over(distance, windows) + (middle * way).sum(axis=1)
    # the same with the velocity along the DVL's axis reversed
    toward = track.global_from_dvl.inv().apply(track.way.signal) * [1.0, 1.0, -1.0]
    mirrored = integral(track.way.t_s, track.global_from_dvl.apply(toward)).total[rows]
    # In global axes the normal should not change. Across the tray's axis the tray itself turns it.
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
class View:
    """A pair of images, with the motion and the plane of hull that other sensors give it."""

    flow: Flow
    second_from_first: Poses  # of the upper camera, by DVL, attitude and tray
    late: Array  # (3,) rad by which that turns otherwise where stamps are late by LATE_S
    tray_axis: Array  # (3,) in the camera
    away: Array  # (3,) normal of the hull in the first camera
    depth: float  # m, of that plane


def views_of(
    ping_ns: Ints, hull: HullPlanes, rig: Rig, flows: Sequence[Flow], track: Track
) -> list[View]:
    """Look up how the upper camera moved between two images, and the plane of hull in front of it.

    ping_ns: of all pings.
    """
    if rig.tray_from_top is None or len(flows) < LEAST_WINDOWS:
        return []
    # the ping with a plane of hull that is nearest to each first image
    common, _, of = np.intersect1d(track.t_ns, ping_ns[hull.ping], return_indices=True)
    if len(common) < LEAST_WINDOWS:
        return []
    dvl_from_top = rig.tray_from_dvl.inverse() @ rig.tray_from_top
    flows = [f for f in flows if track.t_ns[0] <= f.t_ns[0] and f.t_ns[1] <= track.t_ns[-1]]
    at = np.array([flow.t_ns for flow in flows], np.int64).reshape(-1, 2)
    near = of[np.abs(common[:, None] - at[:, 0]).argmin(axis=0)]
    # the camera's motion, and how it would turn if images were a little later than stamped
    path = Poses(track.global_from_dvl.as_quat(), track.way.total)
    moved, later = (
        _step(interpolate(track.t_ns, path, (at + late_ns).T.ravel()), dvl_from_top)
        for late_ns in (0, round(LATE_S * NS))
    )
    late = (later.rotation * moved.rotation.inv()).as_rotvec()
    # the plane in the camera's axes
    away = dvl_from_top.rotation.inv().apply(hull.normal[near])
    depth = hull.distance[near] - hull.normal[near] @ dvl_from_top.translation[0]
    tray_axis = rig.tray_from_top.rotation.inv().apply([0.0, 1.0, 0.0])[0]
    return [
        View(
            flow=flow,
            second_from_first=moved[k],
            late=late[k],
            tray_axis=tray_axis,
            away=away[k],
            depth=float(depth[k]),
        )
        for k, flow in enumerate(flows)
    ]


def _step(path: Poses, mount: Poses) -> Poses:
    """Compute second_from_first of what is mounted on the first and second half of some poses."""
    top = path @ mount
    half = len(path) // 2
    return top[half:].inverse() @ top[:half]


def compare_flow(views: Sequence[View]) -> Comparison | None:
    """Compare the motion of features with what DVL, attitude and tray make of it."""
    seen, made = [], []
    for view in views:
        first, second = view.flow.first, view.flow.second
        rays = np.column_stack([first, np.ones(len(first))])
        slope = rays @ view.away
        if view.depth <= 0 or (slope <= 0).any():
            continue
        points = view.second_from_first.apply(rays * (view.depth / slope)[:, None])
        if (points[:, 2] <= 0).any():
            continue
        made.append(np.median(points[:, :2] / points[:, 2:] - first, axis=0))
        seen.append(np.median(second - first, axis=0))
    if len(seen) < LEAST_WINDOWS:
        return None
    by_images, by_dvl = np.array(seen), np.array(made)
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


def compare_view(views: Sequence[View]) -> Comparison | None:
    """Compare the camera's turn that features show with the turn by attitude and tray.

    The direction of motion counts too: with a wrong distortion, motion across the view looks in
    part like a turn. About the tray's own axis, where its backlash is, the turns tell little.
    """
    views = [view for view in views if view.depth > 0]
    if len(views) < LEAST_WINDOWS:
        return None
    turn, sigma = fit_turns(
        stacked([v.second_from_first for v in views]),
        [v.flow.first for v in views],
        [v.flow.second for v in views],
    )
    backlash = TILT_RAD * np.array([view.tray_axis for view in views])
    lag = np.array([view.late for view in views])
    made = np.array(
        [
            v.second_from_first.rotation.as_rotvec()[0]
            + np.cross([0.0, 0.0, 1.0], v.second_from_first.translation[0]) / v.depth
            for v in views
        ]
    )
    return Comparison(
        kind="view",
        sensors=SEEN - {Sensor.DVL},  # of which the way's direction alone counts
        residual=turn.ravel(),
        sigma=np.sqrt(sigma**2 + VIEW_RAD**2 + backlash**2 + lag**2).ravel(),
        nuisance=np.zeros((turn.size, 0)),
        first=(made + turn).ravel(),
        second=made.ravel(),
    )


@dataclass(frozen=True, kw_only=True)
class HullPlanes:
    """Planes through the returns of each ping that has enough."""

    ping: Ints  # (n,) rows of the pings
    normal: Array  # (n, 3) in the DVL's frame, away from it
    distance: Array  # (n,) m


def hull_planes(dvl: DvlPings) -> HullPlanes:
    """Fit a plane to the returns of each ping."""
    t_ns, normal = hull_normals(dvl)
    if not len(t_ns):
        return HullPlanes(ping=t_ns, normal=normal, distance=np.zeros(0))
    ping = np.searchsorted(dvl.t_ns, t_ns)
    ends = dvl.ranges[ping][:, :, None] * dvl.beams
    distance = np.nanmedian((ends * normal[:, None]).sum(axis=2), axis=1)
    return HullPlanes(ping=ping, normal=normal, distance=distance)


def compare_level(pressure: PressureSamples) -> Comparison:
    """Compare the depth with zero: no vehicle dives above the water surface."""
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


def _windows(t_ns: Ints, lasts_s: float, inside: Array | None = None) -> Ints:
    """Cut time into windows (m, 2) of rows, without long gaps, at most MOST_WINDOWS of them."""
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
