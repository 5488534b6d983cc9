# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which steps a dive can have, and which files of its package each reads (`steps/chain.py`).

Listed paths are relative to the package, or absolute for files outside it.
"""

from __future__ import annotations

import os
from pathlib import Path

from hullrecon.artifacts.manifest import FILE_NAME
from hullrecon.artifacts.stage import StageSettings
from hullrecon.artifacts.workspace import PUBLISHED
from hullrecon.change.options import EarlierDive
from hullrecon.dive.config.schema import Logs, Topics
from hullrecon.dive.logs.readers.open import is_of_sonar
from hullrecon.dive.package_files import log_files, named_images
from hullrecon.geometry.frames import Camera
from hullrecon.report.options import ReportOptions
from hullrecon.steps.finished_run import HULL_SURVEY_FILES


def why_no_images(settings: StageSettings, package: Path) -> str | None:
    """Say why a dive has no step that needs images. None if it has."""
    return None if settings["camera.top.time_offset"] is not None else "no camera was carried"


def why_no_matches(settings: StageSettings, package: Path) -> str | None:
    """Say why a dive has no feature tracks. None if it has."""
    return None if settings["camera.top.mount"] is not None else "no camera was carried"


def why_no_sonar(settings: StageSettings, package: Path) -> str | None:
    """Say why there is no sonar mosaic. None if an imaging sonar was carried and logged.

    It may be logged in a topic, or in a log without topics, such as the sonar's own file.
    """
    topics, logs = settings["topics"], settings["logs"]
    is_logged = isinstance(topics, Topics) and topics.sonar is not None
    if not is_logged and isinstance(logs, Logs):
        is_logged = any(is_of_sonar(package / name) for name in logs.files)
    return (
        None
        if settings["sonar.mount"] is not None and is_logged
        else "no imaging sonar was carried"
    )


def why_no_change(settings: StageSettings, package: Path) -> str | None:
    """Say why the dive is not compared with an earlier dive. None if it is.

    Both an earlier dive and a CAD model are needed, as dives are compared on the CAD model.
    """
    if settings.read("change", EarlierDive).earlier is None:
        return "no earlier dive is named (change.earlier)"
    return "no CAD model was given" if settings["hull.mesh"] is None else None


def files_to_ingest(settings: StageSettings, package: Path) -> list[Path]:
    """List what ingest reads: logs, files that tables name, calibrations and the CAD model.

    When one of them changes, ingest runs again.
    """
    keys = [*(f"{camera.section}.calibration" for camera in Camera), "hull.mesh"]
    named = [settings.read_optional(key, str) for key in keys]
    logs = [file for log in settings.read("logs", Logs).files for file in log_files(package, log)]
    return [*logs, *(Path(name) for name in named if name)]


def images_of_tables(settings: StageSettings, package: Path) -> list[Path]:
    """List the images that tables of the package name, which steps after ingest read again."""
    return named_images(package, settings.read("logs", Logs).files)


def files_to_report(settings: StageSettings, package: Path) -> list[Path]:
    """List the images that tables name, and the logo."""
    logo = settings.read("report", ReportOptions).logo
    return [*images_of_tables(settings, package), *([Path(logo)] if logo is not None else [])]


def files_of_earlier_dive(settings: StageSettings, package: Path) -> list[Path]:
    """List the files of the earlier dive's run that are read, as far as they exist.

    Missing ones are no error here: the step itself says so, and the rest of the chain runs.
    """
    earlier = settings.read("change", EarlierDive).earlier
    if earlier is None:
        return []
    root = Path(earlier).parent if Path(earlier).name == PUBLISHED else Path(earlier)
    files = [
        root / step / name
        for step, names in HULL_SURVEY_FILES.items()
        for name in (*names, FILE_NAME)
    ]
    return [
        file
        for file in files
        if os.path.isfile(package / file) and os.access(package / file, os.R_OK)
    ]
