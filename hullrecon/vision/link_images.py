# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The images of a dive linked in rounds: neighbours first, then, as the path that they straighten
allows, images of other legs.

Each round proposes pairs by how probably they overlap on the path as it is known by then, matches
them within its covariance, and has the path solved again with what was found; it ends when nothing
new is found.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar

import numpy as np

from hullrecon.records.links import CameraLinks, LinkedPath, NodePairs, NodeStereo, PairFeatures
from hullrecon.records.trajectory import VehiclePath
from hullrecon.typing import Ints, Mask
from hullrecon.vision.appearance.recognition import (
    Recognition,
    bears_out,
    recognise_places,
    reject_look_alikes,
    reject_others,
)
from hullrecon.vision.compared_pairs import ComparedPairs, LinkedScene, Map, NavigatedDive
from hullrecon.vision.pair_match import Reason
from hullrecon.vision.pairs.camera_track import (
    CameraTrack,
    RelativeErrors,
    depth_priors,
    track_cameras,
)
from hullrecon.vision.pairs.cycles import contradicted_links
from hullrecon.vision.pairs.match_worker import MatchNode, MatchStereo, MatchWorker
from hullrecon.vision.pairs.selection import (
    Proposal,
    propose_neighbours,
    propose_overlapping,
    propose_revisits,
    select_keyframes,
)
from hullrecon.vision.stereo.matching import no_matches

MIN_STEREO_POINTS = 8  # from which their median is the depth of the scene
# A round compares pairs that overlap at least so probably; the next step is taken when one finds
# nothing.
PROBABILITIES = (0.5, 0.2, 0.05)


class SolvedPath(Protocol):
    """The path that navigation and links give."""

    @property
    def path(self) -> VehiclePath:
        """Return the vehicle and its tray at the nodes."""
        ...

    @property
    def rejected(self) -> Mask:
        """Return which links contradict the rest."""
        ...

    def relative_errors(self, bottom: Mask) -> RelativeErrors:
        """Return how well the nodes' leading cameras are known relative to each other; bottom (n,):
        where that is the bottom one.
        """
        ...

    def record(self) -> LinkedPath:
        """Return the path with its covariance."""
        ...


Solved = TypeVar("Solved", bound=SolvedPath)
# from the links, and a solution with fewer of them
PathSolver = Callable[[CameraLinks, Solved | None], Solved]


@dataclass(frozen=True, kw_only=True)
class LinkedImages:
    """The pairs that were compared, the features and relative poses that they gave (of the pairs
    joined, in their order), what the two cameras of each node have in common, and the path;
    keyframes: nodes that were compared with others; appearance: what it was asked, nothing where
    the rounds reach all that the path leaves open; look_alikes: neighbours that match across an
    outage and are not believed, as other places look alike.
    """

    pairs: NodePairs
    features: PairFeatures
    links: CameraLinks
    stereo: NodeStereo
    path: LinkedPath
    keyframes: Ints
    appearance: tuple[Recognition, ...] = ()
    look_alikes: int = 0

    def rounds(self) -> list[dict[str, int]]:
        """Return how many pairs each round compared, joined and rejected."""
        p = self.pairs
        numbers = range(int(p.round.max(initial=-1)) + 1)
        return [
            {
                "compared": int((p.round == k).sum()),
                "joined": int((p.joined & (p.round == k)).sum()),
                "rejected": int((p.rejected & (p.round == k)).sum()),
            }
            for k in numbers
        ]


def link_images(
    worker: MatchWorker,
    dive: NavigatedDive,
    solve_path: PathSolver[Solved],
    map_items: Map,
    max_rounds: int,
    appearance: bool,
) -> tuple[LinkedImages, Solved]:
    """Return the images of a dive linked, and the solution that the links and navigation give.
    max_rounds: across legs; appearance: whether it is asked where the path is known too badly for
    these.
    """
    usable = np.asarray((dive.trajectory.image >= 0).any(axis=1))
    nodes, count, bottom, track = _match_cameras(worker, dive, np.flatnonzero(usable), map_items)
    depth_m = np.array([_scene_depth(node) for node in nodes])
    scene = LinkedScene(worker=worker, dive=dive, nodes=nodes, depth_m=depth_m, bottom=bottom)
    keyframes = select_keyframes(track, usable, scene.depth_m, scene.camera, worker.options)
    neighbours = propose_neighbours(track, keyframes, scene.depth_m, scene.camera, worker.options)
    compared = ComparedPairs.none().joined_with(
        neighbours, scene.match(track, neighbours, map_items), number=0
    )
    matched = len(compared.kept())
    if appearance:
        compared = reject_look_alikes(scene, track, keyframes, compared, map_items)
    look_alikes = matched - len(compared.kept())
    solved = solve_path(compared.links(scene), None)
    salient = np.array(
        [worker.saliency(nodes[k]) >= worker.options.min_saliency for k in keyframes], bool
    )
    rounds = _Rounds(
        scene=scene, keyframes=keyframes[salient], solve_path=solve_path, map_items=map_items
    )
    if worker.options.across > 0:
        compared, solved = rounds.link_legs(compared, solved, max_rounds)
    asked: list[Recognition] = []
    if worker.options.across > 0 and max_rounds > 0 and appearance:
        compared, solved, asked = rounds.close_loops(compared, solved, max_rounds)
    if compared.across().any():
        compared, solved = rounds.link_overlapping(compared, solved)
    linked = _collect_links(scene, keyframes, count, compared, solved)
    return replace(linked, appearance=tuple(asked), look_alikes=look_alikes), solved


