# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find the sensor that contradicts the others, put it right, leave it out, or name it.

See docs/methods.md, Suspects. Comparisons of two sensors show where a dive contradicts itself. Each
hypothesis takes a fault off one sensor. The one that explains a contradiction has to leave none
behind, and no other sensor's may explain as much. Where no hypothesis explains it, or several
sensors' do, all of them are named.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.heading import heading_by_rates
from hullrecon.findings.finding import Finding
from hullrecon.navigation.suspects.comparisons import (
    GAIN,
    RESTS_ON,
    Comparison,
    Flow,
    Motions,
    Sensor,
    compare,
    compare_rates,
)
from hullrecon.navigation.suspects.hypotheses import Hypothesis, hypotheses
from hullrecon.navigation.suspects.remedies import Conventions, find_remedy
from hullrecon.records.sensors import ImuSamples, SensorRecords
from hullrecon.rig import Rig

ALIKE = 4.0  # hypotheses whose chi-squares differ by less explain as much (navigation/clocks)
EXPLAINED = 0.4  # of a motion, which the residuals of a hypothesis that explains it stay below
GROSS = 0.6  # of a motion; a contradiction that size makes a path worthless
GROSS_SWING_RAD = 0.1  # of a heading: it moves a tenth of the way across
KEPT = 0.5  # of the rows of a comparison, which a hypothesis leaves to judge it by
SHOWN = 8  # hypotheses by contradiction that are listed
UNITS = ("unit", "gauge")  # faults of a pressure that are one of its unit
USUAL = {fault: rank for rank, fault in enumerate((*UNITS, "scale", "sign", "constant"))}
USUAL_ANGLE_DEG = 45  # of mounts
# Faults by any factor. One of the factors that are tried fits about as well as a cause whose factor
# is known: water's for focal lengths, a picture of half the size.
ANY_FACTOR = ("focal", "ranges", "scale")
KNOWN_FACTOR = ("medium", "size")
SAME_DEPTH_M = 0.5  # by which two readings of a pressure may differ that are one
BY_DEFAULT = Conventions()
FAULTS = 3  # that are looked for, one after the other


@dataclass(frozen=True, kw_only=True)
class Tried:
    """What a hypothesis explains."""

    sensor: Sensor
    fault: str
    value: str
    chi2: float  # of the comparisons that it may change, by this hypothesis
    chi2_before: float
    explains: bool

    def document(self) -> dict[str, object]:
        """Return the facts for JSON."""
        return {
            "sensor": str(self.sensor),
            "fault": self.fault,
            "value": self.value,
            "chi2": round(self.chi2, 1),
            "chi2_before": round(self.chi2_before, 1),
            "explains": self.explains,
        }


@dataclass(frozen=True, kw_only=True)
class Judged:
    """Records with what was put right, and what was found."""

    records: SensorRecords
    findings: list[Finding]
    tried: list[Tried]  # those that explain most, by contradiction
    depth_offset_m: float = 0.0  # by which the level of depths may be off, where it stepped


def judge(
    records: SensorRecords,
    rig: Rig,
    atmosphere_m: float,
    topics: Mapping[Sensor, str] = MappingProxyType({}),
    flows: Sequence[Flow] = (),
    given: Conventions = BY_DEFAULT,
) -> Judged:
    """Hold the sensors of a dive against each other.

    Parameters
    ----------
    records, rig
        The dive.
    atmosphere_m
        The air's pressure in metres of water, which was taken off the pressure.
    topics
        Of the sensors, for what is said.
    flows
        Features of neighbouring images.
    given
        What dive.toml says of the sensors, for the remedies.
    """
    findings: list[Finding] = []
    tried: list[Tried] = []
    for _ in range(FAULTS):
        motions = Motions(records, rig, flows)
        base = compare(motions)
        wrong = [c for c in base if c.accuses]
        if not wrong:
            break
        found = _try_all(motions, atmosphere_m, base)
        tried += [one for _, one in found[:SHOWN]]
        best = explain_best(found)
        sensors = list(dict.fromkeys(h.sensor for h, _ in best))
        late = [h for h, _ in best if h.fault == "clock"]
        if late:  # a swell repeats itself: of offsets that fit as well, the least
            least = min(late, key=lambda h: abs(h.late_s))
            values = {"sensor": str(least.sensor), "seconds": least.late_s}
            findings.append(Finding("sensors-late", values))
        elif best and best[0][0].fault == "rate":
            values = {"sensors": [str(s) for s in sensors], "per_cent": float(best[0][0].value)}
            findings.append(Finding("sensors-drift", values))
        elif len(sensors) != 1:
            findings.append(_describe_unknown(records, sensors, wrong, base))
        elif len(readings := _depths([h for h, _ in best])) > 1:
            where = topics.get(Sensor.PRESSURE, "")
            findings.append(Finding("pressure-unit-open", {"readings": readings}, where))
        elif best[0][0].exact:
            records = best[0][0].mended
            findings.append(_describe("sensor-mended", best[0][0], wrong, topics))
            continue
        else:
            found_wrong = _describe("sensor-wrong", best[0][0], wrong, topics)
            one = best[0][0]
            remedy = find_remedy(one.sensor, one.fault, one.value, given, rig.tray_from_dvl)
            values = {**found_wrong.values, "remedy": remedy}
            findings.append(replace(found_wrong, values=values))
        break
    return Judged(records=records, findings=findings, tried=tried)


