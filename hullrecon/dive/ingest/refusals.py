# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Refuse packages whose logs hold no dive, several dives, or not what dive.toml names."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence

import numpy as np

from hullrecon.dive.check.time_overlap import clock_gaps
from hullrecon.dive.ingest.request import JOINT_KEYS, IngestRequest
from hullrecon.dive.ingest.result import IngestResult
from hullrecon.dive.logs.read_streams import LogContents
from hullrecon.dive.logs.readers.protocol import Loss
from hullrecon.dive.logs.readers.unpack import printable
from hullrecon.dive.logs.samples import JointSample
from hullrecon.dive.logs.time_window import TimeWindow
from hullrecon.dive.problems import Problems
from hullrecon.errors import InputError
from hullrecon.findings.finding import Finding
from hullrecon.records.clock import NS, format_time
from hullrecon.records.sensors import ImageIndex

# without a velocity; at a decimetre a second the vehicle may then be anywhere in a harbour
LONG_SILENCE_S = 3600.0


def check_found(
    out: IngestResult,
    request: IngestRequest,
    window: TimeWindow | None,
    losses: Sequence[tuple[str, Loss]],
    problems: Problems,
) -> None:
    """Refuse several dives in one, clocks that are apart, and a package without any reading.

    The latter is not refused where other problems were found, which explain it.

    Parameters
    ----------
    out : what was read
    request : what was asked for
    window : the time window, where it excluded measurements, else None
    losses : what of the logs could not be read, with the file's name
    problems : collects or raises what is refused
    """
    with problems.collect():
        _check_silence(out)
    for gap in clock_gaps({**out.records.by_name(), **out.images}, request.added_ns):
        if gap.severity == "error":
            problems.refuse(gap)
    if not out.records.by_name() and not out.images and not problems.found:
        with problems.collect():
            raise _nothing_read(request, window, [loss for _, loss in losses])


def _nothing_read(
    request: IngestRequest, window: TimeWindow | None, losses: Sequence[Loss]
) -> InputError:
    """Make the error that says why no sensor gave a reading: damage, the time window or topics."""
    if losses:
        return InputError(
            f"no sensor could be read from the logs: {losses[0].why}",
            where=", ".join(request.logs),
            remedy="give a log that is whole",
        )
    if window is not None:
        return InputError(
            f"nothing was measured {window.describe()}",
            where="dive.from",
            remedy="`hullrecon init LOG` says when a log begins",
        )
    return InputError(
        "no sensor could be read from the logs",
        where=", ".join(request.logs),
        remedy="`hullrecon init LOG` lists what a log holds; a run needs a DVL with an IMU, or two "
        "cameras, in [topics]",
    )


def _check_silence(found: IngestResult) -> None:
    """Raise InputError where the DVL is silent for LONG_SILENCE_S, without images in between.

    Nothing then tells how the vehicle moved, so the package holds several dives.
    """
    dvl = found.records.dvl
    if dvl is None or found.images:
        return
    t_ns = dvl.t_ns[np.isfinite(dvl.velocity).all(axis=1)]
    silent_s = np.diff(t_ns) / NS
    if not len(silent_s) or silent_s.max() < LONG_SILENCE_S:
        return
    at = int(silent_s.argmax())
    raise InputError(
        f"the DVL gives no velocity for {silent_s[at] / 3600:.1f} h from "
        f"{format_time(int(t_ns[at]))} on, and no image tells how the vehicle moved meanwhile: "
        "these are several dives",
        where="logs.files",
        remedy="give one at a time, by other files or by dive.from and dive.to",
    )


def check_topics(topics: Mapping[str, str], found: LogContents, problems: Problems) -> None:
    """Raise InputError for a topic that dive.toml names but no log holds.

    Where logs are damaged its messages may have been lost. That is only noted.
    """
    held = {channel.topic for channel in found.counts}
    for sensor, topic in sorted(topics.items()):
        if topic in held:
            continue
        if found.losses:
            found.notes.append(Finding("topic-lost", {"topic": topic}, sensor))
            continue
        with problems.collect():
            raise InputError(
                f"topic {topic} is not in the log, which holds "
                f"{', '.join(sorted(held)) or 'nothing'}",
                where=f"topics.{sensor}",
                remedy="name the topic that the log has, or leave the key away",
            )


def check_joints(joints: Mapping[str, str], found: LogContents, notes: list[Finding]) -> None:
    """Raise InputError for a servo that dive.toml names but no joint message holds.

    It is only noted for the sonar's servo where no joint was logged at all, and where a damaged log
    may have held it. Nothing is said of the tray where no joint was logged: that it is taken as
    fixed is reported elsewhere.

    joints: name of the servo by record, as dive.toml gives it. notes: what is noted is added.
    """
    held = {s.name for s in found.samples["joints"] if isinstance(s, JointSample)}
    for record, joint in joints.items():
        where = JOINT_KEYS[record]
        if joint in held:
            continue
        if not held or found.losses:
            if held or record != "tray":
                notes.append(Finding("joint-absent", {"joint": joint}, where))
            continue
        others = held - set(joints.values())  # joints that dive.toml does not name
        near = difflib.get_close_matches(joint, others, n=1, cutoff=0.6)
        remedy = f'name one of them, or set {where} = "" if nothing turns there'
        if near:
            remedy = f'did you mean "{near[0]}"?'
        raise InputError(
            f"joint {joint} is not in the log, which holds {', '.join(sorted(held))}",
            where=where,
            remedy=remedy,
        )


def refuse_same_files(images: Mapping[str, ImageIndex]) -> None:
    """Raise InputError where two cameras' tables name the same pictures."""
    named = [set(index.file.tolist()) - {""} for index in images.values()]
    same = sorted(set.intersection(*named)) if len(named) > 1 else []
    if same:
        raise InputError(
            f"{len(same)} pictures are of both cameras, the first is {printable(same[0])}",
            where=" and ".join(f"{camera}.csv" for camera in images),
            remedy="name each camera's own pictures in its table",
        )
