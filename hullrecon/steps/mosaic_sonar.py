# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The mosaic of the imaging sonar on the hull's chart and on the surface."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.artifacts.graph.stage import Context, Stage, load_arrays
from hullrecon.dive.config.schema import Sonar
from hullrecon.errors import StageError
from hullrecon.geometry.poses import Poses, from_mount, interpolate, tray_poses
from hullrecon.mosaic.imagery.camera_views import Footprints
from hullrecon.mosaic.options import SonarOptions
from hullrecon.mosaic.position_sigma import PingUncertainty, position_sigma
from hullrecon.mosaic.sonar import sonar_mosaic
from hullrecon.records.sensors import JointSamples, SonarPings
from hullrecon.records.serialisation import from_arrays
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.steps.mosaics import MosaicInputs, scenery, write_mosaic


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
        made = sonar_mosaic(place.surface, pings, poses, np.radians(sonar.elevation_deg), options, context.progress)
    except ValueError as error:
        raise StageError(f"no sonar mosaic: {error}", where="mosaic-sonar", remedy="check the mount of the sonar") from error
    spread = place_spread(place, pings.t_ns, poses, sonar, made.footprints)
    remarks = (
        ["returns brought to one level by range, beam and ping"] if made.light_corrected else ["returns left as they were"]
    )
    facts = {
        **spread,
        "pings": len(pings.t_ns),
        "poses": "adjusted" if place.solution is not None else "dead reckoned",
        "remarks": remarks,
    }
    write_mosaic(context, place, made.store, "Sonar mosaic", facts, (options.texture_px, options.faces))


def sonar_poses(track: VehicleTrack, t_ns: NDArray[np.int64], angles: JointSamples | None, sonar: Sonar) -> Poses:
    """T_M_o (T_g_o) at the pings: the vehicle between its nodes, the servo between its samples, the mount."""
    vehicle = interpolate(track.t_ns, track.poses, t_ns)
    if sonar.joint is None:
        angle = np.zeros(len(t_ns))
    elif angles is None or not len(angles.t_ns):
        raise StageError(f"the joint {sonar.joint} is not in the log", where="mosaic-sonar", remedy="check sonar.joint")
    else:
        angle = np.interp(t_ns - t_ns[0], angles.t_ns - t_ns[0], angles.angle)
    return vehicle @ tray_poses(sonar.origin, angle) @ from_mount(sonar.mount)


def place_spread(
    place: MosaicInputs, t_ns: NDArray[np.int64], poses: Poses, sonar: Sonar, footprints: Footprints
) -> dict[str, float | None]:
    """One sigma of a texel's place on the hull, in the median over pings and their footprints, and what the mount has of it."""
    track, chart = place.track, place.surface.chart
    near = np.minimum(np.searchsorted(track.t_ns, t_ns), len(track.t_ns) - 1)
    pings = PingUncertainty(
        sonar=poses, vehicle=interpolate(track.t_ns, track.poses, t_ns), pose_covariance=track.covariance[near],
        servo_from_sonar=from_mount(sonar.mount),
        mount_sigma=np.r_[sonar.mount_sigma[:3], np.radians(sonar.mount_sigma[3:])],
    )  # fmt: skip
    normals = chart.from_chart(footprints.at.reshape(-1, 2))[1].reshape(footprints.point.shape)
    names = ("position_sigma_m", "position_sigma_of_mount_m")
    both = position_sigma(pings, footprints.point, normals)
    return {n: float(np.nanmedian(s)) if np.isfinite(s).any() else None for n, s in zip(names, both, strict=True)}


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
