# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The step `adjust`: images, DVL ranges and the CAD model adjusted together."""

from __future__ import annotations

import logging
import shutil
import tempfile
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np

from hullrecon.adjustment.bundle_adjustment import Adjusted, adjust
from hullrecon.adjustment.options import PRODUCT, AdjustOptions, Strategy
from hullrecon.adjustment.problem.intrinsics import camera_fields
from hullrecon.adjustment.problem.measurements import CadModel, Measurements
from hullrecon.adjustment.problem.triangulation import camera_poses
from hullrecon.adjustment.results.colmap_export import SparseModel, write_model
from hullrecon.adjustment.results.summary import summarise_adjustment
from hullrecon.artifacts.machine import refuse_small_address_space
from hullrecon.artifacts.stage import Context, StageSettings
from hullrecon.dive.check.hull_checks import check_length
from hullrecon.dive.config import schema
from hullrecon.dive.config.mounts import guess_sigma
from hullrecon.findings.finding import sentences
from hullrecon.geometry import poses
from hullrecon.geometry.charts.chart import chart_for_hull
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.serialisation import to_arrays
from hullrecon.records.trajectory import Attitude
from hullrecon.steps.artifacts import IngestArtifact, InputArtifacts
from hullrecon.typing import Ints

Options = TypeVar("Options", bound=AdjustOptions)


def run(context: Context[AdjustOptions]) -> None:
    """Adjust the dive by the strategy of the product."""
    run_adjustment(context, PRODUCT)


def run_adjustment(context: Context[Options], strategy: Strategy) -> None:
    """Adjust the dive, and write the step's files.

    The chart is written only with a hull, cameras.json only if calibrations were refined, and the
    COLMAP model only with feature tracks.

    strategy: the phases and rounds of the adjustment. hullrecon/studies has published ones.
    """
    refuse_small_address_space(context.parameters.threads)
    measured = _measurements(context)
    if not strategy.hull:
        measured = replace(measured, cad_model=None, planes=None)
    # Parts that a killed run left refer to the measurements by these names, and do not hold them.
    given = {name: getattr(measured, name) for name in measured.__dataclass_fields__}
    adjusted = adjust(
        measured,
        context.parameters,
        logging.getLogger(__name__).info,
        strategy,
        partial(context.once, given=given),
    )
    outcome = summarise_adjustment(measured, adjusted, context.parameters)
    for sentence in [
        *guess_without_depth(measured.cad_model, measured.attitude),
        *length_apart(context.settings, measured.cad_model),
        *outcome.warnings,
    ]:
        context.warn(sentence)
    context.out.arrays("solution.npz", to_arrays(outcome.solution))
    context.out.arrays("iterations.npz", outcome.iterations)
    context.record_times("iterations_s", outcome.iterations_s.tolist())
    context.out.json("adjust.json", outcome.summary)
    if adjusted.state.hull is not None:
        context.out.arrays("chart.npz", adjusted.state.hull.cad_model.chart.to_arrays())
    if context.parameters.refine_intrinsics:
        found = {"top": adjusted.rig.top, "bottom": adjusted.rig.bottom}
        context.out.json(
            "cameras.json",
            {name: camera_fields(camera) for name, camera in found.items() if camera is not None},
        )
    if measured.tracks is not None:
        _write_colmap(context, replace(measured, rig=adjusted.rig), adjusted)


def guess_without_depth(cad_model: CadModel | None, attitude: Attitude) -> list[str]:
    """Warn, if no depth was measured, that only the hull's shape determines its height in g.

    Empty without a CAD model, or if a depth was measured.
    """
    if cad_model is None or attitude.has_depth.any():
        return []
    sigma_m = float(np.linalg.norm(poses.up_in(cad_model.guess) * cad_model.guess_sigma[:3]))
    return [
        "No depth was measured: the first pose may be anywhere between the water's surface and "
        f"the keel, and hull.pose tells the height of the hull to {sigma_m:.1f} m (one sigma)."
    ]


def length_apart(settings: StageSettings, cad_model: CadModel | None) -> list[str]:
    """Warn of a CAD model that is a few per cent longer or shorter than hull.length_overall.

    Empty without a CAD model. Raises InputError where it is no ship of that length.
    """
    hull = settings.read_optional("hull", schema.Hull)
    if hull is None or cad_model is None:
        return []
    return sentences(check_length(hull, cad_model.mesh))


