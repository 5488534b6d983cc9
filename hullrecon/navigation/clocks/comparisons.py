# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compare the clocks of two sensors by the motion that both measured (docs/methods.md, Clocks).

- images and attitude: the turn of the upper camera from one image to the next,
- images and DVL: the direction in which the camera went,
- pressure and DVL: the depth against the integral of the DVL's vertical velocity,
- attitude and DVL: the plane through a ping's returns, turned into the global frame, stands still,
- acceleration and DVL: the change of the DVL's velocity against the integral of the IMU's
  acceleration.

Turns about the tray's axis are left out: the play of its servo looks like a time offset.

Offsets here say by how much a sensor's stamps are late: they are to be subtracted from the stamps,
and are negative where these are early.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import lru_cache

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.streams.imu import GRAVITY_M_S2, LEAST_FELT_M_S2
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses, tray_poses
from hullrecon.navigation.dead_reckoning.integral import Integral, integral
from hullrecon.navigation.sensors.attitude import AttitudeHistory
from hullrecon.navigation.sensors.servo import Servo
from hullrecon.navigation.sensors.smoothing import local_line, running_median
from hullrecon.navigation.sensors.velocity import Velocities
from hullrecon.records.clock import NS, seconds
from hullrecon.records.sensors import DvlPings, ImuSamples, PressureSamples
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Mask

# Sigmas of the systematic error of each comparison's offset, s. The largest offsets found on 56
# simulated dives with right clocks are 0.017 s of images and attitude, 0.14 of images and DVL, 0.16
# of pressure and DVL, 0.21 of attitude and DVL, and on seven dives 0.06 of accelerations and DVL.
TURN_S, DIRECTION_S, DEPTH_S, HULL_S, ACCELERATION_S = 0.01, 0.05, 0.05, 0.04, 0.04
LEAST_MOTIONS = 10
LEAST_DEPTH_BLOCKS = 4  # so few tell a sigma badly, but most of the sigma is DEPTH_S
TURN_SIGMA_RAD = 0.0015  # of the attitude's turn between two images
STEP_SIGMA_M = 0.003  # of the DVL's step between two images
DIRECTION_SIGMA_RAD = 0.02  # of the step's direction in the camera
MOUNT_SIGMA_RAD = 0.02  # of the DVL's mount relative to the camera, estimated with the offset
TRUSTED = 3.0  # sigmas; larger residuals are clipped when the mount is estimated
TRAY_AXIS = np.array([0.0, 1.0, 0.0])  # of tray and vehicle
TURNED_S = 1.0  # between three normals of the hull, whose second difference is the residual
SUNK_S = 2.0  # between three depths; second differences cancel the steady rate of a wrong mount
CHANGED_S = 0.8  # between three velocities; second differences cancel gravity and a bias
CHANGED_BLOCK_S = 3.0  # within which their errors are common, those of roll and pitch
STILL = 0.1  # of the motion that others measure; a signal that moves by less tells nothing
LATE = 0.3  # by which the next ping may come after the wanted time, as a share of the spacing
# time within which errors are common, and how many such blocks and rows a comparison has to have;
# more rows than the last are thinned out
BLOCK_S, LEAST_BLOCKS, LEAST_ROWS, MOST_ROWS = 10.0, 6, 60, 5_000
NEIGHBOURS, JUMP_M = 9, 0.15  # pings of a running median, and how far a range may be from it
LEAST_BEAMS = 3  # of a ping, to fit a plane
SMOOTH_S = 0.3  # sigma of the weights by which the pressure is smoothed


class ClockedSensor(StrEnum):
    """Sensors with a clock of their own. Both cameras share one clock."""

    DVL = "DVL"
    IMU = "IMU"
    PRESSURE = "pressure"
    IMAGES = "images"


Offsets = Mapping[ClockedSensor, float]  # by which stamps are late, s; 0 for sensors not in it
Span = tuple[int, int]  # first and last instant, ns


