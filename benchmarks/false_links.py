# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether images of different places are ever linked: python -m benchmarks.false_links PACKAGE RUN
[--pairs N] [--json FILE]

Offers N pairs of images of a simulated dive that share nothing, each as if it were a revisit, known
to 0.3 m and 5 degrees, and as a control as many true revisits. RUN: the dive's folder of results,
run to `adjust`.

A false pair comes with the relative pose of a pair that truly overlaps. On a hull whose paint
repeats (`simulate
--paint-repeats-m`) the false pairs are those that look alike, one repetition or more apart along
the hull, with the pose of a navigation that is wrong by just that: nothing in the images speaks
against them. So they are offered as a run offers them, too: with what the dive's own path says of
the two. And those that the images took are added to the links of the run, one to twenty of these,
for three-cycles and the pose graph to throw out.

Prints JSON: offered and linked, by kind, with the reasons; exit code 1 where the run would have
kept a false link.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.arguments import keep, parser_for
from benchmarks.legs import NoErrors, cast, nearest_frames, true_revisits
from benchmarks.links_in_graph import kept_by_graph, links_of, solved_graph
from hullrecon.dive.config.load import LoadedConfig, load_config
from hullrecon.dive.config.schema import RIG_KEYS, Tray
from hullrecon.evaluation.truth import Truth, read_truth
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import Poses
from hullrecon.navigation.pose_graph.graph import GraphSolution
from hullrecon.rig import rig_from_settings
from hullrecon.steps.artifacts import IngestArtifact, LinksArtifact, NavigateArtifact
from hullrecon.steps.chain import stages
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.match_images import stereo_by_node
from hullrecon.vision.options import MatchOptions
from hullrecon.vision.pairs.camera_track import (
    CameraTrack,
    depth_priors,
    leading_cameras,
    track_cameras,
)
from hullrecon.vision.pairs.footprints import footprint_overlap
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.match_worker import MatchNode, MatchWorker, NodePair
from hullrecon.vision.pairs.pair_match import PairMatch, Reason
from hullrecon.vision.stereo.matching import no_matches

APART_M = 4.0  # between the cameras of two images that share nothing
ALIKE = 0.3  # of the footprints, that look alike
SIGMA = np.diag(np.repeat([0.3**2, np.radians(5.0) ** 2], 3))
# pairs compared at once, in the order of their first nodes, so that views are made but once or
# twice
BLOCK = 50


@dataclass(frozen=True, kw_only=True)
class Offer:
    """Pairs of nodes that are offered as revisits."""

    first: Ints  # (m,)
    second: Ints  # (m,)
    expected: Sequence[Motion]  # (m) second_from_first that is claimed

    def __len__(self) -> int:
        return len(self.first)


@dataclass(frozen=True, kw_only=True)
class Dive:
    """A dive as run, with the true poses of its cameras."""

    package: Path
    run: Path
    config: LoadedConfig
    worker: MatchWorker
    nodes: list[MatchNode]
    bottom: Mask  # (n,) nodes where the bottom camera leads
    cameras: Poses  # (n,) T_M_c of the leading camera at every node, true
    depth_m: Array  # (n,) of the scene along its axis, true


