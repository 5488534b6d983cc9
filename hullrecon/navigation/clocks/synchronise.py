# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Put right the clocks of DVL, IMU, pressure sensor and cameras that are late or early beside the others, or jumped."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hullrecon.geometry.poses import from_matrix
from hullrecon.navigation.clocks.clock_errors import (
    ClockError,
    Sensor,
    describe_errors,
    join_errors,
    on_time,
    put_images_right,
)
from hullrecon.navigation.clocks.images import ImageMotions, shift_of_dvl_from_images, shift_of_imu_from_images
from hullrecon.navigation.clocks.instruments import Disagreement, imu_beside_dvl, pressure_beside_dvl
from hullrecon.navigation.clocks.stretches import stretches
from hullrecon.navigation.clocks.time_shift import TimeShift, find_far_shift, find_time_shift, preference
from hullrecon.navigation.dead_reckoning.dead_reckon import NavigationLogs, sort_streams, usable_frames
from hullrecon.navigation.dead_reckoning.image_walk import STRIDE_S
from hullrecon.navigation.sensors.attitude import AttitudeHistory, attitude_history
from hullrecon.navigation.sensors.servo import Servo, servo
from hullrecon.navigation.sensors.velocity import Velocities, usable_velocities
from hullrecon.records.sensors import DvlPings
from hullrecon.rig import SensorRig
from hullrecon.typing import Array, Ints, Mask

# An error that is put right, s; smaller ones are not told from none: bumps of the hull and waves look like some. Of the DVL's
# clock where one sensor alone tells it, and where images and pressure sensor do, whose own errors have nothing in common.
LEAST_S: Mapping[Sensor, float] = {Sensor.DVL: 0.25, Sensor.IMU: 0.05, Sensor.PRESSURE: 0.25, Sensor.IMAGES: 0.05}
LEAST_BY_TWO_S = 0.08
LEAST_BY_HULL_S = 0.2  # of an IMU that the form of the hull alone is held against
SIGMAS = 5.0
KNOWN_S = 0.1  # sigma of a shift that says something though it is none
AGREE_S = 0.2  # shifts by two sensors that differ by less are one
PREFERRED = 2.0  # sigmas by which one of two explanations has to be the better one
RUNS, LEAST_RUNS, RUN_FRAMES = 6, 3, 6  # of images whose motion is looked at, spread over a stretch

Span = tuple[int, int]  # first and last instant, ns
# From two rows of the upper camera's images: second_from_first (4, 4), its translation of any length, and the sigmas (2,) rad
# of its turn and direction; None where they do not tell.
MeasureMotion = Callable[[int, int], tuple[Array, Array] | None]


@dataclass(frozen=True, kw_only=True)
class Synchronised:
    """Logs with their clocks put right, in time order; what was wrong with the clocks; sentences on what was put right, and on
    what could not be told."""

    logs: NavigationLogs
    errors: list[ClockError]
    remarks: list[str]


@dataclass(frozen=True, kw_only=True)
class _Late:
    """By how much a sensor's clock is later than another one, s, with its sigma; sure: that it is at all."""

    seconds: float
    sigma_s: float
    sure: bool

    def and_later(self, more: _Late) -> _Late:
        """Return how late a clock is that is later still than this one."""
        sigma_s = float(np.hypot(self.sigma_s, more.sigma_s))
        return _Late(seconds=self.seconds + more.seconds, sigma_s=sigma_s, sure=self.sure or more.sure)


def synchronise(
    logs: NavigationLogs, rig: SensorRig, tilt_rad: float, longest_gap_s: float, measure: MeasureMotion | None = None
) -> Synchronised:
    """Return the logs with their clocks put right.

    Each stretch between pauses that may be jumps is looked at by itself. With images (measure), IMU and DVL are held against
    what these show of the camera's motion, and the pressure sensor against the DVL; the clocks that most sensors share are
    right. Without images the DVL's ranges to the hull and the pressure sensor tell.
    """
    logs, messages = sort_streams(logs)
    look = _Look(logs, rig, tilt_rad, longest_gap_s, None if logs.top is None else measure)
    errors, undecided = look.by_images() if look.sees else look.by_hull()
    errors = join_errors(errors)
    remarks = [*messages, *describe_errors(errors), *undecided]
    return Synchronised(logs=_put_right(logs, errors), errors=errors, remarks=remarks)


