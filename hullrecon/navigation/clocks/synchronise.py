# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Estimate and correct the time offsets of DVL, IMU, pressure sensor and cameras.

An offset says by how much stamps are late: it is subtracted from them.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TypeVar

import numpy as np

from hullrecon.dive.logs.timeline import JUMP_S
from hullrecon.geometry.poses import from_matrix
from hullrecon.navigation.clocks.comparisons.comparison import ClockComparison, ClockedSensor, Span
from hullrecon.navigation.clocks.comparisons.dvl import (
    compare_accelerations,
    compare_depth,
    compare_hull_turns,
)
from hullrecon.navigation.clocks.comparisons.images import (
    LEAST_MOTIONS,
    ImageMotions,
    compare_directions,
    compare_turns,
)
from hullrecon.navigation.clocks.evidence import FAR_S, Evidence, weigh_comparisons
from hullrecon.navigation.clocks.remaining_offsets import remaining_offset_sigmas
from hullrecon.navigation.clocks.time_offsets import (
    TimeOffset,
    choose_by_segment,
    segments,
    time_offsets,
)
from hullrecon.navigation.clocks.wrong_clocks import WrongClocks, find_wrong_clocks
from hullrecon.navigation.dead_reckoning.dead_reckon import (
    MotionReadings,
    NavigationLogs,
    usable_frames,
    usable_readings,
)
from hullrecon.navigation.dead_reckoning.image_walk import STRIDE_S
from hullrecon.navigation.dead_reckoning.nodes import pair_frames
from hullrecon.navigation.sensors.attitude import AttitudeHistory
from hullrecon.navigation.sensors.servo import servo
from hullrecon.navigation.sensors.velocity import Velocities
from hullrecon.records.clock import NS, format_time
from hullrecon.rig import Rig
from hullrecon.typing import Array, Ints

# runs of images whose motion is measured, in a dive and at least in a segment, and images of a run
RUNS, LEAST_RUNS, RUN_FRAMES = 6, 3, 6
MOST_PAUSES = 4  # of a stream, the longest; a stream with more loses readings all the time
SAME_S = 0.1  # offsets of two hypotheses that differ by less are the same
KEYS = {  # of dive.toml, whose values are added to the stamps (an offset with the other sign)
    ClockedSensor.DVL: "dvl.time_offset",
    ClockedSensor.IMU: "imu.time_offset",
    ClockedSensor.PRESSURE: "pressure.time_offset",
    ClockedSensor.IMAGES: "camera.*.time_offset",
}

# Measures the motion between two images, given by their rows in the upper camera's index:
# second_from_first (4, 4) with a translation of any length, and the sigmas (2,), rad, of its turn
# and direction. None where the images do not determine it.
MeasureMotion = Callable[[int, int], tuple[Array, Array] | None]
Stream = TypeVar("Stream")


@dataclass(frozen=True, kw_only=True)
class Synchronised:
    """Logs with their clocks corrected."""

    logs: NavigationLogs
    # velocities and attitude of these logs; None where clocks were corrected
    readings: MotionReadings | None
    offsets: list[TimeOffset]  # that were corrected
    # in words: corrections, and clocks that disagree where it is not known which of them is wrong
    remarks: list[str]
    # sigma of each sensor's remaining time offset relative to the IMU; empty where images are
    # compared
    late_sigma_s: Mapping[ClockedSensor, float]


