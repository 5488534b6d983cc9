# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find a fault that a sensor has in a part of the dive only, as after a restart of its driver.

Comparisons of a whole dive cannot explain such a fault by one unit or one set of axes. Where few of
their rows show it they do not even notice it: a vehicle that goes along a hull changes its velocity
at the ends of legs only. So parts of the dive, from the half to the last or first fifth,
are judged by themselves (suspects.py). If a fault explains what contradicts in one, the time at
which it begins or ends is the one with which all rows agree best.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from hullrecon.findings.finding import Finding
from hullrecon.geometry.robust import ALIKE, GAIN
from hullrecon.navigation.suspects.comparisons.comparison import Comparison, Sensor
from hullrecon.navigation.suspects.comparisons.images import Flow
from hullrecon.navigation.suspects.comparisons.motions import DEPENDS_ON, Motions, compare
from hullrecon.navigation.suspects.faults.axes import BY_DEFAULT, Conventions
from hullrecon.navigation.suspects.faults.hypothesis import OF_DRIVERS, Hypothesis
from hullrecon.navigation.suspects.hypotheses import hypotheses
from hullrecon.navigation.suspects.suspects import judge
from hullrecon.records.clock import NS, format_time
from hullrecon.records.sensors import SensorRecord, SensorRecords
from hullrecon.rig import Rig
from hullrecon.rows import Rows
from hullrecon.typing import Ints, Mask

STARTS = (0.5, 0.6, 0.7, 0.8)  # of a part that reaches to the end, as shares of the dive
PARTS = (*((start, 1.0) for start in STARTS), *((0.0, 1.0 - start) for start in STARTS))
COMPARED = ("dvl", "imu", "pressure", "tray")  # records that comparisons read
LEAST_READINGS = 8  # of each sensor in a part
TIMES = 48  # at which a fault may begin or end, over the dive
FINER, FINEST_S = 8, 0.02  # of these times, and the least step between them
BEYOND = 2 * GAIN  # by which chi-square has to fall against a fault of no part and of all


