# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The step `surface`: the hull from DVL returns, or from landmarks if no DVL was carried.

Poses are the adjusted ones if there are any, else dead reckoned.
"""

from __future__ import annotations

from hullrecon.artifacts.stage import Context, StageSettings
from hullrecon.dive.config.mounts import guess_sigma
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import from_mount, up_in
from hullrecon.records.serialisation import to_arrays
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.rig import rig_from_settings
from hullrecon.steps.artifacts import InputArtifacts
from hullrecon.steps.keys import DVL_KEYS
from hullrecon.surface.build import Regression, gaussian_process
from hullrecon.surface.from_returns import (
    CadHull,
    Reference,
    SurfaceInputs,
    UnknownHull,
    move_to_hull_frame,
    own_chart,
    surface_from_survey,
)
from hullrecon.surface.options import SurfaceOptions


def run(
    context: Context[SurfaceOptions],
    regression: Regression = gaussian_process,
    reference: Reference = own_chart,
) -> None:
    """Fit the surface and write it with its chart, on which all later steps work.

    The CAD model is left aside where the adjustment refused it.

    `regression`: how the surface is fitted to returns. `reference`: the surface from which its
    offsets count. hullrecon/studies has published variants of both.
    """
    inputs = InputArtifacts(context.inputs)
    settings = inputs.mounted(context.settings)
    adjust, cad_model = inputs.adjust, inputs.ingest.hull
    if adjust is not None and adjust.solution.hull_pose is None:
        cad_model = None  # there is none, or the adjustment refused it
    rig = rig_from_settings({key: settings[key] for key in DVL_KEYS})
    if adjust is not None:
        track, source = adjust.solution.track(), "adjusted"
    else:
        track, source = _dead_reckoned_track(inputs, settings)
    survey = SurfaceInputs(
        hull=UnknownHull() if cad_model is None else _cad_hull(cad_model, settings),
        track=track,
        rig=rig if adjust is None else rig.with_mounts(adjust.solution.mounts),
        returns=inputs.navigate.returns,
        range_sigma_m=settings.read("dvl.sigma_range", float),
        solution=adjust.solution if adjust is not None else None,
        chart=adjust.chart if adjust is not None else None,
    )
    result = surface_from_survey(survey, context.parameters, regression, reference)
    context.out.arrays("surface.npz", to_arrays(result.surface))
    context.out.arrays("chart.npz", result.chart.to_arrays())
    context.out.json("surface.json", {**result.facts, "poses": source})


def _cad_hull(mesh: Mesh, settings: StageSettings) -> CadHull:
    """Combine the CAD model with what dive.toml tells of its axes: up, bow, aft perpendicular.

    Without hull.pose, up is z of the mesh.
    """
    pose = settings.read_optional("hull.pose", tuple)
    return CadHull(
        mesh=mesh,
        up=(0.0, 0.0, 1.0) if pose is None else up_in(from_mount(pose)),
        bow=settings.read_optional("hull.bow", str),
        aft_perpendicular_m=settings.read_optional("hull.aft_perpendicular", float),
    )


def _dead_reckoned_track(
    inputs: InputArtifacts, settings: StageSettings
) -> tuple[VehicleTrack, str]:
    """Move the dead-reckoned track into the hull frame by hull.pose, and name its source.

    It stays in g without a CAD model or a pose.
    """
    track, pose = inputs.navigate.trajectory.track(), settings.read_optional("hull.pose", tuple)
    if inputs.ingest.hull is None or pose is None:
        return track, "dead reckoned"
    sigma_m = guess_sigma(pose, settings.read_optional("hull.pose_sigma", tuple))[:3]
    return move_to_hull_frame(
        track, from_mount(pose), sigma_m
    ), "dead reckoned, placed by hull.pose"
