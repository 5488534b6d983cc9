# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Faults of the DVL."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.streams.pressure import METRES
from hullrecon.navigation.suspects.comparisons.comparison import Comparison, Sensor
from hullrecon.navigation.suspects.comparisons.images import Flow
from hullrecon.navigation.suspects.comparisons.motions import Motions, compare
from hullrecon.navigation.suspects.faults.axes import TURN_STEP_DEG, is_mirrored, signed_axes
from hullrecon.navigation.suspects.faults.clock import clock_faults
from hullrecon.navigation.suspects.faults.hypothesis import FACTORS, Hypothesis
from hullrecon.records.sensors import DvlPings, SensorRecords
from hullrecon.rig import Rig
from hullrecon.typing import Array, Mask

# m/s of each unit in which a velocity may have been logged instead
METRES_PER_SECOND = {
    "cm/s": 0.01,
    "mm/s": 0.001,
    "ft/s": 0.3048,
    "kn": 0.514444,
    "km/h": 1 / 3.6,
    "mph": 0.44704,
}
OFFSET_M_S = 0.3  # sigma of a constant error of a DVL's velocity that is tried
OFFSET_STEPS = 2  # of its fit: what a tilt of the DVL makes of the velocity changes with it
REPEATED = 4  # pings with one velocity to the last digit: noise of 1 mm/s makes two of them rare


def dvl_faults(
    records: SensorRecords, dvl: DvlPings, rig: Rig, flows: Sequence[Flow]
) -> Iterator[Hypothesis]:
    """Yield faults of the DVL: of what it logged, of its clock, of its mount, a constant error.

    rig: the mount of the DVL. flows: features of neighbouring images.
    """
    yield from _velocity_faults(records, dvl)
    yield from _other_axes(records, dvl)
    yield from _range_faults(records, dvl)
    for clock in clock_faults(dvl.t_ns):
        yield clock.hypothesis(Sensor.DVL, replace(records, dvl=clock.correct(dvl)))
    yield from _mounts(records, dvl, rig.tray_from_dvl.rotation[0])
    yield from _constant_error(records, dvl, rig, flows)


def _velocity_faults(records: SensorRecords, dvl: DvlPings) -> Iterator[Hypothesis]:
    """Yield faults of the velocity: unit, scale, axes, a turn about the DVL's axis, repetition."""
    frozen = _repeated(dvl.velocity)
    # velocity (n, 3) by fault and value, and whether it can be used
    interpretations = {
        **{
            ("unit", unit): (factor * dvl.velocity, True)
            for unit, factor in METRES_PER_SECOND.items()
        },
        **{("scale", f"{f:.2f}"): (f * dvl.velocity, False) for f in FACTORS},
        # turned axes are those of a DVL that sits otherwise, mirrored ones a driver's
        **{
            ("axes", name): (dvl.velocity @ turn.T, is_mirrored(turn))
            for name, turn in signed_axes()
        },
    }
    for angle in range(-175, 180, TURN_STEP_DEG):  # turns by right angles are among "axes"
        if angle % 90:
            turn = Rotation.from_euler("z", angle, degrees=True)
            interpretations["turn", f"{angle:d}"] = turn.apply(dvl.velocity), False
    if frozen.any():
        interpretations["repeated", ""] = (np.where(frozen[:, None], np.nan, dvl.velocity), True)
    for (fault, value), (velocity, exact) in interpretations.items():
        mended = replace(records, dvl=replace(dvl, velocity=velocity))
        yield Hypothesis(sensor=Sensor.DVL, fault=fault, value=value, mended=mended, exact=exact)


def _repeated(velocity: Array) -> Mask:
    """Find pings in runs of REPEATED or more with the same velocity (n, 3) to the last digit."""
    same = np.concatenate([[False], (np.diff(velocity, axis=0) == 0).all(axis=1)])
    run = np.cumsum(~same)
    return np.asarray(np.bincount(run)[run] >= REPEATED)


