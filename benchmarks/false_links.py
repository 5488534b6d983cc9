# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether images of different places are ever linked: python -m benchmarks.false_links PACKAGE RUN [--pairs N] [--json FILE]

Offers N pairs of images of a simulated dive that share nothing (their footprints lie apart), each as if it were a revisit: with
the relative pose of a pair that truly overlaps, known to 0.3 m and 5 degrees. RUN: the dive's folder of results, run to
`links`. Prints how many were linked: none should be.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import numpy as np

from benchmarks.legs import true_revisits
from hullrecon.dive.config.load import load_config
from hullrecon.evaluation.scoring.truth import read_truth
from hullrecon.rig import RIG_KEYS, rig_from_settings
from hullrecon.steps.artifacts import IngestArtifact, NavigateArtifact
from hullrecon.steps.chain import stages
from hullrecon.typing import Array, Ints
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pair_match import Reason
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.match_worker import MatchNode, MatchPairs, MatchStereo, MatchWorker, NodePair
from hullrecon.vision.stereo.camera_rig import CameraRig
from hullrecon.vision.stereo.matching import no_matches

APART_M = 4.0  # between the cameras of two images that share nothing
SIGMA = np.diag(np.repeat([0.3**2, np.radians(5.0) ** 2], 3))
BLOCK = 200  # pairs compared at once, in the order of their first nodes, so that views are made but once or twice


def worker_of(package: Path, run: Path) -> MatchWorker:
    """Return the matcher as the dive's run had it."""
    config = load_config(package, {stage.name: stage.parameters for stage in stages()})
    ingest = IngestArtifact(run / "ingest")
    rig = rig_from_settings({name: config.value(name) for name in RIG_KEYS}, ingest.camera_models)
    options = config.value("matches")
    assert isinstance(options, MatchOptions)
    return MatchWorker(features=run / "features", rig=CameraRig(rig), options=options)


def offered(centres: Array, count: int, rng: np.random.Generator) -> tuple[Ints, Ints]:
    """Return pairs (first, second) of nodes that see different places. centres (n, 3) m."""
    first, second = rng.integers(0, len(centres), (2, 20 * count))
    apart = np.linalg.norm(centres[first] - centres[second], axis=1) > APART_M
    ordered = np.unique(np.sort(np.column_stack([first, second])[apart], axis=1), axis=0)
    chosen = ordered[np.sort(rng.choice(len(ordered), min(count, len(ordered)), replace=False))]
    return chosen[:, 0], chosen[:, 1]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("package", type=Path)
    parser.add_argument("run", type=Path)
    parser.add_argument("--pairs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    rng, truth = np.random.default_rng(args.seed), read_truth(args.package)
    trajectory = NavigateArtifact(args.run / "navigate").trajectory
    t_s = trajectory.t_ns / 1e9
    cameras = truth.cameras_at(np.clip(np.searchsorted(truth.t_s, t_s), 0, len(truth.t_s) - 1))
    overlapping = true_revisits(args.run, truth)
    first, second = offered(cameras.translation, args.pairs, rng)
    like = rng.integers(0, len(overlapping[0]), len(first))
    worker = worker_of(args.package, args.run)
    bare = [MatchNode(image=(int(a), int(b)), depth=None, stereo=no_matches()) for a, b in trajectory.image]
    nodes: dict[int, MatchNode] = {}
    reasons = dict.fromkeys((reason.name for reason in Reason), 0)
    for start in range(0, len(first), BLOCK):
        pairs = []
        for a, b, k in zip(first[start:][:BLOCK], second[start:][:BLOCK], like[start:][:BLOCK], strict=True):
            i, j = overlapping[0][[k]], overlapping[1][[k]]
            expected = Motion((cameras[j].inverse() @ cameras[i]).matrix()[0], SIGMA)
            pairs.append(NodePair(first=int(a), second=int(b), expected=expected, full_search=False))
        for node in {p.first for p in pairs} | {p.second for p in pairs}:
            if node not in nodes:
                _, stereo = MatchStereo(worker)(bare[node])
                nodes[node] = MatchNode(image=bare[node].image, depth=None, stereo=stereo)
        touched = {node: nodes[node] for p in pairs for node in (p.first, p.second)}
        for match in MatchPairs(worker)((touched, pairs)):
            reasons[Reason(match.reason).name] += 1
        done = min(start + BLOCK, len(first))
        print(f"{done} of {len(first)} offered, {reasons[Reason.MATCHED.name]} linked", file=sys.stderr, flush=True)
    row = {"offered": len(first), "linked": reasons[Reason.MATCHED.name], "reasons": reasons}
    print(json.dumps(row))
    if args.json:
        args.json.write_text(json.dumps(row, indent=1))
    return int(row["linked"] > 0)


if __name__ == "__main__":
    sys.exit(main())
