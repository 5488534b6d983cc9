# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The dive adjusted: poses, landmarks with labels, the hull's place and its deviation from the CAD model."""

from __future__ import annotations

import json
import logging
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hullrecon.adjustment.bundle_adjustment import Adjusted, adjust
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.problem.intrinsics import camera_fields
from hullrecon.adjustment.problem.measurements import CadModel, Measurements, rig_from_config
from hullrecon.adjustment.problem.triangulation import camera_poses
from hullrecon.adjustment.results.colmap_export import SparseModel, write_model
from hullrecon.adjustment.results.solution import summarise_adjustment
from hullrecon.artifacts.graph.stage import Context, Stage, load_arrays
from hullrecon.geometry import poses
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.charts.chart import chart_for_hull
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.records.sensors import ImageIndex
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.tracks import Tracks
from hullrecon.records.trajectory import Attitude, Odometry, Returns, Trajectory


def run(context: Context) -> None:
    measured = _measurements(context)
    adjusted = adjust(measured, context.parameters, logging.getLogger(__name__).info)
    outcome = summarise_adjustment(measured, adjusted, context.parameters)
    for sentence in outcome.warnings:
        context.warn(sentence)
    context.out.arrays("solution.npz", to_arrays(outcome.solution))
    context.out.arrays("iterations.npz", outcome.iterations)
    context.record_times("iterations_s", outcome.iterations_s.tolist())
    context.out.json("adjust.json", outcome.summary)
    if measured.cad_model is not None:
        context.out.arrays("chart.npz", measured.cad_model.chart.to_arrays())
    if context.parameters.refine_intrinsics:
        found = {"top": adjusted.rig.top, "bottom": adjusted.rig.bottom}
        context.out.json("cameras.json", {name: camera_fields(camera) for name, camera in found.items() if camera is not None})
    if measured.tracks is not None:
        _write_colmap(context, replace(measured, rig=adjusted.rig), adjusted)


def _measurements(context: Context) -> Measurements:
    navigate, settings = context.inputs["navigate"], context.settings
    cameras = _cameras(context.inputs["ingest"] / "cameras.json")
    tracks = context.inputs.get("matches")
    returns = navigate / "returns.npz"
    return Measurements(
        trajectory=from_arrays(Trajectory, load_arrays(navigate / "trajectory.npz")),
        odometry=from_arrays(Odometry, load_arrays(navigate / "odometry.npz")),
        returns=from_arrays(Returns, load_arrays(returns)) if returns.exists() else None,
        attitude=from_arrays(Attitude, load_arrays(navigate / "attitude.npz")),
        tracks=from_arrays(Tracks, load_arrays(tracks / "tracks.npz")) if tracks is not None else None,
        rig=rig_from_config(
            settings["tray"],
            settings["imu"],
            settings["pressure"],
            settings["dvl"],
            settings["camera.top"],
            settings["camera.bottom"],
            cameras,
            context.parameters.free_dvl_position,
        ),
        cad_model=_cad_model(context.inputs["ingest"] / "hull.npz", settings["hull"]),
    )


def _cameras(path: Path) -> dict[str, CameraModel]:
    if not path.exists():
        return {}
    return {name: CameraModel(**fields) for name, fields in json.loads(path.read_text()).items()}


def _cad_model(path: Path, hull: Any) -> CadModel | None:
    if hull is None or not path.exists():
        return None
    arrays = load_arrays(path)
    mesh = Mesh(arrays["vertices"], arrays["faces"])
    sigma = np.array(hull.pose_sigma) * np.r_[np.ones(3), np.full(3, np.pi / 180)]
    return CadModel(
        mesh=mesh,
        chart=chart_for_hull(mesh),
        guess=poses.from_mount(hull.pose),
        guess_sigma=np.maximum(sigma, 1e-6),
        deviation_sigma=hull.deviation_sigma,
        deviation_length=hull.deviation_length,
    )


def _write_colmap(context: Context, m: Measurements, adjusted: Adjusted) -> None:
    state, mount = adjusted.state, adjusted.state.T_s_ct
    if m.tracks is None or m.rig.top is None or mount is None:
        return
    top, _ = camera_poses(state.nodes, state.tray, m.rig, mount, state.T_ct_cb)
    to_hull = state.T_g_M.inverse() if state.T_g_M is not None else poses.identity()
    model = SparseModel(
        tracks=m.tracks,
        top=adjusted.chosen.top,
        bottom=adjusted.chosen.bottom,
        hull_from_top=to_hull @ top,
        T_ct_cb=state.T_ct_cb,
        cameras=(m.rig.top, m.rig.bottom),
        stamps=_stamps(context.inputs["ingest"], m.trajectory.image),
        position=to_hull.apply(state.landmark),
    )
    with tempfile.TemporaryDirectory() as folder:
        write_model(model, Path(folder))
        for file in sorted(Path(folder).iterdir()):
            context.out.bytes(f"colmap/{file.name}", file.read_bytes())


def _stamps(ingest: Path, image: NDArray[np.int64]) -> NDArray[np.int64]:
    """Time stamps (n, 2) in ns of the images at the nodes, -1 where there is none."""
    stamps = np.full(image.shape, -1, np.int64)
    for k, name in enumerate(("camera_top", "camera_bottom")):
        path = ingest / f"images_{name}.npz"
        if path.exists():
            index = from_arrays(ImageIndex, load_arrays(path))
            has = image[:, k] >= 0
            stamps[has, k] = index.t_ns[image[has, k]]
    return stamps


STAGE = Stage(
    name="adjust",
    summary="adjust images, DVL ranges and the CAD model together",
    inputs=("ingest", "navigate"),
    optional=("matches",),
    uses=("tray", "imu", "pressure", "dvl", "camera.top", "camera.bottom", "hull"),
    parameters=AdjustOptions,
    version=4,
    run=run,
)
