# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Check a whole package and describe it, without keeping anything."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import numpy as np
from msgspec import Struct

from hullrecon.dive.check.bow import describe_bow
from hullrecon.dive.check.consistency_checks import (
    check_consistency,
    check_mount_of_attitude,
    describe_start_offset,
)
from hullrecon.dive.check.hull_regions import describe_regions
from hullrecon.dive.check.messages import Stream
from hullrecon.dive.check.sampled_images import SampledImages
from hullrecon.dive.check.to_fill_in import to_fill_in
from hullrecon.dive.config.config_errors import shorten
from hullrecon.dive.config.load import LoadedConfig
from hullrecon.dive.config.mounts import (
    DEFAULTS,
    choose_mounts,
    describe_mounts,
    filled_in,
    refuse_parted_tray,
)
from hullrecon.dive.config.schema import DiveConfig, Hull
from hullrecon.dive.hull.pose_guess import guess_sigma
from hullrecon.dive.ingest import IngestRequest, IngestResult, ingest
from hullrecon.dive.logs.messages.samples import TYPES
from hullrecon.dive.logs.read_streams import Watch
from hullrecon.dive.logs.summary import WITHOUT_CAMERAS, missing, needs
from hullrecon.dive.package_files import earlier_dive_of, logo_of
from hullrecon.dive.problems import Problems
from hullrecon.findings.finding import sentences
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.clock import rate_hz
from hullrecon.records.sensors import DvlPings, ImageIndex

VEHICLE_SECTIONS = (
    "tray",
    "imu",
    "pressure",
    "dvl",
    *(camera.section for camera in Camera),
    "sonar",
    "hull",
)


CheckImages = Callable[[LoadedConfig, IngestResult, Mapping[str, SampledImages]], list[str]]


@dataclass(frozen=True, kw_only=True)
class PackageCheck:
    """What `check` reports about a package. missing_files: those that dive.toml names and that are
    not there, with their keys; unusable: what is there but cannot be used, and what to do; needs:
    sensors without which nothing can be computed; missing: what the absence of sensors means;
    warnings: contradictions; bow: which end of the CAD model is taken for it, None without a model;
    regions: how much hull each of dive.toml holds; mounts: those that the log gave; defaults:
    values by key that nobody gave.
    """

    name: str
    vessel: str
    found: IngestResult
    missing_files: list[str]
    unusable: list[str]
    needs: list[str]
    missing: list[str]
    to_fill_in: list[str]
    warnings: list[str]
    bow: str | None
    regions: list[str]
    mounts: list[str]
    defaults: dict[str, object]

    @property
    def reasons(self) -> list[str]:
        """Return all that stands against a run; none where one is possible."""
        return [*(f"missing: {file}" for file in self.missing_files), *self.unusable, *self.needs]

    @property
    def run_is_possible(self) -> bool:
        return not self.reasons

    @property
    def verdict(self) -> str:
        """Return one line: ready, and what a run would have to believe; or not, and all that is in
        its way.
        """
        if self.reasons:
            return f"not ready: {'; '.join(self.reasons)}"
        keys = ", ".join(line.split(": ")[1] for line in self.to_fill_in)
        remaining = [f"{len(self.warnings)} above"] if self.warnings else []
        remaining += [f"to fill in: {keys}"] if keys else []
        return f"ready, with warnings ({'; '.join(remaining)})" if remaining else "ready"

    def lines(self) -> list[str]:
        """Return the report, a sentence a line."""
        findings = self.found.findings()
        defaults = ", ".join(
            f"{key} = {_toml(value)}" for key, value in sorted(self.defaults.items())
        )
        return [
            f"{self.name}: {self.vessel}" if self.vessel else self.name,
            *findings["spans"],
            *describe_start_offset(self.found.records, self.found.images),
            *findings["hull"],
            *([] if self.bow is None else [self.bow]),
            *self.regions,
            *(f"missing: {file}" for file in self.missing_files),
            *(f"not usable: {line}" for line in self.unusable),
            *(f"lost: {line}" for line in findings["lost"]),
            *(f"note: {line}" for line in (*findings["remarks"], *self.mounts, *self.found.unused)),
            *self.missing,
            *self.to_fill_in,
            *(f"warning: {line}" for line in self.warnings),
            f"defaults used: {defaults}",
            f"verdict: {self.verdict}",
        ]

    def document(self) -> dict[str, object]:
        """Return the report as --json prints it."""
        streams: Mapping[str, Stream] = {**self.found.records.by_name(), **self.found.images}
        return {
            "name": self.name,
            "vessel": self.vessel,
            "streams": {
                name: _describe_stream(stream)
                for name, stream in streams.items()
                if len(stream.t_ns)
            },
            **self.found.findings(),
            "missing_files": self.missing_files,
            "unusable": self.unusable,
            "missing": self.missing,
            "to_fill_in": self.to_fill_in,
            "warnings": self.warnings,
            "bow": self.bow,
            "regions": self.regions,
            "mounts": self.mounts,
            "topics": self.found.counts,
            "unused": self.found.unused,
            "offset": describe_start_offset(self.found.records, self.found.images),
            "defaults": self.defaults,
            "run_is_possible": self.run_is_possible,
            "verdict": self.verdict,
        }


