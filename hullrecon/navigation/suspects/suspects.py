# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find the sensor that contradicts the others, and correct it, leave it out, or name it.

See docs/methods.md, Suspects. Comparisons of two sensors show where a dive contradicts itself. Each
hypothesis corrects a fault of one sensor. It explains the contradictions of that sensor if they
vanish with it. A sensor is at fault where no hypothesis of another sensor explains as much. Where
no hypothesis explains them, or hypotheses of several sensors do, all of these sensors are named.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.heading import heading_by_rates
from hullrecon.findings.finding import Finding
from hullrecon.geometry.robust import ALIKE, GAIN
from hullrecon.navigation.suspects.comparisons.comparison import Comparison, Sensor
from hullrecon.navigation.suspects.comparisons.images import Flow
from hullrecon.navigation.suspects.comparisons.imu import compare_rates
from hullrecon.navigation.suspects.comparisons.motions import DEPENDS_ON, Motions, compare
from hullrecon.navigation.suspects.faults.axes import BY_DEFAULT, Conventions
from hullrecon.navigation.suspects.faults.hypothesis import Hypothesis
from hullrecon.navigation.suspects.hypotheses import hypotheses
from hullrecon.navigation.suspects.remedies import find_remedy
from hullrecon.records.sensors import ImuSamples, SensorRecords
from hullrecon.rig import Rig

EXPLAINED = 0.4  # residuals of a hypothesis, as a share of the motion, below which it is explained
GROSS = 0.6  # residuals as a share of the motion, above which a path would be worthless
GROSS_SWING_RAD = 0.1  # swing of a heading: a path then errs sideways by a tenth of its length
KEPT = 0.5  # share of a comparison's rows that must remain under a hypothesis to judge it
SHOWN = 8  # hypotheses that are listed for each contradiction
UNITS = ("unit", "gauge")  # faults of a pressure that concern its unit
# faults of a pressure, the usual ones first
USUAL = {fault: rank for rank, fault in enumerate((*UNITS, "scale", "sign", "constant"))}
OF_RATES = ("turn", "heading")  # comparisons of an IMU's rates with its orientation
LARGEST_TURN_DEG = 5  # of a mount that the adjustment believes (adjustment/contradictions)
USUAL_ANGLE_DEG = 45  # mounts are usually turned by multiples of it
# Faults by an arbitrary factor. One of the factors that are tried fits about as well as a cause
# whose factor is known: the medium of focal lengths, a picture of half the size, a unit. The cause
# counts.
ANY_FACTOR = ("focal", "ranges", "scale")
KNOWN_FACTOR = ("medium", "port", "size", "unit")
SAME_DEPTH_M = 0.5  # median depths by two interpretations that differ by less are the same
ORDERS_SHOWN = 2  # of a DVL's beams
FAULTS = 3  # that are sought, one after the other


@dataclass(frozen=True, kw_only=True)
class Tried:
    """A hypothesis that was tried, and what it explains."""

    sensor: Sensor
    fault: str
    value: str
    chi2: float  # of all comparisons, under this hypothesis, and GAIN for each further fault
    chi2_before: float  # of all comparisons, as the dive was logged
    explains: bool

    def document(self) -> dict[str, object]:
        """List the facts, by their names in JSON."""
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
    """Result of judging the sensors of a dive."""

    records: SensorRecords  # with faults corrected where that is possible
    findings: list[Finding]
    tried: list[Tried]  # for each contradiction, the hypotheses that explain most
    depth_offset_m: float = 0.0  # by which the level of depths may be off, where it stepped
    heading_drift_sigma_rad_s: float = 0.0  # of a heading that was taken from the rates
    chi2: float = np.inf  # of all comparisons without the faults; infinite where none explain them

    @property
    def cost(self) -> float:
        """Chi-square without the faults, and GAIN for each of them."""
        return self.chi2 + GAIN * len(self.findings)


