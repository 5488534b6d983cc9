# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""links: images compared pair by pair, in rounds, and the path that they and navigation give."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hullrecon.artifacts.graph.stage import Context, Stage
from hullrecon.dive.config.schema import Tray
from hullrecon.estimation.rig_priors import RIG_SECTIONS, rig_priors_from_settings
from hullrecon.navigation.pose_graph.graph import PoseGraph
from hullrecon.navigation.pose_graph.ties import describe_parts
from hullrecon.records.serialisation import to_arrays
from hullrecon.rig import RIG_KEYS, rig_from_settings
from hullrecon.steps.artifacts import InputArtifacts
from hullrecon.vision.compared_pairs import NavigatedDive
from hullrecon.vision.link_images import link_images
from hullrecon.vision.options import LinkOptions, MatchOptions
from hullrecon.vision.pairs.match_worker import MatchWorker
from hullrecon.vision.stereo.camera_rig import CameraRig


def applies(settings: Mapping[str, object]) -> str | None:
    """Return why a dive cannot have this step; None where it can."""
    return None if settings["camera.top"] is not None else "no camera was carried"


def run(context: Context[LinkOptions]) -> None:
    """Leave what pairs of images have in common, and the path that this ties together."""
    inputs, settings = InputArtifacts(context.inputs), context.settings
    rig = rig_from_settings(_rig_values(settings), inputs.ingest.camera_models)
    worker = MatchWorker(
        features=context.inputs["features"], rig=CameraRig(rig), options=settings.read("matches", MatchOptions)
    )
    navigate = inputs.navigate
    dive = NavigatedDive(
        trajectory=navigate.trajectory,
        errors=navigate.error_model,
        returns=navigate.returns,
        tray_sigma_rad=float(np.radians(settings.read("tray", Tray).sigma_deg)),
    )
    graph = PoseGraph(
        trajectory=navigate.trajectory,
        odometry=navigate.odometry,
        attitude=navigate.attitude,
        rig=rig_priors_from_settings(settings, inputs.ingest.camera_models),
        kernel=context.parameters.kernel,
    )
    found = link_images(worker, dive, graph.solve, context.map, context.parameters.max_rounds)
    context.out.arrays("pairs.npz", to_arrays(found.pairs))
    context.out.arrays("features.npz", to_arrays(found.features))
    context.out.arrays("links.npz", to_arrays(found.links))
    context.out.arrays("stereo.npz", to_arrays(found.stereo))
    context.out.arrays("path.npz", to_arrays(found.path))
    sentence = describe_parts(found.path, navigate.trajectory.t_ns)
    if sentence is not None:
        context.warn(sentence)
    context.out.json("links.json", {"keyframes": len(found.keyframes), "rounds": found.rounds()})


def _rig_values(settings: Mapping[str, object]) -> dict[str, object]:
    """Return the values that a rig is made of, out of the sections, which are read whole for their sigmas."""
    sections = {key: key.rpartition(".") for key in RIG_KEYS if not key.startswith("sonar")}
    return {key: getattr(settings[section], name, None) for key, (section, _, name) in sections.items()}


STAGE = Stage(
    name="links",
    summary="link images in rounds and straighten the path with them",
    inputs=("ingest", "navigate", "features"),
    parameters=LinkOptions,
    version=2,
    run=run,
    uses=(*RIG_SECTIONS, "matches"),
    applies=applies,
)
