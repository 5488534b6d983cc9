# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Build the record of each sensor from the samples of all logs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np

from hullrecon.dive.ingest.refusals import check_joints
from hullrecon.dive.ingest.request import JOINT_KEYS, IngestRequest
from hullrecon.dive.logs.ping_spool import KeepImages, PingSpool, SpooledPing
from hullrecon.dive.logs.positions import is_acoustic, position_fixes
from hullrecon.dive.logs.read_streams import LogContents
from hullrecon.dive.logs.republished import drop_republished
from hullrecon.dive.logs.samples import (
    DepthSample,
    DvlSample,
    ImuSample,
    JointSample,
    PositionSample,
    PressureSample,
    Sample,
    are_written_twice,
    find_copies,
    is_of_dvl,
)
from hullrecon.dive.logs.streams.dvl import dvl_pings
from hullrecon.dive.logs.streams.imu import imu_samples
from hullrecon.dive.logs.streams.joints import joint_samples
from hullrecon.dive.logs.streams.pressure import pressure_samples
from hullrecon.dive.logs.streams.sonar import sonar_pings
from hullrecon.dive.logs.timeline import put_in_order
from hullrecon.dive.problems import Problems
from hullrecon.findings.finding import Finding
from hullrecon.records.clock import NS
from hullrecon.records.sensors import (
    DvlPings,
    ImuSamples,
    JointSamples,
    PositionFixes,
    PressureSamples,
    SensorRecord,
    SensorRecords,
    SonarPings,
)

LEAST_SINKING_S = 20.0  # span of velocities by which the unit of depths can be judged
Kind = TypeVar("Kind", bound=Sample)
DEPTHS: tuple[type[PressureSample | DepthSample], ...] = (PressureSample, DepthSample)


def build_records(source: Source, problems: Problems) -> SensorRecords:
    """Build the records of all sensors but the cameras.

    A record is None without its sensor, and where what is wrong with it was collected as a problem.
    """
    for name, build in BUILDERS.items():
        with problems.collect():
            source.built[name] = build(source)
    with problems.collect():
        check_joints(source.request.joints, source.found, source.notes)
    for record in JOINT_KEYS:
        with problems.collect():
            source.built[record] = _build_joint(record, source)
    return SensorRecords(**source.built)  # type: ignore[arg-type]


@dataclass
class Source:
    """The inputs from which the records are built, and the records so far."""

    request: IngestRequest
    found: LogContents  # samples by sensor
    notes: list[Finding]  # what is assumed or left out is added
    spool: PingSpool  # the images of the sonar's samples
    keep_images: KeepImages  # stores the images of the sonar's record
    attitude_is_dvls: bool = False  # the attitude is by sensors inside the DVL
    built: dict[str, SensorRecord | None] = field(default_factory=dict)  # by sensor

    def samples(
        self, sensor: str, kind: type[Kind] | tuple[type[Kind], ...], joint: str | None = None
    ) -> list[Kind]:
        """Collect the samples of a sensor in order of time, without duplicates.

        Empty where it was not logged. Attitudes and depths of the DVL's own sensors are ignored
        where another sensor was logged. Clock jumps are corrected. Readings that were stamped in
        bursts, when a buffer was read, are spread over the time in which they were measured.
        Readings that were written twice, or that a driver repeated until the next one, are dropped.

        Parameters
        ----------
        sensor : its key in [topics] of dive.toml
        kind : type of its samples; others are ignored
        joint : name of one servo among those of "joints"
        """
        found = self.found
        rows = [
            row
            for row in zip(
                found.samples[sensor], found.logged_ns[sensor], found.log[sensor], strict=True
            )
            if isinstance(row[0], kind) and joint in (None, getattr(row[0], "name", None))
        ]
        # done before sorting by time, as two sensors have two clocks
        own = [row for row in rows if not is_of_dvl(row[0])]
        if own and len(own) < len(rows):
            values = {"sensor": sensor, "count": len(rows) - len(own)}
            self.notes.append(Finding("dvl-sensors-ignored", values, sensor))
            rows = own
        name = sensor if joint is None else f"joint {joint}"
        copies = set(find_copies([sample for sample, *_ in rows], [log for *_, log in rows]))
        if copies and len(copies) < len(rows) - 1:  # else the clock stands still
            values = {"copies": len(copies), "count": len(rows)}
            self.notes.append(Finding("readings-twice", values, name))
            rows = [row for number, row in enumerate(rows) if number not in copies]
        line = put_in_order(
            name,
            [sample.t_ns for sample, *_ in rows],
            [logged for _, logged, _ in rows],
            [log for *_, log in rows],
            spread=not are_written_twice([sample for sample, *_ in rows]),
        )
        self.notes += line.notes
        ordered = ((rows[i][0], int(t_ns)) for i, t_ns in zip(line.keep, line.t_ns, strict=True))
        kept = [s if s.t_ns == t_ns else replace(s, t_ns=t_ns) for s, t_ns in ordered]
        return drop_republished(name, kept, self.notes)