def judge(
    records: SensorRecords,
    rig: Rig,
    atmosphere_m: float,
    topics: Mapping[Sensor, str] = MappingProxyType({}),
    flows: Sequence[Flow] = (),
    given: Conventions = BY_DEFAULT,
) -> Judged:
    """Compare the sensors of a dive with each other, and find the one that is wrong.

    Up to FAULTS faults are sought one after the other, as long as each can be corrected exactly.

    Parameters
    ----------
    records, rig
        The dive.
    atmosphere_m
        The air's pressure in metres of water, which was subtracted from the pressure.
    topics
        Of the sensors, for the findings.
    flows
        Features of neighbouring images.
    given
        What dive.toml says of the sensors, for the remedies.
    """
    findings: list[Finding] = []
    tried: list[Tried] = []
    drift_sigma_rad_s, chi2 = 0.0, np.inf
    for _ in range(FAULTS):
        motions = Motions(records, rig, flows)
        base = compare(motions)
        wrong = [c for c in base if c.accuses]
        if not wrong:
            chi2 = sum(c.chi2 for c in base)
            break
        found = _try_all(motions, atmosphere_m, base, given)  # those that explain most first
        tried += [one for _, one in found[:SHOWN]]
        best = explain_best(found)
        sensors = list(dict.fromkeys(h.sensor for h, _ in best))
        late = [h for h, _ in best if h.fault == "clock"]
        # What can be reported of the fault: a clock, a drift, several sensors, several units of a
        # pressure, a fault that is corrected (then the next one is sought), or one that is not.
        if late:  # a swell repeats itself, so of offsets that fit as well the smallest is reported
            least = min(late, key=lambda h: abs(h.late_s))
            values = {"sensor": str(least.sensor), "seconds": least.late_s}
            findings.append(Finding("sensors-late", values))
            chi2 = best[0][1].chi2
        elif best and best[0][0].fault == "rate":
            values = {"sensors": [str(s) for s in sensors], "per_cent": float(best[0][0].value)}
            findings.append(Finding("sensors-drift", values))
        elif len(sensors) != 1:
            findings.append(_describe_unknown(records, [h for h, _ in best], wrong, base))
        elif len(units := possible_units([h for h, _ in best])) > 1:
            where = topics.get(Sensor.PRESSURE, "")
            findings.append(Finding("pressure-unit-open", {"readings": units}, where))
        elif best[0][0].exact:
            records = best[0][0].mended
            drift_sigma_rad_s = max(drift_sigma_rad_s, best[0][0].heading_drift_sigma_rad_s)
            findings.append(describe_fault("sensor-mended", best[0][0], wrong, topics))
            continue
        else:
            found_wrong = describe_fault("sensor-wrong", best[0][0], wrong, topics)
            one = best[0][0]
            remedy = find_remedy(one.sensor, one.fault, one.value, given, rig.tray_from_dvl)
            values = {**found_wrong.values, "remedy": remedy}
            if one.fault == "beams":
                values["value"] = possible_orders([h for h, _ in best])
            findings.append(replace(found_wrong, values=values))
            chi2 = best[0][1].chi2
        break
    return Judged(
        records=records,
        findings=findings,
        tried=tried,
        heading_drift_sigma_rad_s=drift_sigma_rad_s,
        chi2=chi2,
    )


def explain_best(found: Sequence[tuple[Hypothesis, Tried]]) -> list[tuple[Hypothesis, Tried]]:
    """Select the hypotheses that explain most, the usual ones first.

    found: all hypotheses that were tried, by growing chi-square.
    """
    best = [(h, one) for h, one in found if one.explains]
    # leaving the sensor out always has the least chi-square, as no residuals of it remain
    if any(h.fault in UNITS for h, _ in best):
        best = [(h, one) for h, one in best if h.fault != "constant"]
    best = [pair for pair in best if _explains_as_much(*pair, *best[0])]
    if any(h.fault in KNOWN_FACTOR for h, _ in best):
        best = [(h, one) for h, one in best if h.fault not in ANY_FACTOR]
    return sorted(best, key=lambda pair: rank_by_usualness(pair[0]))


