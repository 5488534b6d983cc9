# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The chain: every step with what it takes, reads and applies to.

Nothing here imports what a step does, so that commands that run no step start at once.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import Any

from hullrecon.adjustment.options import AdjustOptions
from hullrecon.artifacts.stage import Context, Stage
from hullrecon.change.options import EarlierDive
from hullrecon.detection.options import DetectOptions
from hullrecon.dive.config.schema import RIG_KEYS, RIG_SECTIONS, Section
from hullrecon.mosaic.options import OpticalOptions, SonarOptions
from hullrecon.navigation.sigmas import SIGMA_KEYS
from hullrecon.report.options import ReportOptions
from hullrecon.steps.conditions import (
    files_of_earlier_dive,
    files_to_ingest,
    files_to_report,
    images_of_tables,
    why_no_change,
    why_no_images,
    why_no_matches,
    why_no_sonar,
)
from hullrecon.steps.keys import (
    CAMERA_KEYS,
    DVL_KEYS,
    INGEST_KEYS,
    READOUT_KEYS,
    SENSOR_KEYS,
    SONAR_KEYS,
    TRAY_KEYS,
)
from hullrecon.surface.options import SurfaceOptions
from hullrecon.vision.options import FeatureOptions, LinkOptions, MatchOptions

NAMES = (
    "ingest", "navigate", "features", "links", "matches", "adjust", "surface", "detect",
    "mosaic-optical", "mosaic-sonar", "change", "report",
)  # fmt: skip


class NoOptions(Section, frozen=True):
    """The section of a step without options."""


def stage(name: str) -> Stage:
    """Look up the step of that name."""
    return STAGES[NAMES.index(name)]


def stages() -> tuple[Stage, ...]:
    """List all steps, each after its inputs."""
    return STAGES


def _later(module: str) -> Callable[[Context[Any]], None]:
    """Make the function of a step, which imports its module when it runs."""
    return partial(_run_module, module)


def _run_module(module: str, context: Context[Any]) -> None:
    import_module(f"hullrecon.steps.{module}").run(context)


# Each after its inputs. `version` is raised when a step's result changes for the same input.
STAGES = (
    Stage(
        name="ingest",
        summary="read the logs, the calibration and the CAD model",
        inputs=(),
        parameters=NoOptions,
        version=26,
        run=_later("ingest"),
        uses=INGEST_KEYS,
        external=files_to_ingest,
    ),
    Stage(
        name="navigate",
        summary="compute the dead-reckoned trajectory",
        inputs=("ingest",),
        parameters=NoOptions,
        version=42,
        run=_later("navigate"),
        uses=(
            *SENSOR_KEYS,
            *SIGMA_KEYS,
            *READOUT_KEYS,
            "camera.bottom.pose_sigma",
            "camera.bottom.time_offset",
            "position.origin",
            "logs",
        ),
        external=images_of_tables,
    ),
    Stage(
        name="features",
        summary="find features in every image",
        inputs=("ingest",),
        parameters=FeatureOptions,
        version=4,
        run=_later("features"),
        uses=("camera.top.time_offset", "logs"),
        external=images_of_tables,
        applies=why_no_images,
    ),
    Stage(
        name="links",
        summary="link images in rounds, tie passes by the hull, and straighten the path with them",
        inputs=("ingest", "navigate"),
        optional=("features",),
        parameters=LinkOptions,
        version=23,
        run=_later("links"),
        uses=(*RIG_SECTIONS, "matches"),
    ),
    Stage(
        name="matches",
        summary="join matches of linked images to feature tracks",
        inputs=("ingest", "navigate", "features", "links"),
        parameters=MatchOptions,
        version=9,
        run=_later("matches"),
        uses=RIG_KEYS,
        applies=why_no_matches,
    ),
    Stage(
        name="adjust",
        summary="adjust images, DVL ranges and the CAD model together",
        inputs=("ingest", "navigate"),
        optional=("links", "matches"),
        uses=(*RIG_SECTIONS, "hull"),
        parameters=AdjustOptions,
        version=45,
        run=_later("adjust"),
    ),
    Stage(
        name="surface",
        summary="fit a surface to the DVL's returns",
        inputs=("ingest", "navigate"),
        optional=("adjust",),
        parameters=SurfaceOptions,
        version=10,
        run=_later("surface"),
        fails_alone=True,
        uses=(
            *DVL_KEYS,
            "dvl.sigma_range",
            "hull.pose",
            "hull.pose_sigma",
            "hull.bow",
            "hull.aft_perpendicular",
        ),
    ),
    Stage(
        name="detect",
        summary="find structures and remesh the hull as found",
        inputs=("ingest", "adjust", "surface"),
        parameters=DetectOptions,
        version=18,
        run=_later("detect"),
        fails_alone=True,
        uses=(
            *TRAY_KEYS,
            "hull.frame_spacing",
            "hull.region",
            *SONAR_KEYS,
            "sonar.joint",
            "sonar.elevation_deg",
        ),
    ),
    Stage(
        name="mosaic-optical",
        summary="blend the images on the hull's surface",
        inputs=("ingest", "navigate", "surface"),
        optional=("adjust", "detect"),
        parameters=OpticalOptions,
        version=14,
        run=_later("mosaic_optical"),
        fails_alone=True,
        uses=("camera.top.time_offset", *CAMERA_KEYS, "logs", "hull.frame_spacing"),
        external=images_of_tables,
        applies=why_no_images,
    ),
    Stage(
        name="mosaic-sonar",
        summary="blend the sonar's pings on the hull's surface",
        inputs=("ingest", "navigate", "surface"),
        optional=("adjust", "detect"),
        parameters=SonarOptions,
        version=14,
        run=_later("mosaic_sonar"),
        fails_alone=True,
        uses=(
            *SONAR_KEYS,
            "sonar.joint",
            "sonar.mount_sigma",
            "sonar.elevation_deg",
            "topics",
            "logs",
            "hull.frame_spacing",
        ),
        applies=why_no_sonar,
    ),
    Stage(
        name="change",
        summary="say what changed since an earlier dive of the hull",
        inputs=("ingest", "adjust", "surface", "detect"),
        parameters=EarlierDive,
        version=3,
        run=_later("change"),
        fails_alone=True,
        uses=("dive.name", "hull.mesh", "hull.frame_spacing"),
        external=files_of_earlier_dive,
        applies=why_no_change,
    ),
    Stage(
        name="report",
        summary="write the deliverables and the report",
        inputs=("ingest", "navigate"),
        optional=NAMES[2:-1],
        parameters=ReportOptions,
        version=24,
        run=_later("report"),
        uses=("dive", "logs", "hull", "camera.top.time_offset", "change.earlier", *RIG_KEYS),
        external=files_to_report,
    ),
)
