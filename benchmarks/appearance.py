# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How well places are recognised by appearance: python -m benchmarks.appearance PACKAGE RUN [--json
FILE]

RUN: the folder of results of a simulated dive, run to `links`. For each keyframe that truly came
back to a place (footprints overlapping by 30 %, 4 m of way or more between), all keyframes that are
4 m of way off are ranked by how alike they look: by words weighted as the step `links` does it, by
FAB-MAP [CumminsNewman2008] with and without its tree, and at random. Recall at k: share of those
queries with a true place among the first k; precision: share of true places among the first k;
called new: share of them that FAB-MAP takes for a place never seen.

Then the step's own way is gone again, from the path as neighbours alone leave it, and its links are
compared with the truth: those that matched, and those that were accepted. Prints JSON; exit code 1
where a false link was accepted.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.special import gammaln

from benchmarks import fabmap
from benchmarks.arguments import keep, parser_for
from benchmarks.false_links import Dive, read_dive
from benchmarks.legs import OTHER_LEG_M, OVERLAPPING, NoErrors
from benchmarks.links_in_graph import select, solved_graph
from hullrecon.navigation.pose_graph.graph import GraphSolution
from hullrecon.steps.artifacts import LinksArtifact
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.appearance.recognition import Recognition, learn_words, recognise_places
from hullrecon.vision.appearance.vocabulary import invert
from hullrecon.vision.compared_pairs import Item, LinkedScene, Result
from hullrecon.vision.pairs.camera_track import CameraTrack
from hullrecon.vision.pairs.footprints import footprint_overlap

RANKS = (1, 5, 20)
FALSE_M = 0.4  # between the relative position of a link and the true one
Figures = dict[str, object]


def here(function: Callable[[Item], Result], items: Sequence[Item], label: str) -> list[Result]:
    """Return the function of each item."""
    return [function(item) for item in items]


def ranked(scores: Array, candidate: Mask, true: Mask) -> Figures:
    """Return recall and precision of the highest scores (q, n) among the candidates; true (q, n):
    of the same place.
    """
    order = np.argsort(-np.where(candidate, scores, -np.inf), axis=1, kind="stable")
    hit = np.take_along_axis(true & candidate, order, axis=1)
    out: Figures = {}
    for k in RANKS:
        out[f"recall_at_{k}"] = float(hit[:, :k].any(axis=1).mean())
        out[f"precision_at_{k}"] = float(hit[:, :k].mean())
    return out


def at_random(candidate: Mask, true: Mask) -> Figures:
    """Return the mean score of a random ranking."""
    count, right = candidate.sum(axis=1), (true & candidate).sum(axis=1)
    out: Figures = {}
    for k in RANKS:
        wrong = count - right
        possible = wrong >= k
        none = np.where(
            possible, np.exp(_log_choose(np.maximum(wrong, k), k) - _log_choose(count, k)), 0.0
        )
        out[f"recall_at_{k}"] = float((1 - none).mean())
        out[f"precision_at_{k}"] = float((right / count).mean())
    return out


def _log_choose(n: Ints, k: int) -> Array:
    return np.asarray(gammaln(n + 1) - gammaln(k + 1) - gammaln(n - k + 1))