def _explains_as_much(one: Hypothesis, tried: Tried, best: Hypothesis, least: Tried) -> bool:
    """Tell whether a hypothesis explains as much as the best one.

    The comparison of depths with velocities cannot tell a factor of the depths from its reciprocal
    of the velocities, except by the noise, which grows with the factor. So a larger difference of
    chi-square is allowed between two scales.

    one, tried: the hypothesis, and its result. best, least: those of the best one.
    """
    are_scales = one.fault == best.fault == "scale"
    return tried.chi2 < least.chi2 + (GAIN if are_scales else ALIKE)


def rank_by_usualness(one: Hypothesis) -> int:
    """Rank a hypothesis by how usual its fault is, 0 for the most usual.

    It orders faults of a pressure and of a tray, angles of mounts and axes of orientations.
    """
    if one.sensor is Sensor.ATTITUDE and one.fault == "axes":
        return 1
    if one.fault in ("turn", "mount"):
        return int(int(one.value) % USUAL_ANGLE_DEG != 0)
    if one.sensor is Sensor.TRAY:
        # A reading near 1.57 is a zero that is off by a quarter of a turn, or a small angle in
        # degrees. Where both explain as much, the zero counts: a tray that is logged in degrees
        # would swing by 57 times as much.
        return int(one.fault not in ("zero", "reversed"))
    return USUAL.get(one.fault, len(USUAL)) if one.sensor is Sensor.PRESSURE else 0


def possible_units(best: Sequence[Hypothesis]) -> list[list[object]]:
    """List the units of a pressure that explain a contradiction equally well.

    With more than one, the user is asked which it is. Interpretations with the same depths count
    once. Where a unit fits both as absolute and as gauge pressure, only the absolute one is listed.

    Returns
    -------
    list of list
        Fault, unit, and least and greatest depth, m. Empty where another sensor is at fault.
    """
    absolute = {one.value for one in best if one.fault == "unit"}
    out: list[list[object]] = []
    medians: list[float] = []
    for one in best:
        pressure = one.mended.pressure
        if one.sensor is not Sensor.PRESSURE or pressure is None or one.fault not in UNITS:
            continue
        low, median, high = map(float, np.percentile(pressure.depth, [5, 50, 95]))
        is_listed = one.fault == "gauge" and one.value in absolute
        if not is_listed and all(abs(median - other) > SAME_DEPTH_M for other in medians):
            medians.append(median)
            out.append([one.fault, one.value, low, high])
    return out


def possible_orders(best: Sequence[Hypothesis]) -> str:
    """Say which order of the DVL's beams explains a contradiction, and how many do as well.

    A hull that stands square to the DVL hardly tells which of two neighbouring beams is which.
    """
    orders = [one.value for one in best if one.fault == "beams"]
    if len(orders) <= ORDERS_SHOWN:
        return " (or ".join(orders) + ")" * (len(orders) - 1)
    return f"{orders[0]} (or in one of {len(orders) - 1} other orders that fit as well)"