def check_package(
    loaded: LoadedConfig,
    request: IngestRequest,
    watch: Watch = iter,
    check_images: CheckImages | None = None,
) -> PackageCheck:
    """Return what the package holds and lacks, all of it read. What cannot be used is listed, all
    of it.

    check_images: looks at some of the images, by camera, and returns what contradicts the
    configuration.
    """
    request, missing_files = _leave_out_missing(loaded.package, request)
    logo = logo_of(loaded)
    missing_files += (
        [f"{logo} (report.logo)"] if logo is not None and not _exists(loaded.package / logo) else []
    )
    sampled: dict[str, SampledImages] = {}
    problems = Problems(go_on=True)
    found = ingest(
        loaded.package,
        request,
        lambda camera: sampled.setdefault(camera, SampledImages()),
        watch,
        problems,
    )
    declared = {key: loaded.value(key) for key in DEFAULTS}
    if found.records.tray is not None and len(found.records.tray.t_ns):
        with problems.collect():
            refuse_parted_tray(declared, found.sensors)
    mounts = choose_mounts(declared, found.sensors)
    taken = {key: mount for key, mount in mounts.items() if mount.source}
    loaded = filled_in(loaded, mounts)
    streams: Mapping[str, Stream] = {**found.records.by_name(), **found.images}
    present = {
        "joints" if name == "tray" else name for name, stream in streams.items() if len(stream.t_ns)
    }
    named = {sensor for sensor, topic in request.topics.items() if topic in found.counts}
    logged = named | (TYPES.keys() & found.counts.keys())
    known = present | logged if problems.found else present  # of what cannot be used it is said why
    bow, not_aft = _bow(loaded.config.hull, found.hull, problems)
    regions, empty_regions = describe_regions(
        loaded.config.hull, found.hull if bow is not None else None
    )
    return PackageCheck(
        name=loaded.config.dive.name,
        vessel=loaded.config.dive.vessel,
        found=found,
        missing_files=missing_files,
        unusable=[
            *_lost_velocities(found.records.dvl, found.images),
            *(error.line() for error in problems.found),
        ],
        needs=[*needs(known, found.unread_dvls), *_images_not_logged(loaded.config, known)],
        missing=missing(known, hull=request.mesh is not None or loaded.config.hull is not None),
        to_fill_in=to_fill_in(loaded, logged, taken.keys()),
        warnings=[
            *sentences(check_consistency(loaded.config, found.records, found.images)),
            *sentences(
                check_mount_of_attitude(loaded.config, found.records.tray)
                if found.attitude_is_dvls
                else []
            ),
            *(check_images(loaded, found, sampled) if check_images is not None else []),
            *not_aft,
            *empty_regions,
            *_no_earlier_dive(loaded),
        ],
        bow=bow,
        regions=regions,
        mounts=describe_mounts(taken),
        defaults={
            key: value
            for key, value in defaults_of(
                loaded, with_positions="position" in logged | known
            ).items()
            if key not in taken
        },
    )


