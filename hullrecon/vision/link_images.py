# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The images of a dive linked in rounds: neighbours first, then images of other legs.

Each round proposes pairs by how probably they overlap on the path known so far, matches them within
its covariance, and solves the path again with what was found. It ends when nothing new is found.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar

import numpy as np

from hullrecon.records.links import CameraLinks, LinkedPath, NodePairs, NodeStereo
from hullrecon.records.trajectory import Returns, Trajectory, TrajectoryErrorModel, VehiclePath
from hullrecon.rows import blocks_of_rows
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.appearance.recognition import (
    Recognition,
    is_confirmed,
    recognise_places,
    reject_look_alikes,
)
from hullrecon.vision.compared_pairs import CommonFeatures, ComparedPairs, LinkedScene, Map
from hullrecon.vision.pairs.camera_track import (
    CameraTrack,
    RelativeErrors,
    depth_priors,
    track_cameras,
)
from hullrecon.vision.pairs.cycles import contradicted_links
from hullrecon.vision.pairs.expected_overlap import COVARIANCE_BLOCK
from hullrecon.vision.pairs.match_worker import MatchNode, MatchWorker
from hullrecon.vision.pairs.pair_match import FeatureSpool, Reason
from hullrecon.vision.pairs.selection import (
    MOST_GAIN,
    Proposal,
    Revisits,
    choose_informative,
    propose_neighbours,
    propose_revisits,
    select_keyframes,
)
from hullrecon.vision.stereo.matching import no_matches

MIN_STEREO_POINTS = 8  # stereo points of which the median is taken as the depth of the scene
# Least probability of overlap of the pairs that a round compares. Once a round links no pair, the
# next lower probability is used.
PROBABILITIES = (0.5, 0.2, 0.05)
# Least worth of a comparison across legs: expected information gain of the path, nats. It leaves
# out a quarter to 70 % of the pairs that overlap, and the adjusted path's sigmas are the same to
# 1 % (docs/methods.md 17).
LEAST_GAIN = 1.0


@dataclass(frozen=True, kw_only=True)
class NavigatedDive:
    """The dive by navigation."""

    trajectory: Trajectory
    errors: TrajectoryErrorModel
    returns: Returns | None  # None without a DVL
    tray_sigma_rad: float  # of the tray's angle, for the servo's backlash


class SolvedPath(Protocol):
    """The path by navigation and links."""

    @property
    def path(self) -> VehiclePath:
        """The vehicle and its tray at the nodes."""
        ...

    @property
    def rejected(self) -> Mask:
        """Links that contradict the rest."""
        ...

    def relative_errors(self, bottom: Mask) -> RelativeErrors:
        """Give the uncertainty of the leading cameras' relative poses.

        With it the next round knows which pairs may overlap, and where to search for features.
        bottom: (n,) nodes whose leading camera is the bottom one.
        """
        ...

    def information_gain(
        self, bottom: Mask, first: Ints, second: Ints, information: Array
    ) -> Array:
        """Compute by how much each of m possible links would reduce the path's uncertainty, nats.

        bottom: (n,) nodes whose leading camera is the bottom one. first, second: (m,) nodes of the
        links. information: (m, 6, 6) inverse covariance of each link's second_from_first, in the
        order of `CameraLinks.covariance`. It is singular where a link measures no length. Returns
        (m,).
        """
        ...

    def record(self) -> LinkedPath:
        """Convert the path to its record, with its covariance and the parts that links connect."""
        ...


Solved = TypeVar("Solved", bound=SolvedPath)
# Solves the path with links. It starts from a solution with fewer of them, or, without one, from
# navigation followed along the links.
PathSolver = Callable[[CameraLinks, Solved | None], Solved]


@dataclass(frozen=True, kw_only=True)
class LinkedImages:
    """The images of a dive linked."""

    pairs: NodePairs  # all pairs compared
    # Joined pairs are those that matched and were not rejected (`NodePairs.joined`).
    features: CommonFeatures  # of the joined pairs, in their order
    links: CameraLinks  # relative poses of the joined pairs, in their order
    stereo: NodeStereo  # matches between the two cameras of each node
    path: LinkedPath
    keyframes: Ints  # nodes that were compared with others
    appearance: tuple[Recognition, ...] = ()  # results of place recognition, none if not needed
    look_alikes: int = 0  # matches across an outage rejected because other places look alike

    def rounds(self) -> list[dict[str, int]]:
        """Count the pairs that each round compared, joined and rejected, by these names."""
        p = self.pairs
        return [
            {
                "compared": int((p.round == k).sum()),
                "joined": int((p.joined & (p.round == k)).sum()),
                "rejected": int((p.rejected & (p.round == k)).sum()),
            }
            for k in range(int(p.round.max(initial=-1)) + 1)
        ]