def retrieval(dive: Dive, scene: LinkedScene, keyframes: Ints) -> Figures:
    """Rank the true revisits of keyframes."""
    vocabulary, words = learn_words(scene.worker, [scene.nodes[k] for k in keyframes])
    n = len(keyframes)
    a, b = np.triu_indices(n, 1)
    track = CameraTrack(global_from_camera=dive.cameras[keyframes], errors=NoErrors())
    overlap = np.zeros((n, n))
    overlap[a, b] = footprint_overlap(track, a, b, dive.depth_m[keyframes], scene.camera)
    at = dive.cameras.translation
    way = np.r_[0, np.cumsum(np.linalg.norm(np.diff(at, axis=0), axis=1))][keyframes]
    candidate = np.abs(way[:, None] - way) > OTHER_LEG_M
    true = (overlap + overlap.T >= OVERLAPPING) & candidate
    queries = np.flatnonzero(true.any(axis=1))
    if len(queries) == 0:
        return {"keyframes": n, "queries": 0}
    shown = np.zeros((n, len(vocabulary)), bool)
    for row, found in enumerate(words):
        shown[row, found] = True
    learnt = fabmap.learn(shown)
    out: Figures = {"keyframes": n, "queries": len(queries), "words": len(vocabulary)}
    rows = candidate[queries], true[queries]
    out["tf_idf"] = ranked(invert(words, len(vocabulary)).scores(queries), *rows)
    for name, tree in (("fab_map", True), ("fab_map_naive_bayes", False)):
        likelihood = fabmap.log_likelihoods(learnt, shown, queries, tree)
        best = np.where(rows[0], likelihood[:, :-1], -np.inf).max(axis=1)
        out[name] = ranked(likelihood[:, :-1], *rows) | {
            "called_new": float((likelihood[:, -1] > best).mean())
        }
    return out | {"random": at_random(*rows)}


def closed(dive: Dive, scene: LinkedScene, keyframes: Ints, solved: GraphSolution) -> Figures:
    """Count the pairs that the step would accept, and the false ones among them."""
    track = scene.track(solved.path, solved.relative_errors(scene.bottom))
    found = recognise_places(scene, track, keyframes, np.zeros(0, np.int64))
    if found is None:
        return {"asked": False}
    wrong = false_links(dive, found)
    matched = np.array([pair.motion is not None for pair in found.found], bool)
    return {
        "asked": True,
        **found.facts(),
        "false_offered": int((~truly_overlapping(dive, scene, found)).sum()),
        "false_matched": int((wrong & matched).sum()),
        "false_accepted": int((wrong & found.accepted).sum()),
    }


def false_links(dive: Dive, found: Recognition) -> Mask:
    """Mark the pairs (m,) whose relative position is wrong."""
    first, second = found.proposal.first, found.proposal.second
    true = (dive.cameras[second].inverse() @ dive.cameras[first]).matrix()
    out = np.zeros(len(first), bool)
    for k, pair in enumerate(found.found):
        if pair.motion is not None:
            out[k] = np.linalg.norm(pair.motion.second_from_first[:3, 3] - true[k, :3, 3]) > FALSE_M
    return out


def truly_overlapping(dive: Dive, scene: LinkedScene, found: Recognition) -> Mask:
    """Mark the offered pairs (m,) that share any hull."""
    track = CameraTrack(global_from_camera=dive.cameras, errors=NoErrors())
    first, second = found.proposal.first, found.proposal.second
    return np.asarray(footprint_overlap(track, first, second, dive.depth_m, scene.camera) > 0)


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("package", type=Path)
    parser.add_argument("run", type=Path)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    dive, links = read_dive(args.package, args.run), LinksArtifact(args.run / "links")
    nodes = [replace(node, stereo=dive.worker.match_stereo(node)[1]) for node in dive.nodes]
    scene = LinkedScene(
        worker=dive.worker, map_items=here, nodes=nodes, depth_m=dive.depth_m, bottom=dive.bottom
    )
    pairs = links.pairs
    keyframes = np.unique(np.r_[pairs.first[~pairs.across], pairs.second[~pairs.across]])
    keyframes = keyframes[
        [
            dive.worker.saliency(scene.nodes[k]) >= dive.worker.options.min_saliency
            for k in keyframes
        ]
    ]
    solved = solved_graph(args.run, dive.config)
    neighbours = select(solved.links, ~pairs.across[pairs.joined])
    alone = solved.graph.solve(neighbours, None)
    row: Figures = {
        "retrieval": retrieval(dive, scene, keyframes),
        "closed": closed(dive, scene, keyframes, alone),
    }
    print(json.dumps(row))
    keep(row, args.json)
    result = row["closed"]
    return int(isinstance(result, dict) and bool(result.get("false_accepted")))


if __name__ == "__main__":
    sys.exit(main())