@dataclass(frozen=True, kw_only=True)
class ClockComparison:
    """Residuals of two sensors' measurements of one motion, as a function of time offsets."""

    first: ClockedSensor
    second: ClockedSensor
    systematic_s: float  # sigma of the relative offset's error that no number of rows reduces
    begin_ns: Ints  # (n,) first instant of the motion of each row
    end_ns: Ints  # (n,) its last instant
    block: Ints  # (n,) number of the block; errors are common within a block only
    # residuals (n, k) of rows (n,) at some offsets, NaN where unknown
    evaluate: Callable[[Offsets, Ints], Array]
    rows: Ints  # (n,) the rows that are used, as `evaluate` numbers them
    least_rows: int  # that are needed for an estimate
    least_blocks: int = 1

    def residuals(self, offsets: Offsets) -> Array:
        """Compute the residuals (n, k) of all rows at some offsets."""
        return self.evaluate(offsets, self.rows)

    def within(self, span: Span) -> ClockComparison:
        """Keep the rows between two instants."""
        kept = np.flatnonzero((self.begin_ns >= span[0]) & (self.end_ns <= span[1]))
        cut = {name: getattr(self, name)[kept] for name in ("begin_ns", "end_ns", "block", "rows")}
        return replace(self, **cut)

    @property
    def is_enough(self) -> bool:
        """Tell whether the rows suffice to estimate an offset with its sigma."""
        enough = len(self.rows) >= self.least_rows
        return enough and len(np.unique(self.block)) >= self.least_blocks


@dataclass(frozen=True, kw_only=True)
class ImageMotions:
    """Motions of the upper camera between neighbouring images."""

    first_ns: Ints  # (m,)
    second_ns: Ints  # (m,)
    second_from_first: Poses  # (m,), translations of any length
    sigma_rad: Array  # (m, 2) of the turn, each axis, and of the direction

    def __len__(self) -> int:
        return len(self.first_ns)


def compare_turns(
    motions: ImageMotions, attitude: AttitudeHistory, servo: Servo, rig: Rig
) -> ClockComparison:
    """Compare attitude and images by the turns of the upper camera between images.

    The residual is the rotation that images and attitude disagree by, in sigmas, without its part
    about the tray's axis. It is NaN where a motion begins or ends beyond the attitude's readings.
    """
    tray_from_top = rig.tray_from(Camera.TOP).rotation
    axis = tray_from_top.inv().apply(TRAY_AXIS)
    sigma = np.hypot(motions.sigma_rad[:, :1], TURN_SIGMA_RAD)
    attitude_at, seen = _fast_rotation(attitude), motions.second_from_first.rotation.inv()

    def evaluate(offsets: Offsets, rows: Ints) -> Array:
        """Compute the disagreement (n, 3) of rows, in sigmas."""
        shift_ns = _shift_ns(offsets, ClockedSensor.IMU, ClockedSensor.IMAGES)
        t_ns = np.concatenate([motions.first_ns[rows], motions.second_ns[rows]]) + shift_ns
        tray = tray_poses(rig.tray_origin, servo.angle_at(t_ns)).rotation
        camera = attitude_at(t_ns) * tray * tray_from_top
        first, second = camera[: len(rows)], camera[len(rows) :]
        # second_from_first by the attitude, undone by that of the images: nil if both agree
        turn = (seen[rows] * second.inv() * first).as_rotvec()
        turn[_outside(motions, rows, shift_ns, attitude.t_ns)] = np.nan
        return np.asarray((turn - (turn * axis).sum(axis=1, keepdims=True) * axis) / sigma[rows])

    return _compare_with_images(motions, ClockedSensor.IMU, TURN_S, evaluate)