class _Look:
    """What the sensors of a dive say of each other's clocks, stretch by stretch."""

    def __init__(
        self, logs: NavigationLogs, rig: SensorRig, tilt_rad: float, longest_gap_s: float, measure: MeasureMotion | None
    ) -> None:
        self._logs, self._rig, self._measure = logs, rig, measure
        self._servo: Servo = servo(logs.tray, int(logs.dvl.t_ns[0]))
        heard = int(logs.imu.t_ns[0]), int(logs.imu.t_ns[-1])
        self._velocities: Velocities = usable_velocities(logs.dvl, heard, longest_gap_s)
        self._attitude: AttitudeHistory = attitude_history(logs.imu, tilt_rad, longest_gap_s)
        self._frames = usable_frames(logs.top)
        self.sees = measure is not None and len(self._frames[0]) > 1

    def by_images(self) -> tuple[list[ClockError], list[str]]:
        """Return whose clocks are wrong beside those that most share, by what images show of the motion; by the hull where they
        show none."""
        motions = self._motions()

        def of_imu(span: Span) -> _Late | None:
            return _usable(shift_of_imu_from_images(_between(motions, span), self._attitude, self._servo, self._rig))

        def of_dvl(span: Span) -> _Late | None:
            return _usable(shift_of_dvl_from_images(_between(motions, span), self._velocities, self._rig))

        imu, dvl = (
            _ByStretch(self._stretches(Sensor.IMAGES, Sensor.IMU), of_imu),
            _ByStretch(self._stretches(Sensor.IMAGES, Sensor.DVL), of_dvl),
        )
        if not (imu.is_known or dvl.is_known):
            return self.by_hull()
        errors: list[ClockError] = []
        for span in self._stretches(*Sensor):
            late = {Sensor.IMAGES: _Late(seconds=0.0, sigma_s=0.0, sure=False)}
            for sensor, found in ((Sensor.IMU, imu.at(span)), (Sensor.DVL, dvl.at(span))):
                late |= {} if found is None else {sensor: found}
            if Sensor.DVL not in late:
                errors += _against_most(span, late)
                continue
            imu_late_s = late[Sensor.IMU].seconds - late[Sensor.DVL].seconds if Sensor.IMU in late else 0.0
            sunk = self._sunk(span, imu_late_s)
            if sunk is not None:
                late[Sensor.PRESSURE] = late[Sensor.DVL].and_later(sunk)
            errors += _by_depth_too(span, late, sunk) or _against_most(span, late)
        return errors, []

    def by_hull(self) -> tuple[list[ClockError], list[str]]:
        """Return whose clocks are wrong, by the DVL's ranges to the hull, which stands still, and by depth."""
        imu = _ByStretch(self._stretches(Sensor.DVL, Sensor.IMU), self._turned)
        errors: list[ClockError] = []
        undecided: list[str] = []
        for span in self._stretches(Sensor.DVL, Sensor.IMU, Sensor.PRESSURE):
            turned = imu.at(span)
            error = None
            if turned is not None and turned.sure and abs(turned.seconds) >= LEAST_BY_HULL_S:
                error = _by_turn_and_depth(span, turned, self._sunk(span, turned.seconds))
            sunk = self._sunk(span) if error is None else None
            if sunk is not None and sunk.sure and abs(sunk.seconds) >= LEAST_S[Sensor.PRESSURE]:
                error = self._by_depth_alone(span, sunk)
                if error is None:
                    undecided.append(
                        f"DVL and pressure: their clocks part by {abs(sunk.seconds):.2f} s (sigma {sunk.sigma_s:.3f} s); which"
                        " of them is wrong is not known, and both were left as they are"
                    )
            errors += [] if error is None else [error]
        return errors, list(dict.fromkeys(undecided))

    def _by_depth_alone(self, span: Span, sunk: _Late) -> ClockError | None:
        """Return which of DVL and pressure sensor, which part, is wrong: by where the hull stands more still. None where that
        does not tell."""
        turn = self._hull_turns(span)
        better = 0.0 if turn is None else preference(turn.residuals, turn.block, sunk.seconds, 0.0)
        if better >= PREFERRED:
            late = self._sunk(span, None) or sunk  # with the attitude of the pressure sensor's time
            return _error(Sensor.DVL, span, -late.seconds, late.sigma_s, [Sensor.IMU, Sensor.PRESSURE])
        if better <= -PREFERRED:
            return _error(Sensor.PRESSURE, span, sunk.seconds, sunk.sigma_s, [Sensor.DVL, Sensor.IMU])
        return None

    def _sunk(self, span: Span, imu_late_s: float | None = 0.0) -> _Late | None:
        """Return how late the pressure sensor is beside the DVL; imu_late_s: how late the IMU is; None: as late."""
        pressure = self._logs.pressure
        if pressure is None:
            return None
        found = pressure_beside_dvl(self._pings(span), self._attitude, pressure, self._servo, self._rig, imu_late_s)
        return None if found is None else _usable(find_far_shift(found.residuals, found.block))

    def _turned(self, span: Span) -> _Late | None:
        """Return how late the IMU is beside the DVL."""
        found = self._hull_turns(span)
        return None if found is None else _usable(find_time_shift(found.residuals, found.block))

    def _hull_turns(self, span: Span) -> Disagreement | None:
        return imu_beside_dvl(self._pings(span), self._attitude, self._servo, self._rig)

    def _stretches(self, *sensors: Sensor) -> list[Span]:
        """Return the stretches between the pauses of some sensors."""
        logs = self._logs
        streams = {
            Sensor.DVL: logs.dvl.t_ns,
            Sensor.IMU: logs.imu.t_ns,
            Sensor.PRESSURE: None if logs.pressure is None else logs.pressure.t_ns,
            Sensor.IMAGES: self._frames[0],
        }
        stamps = [streams[sensor] for sensor in sensors]
        return stretches([t_ns for t_ns in stamps if t_ns is not None and len(t_ns)])

    def _pings(self, span: Span) -> DvlPings:
        dvl = self._logs.dvl
        rows: Mask = (dvl.t_ns >= span[0]) & (dvl.t_ns <= span[1])
        return replace(
            dvl,
            t_ns=dvl.t_ns[rows],
            velocity=dvl.velocity[rows],
            velocity_sigma=dvl.velocity_sigma[rows],
            ranges=dvl.ranges[rows],
        )

    def _motions(self) -> ImageMotions:
        """Return the motions over some runs of images in each stretch, where DVL and IMU were heard."""
        t_ns, row = self._frames
        spans = self._stretches(Sensor.IMAGES, Sensor.IMU, Sensor.DVL)
        inside = [np.flatnonzero((t_ns >= begin) & (t_ns <= end)) for begin, end in spans]
        runs = max(LEAST_RUNS, RUNS // len(spans))
        pairs = [pair for rows in inside for run in choose_runs(t_ns, rows, runs) for pair in itertools.pairwise(run)]
        found = [
            (t_ns[a], t_ns[b], *motion)
            for a, b in pairs
            if self._measure is not None
            and self._heard(int(t_ns[a]), int(t_ns[b]))
            and (motion := self._measure(int(row[a]), int(row[b]))) is not None
        ]
        return ImageMotions(
            first_ns=np.array([one[0] for one in found], np.int64),
            second_ns=np.array([one[1] for one in found], np.int64),
            second_from_first=from_matrix(np.array([one[2] for one in found]).reshape(-1, 4, 4)),
            sigma_rad=np.array([one[3] for one in found]).reshape(-1, 2),
        )

    def _heard(self, first_ns: int, second_ns: int) -> bool:
        """Return whether DVL and IMU were heard from one instant to the other."""
        v, a = self._velocities, self._attitude
        if not len(v.t_ns) or first_ns < max(v.t_ns[0], a.t_ns[0]) or second_ns > min(v.t_ns[-1], a.t_ns[-1]):
            return False
        return not any(((gap[:, 0] < second_ns) & (gap[:, 1] > first_ns)).any() for gap in (v.outages, a.holes))


def choose_runs(t_ns: Ints, inside: Ints, runs: int) -> list[list[int]]:
    """Return runs of frames that are spread evenly over those `inside`, each frame of a run at least a stride after the one
    before. t_ns (n,): stamps in time order; inside (m,): rows in order."""
    if len(inside) < 2:
        return []
    starts = np.unique(np.linspace(inside[0], inside[-1], runs + 2)[1:-1].astype(int)).tolist()
    out = []
    for start, end in zip(starts, [*starts[1:], int(inside[-1]) + 1], strict=True):
        chosen = [start]
        for k in range(start + 1, end):
            if len(chosen) < RUN_FRAMES and t_ns[k] - t_ns[chosen[-1]] >= 0.9 * STRIDE_S * 1e9:
                chosen.append(k)
        out.append(chosen)
    return out


def _usable(found: TimeShift | None) -> _Late | None:
    """Return by how much a clock is late, where that is known: surely so, or well enough to say that it is not."""
    if found is None or not found.is_unique():
        return None
    sure = found.is_sure(SIGMAS)
    return _Late(seconds=found.seconds, sigma_s=found.sigma_s, sure=sure) if sure or found.sigma_s <= KNOWN_S else None


class _ByStretch:
    """What is known of two clocks, by the stretches between the pauses of their two sensors."""

    def __init__(self, spans: Sequence[Span], late: Callable[[Span], _Late | None]) -> None:
        self._spans, self._late = spans, [late(span) for span in spans]

    @property
    def is_known(self) -> bool:
        """Return whether anything is known in any stretch."""
        return any(late is not None for late in self._late)

    def at(self, span: Span) -> _Late | None:
        """Return what is known in a span that lies within one of the stretches, or within them all."""
        middle = (span[0] + span[1]) // 2
        return next((late for (begin, end), late in zip(self._spans, self._late, strict=True) if begin <= middle <= end), None)


def _between(motions: ImageMotions, span: Span) -> ImageMotions:
    rows = np.flatnonzero((motions.first_ns >= span[0]) & (motions.second_ns <= span[1]))
    return ImageMotions(
        first_ns=motions.first_ns[rows],
        second_ns=motions.second_ns[rows],
        second_from_first=motions.second_from_first[rows],
        sigma_rad=motions.sigma_rad[rows],
    )


def _against_most(span: Span, late: Mapping[Sensor, _Late]) -> list[ClockError]:
    """Return the errors of the clocks that are not those of most sensors; of as many, those with the IMU are right."""

    def agree(group: Sequence[Sensor]) -> bool:
        apart = {pair: abs(late[pair[0]].seconds - late[pair[1]].seconds) for pair in itertools.combinations(group, 2)}
        return all(seconds < max(LEAST_S[sensor] for sensor in pair) for pair, seconds in apart.items())

    groups = [g for size in range(1, len(late) + 1) for g in itertools.combinations(late, size) if agree(g)]
    right = max(groups, key=lambda group: (len(group), Sensor.IMU in group))
    best = late[min(right, key=lambda sensor: late[sensor].sigma_s)]
    out = []
    for sensor, own in late.items():
        seconds, sigma_s = own.seconds - best.seconds, float(np.hypot(own.sigma_s, best.sigma_s))
        if sensor not in right and abs(seconds) >= max(LEAST_S[sensor], SIGMAS * sigma_s):
            out.append(_error(sensor, span, seconds, sigma_s, [other for other in Sensor if other in right]))
    return out


def _by_turn_and_depth(span: Span, turned: _Late, sunk: _Late | None) -> ClockError | None:
    """Return whose clock is wrong where the IMU parts from the DVL: the pressure sensor tells; without it the DVL's is. None
    where all three part: that one alone is wrong, and the turns deceive, is likelier."""
    if sunk is None:
        return _error(Sensor.DVL, span, -turned.seconds, turned.sigma_s, [Sensor.IMU])
    if abs(sunk.seconds - turned.seconds) <= max(AGREE_S, 3 * turned.sigma_s):
        return _error(Sensor.DVL, span, -sunk.seconds, sunk.sigma_s, [Sensor.IMU, Sensor.PRESSURE])
    if not sunk.sure or abs(sunk.seconds) < LEAST_S[Sensor.PRESSURE]:
        return _error(Sensor.IMU, span, turned.seconds, turned.sigma_s, [Sensor.DVL, Sensor.PRESSURE])
    return None


def _by_depth_too(span: Span, late: Mapping[Sensor, _Late], sunk: _Late | None) -> list[ClockError]:
    """Return the error of the DVL's clock where images and pressure sensor both tell it and much the same, with images and IMU
    that agree; none else. The depth tells it more exactly than the directions in which the camera went."""
    dvl, imu = late[Sensor.DVL], late.get(Sensor.IMU)
    if sunk is None or not (dvl.sure and sunk.sure) or (imu is not None and abs(imu.seconds) >= LEAST_S[Sensor.IMU]):
        return []
    if min(abs(dvl.seconds), abs(sunk.seconds)) < LEAST_BY_TWO_S or abs(dvl.seconds + sunk.seconds) > AGREE_S:
        return []
    others = [Sensor.IMU] * (imu is not None) + [Sensor.PRESSURE, Sensor.IMAGES]
    return [_error(Sensor.DVL, span, -sunk.seconds, sunk.sigma_s, others)]


def _error(sensor: Sensor, span: Span, late_s: float, sigma_s: float, beside: Sequence[Sensor]) -> ClockError:
    return ClockError(sensor=sensor, from_ns=span[0], to_ns=span[1], late_s=late_s, sigma_s=sigma_s, beside=tuple(beside))


def _put_right(logs: NavigationLogs, errors: Sequence[ClockError]) -> NavigationLogs:
    if not errors:
        return logs
    pressure = logs.pressure
    if pressure is not None:
        pressure = replace(pressure, t_ns=on_time(pressure.t_ns, errors, Sensor.PRESSURE))
    top, bottom = put_images_right(logs.top, logs.bottom, errors)
    return sort_streams(
        replace(
            logs,
            dvl=replace(logs.dvl, t_ns=on_time(logs.dvl.t_ns, errors, Sensor.DVL)),
            imu=replace(logs.imu, t_ns=on_time(logs.imu.t_ns, errors, Sensor.IMU)),
            pressure=pressure,
            top=top,
            bottom=bottom,
        )
    )[0]
