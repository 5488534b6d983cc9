# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Check a whole package and describe it, without keeping anything."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import msgspec
import numpy as np
from msgspec import Struct

from hullrecon.dive.check.consistency_checks import (
    COARSE,
    check_consistency,
    check_mount_of_attitude,
)
from hullrecon.dive.check.contents import describe_start_offset
from hullrecon.dive.check.hull_checks import (
    check_afloat,
    check_length,
    check_reach,
    check_upright,
    describe_bow,
    describe_regions,
    refuse_far_hull,
)
from hullrecon.dive.check.motion_offset import add_motion
from hullrecon.dive.check.package_report import PackageCheck
from hullrecon.dive.check.requirements import configured_sensors, missing, needs, to_fill_in
from hullrecon.dive.check.time_overlap import Stream
from hullrecon.dive.config.config_errors import shorten
from hullrecon.dive.config.load import LoadedConfig
from hullrecon.dive.config.mounts import (
    ChosenMount,
    choose_mounts,
    describe_mounts,
    filled_in,
    guess_sigma,
    refuse_mounts,
)
from hullrecon.dive.config.schema import DEFAULT_MOUNTS, DiveConfig, Hull
from hullrecon.dive.images.sink import SampledImages
from hullrecon.dive.ingest.ingest import ingest
from hullrecon.dive.ingest.request import IngestRequest
from hullrecon.dive.ingest.result import IngestResult
from hullrecon.dive.logs.messages.samples import TYPES
from hullrecon.dive.logs.read_streams import Watch
from hullrecon.dive.package_files import earlier_dive_of, logo_of
from hullrecon.dive.problems import Problems
from hullrecon.findings.finding import Finding
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.clock import NS, format_time
from hullrecon.records.sensors import DvlPings, ImageIndex, SensorRecords

VEHICLE_SECTIONS = (
    "tray",
    "imu",
    "pressure",
    "dvl",
    *(camera.section for camera in Camera),
    "sonar",
    "hull",
)
MOST_APART_S = 2 * 86_400.0  # of a log's begin and the stated date, which may lack its zone
# looks at some of the images, by camera, and reports what contradicts the configuration
CheckImages = Callable[[LoadedConfig, IngestResult, Mapping[str, SampledImages]], list[Finding]]
# compares the sensors with each other. Returns the records with what was corrected, the findings,
# and the hypotheses that were tried, for `--json`
CheckSensors = Callable[
    [LoadedConfig, IngestResult, Mapping[str, SampledImages]],
    tuple[SensorRecords, list[Finding], list[dict[str, object]]],
]


def check_package(
    loaded: LoadedConfig,
    request: IngestRequest,
    watch: Watch = iter,
    check_images: CheckImages | None = None,
    check_sensors: CheckSensors | None = None,
    check_path: CheckImages | None = None,
) -> PackageCheck:
    """Read a whole package, and list what it holds, what it lacks and what cannot be used.

    A problem does not end the check: it becomes a finding.

    Parameters
    ----------
    loaded : the configuration
    request : what ingest needs of it
    watch : sees every message pass, to report progress
    check_images : looks at some of the images, None: at none. Not called where a sensor is wrong
    check_sensors : compares the sensors with each other, None: they are not compared
    check_path : finds out whether there is a path, None: it is not. Not called where it is known
        already that no run is possible
    """
    request, missing_files = _leave_out_missing(loaded.package, request)
    logo = logo_of(loaded)
    if logo is not None and not _exists(loaded.package / logo):
        missing_files.append(_file_missing(logo, "report.logo"))

    # Read the package as a run does, but keep some images only, and go on after a problem.
    sampled: dict[str, SampledImages] = {}
    problems = Problems(go_on=True)
    found = ingest(
        loaded.package,
        request,
        lambda camera: sampled.setdefault(camera, SampledImages()),
        watch,
        problems,
    )
    loaded, mounts = _fill_mounts(loaded, found, problems)
    known, logged = _known_sensors(loaded, request, found, bool(problems.found))
    bow, wrong_pose = _check_hull_pose(loaded.config.hull, found.hull, problems)
    regions, empty_regions = describe_regions(loaded.config.hull, found.hull if bow else None)

    # Contradictions within the package.
    records, judged, suspects = found.records, list[Finding](), list[dict[str, object]]()
    if check_sensors is not None:
        records, judged, suspects = check_sensors(loaded, found, sampled)
    wrong_sensors = [finding for finding in judged if finding.severity == "error"]
    warnings = _warn_of_contradictions(loaded, found, records, judged)
    hull = loaded.config.hull
    if hull is not None and found.hull is not None and records.dvl is not None and bow:
        wrong_pose = [*wrong_pose, *check_reach(hull, found.hull, records.dvl)]
    if check_images is not None and not wrong_sensors:
        warnings += check_images(loaded, replace(found, records=records), sampled)
    defaults = defaults_of(loaded, with_positions="position" in logged | known)
    checked = PackageCheck(
        name=loaded.config.dive.name,
        vessel=loaded.config.dive.vessel,
        found=found,
        missing_files=missing_files,
        unusable=[
            *_lost_velocities(found.records.dvl, found.images),
            *_unmeasured_hull(found.records.dvl, found.images),
            *add_motion(problems.found, loaded.config, records),
            *wrong_sensors,
        ],
        needs=[
            *needs(known, found.unread_dvls),
            *_images_not_logged(loaded.config, known, found.notes),
        ],
        missing=missing(known, hull=request.mesh is not None or loaded.config.hull is not None),
        to_fill_in=to_fill_in(loaded, logged, mounts.keys()),
        warnings=[
            *warnings,
            *wrong_pose,
            *empty_regions,
            *_no_earlier_dive(loaded),
            *_date_differs(loaded.config.dive.date, found.records),
        ],
        start_offset=describe_start_offset(found.records, found.images),
        bow=bow,
        regions=regions,
        mounts=describe_mounts(mounts),
        defaults={key: value for key, value in defaults.items() if key not in mounts},
        suspects=suspects,
    )
    if check_path is None or checked.reasons:
        return checked
    pathless = check_path(loaded, replace(found, records=records), sampled)
    return replace(checked, unusable=[*checked.unusable, *pathless])