def read_dive(package: Path, run: Path) -> Dive:
    """Return the dive and the matcher as its run had it, with depths of the scene by the DVL."""
    config = load_config(package, {stage.name: stage.parameters for stage in stages()})
    ingest, navigate, truth = (
        IngestArtifact(run / "ingest"),
        NavigateArtifact(run / "navigate"),
        read_truth(package),
    )
    rig = rig_from_settings({name: config.value(name) for name in RIG_KEYS}, ingest.camera_models)
    options, tray = config.value("matches"), config.value("tray")
    assert isinstance(options, MatchOptions)
    assert isinstance(tray, Tray)
    worker = MatchWorker(features=run / "features", rig=rig, options=options)
    reckoned, returns = navigate.trajectory, navigate.returns
    images = [(int(top), int(bottom)) for top, bottom in reckoned.image]
    stereo = stereo_by_node(LinksArtifact(run / "links").stereo)
    bottom = worker.bottom_leads(
        [MatchNode(image=i, depth=None, stereo=s) for i, s in zip(images, stereo, strict=True)]
    )
    track = track_cameras(
        reckoned, navigate.error_model, worker.rig, float(np.radians(tray.sigma_deg)), bottom
    )
    depths = [None] * len(track) if returns is None else depth_priors(track, reckoned, returns, rig)
    bare = [
        MatchNode(image=i, depth=d, stereo=no_matches())
        for i, d in zip(images, depths, strict=True)
    ]
    cameras = true_cameras(truth, reckoned.t_ns / 1e9)
    depth_m = cast(truth.built, cameras.translation, cameras.rotation.as_matrix()[:, :, 2])
    return Dive(
        package=package,
        run=run,
        config=config,
        worker=worker,
        nodes=bare,
        bottom=bottom,
        cameras=cameras,
        depth_m=depth_m,
    )


def true_cameras(truth: Truth, t_s: Array) -> Poses:
    """Return the true camera poses at the frames nearest to times (n,)."""
    return truth.cameras_at(nearest_frames(truth.t_s, t_s))


def motions(cameras: Poses, first: Ints, second: Ints, shift: Array) -> list[Motion]:
    """Return second_from_first of cameras (n), the second moved by shift (m, 3) in M, known to
    SIGMA.
    """
    moved = Poses(cameras.quaternion[second], cameras.translation[second] + shift)
    return [Motion(matrix, SIGMA) for matrix in (moved.inverse() @ cameras[first]).matrix()]


def apart(centres: Array, count: int, rng: np.random.Generator) -> tuple[Ints, Ints]:
    """Return pairs (first, second) of nodes that see different places. centres (n, 3) m."""
    first, second = rng.integers(0, len(centres), (2, 20 * count))
    far = np.linalg.norm(centres[first] - centres[second], axis=1) > APART_M
    return chosen(np.column_stack([first, second])[far], count, rng)


def look_alikes(
    cameras: Poses, depth_m: Array, camera: CameraModel, every_m: float
) -> tuple[Ints, Ints, Array]:
    """Return all pairs (first, second) of cameras (n) that are APART_M apart and whose images would
    overlap by ALIKE if the second lay a whole number of repetitions farther along the hull, and
    that shift (m, 3). depth_m (n,): of the scenes.
    """
    at, n = cameras.translation, len(cameras)
    most = int(np.ptp(at[:, 0]) / every_m)
    first, second = np.triu_indices(n, 1)
    found: list[tuple[Ints, Ints, Array]] = []
    for step in (k * every_m for k in range(-most, most + 1) if k):
        shift = np.array([step, 0.0, 0.0])
        near = np.linalg.norm(at[first] - at[second] - shift, axis=1) < np.nanmedian(depth_m)
        near &= np.linalg.norm(at[first] - at[second], axis=1) > APART_M
        a, b = first[near], second[near]
        both = Poses(np.tile(cameras.quaternion, (2, 1)), np.vstack([at, at + shift]))
        track = CameraTrack(global_from_camera=both, errors=NoErrors())
        same = footprint_overlap(track, a, b + n, np.tile(depth_m, 2), camera) >= ALIKE
        found.append((a[same], b[same], np.tile(shift, (int(same.sum()), 1))))
    first, second, shifts = (np.concatenate(part) for part in zip(*found, strict=True))
    return first, second, shifts


def chosen(pairs: Array, count: int, rng: np.random.Generator) -> tuple[Ints, Ints]:
    """Return at most that many of the pairs (m, 2), the lower node first, by the first node."""
    ordered = np.unique(np.sort(pairs, axis=1), axis=0)
    kept = ordered[np.sort(rng.choice(len(ordered), min(count, len(ordered)), replace=False))]
    return kept[:, 0].astype(np.int64), kept[:, 1].astype(np.int64)