def _build_dvl(source: Source) -> DvlPings | None:
    """Stack the pings of the DVL. None without any."""
    samples, request = source.samples("dvl", DvlSample), source.request
    if not samples:
        return None
    unit = request.log_units.velocity
    return dvl_pings(samples, request.beams, request.sigma_velocity, source.notes, unit)


def _build_imu(source: Source) -> ImuSamples | None:
    """Stack the attitudes, None without any, and note whether they are by the DVL's own sensors."""
    samples, request = source.samples("imu", ImuSample), source.request
    if not samples:
        return None
    source.attitude_is_dvls = all(sample.of_dvl for sample in samples)
    return imu_samples(
        samples,
        request.imu_frame,
        source.notes,
        request.imu_mount_deg,
        request.log_units.rates,
        request.imu_heading,
    )


def _build_pressure(source: Source) -> PressureSamples | None:
    """Stack the depths."""
    samples = source.samples("pressure", DEPTHS)
    if not samples:
        return None
    return pressure_samples(samples, source.request.pressure, source.notes, _tells_depth(source))


def _tells_depth(source: Source) -> bool:
    """Tell whether DVL and IMU give velocities for long enough to compare depths with.

    A wrong unit of the pressure is then found by that comparison, so that depths above the water
    need not be refused here.
    """
    dvl, imu = source.built.get("dvl"), source.built.get("imu")
    if not isinstance(dvl, DvlPings) or imu is None:
        return False
    heard_ns = dvl.t_ns[np.isfinite(dvl.velocity).all(axis=1)]
    return len(heard_ns) > 1 and bool(heard_ns[-1] - heard_ns[0] >= LEAST_SINKING_S * NS)


def _build_sonar(source: Source) -> SonarPings | None:
    """Stack the pings of the imaging sonar. None without any."""
    request, samples = source.request, source.samples("sonar", SpooledPing)
    return sonar_pings(
        samples, source.notes, request.sonar_azimuth_deg, source.keep_images, source.spool.load
    )


def _build_position(source: Source) -> PositionFixes | None:
    """Stack the position fixes (USBL, GNSS), None without any.

    The depth tells when an antenna was under water.
    """
    request, samples = source.request, source.samples("position", PositionSample)
    acoustic = is_acoustic(request.position_source, request.topics.get("position", ""))
    samples = [replace(s, by_satellite=s.by_satellite and not acoustic) for s in samples]
    depths = source.built.get("pressure")
    pressure = depths if isinstance(depths, PressureSamples) else None
    return position_fixes(
        samples, request.sigma_position, request.position_frame, pressure, source.notes
    )


def _build_joint(record: str, source: Source) -> JointSamples | None:
    """Stack the angles of the servo of a record, "tray" or "sonar_tray". None if not logged."""
    joint = source.request.joints.get(record)
    if joint is None:
        return None
    samples = source.samples("joints", JointSample, joint)
    unit = source.request.log_units.joints.get(record, "rad")
    if not samples:
        return None
    servo = joint_samples(samples, record, joint, source.notes, unit)
    return servo if servo is None or record != "tray" else _upwards(servo, source.request)


def _upwards(tray: JointSamples, request: IngestRequest) -> JointSamples:
    """Convert the tray's logged angles to those of the frame `tray`: growing as it tilts up.

    Sense and zero are those of [tray] in dive.toml.
    """
    sense = -1.0 if request.tray_positive == "down" else 1.0
    return replace(tray, angle=sense * tray.angle + np.radians(request.tray_offset_deg))


BUILDERS: dict[str, Callable[[Source], SensorRecord | None]] = {
    "dvl": _build_dvl,
    "imu": _build_imu,
    "pressure": _build_pressure,
    "sonar": _build_sonar,
    "position": _build_position,  # after pressure, which tells when an antenna was under water
}
