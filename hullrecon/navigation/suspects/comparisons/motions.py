# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Make the comparisons of a dive's sensors, as the dive was logged and under each hypothesis.

A module for each pair of sensors holds its comparisons: depth.py, imu.py, hull.py, images.py.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence, Set
from functools import cached_property

import numpy as np

from hullrecon.navigation.dead_reckoning.integral import Integral
from hullrecon.navigation.sensors.motion_signals import integrate_acceleration
from hullrecon.navigation.suspects.comparisons.comparison import Comparison, Sensor
from hullrecon.navigation.suspects.comparisons.depth import (
    SmoothedDepth,
    compare_depth,
    compare_level,
    smooth_depth,
)
from hullrecon.navigation.suspects.comparisons.dvl_track import Track, rows_with_velocity, track_of
from hullrecon.navigation.suspects.comparisons.hull import HullPlanes, compare_ranges, hull_planes
from hullrecon.navigation.suspects.comparisons.images import (
    Flow,
    Views,
    compare_flow,
    compare_view,
    views_of,
)
from hullrecon.navigation.suspects.comparisons.imu import (
    compare_acceleration,
    compare_gravity,
    compare_heading,
    compare_rates,
)
from hullrecon.records.sensors import SensorRecords
from hullrecon.rig import Rig

# Sensors whose readings each kind of comparison depends on, the quickest to compute first.
DEPENDS_ON = {
    # depth and the water's surface
    "level": {Sensor.PRESSURE},
    # mean acceleration and the vertical of the attitude
    "gravity": {Sensor.ACCELERATION, Sensor.ATTITUDE},
    # turns by the rates and by the orientation
    "turn": {Sensor.RATES, Sensor.ATTITUDE},
    # the same about the vertical alone, over seconds
    "heading": {Sensor.RATES, Sensor.ATTITUDE},
    # change of the depth and of the DVL's path
    "depth": {Sensor.PRESSURE, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY},
    # change of the hull's distance by the DVL's ranges, and by its velocity
    "range": {Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY},
    # the hull's normal by the DVL's ranges, which the attitude turns back
    "hull": {Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY},
    # change of velocity by the accelerations and by the DVL
    "push": {Sensor.ACCELERATION, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY},
    # median motion of features and the motion by the other sensors
    "flow": {Sensor.CAMERA, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY},
    # turn of the camera by features and by the other sensors
    "view": {Sensor.CAMERA, Sensor.DVL, Sensor.ATTITUDE, Sensor.TRAY},
}
OF_TRACK = {kind for kind, sensors in DEPENDS_ON.items() if Sensor.DVL in sensors}


class Motions:
    """The motion of a dive by its sensors, each part computed when it is first used.

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
        """Compare the IMU's rates and orientation. None without enough readings."""
        imu = self.records.imu
        if imu is None or len(imu.t_ns) < 2:
            return None
        unturned = self._with_same_turns()
        return compare_rates(imu) if unturned is None else unturned.turn

    @cached_property
    def heading(self) -> Comparison | None:
        """Compare the headings of the IMU's rates and orientation. None without enough readings."""
        imu = self.records.imu
        if imu is None or len(imu.t_ns) < 2:
            return None
        unturned = self._with_same_turns()
        return compare_heading(imu) if unturned is None else unturned.heading

    def _with_same_turns(self) -> Motions | None:
        """Return the motions before, where rates and orientation turn alike. None otherwise.

        Turns depend on times between readings only: a hypothesis that moves all stamps of the IMU
        by the same offset leaves them unchanged.
        """
        imu, before = self.records.imu, self._before
        if imu is None or before is None or before.records.imu is None:
            return None
        if not self._has_same(_turn_readings):
            return None
        now_ns, before_ns = imu.t_ns, before.records.imu.t_ns
        return before if np.array_equal(now_ns - now_ns[0], before_ns - before_ns[0]) else None

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
        if not np.array_equal(rows_with_velocity(self.records), before.rows):
            return track_of(self.records, self.rig)
        return before.with_velocity(dvl.velocity[before.rows])

    @cached_property
    def integrated_acceleration(self) -> Integral | None:
        """Integrate the accelerations, less gravity, at seconds since the start of the track.

        None without a track, without accelerations, or where gravity was taken off.
        """
        track, imu = self.track, self.records.imu
        if track is None or imu is None:
            return None
        if self._before is not None and self._has_same(_acceleration_readings):
            before = self._before.track
            if before is not None and before.t_ns[0] == track.t_ns[0]:
                return self._before.integrated_acceleration
        return integrate_acceleration(imu, int(track.t_ns[0]))

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

        Identity is tested, which takes no time, and not equality. readings: lists the arrays that
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
    return () if records.dvl is None else (records.dvl.ranges, records.dvl.beams)


def _depth_readings(records: SensorRecords) -> Sequence[object]:
    return () if records.pressure is None else (records.pressure.t_ns, records.pressure.depth)


def _attitude_readings(records: SensorRecords) -> Sequence[object]:
    """List the readings that the attitude of the DVL at its pings depends on."""
    dvl, imu = records.dvl, records.imu
    if dvl is None or imu is None:
        return ()
    return dvl.t_ns, imu.t_ns, imu.quaternion, records.tray


def compare(motions: Motions, kinds: Set[str] = DEPENDS_ON.keys()) -> list[Comparison]:
    """Make the comparisons for which the dive has enough readings and motion.

    kinds: those to make, of DEPENDS_ON.
    """
    found: list[Comparison | None] = []
    imu, dvl, pressure = motions.records.imu, motions.records.dvl, motions.records.pressure
    if pressure is not None and "level" in kinds:
        found.append(compare_level(pressure))
    if "turn" in kinds:
        found.append(motions.turn)
    if "heading" in kinds:
        found.append(motions.heading)
    if imu is not None and "gravity" in kinds:
        found.append(compare_gravity(imu))
    track = motions.track if kinds & OF_TRACK else None
    if track is None or dvl is None:
        return [one for one in found if one is not None]
    if "depth" in kinds and motions.depth is not None:
        found.append(compare_depth(motions.depth, track))
    if "push" in kinds and motions.integrated_acceleration is not None:
        found.append(compare_acceleration(motions.integrated_acceleration, track))
    if "flow" in kinds and motions.views is not None:
        found.append(compare_flow(motions.views))
    if "view" in kinds and motions.views is not None:
        found.append(compare_view(motions.views))
    if kinds & {"range", "hull"} and motions.hull is not None:
        found += compare_ranges(dvl.t_ns, motions.hull, track)
    return [one for one in found if one is not None]