def link_images(
    worker: MatchWorker,
    dive: NavigatedDive,
    solve_path: PathSolver[Solved],
    map_items: Map,
    spool: FeatureSpool,
    max_rounds: int,
    appearance: bool,
) -> tuple[LinkedImages, Solved]:
    """Link the images of a dive, and solve the path with the links.

    Only keyframes are compared. Those whose image has little to recognise (`min_saliency`) are
    compared with their neighbours alone. Without any matching pair there are no links, and the path
    is that of navigation alone.

    Parameters
    ----------
    worker
        Reads features and matches nodes, by the rig and the options that it holds.
    dive
        The path by dead reckoning with its errors, on which the first pairs are proposed.
    solve_path
        Solves the path anew with the links of each round.
    map_items
        Spreads the matching over processes.
    spool
        File to which the common features of compared pairs are written.
    max_rounds
        Rounds across legs at most.
    appearance
        Recognise places by how they look, where the path is known too badly for such rounds. Also
        reject matches across an outage where different places look alike.

    Returns
    -------
    linked
        The compared pairs and what they gave.
    solved
        The path with the links that were kept.
    """
    options = worker.options

    # Match the two cameras of each node, which gives depths of the scene.
    nodes, count, bottom, track = _match_cameras(worker, dive, map_items)
    depth_m = np.array([_scene_depth(node) for node in nodes])
    scene = LinkedScene(
        worker=worker,
        map_items=map_items,
        spool=spool,
        nodes=nodes,
        depth_m=depth_m,
        bottom=bottom,
    )

    # Match neighbours along the path of dead reckoning.
    usable = np.asarray((dive.trajectory.image >= 0).any(axis=1))
    keyframes = select_keyframes(track, usable, depth_m, scene.camera)
    neighbours = propose_neighbours(track, keyframes, depth_m, scene.camera, options)
    compared = ComparedPairs.none().followed_by(neighbours, scene.match(track, neighbours), 0)
    matched = len(compared.kept())
    if appearance:
        compared = reject_look_alikes(scene, track, keyframes, compared)
    look_alikes = matched - len(compared.kept())
    solved = solve_path(compared.links(bottom), None)

    # Match nodes of other legs, on the path that each round straightens.
    salient = [worker.saliency(nodes[k]) >= options.min_saliency for k in keyframes]
    rounds = _Rounds(
        scene=scene, keyframes=keyframes[np.array(salient, bool)], solve_path=solve_path
    )
    recognised: list[Recognition] = []
    compared, solved = rounds.link_legs(compared, solved, max_rounds)
    if appearance:
        compared, solved, recognised = rounds.close_loops(compared, solved, max_rounds)

    final = compared.sorted()
    linked = LinkedImages(
        pairs=final.record(),
        features=final.features(spool),
        links=final.links(bottom),
        stereo=_record_stereo(nodes, count),
        path=solved.record(),
        keyframes=keyframes,
        appearance=tuple(recognised),
        look_alikes=look_alikes,
    )
    return linked, solved


