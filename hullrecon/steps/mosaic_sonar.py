# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The mosaic of the imaging sonar on the hull's chart and on the surface."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.artifacts.graph.stage import Context, Stage, load_arrays
from hullrecon.dive.config import Sonar
from hullrecon.dive.records import JointSamples, SonarPings, from_arrays
from hullrecon.errors import StageError
from hullrecon.geometry.poses import Poses, from_mount, interpolate, tray
from hullrecon.mosaic.options import SonarOptions
from hullrecon.mosaic.sonar import sonar_mosaic
from hullrecon.report.track import Track
from hullrecon.steps.mosaics import scenery, write_mosaic


def applies(settings: Mapping[str, Any]) -> str | None:
    return None if settings["sonar"] is not None and settings["topics"].sonar is not None else "no imaging sonar was carried"


def run(context: Context) -> None:
    options: SonarOptions = context.parameters
    ingest = context.inputs["ingest"]
    if not (ingest / "sonar.npz").exists():
        raise StageError("the log holds no sonar ping", where="mosaic-sonar", remedy="check topics.sonar")
    pings = from_arrays(SonarPings, load_arrays(ingest / "sonar.npz"))
    place = scenery(context, options.reach_m)
    joint = ingest / "sonar_tray.npz"
    angles = from_arrays(JointSamples, load_arrays(joint)) if joint.exists() else None
    sonar: Sonar = context.settings["sonar"]
    poses = sonar_poses(place.track, pings.t_ns, angles, sonar)
    try:
        made = sonar_mosaic(place.ground, pings, poses, np.radians(sonar.elevation_deg), options, context.progress)
    except ValueError as error:
        raise StageError(f"no sonar mosaic: {error}", where="mosaic-sonar", remedy="check the mount of the sonar") from error
    facts = {
        "pings": len(pings.t_ns),
        "poses": "adjusted" if place.solution is not None else "dead reckoned",
        "remarks": ["returns brought to one level by range, beam and ping"] if made.lit else ["returns left as they were"],
    }
    write_mosaic(context, place, made.store, "Sonar mosaic", facts, (options.texture_px, options.faces))


def sonar_poses(track: Track, t_ns: NDArray[np.int64], angles: JointSamples | None, sonar: Sonar) -> Poses:
    """T_M_o (T_g_o) at the pings: the vehicle between its nodes, the servo between its samples, the mount."""
    vehicle = interpolate(track.t_ns, track.poses, t_ns)
    if sonar.joint is None:
        angle = np.zeros(len(t_ns))
    elif angles is None or not len(angles.t_ns):
        raise StageError(f"the joint {sonar.joint} is not in the log", where="mosaic-sonar", remedy="check sonar.joint")
    else:
        angle = np.interp(t_ns - t_ns[0], angles.t_ns - t_ns[0], angles.angle)
    return vehicle @ tray(sonar.origin, angle) @ from_mount(sonar.mount)


STAGE = Stage(
    name="mosaic-sonar",
    summary="blend the sonar's pings on the hull's surface",
    inputs=("ingest", "navigate", "surface"),
    optional=("adjust", "detect"),
    parameters=SonarOptions,
    version=3,
    run=run,
    uses=("sonar", "topics", "hull.frame_spacing"),
    applies=applies,
)