def explain_best(found: Sequence[tuple[Hypothesis, Tried]]) -> list[tuple[Hypothesis, Tried]]:
    """Select the hypotheses that explain most. `found` begins with those that leave least."""
    best = [(h, one) for h, one in found if one.explains]
    if any(h.fault in UNITS for h, _ in best):  # a sensor left out has no residuals at all
        best = [(h, one) for h, one in best if h.fault != "constant"]
    best = [pair for pair in best if _explains_as_much(*pair, *best[0])]
    if any(h.fault in KNOWN_FACTOR for h, _ in best):
        best = [(h, one) for h, one in best if h.fault not in ANY_FACTOR]
    return sorted(best, key=lambda pair: _rank(pair[0]))


def _explains_as_much(one: Hypothesis, tried: Tried, best: Hypothesis, least: Tried) -> bool:
    """Tell whether a hypothesis explains as much as the best.

    To the comparison of depths with velocities, a factor of the depths and its reciprocal of the
    velocities are the same but for the noise, which grows with the factor.
    """
    factors = one.fault == best.fault == "scale"
    return tried.chi2 < least.chi2 + (GAIN if factors else ALIKE)


def _rank(one: Hypothesis) -> int:
    """Order readings of a pressure, mount angles and axes of orientations by how usual they are."""
    if one.sensor is Sensor.ATTITUDE and one.fault == "axes":
        return 1
    if one.fault in ("turn", "mount"):
        return int(int(one.value) % USUAL_ANGLE_DEG != 0)
    if one.sensor is Sensor.TRAY:
        # where the zero explains as much as a unit: in degrees the angles would swing by 57 times
        # as much
        return int(one.fault != "zero")
    return USUAL.get(one.fault, len(USUAL)) if one.sensor is Sensor.PRESSURE else 0


def _depths(best: Sequence[Hypothesis]) -> list[list[object]]:
    """List the readings of a pressure that explain it best: fault, unit, least and greatest depth.

    Empty where all explain another sensor. A pressure in one unit is taken as absolute, not as
    above the air's.
    """
    absolute = {one.value for one in best if one.fault == "unit"}
    out: list[list[object]] = []
    medians: list[float] = []
    for one in best:
        pressure = one.mended.pressure
        if one.sensor is not Sensor.PRESSURE or pressure is None or one.fault not in UNITS:
            continue
        low, median, high = map(float, np.percentile(pressure.depth, [5, 50, 95]))
        is_known = one.fault == "gauge" and one.value in absolute
        if not is_known and all(abs(median - other) > SAME_DEPTH_M for other in medians):
            medians.append(median)
            out.append([one.fault, one.value, low, high])
    return out


def _try_all(
    motions: Motions,
    atmosphere_m: float,
    base: Sequence[Comparison],
) -> list[tuple[Hypothesis, Tried]]:
    """Make the comparisons again under each hypothesis. Those that explain most come first.

    A hypothesis that leaves a contradiction explains nothing. Only the SHOWN best are compared with
    all sensors, and none that could not come near the best even if those comparisons left nothing.
    """
    # Take each hypothesis to the contradictions in which its sensor has a part: does it solve them?
    wrong = sorted((c for c in base if c.accuses), key=lambda c: list(RESTS_ON).index(c.kind))
    suspects = frozenset().union(*(c.sensors for c in wrong))
    before = sum(c.chi2 for c in base)
    solved: list[tuple[float, Hypothesis, _Again]] = []
    unsolved: list[tuple[float, Hypothesis, _Again]] = []
    records, flows, camera = motions.records, motions.flows, motions.rig.top
    for one in hypotheses(records, suspects, atmosphere_m, flows, camera):
        own = [c for c in wrong if one.sensor in c.sensors]
        is_constant = one.fault == "constant"
        if not own or (is_constant and not all(c.stands_still for c in own if c.second.any())):
            continue
        again = _Again(one, motions)
        left = None if is_constant else next((c for c in own if not again.solves(c)), None)
        if left is None:
            # at best, comparisons not made again yet fall to nothing
            gain = sum(c.chi2 - _chi2_left(c, again.made(c.kind)) for c in own)
            gain += sum(c.chi2 for c in base if one.sensor in c.sensors and not c.accuses)
            solved.append((before - gain, one, again))
        else:
            worse = _chi2_left(left, again.made(left.kind)) - left.chi2
            unsolved = sorted([*unsolved, (worse, one, again)], key=lambda found: found[0])[:SHOWN]
    # Make the other comparisons of those that may still be the best, and of some that failed.
    tried: list[tuple[Hypothesis, Tried]] = []
    best = np.inf
    for least, one, again in sorted(solved, key=lambda found: found[0]):
        if least <= best + GAIN or len(tried) < SHOWN:
            tried.append((one, _weigh(one, base, again)))
            best = min(best, tried[-1][1].chi2) if tried[-1][1].explains else best
    for _, one, again in unsolved:
        tried.append((one, _weigh(one, base, again)))
    return sorted(tried, key=lambda pair: (not pair[1].explains, pair[1].chi2))


