# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The mosaic of the imaging sonar on the hull's chart and on the surface."""

from __future__ import annotations

from functools import partial
from typing import BinaryIO

import numpy as np

from hullrecon.artifacts.stage import Context, StageSettings
from hullrecon.errors import StageError
from hullrecon.geometry.poses import Poses, from_mount
from hullrecon.mosaic.mosaic_surface import MosaicSurface
from hullrecon.mosaic.options import SonarOptions
from hullrecon.mosaic.position_sigma import PingUncertainty, median_position_sigma
from hullrecon.mosaic.sonar import SonarMosaic, sonar_mosaic
from hullrecon.mosaic.stream import Stream
from hullrecon.records.sensors import SonarPings
from hullrecon.steps.artifacts import InputArtifacts
from hullrecon.steps.mosaics import read_mosaic_inputs, write_mosaic
from hullrecon.steps.sonar import logged_pings, ping_poses
from hullrecon.threads import in_threads


def run(context: Context[SonarOptions]) -> None:
    """Blend the sonar's pings on the surface, and write the mosaic with its position's sigma.

    The sigma follows from the poses' covariance and the sonar's mount. Raises StageError if there
    is no ping, the sonar's servo was not logged, or no ping meets the surface.
    """
    artifacts = InputArtifacts(context.inputs)
    settings = artifacts.mounted(context.settings)
    pings = logged_pings(artifacts)
    inputs = read_mosaic_inputs(artifacts)
    poses = ping_poses(artifacts, settings, inputs.track)
    nodes_ns, mount_sigma = inputs.track.t_ns, np.array(settings.read("sonar.mount_sigma", tuple))
    uncertainty = PingUncertainty(
        sonar=poses,
        vehicle=inputs.track.vehicle_at(pings.t_ns),
        # of the first node at or after the ping
        pose_covariance=inputs.track.covariance[
            np.minimum(np.searchsorted(nodes_ns, pings.t_ns), len(nodes_ns) - 1)
        ],
        servo_from_sonar=from_mount(settings.read("sonar.mount", tuple)),
        mount_sigma=np.r_[mount_sigma[:3], np.radians(mount_sigma[3:])],
    )
    stream = partial(context.stream, by=in_threads)
    with context.out.scratch() as scratch:
        mosaic = blend_pings(inputs.surface, pings, poses, settings, stream, scratch)
        if mosaic.contrast is not None and mosaic.contrast.words:
            context.warn(mosaic.contrast.words)
        facts: dict[str, object] = {
            **median_position_sigma(uncertainty, mosaic.footprints, inputs.surface.chart),
            "pings": len(pings.t_ns),
            "poses": "dead reckoned" if inputs.mounts is None else "adjusted",
            "remarks": ["returns brought to one level by range, beam and ping"]
            if mosaic.light_corrected
            else ["returns left as they were"],
        }
        write_mosaic(context, inputs, mosaic.store, "Sonar mosaic", facts, scratch)


def blend_pings(
    surface: MosaicSurface,
    pings: SonarPings,
    poses: Poses,
    settings: StageSettings,
    stream: Stream,
    scratch: BinaryIO,
) -> SonarMosaic:
    """Blend pings with known poses on a surface. Raises StageError if no ping meets it."""
    elevation_rad = np.radians(settings.read("sonar.elevation_deg", float))
    try:
        return sonar_mosaic(
            surface,
            pings,
            poses,
            elevation_rad,
            settings.read("mosaic-sonar", SonarOptions),
            stream,
            scratch,
        )
    except ValueError as error:
        where = f"mosaic-sonar, pings to {pings.range_m.max():.1f} m"
        raise StageError(f"no sonar mosaic: {error}", where=where) from error