def false_offer(
    dive: Dive, like: Offer, repeats_m: float | None, count: int, rng: np.random.Generator
) -> Offer:
    """Return pairs that share nothing: those that look alike on a hull whose paint repeats, else
    any far apart, each with the motion of a pair of `like`.
    """
    if repeats_m is not None:
        camera = dive.worker.rig.model(Camera.TOP)
        first, second, shift = look_alikes(dive.cameras, dive.depth_m, camera, repeats_m)
        kept = np.sort(rng.choice(len(first), min(count, len(first)), replace=False))
        first, second = first[kept], second[kept]
        return Offer(
            first=first, second=second, expected=motions(dive.cameras, first, second, shift[kept])
        )
    first, second = apart(dive.cameras.translation, count, rng)
    expected = [like.expected[k] for k in rng.integers(0, len(like), len(first))]
    return Offer(first=first, second=second, expected=expected)


def true_offer(dive: Dive, count: int, rng: np.random.Generator) -> Offer:
    """Draw true revisits with the covariance that false pairs pretend to have."""
    first, second, _ = true_revisits(dive.run, read_truth(dive.package))
    first, second = chosen(np.column_stack([first, second]), count, rng)
    return Offer(
        first=first, second=second, expected=motions(dive.cameras, first, second, np.zeros(3))
    )


def compare(dive: Dive, offer: Offer, what: str) -> list[PairMatch]:
    """Return the outcome of each pair."""
    out: list[PairMatch] = []
    for start in range(0, len(offer), BLOCK):
        rows = range(start, min(start + BLOCK, len(offer)))
        pairs = [
            NodePair(
                first=int(offer.first[k]),
                second=int(offer.second[k]),
                expected=offer.expected[k],
                full_search=False,
            )
            for k in rows
        ]
        touched = sorted({p.first for p in pairs} | {p.second for p in pairs})
        views = {
            k: replace(dive.nodes[k], stereo=dive.worker.match_stereo(dive.nodes[k])[1])
            for k in touched
        }
        out += dive.worker.match_pairs((views, pairs))
        linked = sum(match.reason is Reason.MATCHED for match in out)
        print(
            f"{what}: {len(out)} of {len(offer)} offered, {linked} linked",
            file=sys.stderr,
            flush=True,
        )
    return out


def row_of(matches: Sequence[PairMatch]) -> dict[str, object]:
    """Return offered, linked and the reasons."""
    reasons = {reason.name: sum(match.reason is reason for match in matches) for reason in Reason}
    return {"offered": len(matches), "linked": reasons[Reason.MATCHED.name], "reasons": reasons}


def as_run(dive: Dive, offer: Offer, solved: GraphSolution) -> Offer:
    """Predict the pairs from the path of images and navigation."""
    poses = leading_cameras(dive.worker.rig, solved.path, dive.bottom)
    track = CameraTrack(global_from_camera=poses, errors=solved.relative_errors(dive.bottom))
    return replace(offer, expected=track.motions(offer.first, offer.second))


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("package", type=Path)
    parser.add_argument("run", type=Path)
    parser.add_argument("--pairs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--repeats-m", type=float, help="after which length the paint repeats, as it was simulated"
    )
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    rng, dive = np.random.default_rng(args.seed), read_dive(args.package, args.run)
    right = true_offer(dive, args.pairs, rng)
    wrong = false_offer(dive, right, args.repeats_m, args.pairs, rng)
    matches = compare(dive, wrong, "false")
    row: dict[str, object] = {
        "false": row_of(matches),
        "true": row_of(compare(dive, right, "true")),
    }
    kept = sum(match.reason is Reason.MATCHED for match in matches)
    if args.repeats_m is not None:
        solved = solved_graph(args.run, dive.config)
        ran = compare(dive, as_run(dive, wrong, solved), "false, as the run has them")
        kept = sum(match.reason is Reason.MATCHED for match in ran)
        in_graph = kept_by_graph(args.run, solved, links_of(wrong.first, wrong.second, matches))
        row |= {"false_as_run": row_of(ran), "false_in_graph": in_graph}
        kept += in_graph["kept"]
    print(json.dumps(row))
    keep(row, args.json)
    return int(kept > 0)


if __name__ == "__main__":
    sys.exit(main())
