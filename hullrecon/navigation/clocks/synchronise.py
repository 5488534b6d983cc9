# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Put right the clocks of DVL, IMU, pressure sensor and cameras that are late or early beside the
others, or jumped.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from hullrecon.geometry.poses import from_matrix
from hullrecon.navigation.clocks.clock_errors import (
    ClockError,
    Sensor,
    describe_errors,
    join_errors,
    late_beside,
    on_time,
    put_images_right,
)
from hullrecon.navigation.clocks.images import ImageMotions, dvl_beside_images, imu_beside_images
from hullrecon.navigation.clocks.instruments import imu_beside_dvl, pressure_beside_dvl
from hullrecon.navigation.clocks.stretches import (
    PREFERRED,
    Decision,
    Span,
    decide_by_stretch,
    stretches,
)
from hullrecon.navigation.clocks.time_shift import (
    FAR_S,
    Disagreement,
    find_far_shift,
    find_time_shift,
    preference,
    sum_of_sigmas,
)
from hullrecon.navigation.clocks.whose_clock import (
    LEAST_BY_HULL_S,
    LEAST_S,
    Late,
    against_most,
    agree,
    by_depth_too,
    by_turn_and_depth,
    error_of,
    usable,
)
from hullrecon.navigation.dead_reckoning.dead_reckon import (
    NavigationLogs,
    sort_streams,
    usable_frames,
)
from hullrecon.navigation.dead_reckoning.image_walk import STRIDE_S
from hullrecon.navigation.sensors.attitude import AttitudeHistory, attitude_history
from hullrecon.navigation.sensors.servo import Servo, servo
from hullrecon.navigation.sensors.velocity import Velocities, usable_velocities
from hullrecon.records.sensors import DvlPings
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints, Mask

RUNS, LEAST_RUNS, RUN_FRAMES = 6, 3, 6  # of images whose motion is looked at, spread over a stretch

# From two rows of the upper camera's images: second_from_first (4, 4), its translation of any
# length, and the sigmas (2,) rad of its turn and direction; None where they do not tell.
MeasureMotion = Callable[[int, int], tuple[Array, Array] | None]


@dataclass(frozen=True, kw_only=True)
class Synchronised:
    """Logs with their clocks put right, in time order; what was wrong with the clocks; sentences on
    what was put right, and on what could not be told.
    """

    logs: NavigationLogs
    errors: list[ClockError]
    remarks: list[str]