@dataclass(frozen=True, kw_only=True)
class _Rounds(Generic[Solved]):
    """Comparisons across legs, among the keyframes that have something to recognise. Each takes the
    pairs compared so far and the path that they give, and returns both with what it adds.
    """

    scene: LinkedScene
    keyframes: Ints
    solve_path: PathSolver[Solved]
    map_items: Map

    def link_legs(
        self, compared: ComparedPairs, solved: Solved, max_rounds: int
    ) -> tuple[ComparedPairs, Solved]:
        """Compare what probably overlaps, round by round on the path that the round before has
        straightened.
        """
        scene, level = self.scene, 0
        for _ in range(max_rounds):
            track = self._track(solved)
            proposal = propose_revisits(
                track,
                self.keyframes,
                scene.depth_m,
                scene.camera,
                scene.worker.options,
                PROBABILITIES[level],
                compared.keys(len(track)),
            )
            compared, solved, new = self._try_pairs(track, proposal, compared, solved)
            level += not new
            if level == len(PROBABILITIES):
                break
        return compared, solved

    def close_loops(
        self, compared: ComparedPairs, solved: Solved, max_rounds: int
    ) -> tuple[ComparedPairs, Solved, list[Recognition]]:
        """Ask appearance, with rounds after each answer, until it gives nothing; return also what
        it was asked.
        """
        asked: list[Recognition] = []
        for _ in range(max_rounds):
            track = self._track(solved)
            recognised = recognise_places(
                self.scene, track, self.keyframes, compared.keys(len(track)), self.map_items
            )
            if recognised is None:
                break
            number = 1 + int(compared.round.max(initial=0))
            tried = compared.joined_with(recognised.proposal, recognised.found, number)
            closed, path = reject_others(tried, recognised.accepted), solved
            if recognised.accepted.any():
                # with no solution to begin with: it is far from this one
                path = self.solve_path(closed.links(self.scene), None)
                closed, path = self.link_legs(closed.rejecting(path.rejected), path, 1)
            if not bears_out(closed, number):
                compared = reject_others(tried, np.zeros_like(recognised.accepted))
                asked.append(
                    recognised.refused("the images that it puts beside each other do not match")
                )
                break
            asked.append(recognised)
            compared, solved = self.link_legs(closed, path, max_rounds)
        return compared, solved, asked

    def link_overlapping(
        self, compared: ComparedPairs, solved: Solved
    ) -> tuple[ComparedPairs, Solved]:
        """Compare in a last round what overlaps well on the path that the rounds before have tied."""
        track, scene = self._track(solved), self.scene
        proposal = propose_overlapping(
            track,
            self.keyframes,
            scene.depth_m,
            scene.camera,
            scene.worker.options,
            compared.keys(len(track)),
        )
        compared, solved, _ = self._try_pairs(track, proposal, compared, solved)
        return compared, solved

    def _track(self, solved: Solved) -> CameraTrack:
        return self.scene.track(solved.path, solved.relative_errors(self.scene.bottom))

    def _try_pairs(
        self, track: CameraTrack, proposal: Proposal, compared: ComparedPairs, solved: Solved
    ) -> tuple[ComparedPairs, Solved, bool]:
        """Match the pairs proposed and solve the path with them; return also whether one of them
        matched.
        """
        found = self.scene.match(track, proposal, self.map_items)
        compared = compared.joined_with(proposal, found, 1 + int(compared.round.max(initial=-1)))
        if not any(pair.reason is Reason.MATCHED for pair in found):
            return compared, solved, False
        compared = compared.rejecting(
            contradicted_links(compared.links(self.scene), compared.across())
        )
        solved = self.solve_path(compared.links(self.scene), solved)
        return compared.rejecting(solved.rejected), solved, True