def compare_directions(
    motions: ImageMotions, velocities: Velocities, rig: Rig
) -> ClockComparison | None:
    """Compare DVL and images by the camera's directions of motion.

    Both sit on the tray, so that no attitude is needed. The motion of the lever arm between them
    follows from the rotation that the images measured. A small rotation between their mounts is
    estimated. None for fewer than two pings.

    The residual, (n, 3), is the small rotation from the direction in which the images saw the top
    camera go to the one by the DVL, in sigmas, both in axes halfway between those of the two
    images.

    velocities: of the DVL in its own frame.
    """
    if len(velocities.t_ns) < 2:
        return None
    start = int(velocities.t_ns[0])
    path = integral(seconds(velocities.t_ns, start), velocities.velocity)
    top_from_dvl = rig.tray_from(Camera.TOP).inverse() @ rig.tray_from_dvl
    # in axes halfway between those of the two images, in which the DVL measured its step
    halfway = Rotation.from_rotvec(0.5 * motions.second_from_first.rotation.as_rotvec())
    # the translation of second_from_first is where the first camera lies seen from the second: the
    # motion is its negative
    seen = -_directions(halfway.inv().apply(motions.second_from_first.translation))
    lever, turned = top_from_dvl.translation, top_from_dvl.rotation
    # by how much the DVL moves relative to the camera, as the rig turns
    swept = halfway.inv().apply(lever) - halfway.apply(lever)

    def step(shift_s: float, rows: Ints) -> Array:
        """Compute the camera's step (n, 3), m, between two images by the DVL, in halfway axes."""
        t_ns = np.concatenate([motions.first_ns[rows], motions.second_ns[rows]])
        at = path.at(seconds(t_ns, start) + shift_s)
        return np.asarray(turned.apply(at[len(rows) :] - at[: len(rows)]) - swept[rows])

    # sigmas are the same for all offsets: else the offsets with the shortest steps would fit best
    length = np.linalg.norm(step(0.0, np.arange(len(motions))), axis=1)
    of_step = STEP_SIGMA_M / np.maximum(length, STEP_SIGMA_M) + DIRECTION_SIGMA_RAD
    sigma = np.hypot(motions.sigma_rad[:, 1], of_step)[:, None]
    # derivative of `angle` by a small rotation between the mounts: its part about the direction
    # itself does not show
    by_mount = np.eye(3) - seen[:, :, None] * seen[:, None, :]

    def evaluate(offsets: Offsets, rows: Ints) -> Array:
        """Compute the angle between the direction seen and that of the DVL's step, in sigmas.

        A small rotation between both mounts is fitted at each offset, and taken off.
        """
        shift_ns = _shift_ns(offsets, ClockedSensor.DVL, ClockedSensor.IMAGES)
        angle = np.cross(seen[rows], _directions(step(shift_ns / NS, rows)))
        unknown = _outside(motions, rows, shift_ns, velocities.t_ns)
        angle[unknown] = 0.0
        # the rotation of the mounts by least squares, of angles clipped so that none counts much
        own, turned_by = sigma[rows], by_mount[rows]
        clipped = np.clip(angle, -TRUSTED * own, TRUSTED * own)
        information = (turned_by / own[:, :, None] ** 2).sum(axis=0)
        information = information + np.eye(3) / MOUNT_SIGMA_RAD**2
        mount = np.linalg.solve(information, (clipped / own**2).sum(axis=0))
        found = (angle - turned_by @ mount) / own
        found[unknown] = np.nan
        return np.asarray(found)

    return _compare_with_images(motions, ClockedSensor.DVL, DIRECTION_S, evaluate)