def _bow(hull: Hull | None, mesh: Mesh | None, problems: Problems) -> tuple[str | None, list[str]]:
    """Return what `describe_bow` says; nothing without a CAD model, or for a bow that it does not
    have, which is a problem.
    """
    if hull is not None and mesh is not None:
        with problems.collect():
            return describe_bow(hull, mesh)
    return None, []


def _no_earlier_dive(loaded: LoadedConfig) -> list[str]:
    """Return a sentence where the earlier dive that dive.toml names is not there: a run goes
    without the chapter on change.
    """
    earlier = earlier_dive_of(loaded)
    if earlier is None or (loaded.package / earlier).is_dir():
        return []
    return [
        f"change.earlier names no folder: {shorten(earlier, 100)}; the report will not say what changed"
    ]


def _images_not_logged(config: DiveConfig, known: Set[str]) -> list[str]:
    """Return a sentence where dive.toml has a camera that leads, and the logs no image of it."""
    top = config.camera.top
    if top is None or Camera.TOP.key in known:
        return []
    return [f"no image of camera.top was logged: {WITHOUT_CAMERAS}"]


def _lost_velocities(dvl: DvlPings | None, images: Mapping[str, ImageIndex]) -> list[str]:
    """Return a sentence where a DVL measured no velocity at all: nothing could be reckoned from it."""
    if dvl is None or np.isfinite(dvl.velocity).any():
        return []
    stereo = all(camera.key in images for camera in Camera)
    other = (
        "leave the DVL away (topics.dvl, or its file in logs.files)"
        if stereo
        else "give two cameras instead"
    )
    return [
        f"the DVL's {len(dvl.t_ns)} pings have no velocity over ground: log its bottom track, or {other}"
    ]


def _leave_out_missing(package: Path, request: IngestRequest) -> tuple[IngestRequest, list[str]]:
    """Return the request without the files that are not there, and those with their keys."""
    named = [("logs.files", name) for name in request.logs]
    named += [
        (f"{Camera(name.removeprefix('camera_')).section}.calibration", f)
        for name, f in request.calibration.items()
    ]
    named += [("hull.mesh", request.mesh)] if request.mesh is not None else []
    missing_files = [f"{file} ({key})" for key, file in named if not _exists(package / file)]
    left = replace(
        request,
        logs=tuple(name for name in request.logs if _exists(package / name)),
        calibration={
            name: file for name, file in request.calibration.items() if _exists(package / file)
        },
        uncalibrated=request.uncalibrated
        if all(_exists(package / name) for name in request.logs)
        else (),
        mesh=request.mesh if request.mesh is not None and _exists(package / request.mesh) else None,
    )
    # of a single log its reader says what is wrong
    lone = not left.logs and len(missing_files) == 1
    return (request, []) if lone else (left, missing_files)


def _exists(path: Path) -> bool:
    """Return whether there is something; a name that no file can have is left to its reader."""
    try:
        return path.exists()
    except OSError:
        return True


def _describe_stream(stream: Stream) -> dict[str, int | float]:
    t = stream.t_ns
    return {
        "count": len(t),
        "start_ns": int(t[0]),
        "end_ns": int(t[-1]),
        "rate_hz": round(rate_hz(t), 3),
    }


def defaults_of(loaded: LoadedConfig, with_positions: bool = False) -> dict[str, object]:
    """Return the keys of the vehicle's sections that dive.toml leaves to their defaults, with these
    values; with_positions: there are some from outside, by [position].
    """
    names = (*VEHICLE_SECTIONS, "position") if with_positions else VEHICLE_SECTIONS
    sections, hull = {name: loaded.sections[name] for name in names}, loaded.config.hull
    by_pose = (
        {}
        if hull is None or hull.pose_sigma is not None
        else {"hull.pose_sigma": guess_sigma(hull.pose, None).tolist()}
    )
    return by_pose | {
        f"{name}.{key}": value
        for name, section in sections.items()
        if isinstance(section, Struct)
        for key, value in msgspec.to_builtins(section).items()
        if value is not None and f"{name}.{key}" not in loaded.given
    }


def _toml(value: object) -> str:
    """Return a number, a text or a list of them as dive.toml has it."""
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml, value))}]"
    return f"{value:g}" if isinstance(value, int | float) else f'"{value}"'