def _try_all(
    motions: Motions,
    atmosphere_m: float,
    base: Sequence[Comparison],
    given: Conventions,
) -> list[tuple[Hypothesis, Tried]]:
    """Repeat the comparisons under each hypothesis, and sort by what it explains.

    A hypothesis that leaves a contradiction explains nothing. To save time all comparisons of its
    sensor are repeated only for hypotheses that may still be the best, and for some others that are
    listed.

    motions, base: motions and comparisons of the dive as logged.
    """
    # Repeat the contradictions of each hypothesis' sensor: does it solve them?
    wrong = sorted((c for c in base if c.accuses), key=lambda c: list(DEPENDS_ON).index(c.kind))
    suspects = frozenset().union(*(c.sensors for c in wrong))
    before = sum(c.chi2 for c in base)
    # with a lower bound of chi-square
    solved: list[tuple[float, Hypothesis, RepeatedComparisons]] = []
    # with the growth of the chi-square of a contradiction that remains
    unsolved: list[tuple[float, Hypothesis, RepeatedComparisons]] = []
    records, flows = motions.records, motions.flows
    for one in hypotheses(records, suspects, atmosphere_m, motions.rig, flows, given):
        own = [c for c in wrong if one.sensor in c.sensors]
        is_constant = one.fault == "constant"
        if not own or (is_constant and not all(c.stands_still for c in own if c.second.any())):
            continue
        repeated = RepeatedComparisons(one, motions)
        remaining = None if is_constant else next((c for c in own if not repeated.solves(c)), None)
        if remaining is None:
            # the chi-square of comparisons that are not repeated yet falls to zero at best
            gain = sum(c.chi2 - repeated.chi2(c) for c in own)
            gain += sum(c.chi2 for c in base if one.sensor in c.sensors and not c.accuses)
            solved.append((before - gain, one, repeated))
        else:
            worse = repeated.chi2(remaining) - remaining.chi2
            unsolved = sorted([*unsolved, (worse, one, repeated)], key=lambda row: row[0])[:SHOWN]
    # Repeat all comparisons of hypotheses that may still be the best, and of some that failed.
    tried: list[tuple[Hypothesis, Tried]] = []
    best = np.inf
    for least, one, repeated in sorted(solved, key=lambda found: found[0]):
        if least <= best + GAIN or len(tried) < SHOWN:
            tried.append((one, _weigh_hypothesis(one, base, repeated)))
            best = min(best, tried[-1][1].chi2) if tried[-1][1].explains else best
    for _, one, repeated in unsolved:
        tried.append((one, _weigh_hypothesis(one, base, repeated)))
    return sorted(tried, key=lambda pair: (not pair[1].explains, pair[1].chi2))


class RepeatedComparisons:
    """Comparisons under a hypothesis, each made when it is asked for.

    before: motions as the dive was logged, of which unchanged parts are used again.
    """

    def __init__(self, one: Hypothesis, before: Motions) -> None:
        """Prepare comparisons with the records that a hypothesis corrects, and of the motions."""
        flows = before.flows if one.flows is None else one.flows
        self._motions = Motions(one.mended, before.rig, flows, before)
        self._untested = one.untested
        self._made: dict[str, Comparison | None] = {}

    def comparison(self, kind: str) -> Comparison | None:
        """Make a comparison of one kind, once. None without enough readings or motion."""
        if kind not in self._made:
            found = compare(self._motions, {kind})
            self._made |= {kind: None, **{c.kind: c for c in found}}
        return self._made[kind]

    def solves(self, before: Comparison) -> bool:
        """Tell whether the hypothesis explains a contradiction, and not by losing rows.

        before: the comparison as the dive was logged.
        """
        after = self.comparison(before.kind)
        if after is None or len(after.residual) < KEPT * len(before.residual):
            return False
        return after.misfit < EXPLAINED or (before.is_reversed and not after.is_contradiction)

    def chi2(self, before: Comparison) -> float:
        """Compute a comparison's chi-square under the hypothesis.

        Rows that are lost under it, or that agree whatever was logged, cost as much as before, but
        at most one each, so that losing them is no gain.

        before: the comparison as the dive was logged.
        """
        after = self.comparison(before.kind)
        kept = after.chi2 if after is not None else 0.0
        rows = len(before.residual)
        lost = rows - (len(after.residual) if after is not None else 0)
        lost += round(rows * self._untested.get(before.kind, 0.0))
        return kept + max(0, lost) * min(1.0, before.chi2 / max(1, rows))


def _weigh_hypothesis(
    one: Hypothesis, base: Sequence[Comparison], repeated: RepeatedComparisons
) -> Tried:
    """Tell whether a hypothesis explains the contradictions, by all comparisons of its sensor.

    It has to solve all contradictions of its sensor and cause no new one. It also has to lower
    chi-square by GAIN, unless a sign was reversed: large sigmas may hide that from chi-square. Each
    further fault that it corrects at once has to lower it by GAIN too, as with wrong clocks.
    """
    own = [c for c in base if c.accuses and one.sensor in c.sensors]
    before = sum(c.chi2 for c in base)
    chi2 = before + sum(repeated.chi2(c) - c.chi2 for c in base if one.sensor in c.sensors)
    chi2 += GAIN * (one.faults - 1)
    solved = one.fault == "constant" or all(repeated.solves(c) for c in own)
    after = [
        repeated.comparison(kind) for kind, sensors in DEPENDS_ON.items() if one.sensor in sensors
    ]
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