def compare_depth(
    dvl: DvlPings,
    attitude: AttitudeHistory,
    pressure: PressureSamples,
    servo: Servo,
    rig: Rig,
) -> ClockComparison | None:
    """Compare pressure sensor and DVL by the depth.

    The depth by pressure is held against the integral of the DVL's vertical velocity. The attitude
    that levels the velocity is looked up with the IMU's offset. None without three pings that lie
    SUNK_S apart, or with fewer than LEAST_ROWS pressure readings.

    Residuals are second differences over such three pings, so that a bias of the depth and a steady
    rate, as by a wrong mount, cancel.
    """
    known, read = np.isfinite(dvl.velocity).all(axis=1), np.isfinite(pressure.depth)
    t_ns, read_ns = dvl.t_ns[known], pressure.t_ns[read]
    triples = _rows_apart(t_ns, SUNK_S)
    if not len(triples) or len(read_ns) < LEAST_ROWS:
        return None
    t_s, read_s = seconds(t_ns, int(t_ns[0])), seconds(read_ns, int(t_ns[0]))
    velocity = _vehicle_from_dvl(servo, rig, t_ns).apply(dvl.velocity[known])
    smooth = local_line(read_s, pressure.depth[read], read_s, SMOOTH_S)[0][:, 0]
    dvl_origin = tray_poses(rig.tray_origin, servo.angle_at(t_ns)).apply(
        rig.tray_from_dvl.translation
    )
    lever = dvl_origin - rig.pressure_origin
    attitude_at = _fast_rotation(attitude)

    @lru_cache(maxsize=8)
    def sunk(shift_ns: int) -> Array:
        """Integrate how far the pressure sensor sank (n,), m, by DVL and an attitude shifted so."""
        at_ns = t_ns + shift_ns
        level = attitude_at(at_ns)
        found = integral(t_s, level.apply(velocity)[:, 2]).total - level.apply(lever)[:, 2]
        found[(at_ns < attitude.t_ns[0]) | (at_ns > attitude.t_ns[-1])] = np.nan
        return np.asarray(found)

    def evaluate(offsets: Offsets, rows: Ints) -> Array:
        """Compute the second difference (n, 1), m, of what the two depths differ by.

        NaN where pressure or attitude were not read at one of the three pings.
        """
        at_s = t_s + _shift_ns(offsets, ClockedSensor.PRESSURE, ClockedSensor.DVL) / NS
        depth = np.interp(at_s, read_s, smooth)
        depth[(at_s < read_s[0]) | (at_s > read_s[-1])] = np.nan
        # by what the two depths differ, (n, 3) m at the three pings of each row
        apart = (depth - sunk(_shift_ns(offsets, ClockedSensor.IMU, ClockedSensor.DVL)))[
            triples[rows]
        ]
        # in which a constant bias and a steady drift cancel
        return np.asarray((apart[:, 0] - 2 * apart[:, 1] + apart[:, 2])[:, None])

    found = _compare_with_dvl(t_ns, triples, ClockedSensor.PRESSURE, DEPTH_S, evaluate)
    return replace(found, least_blocks=LEAST_DEPTH_BLOCKS)


def compare_hull_turns(
    dvl: DvlPings, attitude: AttitudeHistory, servo: Servo, rig: Rig
) -> ClockComparison | None:
    """Compare attitude and DVL by the apparent turns of the hull, which does not move.

    The normal of the hull is that of a plane through a ping's returns. Turned into the global frame
    with an attitude of the right time, it stands still or turns evenly. None without three such
    pings that lie TURNED_S apart.
    """
    t_ns, normal = hull_normals(dvl)
    triples = _rows_apart(t_ns, TURNED_S)
    if not len(triples):
        return None
    used, of_used = np.unique(triples, return_inverse=True)
    used_ns, of_used = t_ns[used], of_used.reshape(-1, 3)
    in_vehicle = _vehicle_from_dvl(servo, rig, used_ns).apply(normal[used])
    attitude_at = _fast_rotation(attitude)

    def evaluate(offsets: Offsets, rows: Ints) -> Array:
        """Compute the second difference (n, 1) of the normals in `global` along the tray axis.

        A servo that is off turns the normals across this axis, so it does not count.
        """
        of = of_used[rows]
        at_ns = used_ns + _shift_ns(offsets, ClockedSensor.IMU, ClockedSensor.DVL)
        global_from_vehicle = attitude_at(at_ns)
        seen, axis = (global_from_vehicle.apply(vectors) for vectors in (in_vehicle, TRAY_AXIS))
        seen[(at_ns < attitude.t_ns[0]) | (at_ns > attitude.t_ns[-1])] = np.nan
        # the normal of a curved hull turns evenly as the vehicle passes, which cancels
        bend = seen[of[:, 0]] - 2 * seen[of[:, 1]] + seen[of[:, 2]]
        return np.asarray((bend * axis[of[:, 1]]).sum(axis=1, keepdims=True))

    return _compare_with_dvl(t_ns, triples, ClockedSensor.IMU, HULL_S, evaluate)