def _other_axes(records: SensorRecords, dvl: DvlPings) -> Iterator[Hypothesis]:
    """Yield a DVL that gives velocities along its beams, and one in left-handed axes."""
    if np.linalg.matrix_rank(dvl.beams[:3]) == 3:
        # three of the four velocities along the beams were logged as x, y, z
        for value, along in (("towards", -dvl.beams[:3]), ("away from", dvl.beams[:3])):
            velocity = dvl.velocity @ np.linalg.inv(along).T
            mended = replace(records, dvl=replace(dvl, velocity=velocity))
            yield Hypothesis(
                sensor=Sensor.DVL, fault="along", value=value, mended=mended, exact=True
            )
    for axis, name in enumerate("xyz"):
        mirror = np.where(np.arange(3) == axis, -1.0, 1.0)
        left = replace(dvl, velocity=mirror * dvl.velocity, beams=mirror * dvl.beams)
        mended = replace(records, dvl=left)
        yield Hypothesis(sensor=Sensor.DVL, fault="mirrored", value=name, mended=mended, exact=True)


def _range_faults(records: SensorRecords, dvl: DvlPings) -> Iterator[Hypothesis]:
    """Yield faults of the ranges: their unit or scale, and the order of the beams."""
    for value, factor in {**METRES, **{f"{f:.2f}": f for f in FACTORS}}.items():
        mended = replace(records, dvl=replace(dvl, ranges=factor * dvl.ranges))
        if factor != 1:
            yield Hypothesis(sensor=Sensor.DVL, fault="ranges", value=value, mended=mended)
    for order in itertools.permutations(range(4)) if dvl.ranges.shape[1] == 4 else ():
        # the range logged as that of the beam k is of the beam order[k]
        mended = replace(records, dvl=replace(dvl, ranges=dvl.ranges[:, np.argsort(order)]))
        if order != (0, 1, 2, 3):
            value = ", ".join(str(beam + 1) for beam in order)
            yield Hypothesis(sensor=Sensor.DVL, fault="beams", value=value, mended=mended)


def _mounts(records: SensorRecords, dvl: DvlPings, tray_from_dvl: Rotation) -> Iterator[Hypothesis]:
    """Yield mounts of a DVL that looks to another side: it is turned about the tray's z axis.

    Its beams turn with its velocity. Turns about the tray's own axis, y, are left out: they cannot
    be distinguished from a tray whose zero is off.
    """
    for angle in range(TURN_STEP_DEG - 180, 181, TURN_STEP_DEG):
        if angle:
            turn = Rotation.from_euler("z", angle, degrees=True)
            own = tray_from_dvl.inv() * turn * tray_from_dvl
            whole = replace(dvl, velocity=own.apply(dvl.velocity), beams=own.apply(dvl.beams))
            mended = replace(records, dvl=whole)
            yield Hypothesis(sensor=Sensor.DVL, fault="mount", value=f"{angle:d}", mended=mended)


def _constant_error(
    records: SensorRecords, dvl: DvlPings, rig: Rig, flows: Sequence[Flow]
) -> Iterator[Hypothesis]:
    """Yield a DVL whose velocities are all off by the same, fitted to all that it contradicts."""
    motions = Motions(records, rig, flows)

    def residuals(offset: Array) -> dict[str, Comparison]:
        """Repeat the comparisons of the DVL with an offset (3,) m/s taken off its velocities."""
        moved = replace(records, dvl=replace(dvl, velocity=dvl.velocity - offset))
        found = compare(Motions(moved, rig, flows, motions))
        return {one.kind: one for one in found if Sensor.DVL in one.sensors - one.unclear}

    off = np.zeros(3)
    for _ in range(OFFSET_STEPS):
        as_is, along = residuals(off), [residuals(off + axis) for axis in OFFSET_M_S * np.eye(3)]
        normal, right = np.eye(3), -off / OFFSET_M_S  # in OFFSET_M_S, the sigma of an offset
        for kind, one in as_is.items():
            moved = [other[kind].residual for other in along if kind in other]
            if len(moved) < 3 or any(len(residual) != len(one.residual) for residual in moved):
                continue
            design = (np.column_stack(moved) - one.residual[:, None]) / one.sigma[:, None]
            # errors that faultless sensors have are eliminated, each known to one sigma
            other = one.by_nuisance / one.sigma[:, None]
            inner = np.linalg.inv(other.T @ other + np.eye(other.shape[1]))
            left = design - other @ (inner @ (other.T @ design))
            normal += left.T @ design
            right -= left.T @ (one.residual / one.sigma)
        off = off + OFFSET_M_S * np.linalg.solve(normal, right)
    mended = replace(records, dvl=replace(dvl, velocity=dvl.velocity - off))
    value = ", ".join(f"{axis:+.2f}" for axis in off)
    yield Hypothesis(sensor=Sensor.DVL, fault="offset", value=value, mended=mended)
