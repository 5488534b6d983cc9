# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find two faults of different sensors that only together explain what contradicts.

Judged one after the other (suspects.py), a first fault has to leave no contradiction of its sensor.
Of two faults that meet in one comparison neither does: an orientation in another order still
contradicts velocities of other axes. So where no single fault explains a dive, the fault of each
sensor that takes most off chi-square is corrected for once, and the rest is judged.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from hullrecon.findings.finding import Finding
from hullrecon.geometry.robust import ALIKE, GAIN
from hullrecon.navigation.suspects.comparisons.comparison import Sensor
from hullrecon.navigation.suspects.comparisons.images import Flow
from hullrecon.navigation.suspects.comparisons.motions import Motions, compare
from hullrecon.navigation.suspects.faults.axes import BY_DEFAULT, Conventions
from hullrecon.navigation.suspects.faults.hypothesis import OF_DRIVERS, Hypothesis
from hullrecon.navigation.suspects.hypotheses import hypotheses
from hullrecon.navigation.suspects.suspects import (
    Judged,
    RepeatedComparisons,
    describe_fault,
    judge,
    possible_units,
    rank_by_usualness,
)
from hullrecon.records.sensors import SensorRecords
from hullrecon.rig import Rig

MOST_STARTS = 5  # faults that are corrected for once
MOST_LATE_S = 5.0  # beyond, a sensor would hardly have been on at the same time


def judge_pairs(
    records: SensorRecords,
    rig: Rig,
    atmosphere_m: float,
    topics: Mapping[Sensor, str] = MappingProxyType({}),
    flows: Sequence[Flow] = (),
    given: Conventions = BY_DEFAULT,
) -> Judged | None:
    """Find two or more faults that together leave no contradiction.

    None where none do, or where faults of other sensors do about as well. Arguments are those of
    `judge`.
    """
    motions = Motions(records, rig, flows)
    wrong = [c for c in compare(motions) if c.accuses]
    found: list[Judged] = []
    for start in _best_of_each_sensor(motions, atmosphere_m, given):
        rest = judge(start.mended, rig, atmosphere_m, topics, flows, given)
        # A single fault that explains all was found before. One of any size explains too much, and
        # so do several sets of axes of one sensor.
        sensors = {str(start.sensor), *(str(one.values.get("sensor")) for one in rest.findings)}
        is_of_others = len(sensors) == 1 + len(rest.findings)
        if rest.findings and is_of_others and all(map(_is_of_drivers, rest.findings)):
            first = describe_fault("sensor-mended", start, wrong, topics)
            found.append(replace(rest, findings=[first, *rest.findings]))
    found = sorted((one for one in found if np.isfinite(one.chi2)), key=lambda one: one.cost)
    alike = [one for one in found if one.cost < found[0].cost + ALIKE]
    named = {frozenset(str(finding.values["sensor"]) for finding in one.findings) for one in alike}
    return alike[0] if len(named) == 1 else None


def _is_of_drivers(finding: Finding) -> bool:
    """Tell whether a finding is a fault that a driver's settings make, or a clock that is off."""
    late_s = finding.values.get("seconds")
    if isinstance(late_s, float):
        return abs(late_s) <= MOST_LATE_S
    return finding.values.get("fault") in OF_DRIVERS


def _best_of_each_sensor(
    motions: Motions, atmosphere_m: float, given: Conventions
) -> list[Hypothesis]:
    """Find the fault of each sensor that takes most off chi-square, if it can be corrected exactly.

    Of faults that take off as much it is the usual one. The best of the usual ones is another start
    where an unusual one takes off more. A pressure of which several units do is
    left out. At most MOST_STARTS are returned, those that take most first.
    """
    base = compare(motions)
    suspects = frozenset().union(*(c.sensors for c in base if c.accuses))
    gains: dict[Sensor, list[tuple[float, Hypothesis]]] = {}
    records, rig, flows = motions.records, motions.rig, motions.flows
    for one in hypotheses(records, suspects, atmosphere_m, rig, flows, given):
        if one.exact and one.fault in OF_DRIVERS:
            repeated = RepeatedComparisons(one, motions)
            gain = sum(c.chi2 - repeated.chi2(c) for c in base if one.sensor in c.sensors)
            if gain > GAIN:
                gains.setdefault(one.sensor, []).append((gain, one))
    best: list[tuple[float, Hypothesis]] = []
    for of_sensor in gains.values():
        # an unusual fault may take more off, as it hides a part of the other sensor's
        for rank in {rank_by_usualness(one) for _, one in of_sensor}:
            usual = [(gain, one) for gain, one in of_sensor if rank_by_usualness(one) <= rank]
            most = max(gain for gain, _ in usual)
            alike = sorted((h for gain, h in usual if gain > most - ALIKE), key=rank_by_usualness)
            if len(possible_units(alike)) <= 1 and all(alike[0] is not one for _, one in best):
                best.append((most, alike[0]))
    return [one for _, one in sorted(best, key=lambda pair: -pair[0])[:MOST_STARTS]]