def compare_accelerations(
    dvl: DvlPings, imu: ImuSamples, attitude: AttitudeHistory, servo: Servo, rig: Rig
) -> ClockComparison | None:
    """Compare IMU and DVL by the change of velocity, with the integral of the acceleration.

    Residuals are second differences of the velocity over three pings, in which a wrong gravity and
    a constant bias of the IMU cancel. None without three pings that lie CHANGED_S apart, without
    accelerations that hold gravity, or where these hold hardly anything else.
    """
    known = np.isfinite(dvl.velocity).all(axis=1)
    t_ns = dvl.t_ns[known]
    triples = _rows_apart(t_ns, CHANGED_S)
    integrated = velocity_felt(imu, int(t_ns[0])) if len(triples) else None
    if integrated is None:
        return None
    t_s, felt_s = seconds(t_ns, int(t_ns[0])), integrated.t_s
    velocity = _vehicle_from_dvl(servo, rig, t_ns).apply(dvl.velocity[known])
    lever = tray_poses(rig.tray_origin, servo.angle_at(t_ns)).apply(rig.tray_from_dvl.translation)
    attitude_at = _fast_rotation(attitude)

    def evaluate(offsets: Offsets, rows: Ints) -> Array:
        """Compute the second difference (n, 3), m/s, of what the two velocities differ by.

        NaN where the IMU gave no acceleration at one of the three pings.
        """
        shift_ns = _shift_ns(offsets, ClockedSensor.IMU, ClockedSensor.DVL)
        at_ns, at_s = t_ns + shift_ns, t_s + shift_ns / NS
        level = attitude_at(at_ns)
        # velocity of the DVL relative to the vehicle's origin, as the vehicle turns
        swept = np.gradient(level.apply(lever), t_s, axis=0)
        apart = level.apply(velocity) - swept - integrated.at(at_s)
        apart[(at_s < felt_s[0]) | (at_s > felt_s[-1])] = np.nan
        return _second_difference(apart, triples[rows])

    moved = attitude_at(t_ns).apply(velocity)
    if is_still(*(_second_difference(each, triples) for each in (integrated.at(t_s), moved))):
        return None  # gravity alone, as of a filter that gives the vertical of its attitude
    found = _compare_with_dvl(t_ns, triples, ClockedSensor.IMU, ACCELERATION_S, evaluate)
    block = (found.begin_ns - t_ns[0]) // round(CHANGED_BLOCK_S * NS)
    return replace(found, block=np.asarray(block, np.int64))


def hull_normals(dvl: DvlPings) -> tuple[Ints, Array]:
    """Fit a plane to each ping's returns, without outliers from the running median of their beam.

    Empty with fewer than NEIGHBOURS pings or LEAST_BEAMS beams.

    Returns
    -------
    tuple
        Stamps (n,) of the pings with enough returns, and the planes' unit normals (n, 3) in the
        DVL's frame, away from the instrument.
    """
    ranges = dvl.ranges
    if len(ranges) < NEIGHBOURS or ranges.shape[1] < LEAST_BEAMS:
        return np.zeros(0, np.int64), np.zeros((0, 3))
    with np.errstate(invalid="ignore"):
        fair = np.abs(ranges - running_median(ranges, NEIGHBOURS)) < JUMP_M
    enough = fair.sum(axis=1) >= LEAST_BEAMS
    fair, ends = fair[enough], (ranges[:, :, None] * dvl.beams)[enough]
    weight = fair[:, :, None].astype(float)
    ends = np.where(fair[:, :, None], ends, 0.0)
    middle = ends.sum(axis=1) / weight.sum(axis=1)
    from_middle = weight * (ends - middle[:, None])
    # the direction in which the ends scatter least
    normal = np.linalg.eigh(np.einsum("nbi,nbj->nij", from_middle, from_middle))[1][:, :, 0]
    away = np.sign((normal * middle).sum(axis=1))
    return dvl.t_ns[enough], np.asarray(normal * away[:, None])