@dataclass(frozen=True, kw_only=True)
class _Rounds(Generic[Solved]):
    """Comparisons across legs among salient keyframes.

    Each method takes the pairs compared so far and the path that they give, and returns both with
    what it adds.
    """

    scene: LinkedScene
    keyframes: Ints
    solve_path: PathSolver[Solved]

    def link_legs(
        self,
        compared: ComparedPairs,
        solved: Solved,
        max_rounds: int,
        least_gain: float = LEAST_GAIN,
    ) -> tuple[ComparedPairs, Solved]:
        """Compare images of different legs in rounds, and solve the path after each.

        A round takes the pairs whose expected information gain is at least `least_gain`, nats, on
        the path of the round before. Once a round links no pair, the next ones also take pairs that
        overlap less probably. The rounds end after `max_rounds`, or when one links no pair even at
        the lowest of PROBABILITIES.
        """
        scene, level = self.scene, 0  # level: place in PROBABILITIES
        for _ in range(max_rounds):
            track = self._track(solved)
            revisits = propose_revisits(
                track,
                self.keyframes,
                scene.depth_m,
                scene.camera,
                scene.worker.options,
                PROBABILITIES[level],
                compared.keys(len(track)),
            )
            chosen = choose_informative(
                revisits.proposal.first,
                revisits.proposal.second,
                *self._predict_gain(track, revisits, compared, solved),
                least_gain,
            )
            compared, solved, new = self._try_pairs(
                track, revisits.proposal.take(chosen), compared, solved
            )
            level += not new
            if level == len(PROBABILITIES):
                break
        return compared, solved

    def _predict_gain(
        self, track: CameraTrack, revisits: Revisits, compared: ComparedPairs, solved: Solved
    ) -> tuple[Array, Array]:
        """Predict the information gain of comparisons before making them [docs/methods.md 17].

        With it only those pairs are compared that are likely to match and would improve the path.
        Features in common, and from them probability and information, are predicted from the pairs
        compared so far. `track` has the leading cameras on the path of `solved`. Before any pair
        has matched, the information of a link cannot be predicted: the gain of each is then
        MOST_GAIN.

        Returns
        -------
        probability
            (m,) that each of the m revisits matches.
        gain
            (m,) information gain of the path if it does, nats.
        """
        probability, gain = revisits.probability.copy(), np.full(len(revisits.proposal), MOST_GAIN)
        if not len(compared.kept()):
            return probability, gain
        bottom, options = self.scene.bottom, self.scene.worker.options
        expected = compared.expected_links(bottom, options.min_inliers)
        for rows in blocks_of_rows(len(gain), COVARIANCE_BLOCK):
            first, second = revisits.proposal.first[rows], revisits.proposal.second[rows]
            common = expected.common(first, second, revisits.expected_overlap[rows])
            first_pose, second_pose = (track.global_from_camera[nodes] for nodes in (first, second))
            translation = (second_pose.inverse() @ first_pose).translation
            information = expected.link_information(first, second, common, translation)
            probability[rows] *= expected.probability(common)
            gain[rows] = solved.information_gain(bottom, first, second, information)
        return probability, gain

    def close_loops(
        self, compared: ComparedPairs, solved: Solved, max_rounds: int
    ) -> tuple[ComparedPairs, Solved, list[Recognition]]:
        """Link places recognised by appearance, then compare more legs on the path so closed.

        This is done up to `max_rounds` times, until nothing new is recognised or a recognition is
        refused. The links of a recognition are kept only if the images that they bring together
        match as well (`is_confirmed`). Otherwise all of them are rejected and the path stays as it
        was.

        Returns
        -------
        compared, solved
            With the new pairs and links.
        recognised
            The result of each recognition, a refused one with the reason. Empty where the search by
            overlap reaches every place, or with one camera.
        """
        recognised: list[Recognition] = []
        for _ in range(max_rounds):
            track = self._track(solved)
            places = recognise_places(self.scene, track, self.keyframes, compared.keys(len(track)))
            if places is None:
                break
            number = 1 + int(compared.round.max(initial=0))
            tried = compared.followed_by(places.proposal, places.found, number)
            closed, path = tried.keeping_recognised(places.accepted), solved
            if places.accepted.any():
                # Without the solution so far as a start: the closed path is far from it.
                path = self.solve_path(closed.links(self.scene.bottom), None)
                # Compare whatever overlaps now, also where it would add no information: the
                # question is whether these images match at all.
                closed, path = self.link_legs(closed.rejecting(path.rejected), path, 1, 0.0)
            if not is_confirmed(closed, number):
                compared = tried.keeping_recognised(np.zeros_like(places.accepted))
                reason = "the images that it puts beside each other do not match"
                recognised.append(places.refused(reason))
                break
            recognised.append(places)
            compared, solved = self.link_legs(closed, path, max_rounds)
        return compared, solved, recognised

    def _track(self, solved: Solved) -> CameraTrack:
        return self.scene.track(solved.path, solved.relative_errors(self.scene.bottom))

    def _try_pairs(
        self, track: CameraTrack, proposal: Proposal, compared: ComparedPairs, solved: Solved
    ) -> tuple[ComparedPairs, Solved, bool]:
        """Match proposed pairs and solve the path with the links that are not contradicted.

        Links are rejected twice: by cycles of three links that do not close, then by the solved
        path. Without a new match, the path is not solved again.

        Returns all pairs so far, the solution, and whether any of the new pairs matched.
        """
        bottom = self.scene.bottom
        found = self.scene.match(track, proposal)
        compared = compared.followed_by(proposal, found, 1 + int(compared.round.max(initial=-1)))
        if not any(pair.reason is Reason.MATCHED for pair in found):
            return compared, solved, False
        contradicted = contradicted_links(compared.links(bottom), compared.across())
        compared = compared.rejecting(contradicted)
        solved = self.solve_path(compared.links(bottom), solved)
        return compared.rejecting(solved.rejected), solved, True