def describe_fault(
    code: str, one: Hypothesis, wrong: Sequence[Comparison], topics: Mapping[Sensor, str]
) -> Finding:
    """Make the finding of what is wrong with a sensor, with the comparison that shows it most.

    code: of the finding. one: the fault. wrong: comparisons that accuse a sensor.
    """
    own = max((c for c in wrong if one.sensor in c.sensors), key=lambda c: c.chi2)
    values = {"sensor": str(one.sensor), "fault": one.fault, "value": one.value, **_facts(own)}
    return Finding(code, values, topics.get(one.sensor, ""))


def _describe_unknown(
    records: SensorRecords,
    best: Sequence[Hypothesis],
    wrong: Sequence[Comparison],
    base: Sequence[Comparison],
) -> Finding:
    """Make the finding that sensors contradict each other, and it is not known which is wrong.

    Named are the sensors of the hypotheses, else those of the worst contradiction. Of the latter,
    sensors that agree with another one in some comparison are left out, and so is a tray that was
    not logged.

    Parameters
    ----------
    records
        The dive.
    best
        Hypotheses of several sensors that explain it equally well, empty where none does.
    wrong, base
        Comparisons that accuse a sensor, and all comparisons.
    """
    # where headings differ within a second too, this is the share of the motion
    quick = [c for c in wrong if c.kind != "heading"]
    worst = max(quick or wrong, key=lambda c: c.chi2)
    agreeing = [c for c in base if len(c.sensors) > 1 and c not in wrong and not c.is_coarse]
    agree = [c.sensors - c.unclear for c in agreeing]
    if worst.kind in OF_RATES:  # an orientation that stands still may agree with gravity and depth
        agree = []
    named = [s for s in Sensor if s in worst.sensors and not any(s in c for c in agree)]
    named = [s for s in named if s is not Sensor.TRAY or records.tray is not None]
    facts = _facts(worst)
    swing_rad = 0.0
    if worst.kind in OF_RATES and records.imu is not None:
        swing_rad = _heading_swing(records.imu)
    if swing_rad:
        facts["kind"] = "heading"
    # the headings' motion is small where a vehicle keeps its course: their swing itself counts
    is_worthless = worst.kind != "heading" and worst.misfit > GROSS
    is_gross = is_worthless or swing_rad > GROSS_SWING_RAD or any(map(_is_turned_far, best))
    sensors = list(dict.fromkeys(one.sensor for one in best))
    sensors_named = [str(s) for s in sensors or named or sorted(worst.sensors)]
    return Finding(
        "sensors-contradict" if is_gross else "sensors-part", {"sensors": sensors_named, **facts}
    )


def _is_turned_far(one: Hypothesis) -> bool:
    """Tell whether a hypothesis turns a sensor by more than the adjustment could correct."""
    if one.fault in ("turn", "mount"):
        return abs(int(one.value)) > LARGEST_TURN_DEG
    return one.fault in ("axes", "body", "frame")


def _heading_swing(imu: ImuSamples) -> float:
    """Measure by how much the orientation's heading swings about that of the rates, rad.

    0 where the two contradict each other also about other axes than the vertical, so that it is no
    compass that swings.
    """
    turned = heading_by_rates(imu.t_ns, Rotation.from_quat(imu.quaternion), imu.angular_velocity)
    again = compare_rates(replace(imu, quaternion=turned.rotation.as_quat()))
    return 0.0 if again is None or again.is_contradiction else turned.swing_rad


def _facts(comparison: Comparison) -> dict[str, object]:
    """Collect a finding's values: kind of comparison, largest motion by either side, misfit."""
    first, second = (float(np.abs(one).max()) for one in (comparison.first, comparison.second))
    return {"kind": comparison.kind, "first": first, "second": second, "misfit": comparison.misfit}