def synchronise(
    logs: NavigationLogs,
    rig: Rig,
    tilt_rad: float,
    measure: MeasureMotion | None = None,
) -> Synchronised:
    """Correct the time offsets of a dive's sensors, as far as it is known whose clock is wrong.

    Clocks that disagree where this is not known are left as they are, and a remark says so.

    Parameters
    ----------
    logs
        What the sensors logged, streams in time order.
    rig
        Where sensors sit, as all of them measure the motion of one vehicle.
    tilt_rad
        Sigma of roll and pitch where the IMU's rates do not tell it.
    measure
        Measures the motion between two images, None without a camera.
    """
    # Segments between pauses of any sensor, at which its clock may have jumped.
    frames = usable_frames(None if measure is None else logs.top)
    spans = _segments_between_pauses(logs, frames[0])

    # Compare the clocks of two sensors each, by the motion that both measured.
    readings, motions = usable_readings(logs, tilt_rad), None
    if measure is not None and len(frames[0]):
        motions = _measure_motions(frames, spans, measure, readings.velocities, readings.attitude)
        motions = motions if len(motions) >= LEAST_MOTIONS else None
    comparisons = _compare_clocks(logs, readings, rig, motions)

    # Explain the dive as a whole and each segment, then choose for each segment among all
    # explanations.
    evidence, parts = weigh_comparisons(comparisons), []
    if len(spans) > 1:
        parts = [weigh_comparisons([c.within(part) for c in comparisons]) for part in spans]
    hypotheses, ambiguous = _explain_clocks([evidence, *parts])
    states = [hypothesis.corrections() for hypothesis in hypotheses]
    chosen = [hypotheses[k] for k in choose_by_segment(evidence, spans, states)]

    # Without images, offsets too small to be corrected may remain. The longest segment, with most
    # rows, bounds them.
    late_sigma_s = {}
    if motions is None:
        k = int(np.argmax([end - begin for begin, end in spans]))
        late_sigma_s = remaining_offset_sigmas(
            parts[k] if parts else evidence, chosen[k].corrections(), spans[k]
        )
    compared = {sensor for c in comparisons for sensor in (c.first, c.second)}
    offsets = time_offsets(
        spans, chosen, [sensor for sensor in ClockedSensor if sensor in compared]
    )
    remarks = [*describe_offsets(offsets), *([] if offsets else dict.fromkeys(ambiguous))]
    return Synchronised(
        logs=_correct_logs(logs, offsets),
        readings=None if offsets else readings,
        offsets=offsets,
        remarks=remarks,
        late_sigma_s=late_sigma_s,
    )


def _segments_between_pauses(logs: NavigationLogs, frames_ns: Ints) -> list[Span]:
    """Cut the dive where a sensor pauses. frames_ns: stamps of the images that are compared."""
    stamps = [logs.dvl.t_ns, logs.imu.t_ns]
    if logs.pressure is not None:
        stamps.append(logs.pressure.t_ns)
    if len(frames_ns):
        stamps.append(frames_ns)
    span = min(int(t_ns[0]) for t_ns in stamps), max(int(t_ns[-1]) for t_ns in stamps)
    return segments((t for t_ns in stamps for t in _longest_pauses(t_ns)), span)


def _explain_clocks(
    by_part: Sequence[Sequence[Evidence]],
) -> tuple[list[WrongClocks], list[str]]:
    """Find whose clocks are wrong by the evidence of the dive and of each segment.

    Returns
    -------
    tuple
        The hypotheses, each once, of which the first is that all clocks are right. In words, clocks
        that disagree where it is not known which of them is wrong.
    """
    hypotheses, ambiguous = [find_wrong_clocks([])[0]], []
    for own in by_part:
        found = find_wrong_clocks(own)
        if len(found) > 1:
            ambiguous.append(_describe_ambiguous(found))
        elif not any(_are_same(found[0], other) for other in hypotheses):
            hypotheses.append(found[0])
    return hypotheses, ambiguous


def _compare_clocks(
    logs: NavigationLogs, readings: MotionReadings, rig: Rig, motions: ImageMotions | None
) -> list[ClockComparison]:
    """Compare the clocks of all sensors, two by two.

    readings: attitude and velocities by the sensors' own clocks. motions: of the upper camera
    between images, None without images. Where images show the motion they are compared with IMU and
    DVL, else these with each other. There may be none, as where neither images nor a pressure were
    logged, and IMU and DVL ran a minute apart.
    """
    attitude, tray = readings.attitude, servo(logs.tray, int(logs.dvl.t_ns[0]))
    made: list[ClockComparison | None] = []
    if motions is not None:
        made.append(compare_turns(motions, attitude, tray, rig))
        made.append(compare_directions(motions, readings.velocities, rig))
    elif not _is_a_minute_off(logs):
        made.append(compare_hull_turns(logs.dvl, attitude, tray, rig))
        made.append(compare_accelerations(logs.dvl, logs.imu, attitude, tray, rig))
    if logs.pressure is not None:
        made.append(compare_depth(logs.dvl, attitude, logs.pressure, tray, rig))
    return [comparison for comparison in made if comparison is not None]


def _are_same(first: WrongClocks, second: WrongClocks) -> bool:
    """Tell whether two hypotheses correct the same sensors by the same offsets, to SAME_S."""
    one, other = first.corrections(), second.corrections()
    return one.keys() == other.keys() and all(abs(one[s] - other[s]) < SAME_S for s in one)