def _known_sensors(
    loaded: LoadedConfig, request: IngestRequest, found: IngestResult, has_problems: bool
) -> tuple[set[str], set[str]]:
    """List the sensors that are known to be there, and those that were logged.

    A sensor that was logged but cannot be used counts as known where there are problems, as its own
    is among those reported. Where a log was not read to its end, the sensors that dive.toml names
    count as known too.
    """
    streams: Mapping[str, Stream] = {**found.records.by_name(), **found.images}
    known = {
        "joints" if name == "tray" else name for name, stream in streams.items() if len(stream.t_ns)
    }
    named = {sensor for sensor, topic in request.topics.items() if topic in found.counts}
    logged = named | (TYPES.keys() & found.counts.keys())
    if has_problems:
        known |= logged
    if not found.is_whole:
        known |= configured_sensors(loaded)
    return known, logged


def _warn_of_contradictions(
    loaded: LoadedConfig, found: IngestResult, records: SensorRecords, judged: Sequence[Finding]
) -> list[Finding]:
    """Warn of sensors that contradict each other or dive.toml.

    Parameters
    ----------
    loaded, found : the configuration, and what was read
    records : what the sensors logged, with what was corrected
    judged : findings of the comparison of sensors
    """
    warnings = check_consistency(loaded.config, records, found.images)
    if any(finding.severity == "error" for finding in judged):
        # a sensor that is wrong causes these too, and they would blame others
        warnings = [one for one in warnings if one.code not in COARSE]
    warnings += [finding for finding in judged if finding.severity == "warning"]
    if found.attitude_is_dvls:
        warnings += check_mount_of_attitude(loaded.config, found.records.tray)
    return warnings


def _fill_mounts(
    loaded: LoadedConfig, found: IngestResult, problems: Problems
) -> tuple[LoadedConfig, Mapping[str, ChosenMount]]:
    """Fill in the mounts that tf_static gives, and collect what is wrong with them as problems.

    Returns the configuration, and the mounts that were filled in by key.
    """
    declared = {key: loaded.value(key) for key in DEFAULT_MOUNTS}
    tray = found.records.tray
    with problems.collect():
        refuse_mounts(declared, found.sensors, tray is not None and len(tray.t_ns) > 0)
    mounts = choose_mounts(declared, found.sensors)
    of_log = {key: mount for key, mount in mounts.items() if mount.source}
    return filled_in(loaded, mounts), of_log


