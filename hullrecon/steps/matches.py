# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""matches: join the matches of linked images to tracks."""

from __future__ import annotations

from hullrecon.artifacts.stage import Context
from hullrecon.errors import InputError
from hullrecon.records.serialisation import to_arrays
from hullrecon.rig import rig_from_settings
from hullrecon.steps.artifacts import InputArtifacts
from hullrecon.vision.match_images import MatchedImages, join_images
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.match_worker import MatchWorker
from hullrecon.vision.pairs.pair_match import REASON_TEXTS


def run(context: Context[MatchOptions]) -> None:
    """Join the matches of linked images to tracks, and write tracks.npz, pairs.npz and pairs.json.

    A track lists the images that show one point of the hull. Raises InputError without links.
    """
    inputs = InputArtifacts(context.inputs)
    rig = rig_from_settings(inputs.mounted(context.settings), inputs.ingest.camera_models)
    worker = MatchWorker(features=context.inputs["features"], rig=rig, options=context.parameters)
    links = inputs.links
    if links is None:
        raise InputError("the links are missing", where="matches", remedy="run the step links")
    found = join_images(
        worker,
        inputs.navigate.trajectory,
        links.pairs,
        links.links,
        links.features,
        links.stereo,
        int(str(links.facts["keyframes"])),
    )
    context.out.arrays("tracks.npz", to_arrays(found.tracks))
    _write_pairs(context, found)


def _write_pairs(context: Context[MatchOptions], found: MatchedImages) -> None:
    """Write the pairs with their inliers, and counts, failures and chains as pairs.json.

    The report tells from pairs.json why pairs of images did not match.
    """
    context.out.arrays("pairs.npz", {**to_arrays(found.pairs), "inliers": found.inliers})
    context.out.json(
        "pairs.json",
        {
            "reasons": {str(int(code)): text for code, text in REASON_TEXTS.items()},
            "failed": found.failures(),
            "chains": found.chains(),
            "counts": found.counts(),
        },
    )