def judge_parts(
    records: SensorRecords,
    rig: Rig,
    atmosphere_m: float,
    flows: Sequence[Flow] = (),
    given: Conventions = BY_DEFAULT,
) -> Finding | None:
    """Find the sensor that is wrong from some time of the dive on, or up to it.

    None where no part contradicts itself, or where no fault of a single sensor explains it.

    Parameters
    ----------
    records, rig, flows : the dive
    atmosphere_m : the air's pressure in metres of water, which was subtracted from the pressure
    given : what dive.toml says of the sensors
    """
    streams = [getattr(records, name) for name in COMPARED]
    logged = [s.t_ns for s in streams if s is not None and len(s.t_ns) >= LEAST_READINGS]
    if records.dvl is None or records.imu is None or not logged:
        return None
    start_ns = max(int(t_ns[0]) for t_ns in logged)
    length_ns = min(int(t_ns[-1]) for t_ns in logged) - start_ns
    for first, last in PARTS if length_ns > 0 else ():
        begin_ns, end_ns = (start_ns + round(share * length_ns) for share in (first, last))
        part = _part_of(records, begin_ns, end_ns)
        seen = [one for one in flows if begin_ns <= one.t_ns[0] and one.t_ns[1] <= end_ns]
        if part is None or not any(c.accuses for c in compare(Motions(part, rig, seen))):
            continue
        # of several faults the first is found first
        found = judge(part, rig, atmosphere_m, flows=seen, given=given).findings[0]
        if found.values.get("fault") not in OF_DRIVERS:
            continue
        sensor = Sensor(str(found.values["sensor"]))
        whole = next(
            one
            for one in hypotheses(records, {sensor}, atmosphere_m, rig, flows, given)
            if (one.fault, one.value) == (found.values["fault"], found.values["value"])
        )
        times_ns = start_ns + (np.arange(1, TIMES) * length_ns) // TIMES
        changes_ns = _times_of_change(Motions(records, rig, flows), whole, times_ns, last == 1.0)
        if changes_ns is not None:
            return _describe(found, changes_ns, length_ns // TIMES, last == 1.0)
    return None


def _part_of(records: SensorRecords, begin_ns: int, end_ns: int) -> SensorRecords | None:
    """Select the readings of a part. None where a sensor that was logged gave too few in it."""
    kept: dict[str, SensorRecord] = {}
    for name in COMPARED:
        stream = getattr(records, name)
        if stream is not None and len(stream.t_ns):
            kept[name] = stream.take((stream.t_ns >= begin_ns) & (stream.t_ns <= end_ns))
            if len(kept[name].t_ns) < LEAST_READINGS:
                return None
    return SensorRecords(**kept)  # type: ignore[arg-type]  # each under its own name


def _times_of_change(
    motions: Motions, fault: Hypothesis, times_ns: Ints, from_on: bool
) -> tuple[int, int] | None:
    """Find the times between which a fault of a part of the dive begins, or ends.

    Parameters
    ----------
    motions : as the dive was logged
    fault : of the part, corrected in the whole dive
    times_ns : at which it is tried
    from_on : the fault begins, False: it ends

    Returns
    -------
    tuple or None
        First and last time with which all comparisons of the sensor agree about as well. None where
        the fault explains no more in a part than in all of the dive or in none of it.
    """
    kinds = {kind for kind, sensors in DEPENDS_ON.items() if fault.sensor in sensors}

    def compared(change_ns: int) -> list[Comparison]:
        records, flows = _corrected_in_part(motions, fault, change_ns, from_on)
        return compare(Motions(records, motions.rig, flows, motions), kinds)

    # at first over the dive, then ever finer about the best time
    chi2 = np.array([_sum_of(compared(int(time_ns))) for time_ns in times_ns])
    best_ns, least, step_ns = int(times_ns[chi2.argmin()]), chi2.min(), int(np.diff(times_ns)[0])
    alike_ns = times_ns[chi2 < least + ALIKE]
    while step_ns > FINEST_S * NS:
        near_ns = best_ns + np.linspace(-step_ns, step_ns, 2 * FINER + 1).astype(np.int64)
        finer = np.array([_sum_of(compared(int(time_ns))) for time_ns in near_ns])
        best_ns, least, step_ns = int(near_ns[finer.argmin()]), finer.min(), step_ns // FINER
    for never in (0, 2 * int(times_ns[-1])):  # in all of the dive, in none of it
        if _sum_of(compared(never)) < least + BEYOND:
            return None
    if any(one.accuses for one in compared(best_ns)):
        return None
    return min(best_ns, int(alike_ns[0])), max(best_ns, int(alike_ns[-1]))


def _sum_of(comparisons: Sequence[Comparison]) -> float:
    return sum(one.chi2 for one in comparisons)


def _corrected_in_part(
    motions: Motions, fault: Hypothesis, change_ns: int, from_on: bool
) -> tuple[SensorRecords, list[Flow]]:
    """Correct a fault from a time on, or up to it, and leave the rest as it was logged."""
    corrected: dict[str, SensorRecord] = {}
    for name in COMPARED:
        logged, mended = getattr(motions.records, name), getattr(fault.mended, name)
        if logged is not None and mended is not logged:
            inside = (logged.t_ns >= change_ns) == from_on
            corrected[name] = _rows_of(mended, logged, inside)
    records = replace(motions.records, **corrected)  # type: ignore[arg-type]  # as above
    flows = [
        by_fault if (as_is.t_ns[0] >= change_ns) == from_on else as_is
        for as_is, by_fault in zip(motions.flows, fault.flows or motions.flows, strict=True)
    ]
    return records, flows


def _rows_of(mended: Rows, logged: Rows, inside: Mask) -> Any:
    """Take the rows inside of one table, and all others of another of the same length.

    A column that both share stays as it is, so that motions know that it did not change.
    """
    columns = {}
    for one in fields(logged):  # type: ignore[arg-type]  # any dataclass
        new, old = getattr(mended, one.name), getattr(logged, one.name)
        if new is not old and one.name not in logged.SHARED:
            rows = inside.reshape(-1, *(1,) * (old.ndim - 1))
            columns[one.name] = np.where(rows, new, old)
    return replace(logged, **columns)  # type: ignore[type-var]  # any dataclass


def _describe(found: Finding, changes_ns: tuple[int, int], step_ns: int, from_on: bool) -> Finding:
    """Make the finding of a part's fault, with the limit of the dive that leaves the part out.

    found: the fault in the part. changes_ns: first and last time at which it may begin or end.
    """
    values = {name: found.values[name] for name in ("sensor", "fault", "value")}
    evidence = {name: found.values[name] for name in ("kind", "first", "second", "misfit")}
    change_ns = changes_ns[0] - step_ns if from_on else changes_ns[1] + step_ns
    return Finding(
        "sensor-wrong-in-part",
        {**values, **evidence, "time": format_time(change_ns), "from_on": from_on},
    )
