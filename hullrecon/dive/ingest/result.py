# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What was read of a dive package."""

from __future__ import annotations

from dataclasses import dataclass, field

from hullrecon.dive.check.contents import describe_streams
from hullrecon.dive.logs.fixed_frames import FixedSensor
from hullrecon.findings.finding import Finding, sentences
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.sensors import ImageIndex, SensorRecords


@dataclass(kw_only=True)
class IngestResult:
    """What was read, filled while the logs stream by."""

    records: SensorRecords = field(default_factory=SensorRecords)  # each in order of time
    images: dict[str, ImageIndex] = field(default_factory=dict)  # by camera
    cameras: dict[str, CameraModel] = field(default_factory=dict)
    hull: Mesh | None = None  # the CAD model
    counts: dict[str, int] = field(default_factory=dict)  # messages by topic
    sensors: dict[str, FixedSensor] = field(default_factory=dict)  # those that tf_static leads to
    # topics that are a DVL's by their names, of types that are not read
    unread_dvls: list[str] = field(default_factory=list)
    is_whole: bool = True  # every log was read to its end
    attitude_is_dvls: bool = False  # by the DVL's own sensors, as no IMU was logged
    lost: list[Finding] = field(default_factory=list)
    hull_notes: list[Finding] = field(default_factory=list)  # what was found and repaired
    unused: list[Finding] = field(default_factory=list)  # topics that no sensor was given
    notes: list[Finding] = field(default_factory=list)

    @property
    def spans(self) -> list[Finding]:
        """Describe each sensor's readings."""
        return describe_streams(self.records, self.images)

    def document(self) -> dict[str, list[str]]:
        """Collect the sentences of findings.json."""
        return {
            "spans": sentences(self.spans),
            "lost": sentences(self.lost),
            "hull": sentences(self.hull_notes),
            "notes": sentences(self.notes),
        }
