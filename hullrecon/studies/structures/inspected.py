# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the studies of structures look at: a dive's landmarks over its hull, and its views."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.api.dive_run import DiveRun
from hullrecon.artifacts.stage import settings_for
from hullrecon.detection.views import CameraViews, views_of_top_camera
from hullrecon.dive.images.store import ImageStore
from hullrecon.errors import InputError
from hullrecon.evaluation.deliverables import TimedPoses
from hullrecon.evaluation.trajectory import score_trajectory
from hullrecon.evaluation.truth import Truth
from hullrecon.geometry.charts.chart import Chart
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.rig import Rig, rig_from_settings
from hullrecon.steps.keys import CAMERA_KEYS
from hullrecon.studies.dive_steps import inputs_of_step
from hullrecon.studies.methods.method_figures import stamps
from hullrecon.typing import Array

MAX_OFF_HULL_M = 0.6  # landmarks farther off the hull are left out, as the step detect does


@dataclass(frozen=True, kw_only=True)
class InspectedHull:
    """An adjusted dive with cameras, in M."""

    features: Array  # (m, 3) landmarks
    height: Array  # (m,) m that they stand over the hull: the CAD model moved by its field
    views: CameraViews  # of the top camera
    track: VehicleTrack
    rig: Rig  # with its mounts as adjusted
    cad_model: Mesh
    chart: Chart
    truth_from_result: Poses  # the rigid motion that lays the path onto the true one
    images: dict[Camera, ImageStore]


def inspect(dive: DiveRun, truth: Truth) -> InspectedHull:
    """Read an adjusted dive. Raises InputError without a CAD model that fits, or a camera."""
    inputs = inputs_of_step(dive, "mosaic-optical")
    adjust, cad_model = inputs.adjust, inputs.ingest.hull
    index = inputs.ingest.image_index(Camera.TOP)
    if adjust is None or adjust.solution.hull_pose is None or cad_model is None or index is None:
        raise InputError(
            "structures are studied on a dive with images whose CAD model fits",
            where=str(dive.workspace.root),
            remedy="take such a dive",
        )
    settings = inputs.mounted(settings_for(dive.chain.stage("mosaic-optical"), dive.chain.sections))
    solution = adjust.solution
    rig = rig_from_settings(
        {key: settings[key] for key in CAMERA_KEYS}, inputs.camera_models
    ).with_mounts(solution.mounts)
    position = solution.result_from_global().apply(solution.landmarks.position)
    position = position[np.isfinite(position).all(axis=1)]
    foot = Scene(cad_model).closest(position)
    height, field = foot.distance, solution.deviation_field
    if field is not None and adjust.chart is not None:
        height = height - np.nan_to_num(field.value_at(adjust.chart.to_chart(foot.foot)[:, :2]))
    near = np.abs(height) < MAX_OFF_HULL_M
    track = solution.track()
    views = views_of_top_camera(rig, track, index.t_ns, position)
    assert views is not None  # there are images, and they gave landmarks
    _, motion = score_trajectory(TimedPoses(t_s=stamps(solution), poses=track.poses), truth)
    return InspectedHull(
        features=position[near],
        height=height[near],
        views=views,
        track=track,
        rig=rig,
        cad_model=cad_model,
        chart=inputs.surface.chart,
        truth_from_result=motion,
        images={camera: inputs.ingest.images(camera, dive.chain.package) for camera in rig.cameras},
    )