def _check_hull_pose(
    hull: Hull | None, mesh: Mesh | None, problems: Problems
) -> tuple[list[Finding], list[Finding]]:
    """Describe which end of the CAD model is the bow, and warn of a doubtful hull.pose.

    A pose far off, another length than is stated and a bow that the CAD model does not have are
    collected as problems. Both lists are empty for such a bow, and without a CAD model.
    """
    if hull is not None and mesh is not None:
        with problems.collect():
            refuse_far_hull(hull, mesh)
        length: list[Finding] = []
        with problems.collect():
            length = check_length(hull, mesh)
        with problems.collect():
            bow, stations_off = describe_bow(hull, mesh)
            return [bow], [
                *check_upright(hull, mesh),
                *check_afloat(hull, mesh),
                *length,
                *stations_off,
            ]
    return [], []


def _no_earlier_dive(loaded: LoadedConfig) -> list[Finding]:
    """Warn where the earlier dive is missing: a run goes without the chapter on change."""
    earlier = earlier_dive_of(loaded)
    if earlier is None or (loaded.package / earlier).is_dir():
        return []
    return [Finding("earlier-dive-missing", {"folder": shorten(earlier, 100)})]


def _date_differs(date: datetime | None, records: SensorRecords) -> list[Finding]:
    """Warn where most sensors begin days from the stated date, as with clocks never set."""
    starts = sorted(int(s.t_ns[0]) for s in records.by_name().values() if len(s.t_ns))
    if date is None or not starts:
        return []
    start_ns = starts[len(starts) // 2]
    if abs(start_ns / NS - date.timestamp()) < MOST_APART_S:
        return []
    values = {"start": format_time(start_ns), "date": date.isoformat()}
    return [Finding("date-differs", values)]


def _images_not_logged(
    config: DiveConfig, known: Set[str], notes: Sequence[Finding]
) -> list[Finding]:
    """Report an upper camera of which the logs have no image, as an error.

    notes: of the logs, which say where pictures lie that no table names.
    """
    if config.camera.top is None or Camera.TOP.key in known:
        return []
    unnamed = [note for note in notes if note.code == "pictures-unnamed"]
    return [
        Finding("images-not-named", unnamed[0].values) if unnamed else Finding("images-not-logged")
    ]


def _lost_velocities(dvl: DvlPings | None, images: Mapping[str, ImageIndex]) -> list[Finding]:
    """Report a DVL without any velocity, as an error: no path follows from it."""
    if dvl is None or np.isfinite(dvl.velocity).any():
        return []
    stereo = all(camera.key in images for camera in Camera)
    return [Finding("dvl-without-velocity", {"pings": len(dvl.t_ns), "stereo": stereo})]


def _unmeasured_hull(dvl: DvlPings | None, images: Mapping[str, ImageIndex]) -> list[Finding]:
    """Report a dive with neither ranges nor images, as an error: there is no surface to map."""
    if dvl is None or images or np.isfinite(dvl.ranges).any():
        return []
    return [Finding("hull-unmeasured")]


def _file_missing(file: str, key: str) -> Finding:
    return Finding("file-missing", {"file": file, "key": key})


def _leave_out_missing(
    package: Path, request: IngestRequest
) -> tuple[IngestRequest, list[Finding]]:
    """Remove calibrations and a CAD model that are not there from a request, and report each.

    So the rest of the package is still checked. A missing log stays: its reader reports what is
    wrong, and sensors that it may hold are not reported as missing. Nor is a calibration that the
    logs have to hold.
    """
    named = [
        (f"{Camera(name.removeprefix('camera_')).section}.calibration", f)
        for name, f in request.calibration.items()
    ]
    named += [("hull.mesh", request.mesh)] if request.mesh is not None else []
    missing_files = [_file_missing(file, key) for key, file in named if not _exists(package / file)]
    remaining = replace(
        request,
        calibration={
            name: file for name, file in request.calibration.items() if _exists(package / file)
        },
        uncalibrated=request.uncalibrated
        if all(_exists(package / name) for name in request.logs)
        else (),
        mesh=request.mesh if request.mesh is not None and _exists(package / request.mesh) else None,
    )
    return remaining, missing_files


def _exists(path: Path) -> bool:
    """Tell whether a path exists.

    A name that no file can have counts as existing: its reader refuses it.
    """
    try:
        return path.exists()
    except OSError:
        return True


def defaults_of(loaded: LoadedConfig, with_positions: bool = False) -> dict[str, object]:
    """List the keys of the vehicle's sections that dive.toml leaves to defaults, with their values.

    with_positions: position fixes (USBL, GNSS) were logged, so that [position] counts.
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