def _collect_links(
    scene: LinkedScene, keyframes: Ints, count: Ints, compared: ComparedPairs, solved: SolvedPath
) -> LinkedImages:
    final = compared.sorted()
    pairs = [final.found[k] for k in final.kept()]
    size = np.array([len(pair.first) for pair in pairs], np.int64)
    none = np.zeros(0, np.int64)
    stereo = [node.stereo for node in scene.nodes]
    return LinkedImages(
        pairs=NodePairs(
            first=final.proposal.first,
            second=final.proposal.second,
            across=final.proposal.across,
            overlap=final.proposal.overlap,
            round=final.round,
            putative=np.array([pair.putative for pair in final.found], np.int64),
            reason=np.array([pair.reason for pair in final.found], np.int64),
            rejected=final.rejected,
        ),
        features=PairFeatures(
            start=np.concatenate([[0], np.cumsum(size)]),
            first=np.concatenate([none, *(pair.first for pair in pairs)]),
            second=np.concatenate([none, *(pair.second for pair in pairs)]),
            distance=np.concatenate([np.zeros(0, np.float32), *(pair.distance for pair in pairs)]),
        ),
        links=final.links(scene),
        stereo=NodeStereo(
            features=count,
            start=np.concatenate([[0], np.cumsum([len(s) for s in stereo])]),
            top=np.concatenate([none, *(s.top for s in stereo)]),
            bottom=np.concatenate([none, *(s.bottom for s in stereo)]),
            point=np.concatenate([np.zeros((0, 3)), *(s.point for s in stereo)]),
        ),
        path=solved.record(),
        keyframes=keyframes,
    )


def _match_cameras(
    worker: MatchWorker, dive: NavigatedDive, usable: Ints, map_items: Map
) -> tuple[list[MatchNode], Ints, Mask, CameraTrack]:
    """Return the nodes with the matches of their two cameras, the number of the leading camera's
    features (n,), where that is the bottom one (n,), and the leading cameras as dead reckoning has
    them.
    """

    def track_with(bottom: Mask) -> CameraTrack:
        return track_cameras(dive.trajectory, dive.errors, worker.rig, dive.tray_sigma_rad, bottom)

    # stereo is sought at the depths that the top camera has
    track = track_with(np.zeros(len(dive.trajectory.t_ns), bool))
    nodes, count = _match_stereo(worker, _nodes(worker, dive, track), usable, map_items)
    bottom = worker.bottom_leads(nodes)
    if bottom.any():
        track = track_with(bottom)
        seen = zip(_nodes(worker, dive, track), nodes, strict=True)
        nodes = [replace(node, stereo=before.stereo) for node, before in seen]
    return nodes, count, bottom, track


def _nodes(worker: MatchWorker, dive: NavigatedDive, track: CameraTrack) -> list[MatchNode]:
    """Return the nodes with the depth of the scene by the DVL, without stereo matches yet."""
    depths = [None] * len(track) if dive.returns is None else depth_priors(
        track, dive.trajectory, dive.returns, worker.rig, worker.options.range_margin
    )  # fmt: skip
    images = [(int(top), int(bottom)) for top, bottom in dive.trajectory.image]
    return [
        MatchNode(image=image, depth=depth, stereo=no_matches())
        for image, depth in zip(images, depths, strict=True)
    ]


def _match_stereo(
    worker: MatchWorker, nodes: list[MatchNode], usable: Ints, map_items: Map
) -> tuple[list[MatchNode], Ints]:
    """Return the nodes with the matches of their two cameras, and the number of the leading
    camera's features (n,).
    """
    count, out = np.zeros(len(nodes), np.int64), list(nodes)
    stereo = map_items(MatchStereo(worker), [nodes[k] for k in usable], "stereo")
    for k, (features, matches) in zip(usable, stereo, strict=True):
        count[k], out[k] = features, replace(nodes[k], stereo=matches)
    return out, count


def _scene_depth(node: MatchNode) -> float:
    """Return the depth of the scene, m: the stereo's median where there is one, else the DVL's,
    else NaN.
    """
    if len(node.stereo) >= MIN_STEREO_POINTS:
        return float(np.median(node.stereo.point[:, 2]))
    return node.depth.mean if node.depth else float("nan")