def _compare_with_images(
    motions: ImageMotions,
    first: ClockedSensor,
    systematic_s: float,
    evaluate: Callable[[Offsets, Ints], Array],
) -> ClockComparison:
    """Make a comparison of a sensor with images, a row for each motion between two images.

    Errors of different motions are taken to be independent, so each row is a block of its own.
    """
    rows = np.arange(len(motions))
    return ClockComparison(
        first=first,
        second=ClockedSensor.IMAGES,
        systematic_s=systematic_s,
        begin_ns=motions.first_ns,
        end_ns=motions.second_ns,
        block=rows,
        evaluate=evaluate,
        rows=rows,
        least_rows=LEAST_MOTIONS,
    )


def _compare_with_dvl(
    t_ns: Ints,
    triples: Ints,
    first: ClockedSensor,
    systematic_s: float,
    evaluate: Callable[[Offsets, Ints], Array],
) -> ClockComparison:
    """Make a comparison of a sensor with the DVL, a row for each triple of pings.

    Parameters
    ----------
    t_ns, triples
        Stamps of the pings, and rows (m, 3) of three each.
    first
        The sensor that is compared with the DVL.
    systematic_s
        Sigma of the offset's systematic error.
    evaluate
        Computes the residuals of rows at given offsets.
    """
    begin_ns = t_ns[triples[:, 0]]
    return ClockComparison(
        first=first,
        second=ClockedSensor.DVL,
        systematic_s=systematic_s,
        begin_ns=begin_ns,
        end_ns=t_ns[triples[:, 2]],
        block=np.asarray((begin_ns - t_ns[0]) // round(BLOCK_S * NS), np.int64),
        evaluate=evaluate,
        rows=np.arange(len(triples)),
        least_rows=LEAST_ROWS,
        least_blocks=LEAST_BLOCKS,
    )


def felt_in_global(imu: ImuSamples) -> tuple[Ints, Array]:
    """Turn accelerations, as an accelerometer feels them, into `global`: stamps (n,), m/s2 (n, 3).

    At rest it feels the force that holds it up, opposite to gravity. Empty without accelerations,
    or where gravity was taken off.
    """
    felt = Rotation.from_quat(imu.quaternion).apply(imu.acceleration)
    known = np.isfinite(felt).all(axis=1)
    t_ns, felt = imu.t_ns[known], felt[known]
    if not len(felt) or np.linalg.norm(np.median(felt, axis=0)) < LEAST_FELT_M_S2:
        return t_ns[:0], felt[:0]
    return t_ns, felt


def velocity_felt(imu: ImuSamples, start_ns: int) -> Integral | None:
    """Integrate an IMU's accelerations, less gravity, to its velocity in `global` up to a constant.

    Times are seconds since start_ns. None where `felt_in_global` has fewer than two.
    """
    t_ns, felt = felt_in_global(imu)
    if len(felt) < 2:
        return None
    return integral(seconds(t_ns, start_ns), felt + np.array([0.0, 0.0, GRAVITY_M_S2]))


def is_still(values: Array, others: Array) -> bool:
    """Tell whether a sensor measures almost none of the motion (n, k) that others measure."""
    own, whole = (float(np.sqrt(np.mean(np.square(each)))) for each in (values, others))
    return own < STILL * whole


def _second_difference(values: Array, triples: Ints) -> Array:
    first, middle, last = values[triples].transpose(1, 0, 2)
    return np.asarray(first - 2 * middle + last)


def _shift_ns(offsets: Offsets, sensor: ClockedSensor, other: ClockedSensor) -> int:
    """Compute what to add to stamps of `other` so that `sensor` can be looked up at them, ns."""
    return round((offsets.get(sensor, 0.0) - offsets.get(other, 0.0)) * NS)


def _fast_rotation(attitude: AttitudeHistory) -> Callable[[Ints], Rotation]:
    """Make a function that interpolates R_g_v (m) at times (m,) as attitude.rotation does, faster.

    The search calls it at a thousand offsets. So what depends on the readings alone is computed
    once.
    """
    # Slerp is a sum of both quaternions, weighted by sines of shares of the angle between them.
    t_ns, start = attitude.t_ns, attitude.quaternion[:-1]
    if len(t_ns) < 2:
        return attitude.rotation
    same_side = np.where((start * attitude.quaternion[1:]).sum(axis=1) < 0, -1.0, 1.0)
    stop = attitude.quaternion[1:] * same_side[:, None]
    angle = 2 * np.arcsin(np.minimum(0.5 * np.linalg.norm(stop - start, axis=1), 1.0)) / np.pi
    start, stop = (ends / np.sinc(angle)[:, None] for ends in (start, stop))
    duration = np.maximum(1, np.diff(t_ns))

    def rotation(at_ns: Ints) -> Rotation:
        at = np.clip(at_ns, t_ns[0], t_ns[-1])
        row = np.clip(np.searchsorted(t_ns, at, side="right") - 1, 0, len(duration) - 1)
        share, turn = (at - t_ns[row]) / duration[row], angle[row]
        back, ahead = (part * np.sinc(part * turn) for part in (1 - share, share))
        return Rotation.from_quat(back[:, None] * start[row] + ahead[:, None] * stop[row])

    return rotation


def _vehicle_from_dvl(servo: Servo, rig: Rig, t_ns: Ints) -> Rotation:
    return tray_poses(rig.tray_origin, servo.angle_at(t_ns)).rotation * rig.tray_from_dvl.rotation


def _rows_apart(t_ns: Ints, apart_s: float) -> Ints:
    """List the rows of three pings each that lie about apart_s from one to the next.

    Of a quantity at three such pings the second difference is formed, in which a constant bias and
    a steady drift cancel. The second and third ping are the first ones at or after the wanted time.
    A triple is dropped where one of them comes later than that by more than LATE * apart_s, as
    after an outage.

    Parameters
    ----------
    t_ns
        Times (n,) of the pings, in order.
    apart_s
        From the first to the second, and from the second to the third.

    Returns
    -------
    Ints
        Rows (m, 3) of `t_ns`, thinned evenly to about MOST_ROWS. (0, 3) where there are none.
    """
    rows = [np.arange(len(t_ns))]
    near = np.ones(len(t_ns), bool)
    for times in (1, 2):
        wanted = t_ns + round(times * apart_s * NS)
        row = np.searchsorted(t_ns, wanted)
        near &= row < len(t_ns)
        row = np.minimum(row, len(t_ns) - 1)
        near &= t_ns[row] - wanted <= LATE * apart_s * NS
        rows.append(row)
    found = np.stack(rows, axis=1)[near]
    return found[:: 1 + len(found) // MOST_ROWS]


def _outside(motions: ImageMotions, rows: Ints, shift_ns: int, t_ns: Ints) -> Mask:
    """Find the motions (of `rows`) that begin or end beyond a sensor's stamps when shifted."""
    first, second = motions.first_ns[rows] + shift_ns, motions.second_ns[rows] + shift_ns
    return np.asarray((first < t_ns[0]) | (second > t_ns[-1]))


def _directions(vectors: Array) -> Array:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9))