class _Again:
    """Comparisons under a hypothesis, each made when it is asked for."""

    def __init__(self, one: Hypothesis, before: Motions) -> None:
        flows = before.flows if one.flows is None else one.flows
        self._motions = Motions(one.mended, before.rig, flows, before)
        self._made: dict[str, Comparison | None] = {}

    def made(self, kind: str) -> Comparison | None:
        """Make a comparison of one kind. None without readings or motion enough."""
        if kind not in self._made:
            found = compare(self._motions, {kind})
            self._made |= {kind: None, **{c.kind: c for c in found}}
        return self._made[kind]

    def solves(self, before: Comparison) -> bool:
        """Tell whether the hypothesis explains a contradiction, not by having fewer rows."""
        after = self.made(before.kind)
        if after is None or len(after.residual) < KEPT * len(before.residual):
            return False
        return after.misfit < EXPLAINED or (before.is_reversed and not after.is_contradiction)


def _weigh(one: Hypothesis, base: Sequence[Comparison], again: _Again) -> Tried:
    """Tell what a hypothesis explains, by the comparisons that its sensor has a part in."""
    own = [c for c in base if c.accuses and one.sensor in c.sensors]
    before = sum(c.chi2 for c in base)
    chi2 = before + sum(
        _chi2_left(c, again.made(c.kind)) - c.chi2 for c in base if one.sensor in c.sensors
    )
    solved = one.fault == "constant" or all(again.solves(c) for c in own)
    after = [again.made(kind) for kind, sensors in RESTS_ON.items() if one.sensor in sensors]
    sound = not any(c.accuses for c in after if c is not None)
    gains = chi2 < before - GAIN or any(c.is_reversed for c in own)
    return Tried(
        sensor=one.sensor,
        fault=one.fault,
        value=one.value,
        chi2=chi2,
        chi2_before=before,
        explains=solved and sound and gains,
    )


def _chi2_left(before: Comparison, after: Comparison | None) -> float:
    """Compute chi-square under a hypothesis. Rows that it loses cost what they did, at most one."""
    kept = after.chi2 if after is not None else 0.0
    lost = len(before.residual) - (len(after.residual) if after is not None else 0)
    return kept + max(0, lost) * min(1.0, before.chi2 / max(1, len(before.residual)))


def _describe(
    code: str, one: Hypothesis, wrong: Sequence[Comparison], topics: Mapping[Sensor, str]
) -> Finding:
    """Say what is wrong with a sensor, and by which comparison."""
    own = max((c for c in wrong if one.sensor in c.sensors), key=lambda c: c.chi2)
    values = {"sensor": str(one.sensor), "fault": one.fault, "value": one.value, **_facts(own)}
    return Finding(code, values, topics.get(one.sensor, ""))


def _describe_unknown(
    records: SensorRecords,
    sensors: Sequence[Sensor],
    wrong: Sequence[Comparison],
    base: Sequence[Comparison],
) -> Finding:
    """Name the sensors that contradict each other where it is not known which is wrong.

    Those that agree with another one, and a tray that was not logged, are left out.
    """
    worst = max(wrong, key=lambda c: c.chi2)
    agree = [c.sensors for c in base if len(c.sensors) > 1 and c not in wrong and not c.vouches]
    if worst.kind == "turn":  # gravity and depth tell nothing of an orientation that stands still
        agree = []
    named = [s for s in Sensor if s in worst.sensors and not any(s in c for c in agree)]
    named = [s for s in named if s is not Sensor.TRAY or records.tray is not None]
    facts = _facts(worst)
    swing_rad = _swing(records.imu) if worst.kind == "turn" and records.imu is not None else 0.0
    if swing_rad:
        facts["kind"] = "heading"
    is_gross = worst.misfit > GROSS or swing_rad > GROSS_SWING_RAD
    sensors_named = [str(s) for s in sensors or named or sorted(worst.sensors)]
    return Finding(
        "sensors-contradict" if is_gross else "sensors-part", {"sensors": sensors_named, **facts}
    )


def _swing(imu: ImuSamples) -> float:
    """Measure by how much the orientation's heading swings about that of the rates, rad.

    0 where the two contradict each other about other axes than the vertical too.
    """
    turned = heading_by_rates(imu.t_ns, Rotation.from_quat(imu.quaternion), imu.angular_velocity)
    again = compare_rates(replace(imu, quaternion=turned.rotation.as_quat()))
    return 0.0 if again is None or again.is_contradiction else turned.swing_rad


def _facts(comparison: Comparison) -> dict[str, object]:
    first, second = (float(np.abs(one).max()) for one in (comparison.first, comparison.second))
    return {"kind": comparison.kind, "first": first, "second": second, "misfit": comparison.misfit}