def _describe_ambiguous(equivalent: Sequence[WrongClocks]) -> str:
    """Describe clocks that disagree where several hypotheses explain them equally well.

    equivalent: these hypotheses, each with at least one wrong clock.
    """
    sensors = dict.fromkeys(sensor for hypothesis in equivalent for sensor in hypothesis.wrong)
    first = equivalent[0].wrong[0]
    return (
        f"{' and '.join(sensors)}: their clocks differ by "
        f"{abs(equivalent[0].offsets[first]):.2f} s (sigma {equivalent[0].sigma_s[first]:.3f} s); "
        "which of them is wrong is not known, and they were left as they are"
    )


def _is_a_minute_off(logs: NavigationLogs) -> bool:
    """Tell whether the IMU began and ended a minute before, or after, the DVL.

    Such an offset is larger than those that are searched, and a smaller one might fit by chance.
    """
    began_s, ended_s = ((logs.imu.t_ns[end] - logs.dvl.t_ns[end]) / NS for end in (0, -1))
    return bool(min(abs(began_s), abs(ended_s)) > FAR_S and began_s * ended_s > 0)


def _longest_pauses(t_ns: Ints) -> list[int]:
    """Find the middles (ns) of a stream's longest pauses, where its clock may have jumped.

    At most MOST_PAUSES are listed, and only those longer than usual by JUMP_S. Empty without any.
    """
    step = np.diff(t_ns)
    if not len(step):
        return []
    long = np.flatnonzero(step - np.median(step) >= JUMP_S * NS)
    longest = long[np.argsort(-step[long], kind="stable")[:MOST_PAUSES]]
    return [int(t) for t in t_ns[longest] + step[longest] // 2]


def _measure_motions(
    frames: tuple[Ints, Ints],
    spans: Sequence[Span],
    measure: MeasureMotion,
    velocities: Velocities,
    attitude: AttitudeHistory,
) -> ImageMotions:
    """Measure the upper camera's motion in some runs of images of each segment.

    With them the clock of the images is compared with those of DVL and IMU. Motions in outages of
    these, and beyond their records, are left out. So are motions that the images do not determine.
    There may be none.

    Parameters
    ----------
    frames
        Stamps and rows of the upper camera's usable images.
    spans
        The segments (first and last instant), each of which gets runs of its own.
    measure
        Measures the motion between two images.
    velocities, attitude
        When DVL and IMU were read, with their outages.
    """
    t_ns, row = frames
    ends = [stream.t_ns[[0, -1]] for stream in (velocities, attitude) if len(stream.t_ns)]
    begin, end = max(e[0] for e in ends), min(e[1] for e in ends)
    outages = np.concatenate([velocities.outages, attitude.holes])
    found = []
    for span in spans:
        inside = np.flatnonzero((t_ns >= span[0]) & (t_ns <= span[1]))
        for run in choose_runs(t_ns, inside, max(LEAST_RUNS, RUNS // len(spans))):
            for a, b in itertools.pairwise(run):
                in_outage = (outages[:, 0] < t_ns[b]) & (outages[:, 1] > t_ns[a])
                if t_ns[a] < begin or t_ns[b] > end or in_outage.any():
                    continue
                motion = measure(int(row[a]), int(row[b]))
                if motion is not None:
                    found.append((t_ns[a], t_ns[b], *motion))
    return ImageMotions(
        first_ns=np.array([one[0] for one in found], np.int64),
        second_ns=np.array([one[1] for one in found], np.int64),
        second_from_first=from_matrix(np.array([one[2] for one in found]).reshape(-1, 4, 4)),
        sigma_rad=np.array([one[3] for one in found]).reshape(-1, 2),
    )


def choose_runs(t_ns: Ints, inside: Ints, runs: int) -> list[list[int]]:
    """Choose runs of frames, spread evenly over some rows, with STRIDE_S between frames of a run.

    A few runs tell the offset of a whole segment at little cost. Spacings may be a tenth shorter,
    as frames have jitter. A run has at most RUN_FRAMES
    frames, and may have a single one. Fewer runs than asked for are chosen where there are few
    rows, and none from fewer than two.

    Parameters
    ----------
    t_ns
        Stamps of all frames.
    inside
        Rows (m,) to choose from.
    runs
        How many runs to choose, at most.
    """
    if len(inside) < 2:
        return []
    starts = np.unique(np.linspace(inside[0], inside[-1], runs + 2)[1:-1].astype(int)).tolist()
    out = []
    for start, end in zip(starts, [*starts[1:], int(inside[-1]) + 1], strict=True):
        chosen = [start]
        for k in range(start + 1, end):
            if len(chosen) < RUN_FRAMES and t_ns[k] - t_ns[chosen[-1]] >= 0.9 * STRIDE_S * NS:
                chosen.append(k)
        out.append(chosen)
    return out


def corrected_stamps(t_ns: Ints, offsets: Sequence[TimeOffset], sensor: ClockedSensor) -> Ints:
    """Subtract a sensor's offsets, each in its span, from its stamps (n,)."""
    out = t_ns.copy()
    for offset in offsets:
        if offset.sensor is sensor:
            out[(t_ns >= offset.from_ns) & (t_ns <= offset.to_ns)] -= round(offset.seconds * NS)
    return out


def _correct_logs(logs: NavigationLogs, offsets: Sequence[TimeOffset]) -> NavigationLogs:
    """Subtract the offsets from the stamps of the logs, and sort the readings again.

    Both cameras are shifted alike, unless the lower one pairs better as it was. The tray's clock is
    not compared, so its stamps stay as they are.
    """
    wrong = {offset.sensor for offset in offsets}

    def moved(record: Stream, sensor: ClockedSensor) -> Stream:
        """Subtract the offsets of a sensor. Unchanged if its clock is right."""
        if record is None or sensor not in wrong:
            return record
        stamps: Ints = record.t_ns  # type: ignore[attr-defined]
        return replace(record, t_ns=corrected_stamps(stamps, offsets, sensor))  # type: ignore[type-var]

    top, bottom = moved(logs.top, ClockedSensor.IMAGES), moved(logs.bottom, ClockedSensor.IMAGES)
    if top is not None and bottom is not None and logs.bottom is not None:
        # both cameras share a clock, unless the lower camera pairs better uncorrected
        pairs = [
            len(pair_frames(np.sort(top.t_ns), np.sort(lower.t_ns)))
            for lower in (bottom, logs.bottom)
        ]
        bottom = bottom if pairs[0] >= pairs[1] else logs.bottom
    return replace(
        logs,
        dvl=_in_order(moved(logs.dvl, ClockedSensor.DVL)),
        imu=_in_order(moved(logs.imu, ClockedSensor.IMU)),
        pressure=_in_order(moved(logs.pressure, ClockedSensor.PRESSURE)),
        top=top,
        bottom=bottom,
    )


def _in_order(record: Stream) -> Stream:
    """Sort a record whose offset changes along the dive, and drop rows whose stamp repeats then.

    Later offsets may move readings before earlier ones. A record in order is returned as it is.
    """
    if record is None:
        return record
    stamps: Ints = record.t_ns  # type: ignore[attr-defined]
    if (np.diff(stamps) > 0).all():
        return record
    rows = np.unique(stamps, return_index=True)[1]
    kept = {
        field.name: value[rows]
        for field in fields(record)  # type: ignore[arg-type]
        if field.name not in ("beams", "directions", "range_m")
        and (value := getattr(record, field.name)).shape[:1] == stamps.shape
    }
    return replace(record, **kept)  # type: ignore[type-var]


def describe_offsets(offsets: Sequence[TimeOffset]) -> list[str]:
    """Describe by how much each sensor's clock was wrong, one sentence for each sensor.

    offsets: sorted by sensor, then by time.
    """
    out = []
    for sensor, parts in itertools.groupby(offsets, key=lambda offset: offset.sensor):
        found = list(parts)
        spans = ", ".join(
            f"{abs(part.seconds):.2f} s {'late' if part.seconds > 0 else 'early'} "
            f"(sigma {part.sigma_s:.3f} s) from {format_time(part.from_ns)} "
            f"to {format_time(part.to_ns)}"
            for part in found
        )
        *most, last = found[0].relative_to
        others = f"those of {', '.join(most)} and {last}" if most else f"that of {last}"
        out.append(
            f"{sensor}: the clock is {spans}, relative to {others}; the stamps were put right"
            f"{_describe_key(found)}"
        )
    return out


def _describe_key(found: Sequence[TimeOffset]) -> str:
    """Say by how much to change the key of dive.toml that corrects a clock.

    "" where the offset changes along the dive.
    """
    if len(found) > 1:
        return ""
    side = "lower" if found[0].seconds > 0 else "higher"
    key = KEYS[found[0].sensor]
    return f", as {key} {side} by {abs(found[0].seconds):.2f} does for a whole log"