def synchronise(
    logs: NavigationLogs,
    rig: Rig,
    tilt_rad: float,
    longest_gap_s: float,
    measure: MeasureMotion | None = None,
) -> Synchronised:
    """Return the logs with their clocks put right.

    The dive is looked at as a whole, and each stretch between pauses that may be jumps for what
    contradicts that. With images (measure), IMU and DVL are held against what these show of the
    camera's motion, and the pressure sensor against the DVL; the clocks that most sensors share are
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
        self,
        logs: NavigationLogs,
        rig: Rig,
        tilt_rad: float,
        longest_gap_s: float,
        measure: MeasureMotion | None,
    ) -> None:
        self._logs, self._rig, self._measure = logs, rig, measure
        self._servo: Servo = servo(logs.tray, int(logs.dvl.t_ns[0]))
        heard = int(logs.imu.t_ns[0]), int(logs.imu.t_ns[-1])
        self._velocities: Velocities = usable_velocities(logs.dvl, heard, longest_gap_s)
        self._attitude: AttitudeHistory = attitude_history(logs.imu, tilt_rad, longest_gap_s)
        self._frames = usable_frames(logs.top)
        self.sees = measure is not None and len(self._frames[0]) > 1

    def by_images(self) -> Decision:
        """Return whose clocks are wrong beside those that most share, by what images show of the
        motion; by the hull where they show none.
        """
        motions = self._motions()

        def of_imu(span: Span) -> Late | None:
            return _late(
                imu_beside_images(_between(motions, span), self._attitude, self._servo, self._rig)
            )

        def of_dvl(span: Span) -> Late | None:
            return _late(dvl_beside_images(_between(motions, span), self._velocities, self._rig))

        imu, dvl = (
            _ByStretch(self._stretches(Sensor.IMAGES, Sensor.IMU), of_imu),
            _ByStretch(self._stretches(Sensor.IMAGES, Sensor.DVL), of_dvl),
        )
        if not (imu.is_known or dvl.is_known):
            return self.by_hull()

        def decide(span: Span) -> Decision:
            late = {Sensor.IMAGES: Late(seconds=0.0, sigma_s=0.0, sure=False)}
            for sensor, found in ((Sensor.IMU, imu.at(span)), (Sensor.DVL, dvl.at(span))):
                late |= {} if found is None else {sensor: found}
            if Sensor.DVL not in late:
                return against_most(span, late), []
            imu_late_s = (
                late[Sensor.IMU].seconds - late[Sensor.DVL].seconds if Sensor.IMU in late else 0.0
            )
            sunk = self._sunk(span, imu_late_s)
            if sunk is not None:
                late[Sensor.PRESSURE] = late[Sensor.DVL].and_later(sunk)
            return by_depth_too(span, late, sunk) or against_most(span, late), []

        def better(span: Span, first: Sequence[ClockError], second: Sequence[ClockError]) -> float:
            seen = _between(motions, span)
            return sum_of_sigmas(
                [
                    _prefer(
                        imu_beside_images(seen, self._attitude, self._servo, self._rig),
                        Sensor.IMU,
                        Sensor.IMAGES,
                        first,
                        second,
                    ),
                    _prefer(
                        dvl_beside_images(seen, self._velocities, self._rig),
                        Sensor.DVL,
                        Sensor.IMAGES,
                        first,
                        second,
                    ),
                    self._prefer_by_depth(span, first, second),
                ]
            )

        return decide_by_stretch(self._stretches(*Sensor), decide, better)

    def by_hull(self) -> Decision:
        """Return whose clocks are wrong, by the DVL's ranges to the hull, which stands still, and
        by depth.
        """
        imu = _ByStretch(self._stretches(Sensor.DVL, Sensor.IMU), self._turned)

        def decide(span: Span) -> Decision:
            turned = imu.at(span)
            if turned is not None and turned.sure and abs(turned.seconds) >= LEAST_BY_HULL_S:
                error = by_turn_and_depth(span, turned, self._sunk(span, turned.seconds))
            else:
                error = self._by_turn_near_and_depth(span) if turned is None else None
            return self._decide_by_depth(span) if error is None else ([error], [])

        def better(span: Span, first: Sequence[ClockError], second: Sequence[ClockError]) -> float:
            turn = _prefer(self._hull_turns(span), Sensor.IMU, Sensor.DVL, first, second)
            return sum_of_sigmas([turn, self._prefer_by_depth(span, first, second)])

        return decide_by_stretch(
            self._stretches(Sensor.DVL, Sensor.IMU, Sensor.PRESSURE), decide, better
        )

    def _by_turn_near_and_depth(self, span: Span) -> ClockError | None:
        """Return the error of the DVL's clock where the depth tells the same as the turns do among
        near shifts: these alone may fit by chance, where far ones fit as well. None else.
        """
        turn = self._hull_turns(span)
        near = (
            usable(find_time_shift(turn.residuals, turn.block))
            if turn is not None and turn.is_enough
            else None
        )
        if near is None or not near.sure or abs(near.seconds) < LEAST_BY_HULL_S:
            return None
        sunk = self._sunk(span, near.seconds)
        return (
            by_turn_and_depth(span, near, sunk)
            if sunk is not None and sunk.sure and agree(near, sunk)
            else None
        )

    def _decide_by_depth(self, span: Span) -> Decision:
        """Return which of DVL and pressure sensor is wrong, where they part."""
        sunk = self._sunk(span)
        if sunk is None or not sunk.sure or abs(sunk.seconds) < LEAST_S[Sensor.PRESSURE]:
            return [], []
        error = self._by_depth_alone(span, sunk)
        if error is not None:
            return [error], []
        return [], [
            f"DVL and pressure: their clocks part by {abs(sunk.seconds):.2f} s (sigma {sunk.sigma_s:.3f} s); which"
            " of them is wrong is not known, and both were left as they are"
        ]

    def _prefer_by_depth(
        self, span: Span, first: Sequence[ClockError], second: Sequence[ClockError]
    ) -> float:
        """Return how many sigmas better the depth and what the DVL sank agree by some errors than
        by others.
        """
        one, other = (
            self._sinking(span, late_beside(errors, Sensor.IMU, Sensor.DVL))
            for errors in (first, second)
        )
        if one is None or other is None:
            return 0.0
        by_first, by_second = (
            late_beside(errors, Sensor.PRESSURE, Sensor.DVL) for errors in (first, second)
        )
        return preference(one.residuals(by_first), other.residuals(by_second), one.block)

    def _by_depth_alone(self, span: Span, sunk: Late) -> ClockError | None:
        """Return which of DVL and pressure sensor, which part, is wrong: by where the hull stands
        more still. None where that does not tell.
        """
        turn = self._hull_turns(span)
        better = (
            0.0
            if turn is None
            else preference(turn.residuals(sunk.seconds), turn.residuals(0.0), turn.block)
        )
        if better >= PREFERRED:
            late = self._sunk(span, None) or sunk  # with the attitude of the pressure sensor's time
            return error_of(
                Sensor.DVL, span, -late.seconds, late.sigma_s, [Sensor.IMU, Sensor.PRESSURE]
            )
        if better <= -PREFERRED:
            return error_of(
                Sensor.PRESSURE, span, sunk.seconds, sunk.sigma_s, [Sensor.DVL, Sensor.IMU]
            )
        return None

    def _sunk(self, span: Span, imu_late_s: float | None = 0.0) -> Late | None:
        """Return how late the pressure sensor is beside the DVL; imu_late_s: how late the IMU is;
        None: as late.
        """
        return _late(self._sinking(span, imu_late_s))

    def _sinking(self, span: Span, imu_late_s: float | None) -> Disagreement | None:
        pressure = self._logs.pressure
        if pressure is None:
            return None
        return pressure_beside_dvl(
            self._pings(span), self._attitude, pressure, self._servo, self._rig, imu_late_s
        )

    def _turned(self, span: Span) -> Late | None:
        """Return how late the IMU is beside the DVL. None where it began and ended over a minute
        before the DVL, or after it.

        That is a clock farther off than what is looked at, and some nearer shift might fit by
        chance.
        """
        began_s, ended_s = (
            (self._logs.imu.t_ns[end] - self._logs.dvl.t_ns[end]) * 1e-9 for end in (0, -1)
        )
        if min(abs(began_s), abs(ended_s)) > FAR_S and began_s * ended_s > 0:
            return None
        return _late(self._hull_turns(span))

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
        """Return the motions over some runs of images in each stretch, where DVL and IMU were
        heard.
        """
        t_ns, row = self._frames
        spans = self._stretches(Sensor.IMAGES, Sensor.IMU, Sensor.DVL)
        inside = [np.flatnonzero((t_ns >= begin) & (t_ns <= end)) for begin, end in spans]
        runs = max(LEAST_RUNS, RUNS // len(spans))
        pairs = [
            pair
            for rows in inside
            for run in choose_runs(t_ns, rows, runs)
            for pair in itertools.pairwise(run)
        ]
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
        if (
            not len(v.t_ns)
            or first_ns < max(v.t_ns[0], a.t_ns[0])
            or second_ns > min(v.t_ns[-1], a.t_ns[-1])
        ):
            return False
        return not any(
            ((gap[:, 0] < second_ns) & (gap[:, 1] > first_ns)).any() for gap in (v.outages, a.holes)
        )


def choose_runs(t_ns: Ints, inside: Ints, runs: int) -> list[list[int]]:
    """Return runs of frames that are spread evenly over those `inside`, each frame of a run at
    least a stride after the one before. t_ns (n,): stamps in time order; inside (m,): rows in
    order.
    """
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


class _ByStretch:
    """What is known of two clocks, by the stretches between the pauses of their two sensors."""

    def __init__(self, spans: Sequence[Span], late: Callable[[Span], Late | None]) -> None:
        self._spans, self._late = spans, cache(late)

    @property
    def is_known(self) -> bool:
        """Return whether anything is known of the whole or of any stretch."""
        return any(self._late(span) is not None for span in [self._whole, *self._spans])

    def at(self, span: Span) -> Late | None:
        """Return what is known in a span that lies within one of the stretches, or of the whole
        where it covers them all.
        """
        if span[0] <= self._whole[0] and span[1] >= self._whole[1]:
            return self._late(self._whole)
        middle = (span[0] + span[1]) // 2
        return next((self._late(own) for own in self._spans if own[0] <= middle <= own[1]), None)

    @property
    def _whole(self) -> Span:
        return self._spans[0][0], self._spans[-1][1]


def _late(found: Disagreement | None) -> Late | None:
    """Return by how much a clock is late by how it parts from another one; None where that is not
    known.
    """
    return (
        None
        if found is None or not found.is_enough
        else usable(find_far_shift(found.residuals, found.block))
    )


def _prefer(
    found: Disagreement | None,
    sensor: Sensor,
    other: Sensor,
    first: Sequence[ClockError],
    second: Sequence[ClockError],
) -> float:
    """Return how many sigmas better two sensors agree by some errors than by others."""
    if found is None:
        return 0.0
    by_first, by_second = (
        found.residuals(late_beside(errors, sensor, other)) for errors in (first, second)
    )
    return preference(by_first, by_second, found.block)


def _between(motions: ImageMotions, span: Span) -> ImageMotions:
    rows = np.flatnonzero((motions.first_ns >= span[0]) & (motions.second_ns <= span[1]))
    return ImageMotions(
        first_ns=motions.first_ns[rows],
        second_ns=motions.second_ns[rows],
        second_from_first=motions.second_from_first[rows],
        sigma_rad=motions.sigma_rad[rows],
    )


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
