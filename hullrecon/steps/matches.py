# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""matches: images compared pair by pair, and the tracks that their matches join to."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from hullrecon.artifacts.graph.stage import Context, Stage
from hullrecon.records.serialisation import to_arrays
from hullrecon.rig import RIG_KEYS, rig_from_settings
from hullrecon.steps.artifacts import InputArtifacts
from hullrecon.vision.match_images import MatchedImages, NavigatedDive, match_images
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.match_worker import MatchWorker
from hullrecon.vision.pairs.matching import REASON_TEXTS
from hullrecon.vision.stereo.camera_rig import CameraRig


def applies(settings: Mapping[str, object]) -> str | None:
    """Return why a dive cannot have this step; None where it can."""
    return None if settings["camera.top.mount"] is not None else "no camera was carried"


def run(context: Context[MatchOptions]) -> None:
    """Leave tracks.npz, pairs.npz and pairs.json."""
    inputs = InputArtifacts(context.inputs)
    rig = rig_from_settings(context.settings, inputs.ingest.camera_models)
    worker = MatchWorker(features=context.inputs["features"], rig=CameraRig(rig), options=context.parameters)
    dive = NavigatedDive(
        trajectory=inputs.navigate.trajectory,
        errors=inputs.navigate.error_model,
        returns=inputs.navigate.returns,
        tray_sigma_rad=float(np.radians(context.settings.read("tray.sigma_deg", float))),
    )
    found = match_images(worker, dive, context.map)
    context.out.arrays("tracks.npz", to_arrays(found.tracks))
    _write_pairs(context, found)


def _write_pairs(context: Context[MatchOptions], found: MatchedImages) -> None:
    proposal, chains = found.proposal, found.chains()
    context.out.arrays("pairs.npz", {
        "first": proposal.first, "second": proposal.second, "across": proposal.across, "overlap": proposal.overlap,
        "putative": np.array([pair.putative for pair in found.pairs], np.int64), "inliers": found.inliers,
        "reason": found.reason,
    })  # fmt: skip
    if len(chains) > 1:
        context.warn(
            f"the images fall into {len(chains)} chains without a match between them; the longest has {chains[0]} nodes"
        )
    reasons = {str(int(code)): text for code, text in REASON_TEXTS.items()}
    context.out.json("pairs.json", {"reasons": reasons, "failed": found.failures(), "chains": chains, "counts": found.counts()})


STAGE = Stage(
    name="matches",
    summary="match images and build feature tracks",
    inputs=("ingest", "navigate", "features"),
    parameters=MatchOptions,
    version=4,
    run=run,
    uses=(*RIG_KEYS, "tray.sigma_deg"),
    applies=applies,
)