def _measurements(context: Context[Options]) -> Measurements:
    """Collect the measurements of the adjustment from the artifacts of earlier steps.

    What the dive lacks is None: tracks without a camera, returns without a DVL, and so on.
    """
    inputs = InputArtifacts(context.inputs)
    settings = inputs.mounted(context.settings)
    return Measurements(
        trajectory=inputs.navigate.trajectory,
        odometry=inputs.navigate.odometry,
        returns=inputs.navigate.returns,
        attitude=inputs.navigate.attitude,
        tracks=inputs.matches.mapped_tracks() if inputs.matches is not None else None,
        start=inputs.links.path.path() if inputs.links is not None else None,
        planes=inputs.links.planes if inputs.links is not None else None,
        positions=inputs.navigate.positions,
        rig=inputs.rig(settings),
        cad_model=_cad_model(
            inputs.ingest.hull,
            settings.read_optional("hull", schema.Hull),
            has_depth=bool(inputs.navigate.attitude.has_depth.any()),
        ),
    )


def _cad_model(
    mesh: Mesh | None, hull: schema.Hull | None, has_depth: bool = True
) -> CadModel | None:
    """Build the CAD model with the package's guess of its pose. None if the dive has none.

    If no depth was measured, z = 0 of g is the unknown depth of the first pose, anywhere between
    the water's surface and the keel. The guess is relative to the water's surface, so that its
    vertical sigma grows by that depth.
    """
    if hull is None or mesh is None:
        return None
    sigma = guess_sigma(hull.pose, hull.pose_sigma) * np.r_[np.ones(3), np.full(3, np.pi / 180)]
    guess = poses.from_mount(hull.pose)
    if not has_depth:
        keel_m = max(float(guess.apply(mesh.vertices)[:, 2].max()), 0.0)
        start_m = keel_m / np.sqrt(3)  # root mean square of depths equally likely down to the keel
        sigma[:3] = np.hypot(sigma[:3], start_m * poses.up_in(guess))
    return CadModel(
        mesh=mesh,
        chart=chart_for_hull(mesh, poses.up_in(guess), hull.bow, hull.aft_perpendicular),
        guess=guess,
        guess_sigma=np.maximum(sigma, 1e-6),
        deviation_sigma=hull.deviation_sigma,
        deviation_length=hull.deviation_length,
        units=hull.units,
        has_stated_length=hull.length_overall is not None,
    )


def _write_colmap(context: Context[Options], measured: Measurements, adjusted: Adjusted) -> None:
    """Write the adjusted dive as a COLMAP model, for other photogrammetry software.

    Poses and points are in the hull's frame, or in g without a hull. Nothing is written without a
    camera.
    """
    state = adjusted.state
    if measured.tracks is None or measured.rig.top is None or state.mounts.tray_from_top is None:
        return
    top, _ = camera_poses(measured.rig, state)
    to_hull = state.hull.global_from_hull.inverse() if state.hull is not None else poses.identity()
    model = SparseModel(
        tracks=measured.tracks,
        top=adjusted.chosen.top,
        bottom=adjusted.chosen.bottom,
        hull_from_top=to_hull @ top,
        top_from_bottom=state.mounts.top_from_bottom,
        cameras=(measured.rig.top, measured.rig.bottom),
        stamps=_image_stamps(InputArtifacts(context.inputs).ingest, measured.trajectory.image),
        position=to_hull.apply(state.landmark),
    )
    with tempfile.TemporaryDirectory() as folder:
        write_model(model, Path(folder))
        for file in sorted(Path(folder).iterdir()):
            with context.out.path(f"colmap/{file.name}") as target:
                shutil.copyfile(file, target)


def _image_stamps(ingest: IngestArtifact, image: Ints) -> Ints:
    """Look up the stamps (n, 2) ns of the images at the nodes, -1 without an image.

    image (n, 2): rows of top and bottom image in their indices, -1 where there is none.
    """
    stamps = np.full(image.shape, -1, np.int64)
    for camera in Camera:
        index = ingest.image_index(camera)
        if index is not None:
            has = image[:, camera.column] >= 0
            stamps[has, camera.column] = index.t_ns[image[has, camera.column]]
    return stamps