def _match_cameras(
    worker: MatchWorker, dive: NavigatedDive, map_items: Map
) -> tuple[list[MatchNode], Ints, Mask, CameraTrack]:
    """Match the two cameras of every node, and choose the leading camera.

    The matches give the depth of each node's scene, from which footprints are computed.

    Returns
    -------
    nodes
        (n,) with the depths that the DVL measured, and the stereo matches. Nodes without an image
        have no matches.
    count
        Features (n,) of the leading camera.
    bottom
        Nodes (n,) whose leading camera is the bottom one, as the top one is dark or missing.
    track
        The leading cameras by dead reckoning.
    """
    usable = np.flatnonzero((dive.trajectory.image >= 0).any(axis=1))

    def track_with(bottom: Mask) -> CameraTrack:
        return track_cameras(dive.trajectory, dive.errors, worker.rig, dive.tray_sigma_rad, bottom)

    # Stereo matches are searched at the depths that the DVL gives for the top camera.
    track = track_with(np.zeros(len(dive.trajectory.t_ns), bool))
    nodes, count = _nodes_with_depth(worker, dive, track), np.zeros(len(track), np.int64)
    stereo = map_items(worker.match_stereo, [nodes[k] for k in usable], "stereo")
    for k, (features, matches) in zip(usable, stereo, strict=True):
        count[k], nodes[k] = features, replace(nodes[k], stereo=matches)
    bottom = worker.bottom_leads(nodes)
    if bottom.any():
        track = track_with(bottom)
        # Depths are along the leading camera's axis, so that they are computed anew.
        renewed = zip(_nodes_with_depth(worker, dive, track), nodes, strict=True)
        nodes = [replace(node, stereo=before.stereo) for node, before in renewed]
    return nodes, count, bottom, track


def _nodes_with_depth(
    worker: MatchWorker, dive: NavigatedDive, track: CameraTrack
) -> list[MatchNode]:
    """List the nodes with the depth of the scene by the DVL, without stereo matches yet.

    The depth is along the axis of the leading camera, which is that of `track`. A node's is None
    without a DVL, or where none of its returns is near.
    """
    depths = [None] * len(track) if dive.returns is None else depth_priors(
        track, dive.trajectory, dive.returns, worker.rig
    )  # fmt: skip
    exposures = dive.trajectory.exposures
    return [
        MatchNode(
            image=(int(top), int(bottom)),
            depth=depth,
            stereo=no_matches(),
            exposure=None if exposures is None else exposures.take(np.array([k])),
        )
        for k, ((top, bottom), depth) in enumerate(zip(dive.trajectory.image, depths, strict=True))
    ]


def _scene_depth(node: MatchNode) -> float:
    """Choose the depth of a node's scene, m: the median of stereo, else the DVL's, else NaN.

    Footprints and overlaps are computed with it.
    """
    if len(node.stereo) >= MIN_STEREO_POINTS:
        return float(np.median(node.stereo.point[:, 2]))
    return node.depth.mean if node.depth else float("nan")


def _record_stereo(nodes: list[MatchNode], count: Ints) -> NodeStereo:
    """Concatenate the stereo matches of all nodes for the record of the links.

    count: number of features (n,) of each node's leading camera.
    """
    stereo = [node.stereo for node in nodes]
    none = np.zeros(0, np.int64)
    points: Array = np.concatenate([np.zeros((0, 3)), *(s.point for s in stereo)])
    return NodeStereo(
        features=count,
        start=np.concatenate([[0], np.cumsum([len(s) for s in stereo])]),
        top=np.concatenate([none, *(s.top for s in stereo)]),
        bottom=np.concatenate([none, *(s.bottom for s in stereo)]),
        point=points,
    )
