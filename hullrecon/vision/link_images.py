# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The images of a dive linked in rounds: neighbours first, then, as the path that they straighten allows, images of other legs.

Each round proposes pairs by how probably they overlap on the path as it is known by then, matches them within its covariance,
and has the path solved again with what was found; it ends when nothing new is found.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import from_matrix
from hullrecon.records.links import CameraLinks, LinkedPath, NodePairs, NodeStereo, PairFeatures
from hullrecon.records.trajectory import Returns, Trajectory, TrajectoryErrorModel, VehiclePath
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.pairs.camera_track import (
    CameraTrack,
    RelativeErrors,
    bottom_leads,
    depth_priors,
    leading_cameras,
    track_cameras,
)
from hullrecon.vision.pairs.cycles import contradicted_links
from hullrecon.vision.pairs.match_worker import MatchNode, MatchPairs, MatchStereo, MatchWorker, NodePair
from hullrecon.vision.pairs.matching import PairMatch, Reason
from hullrecon.vision.pairs.selection import Proposal, propose_neighbours, propose_revisits, select_keyframes
from hullrecon.vision.stereo.matching import no_matches

BLOCK = 48  # pairs that one call of a worker compares: neighbours share views
MIN_STEREO_POINTS = 8  # from which their median is the depth of the scene
# A round compares pairs that overlap at least so probably; the next step is taken when one finds nothing.
PROBABILITIES = (0.5, 0.2, 0.05)

Item = TypeVar("Item")
Result = TypeVar("Result")


class Map(Protocol):
    """Applies a function that can be pickled to all items, in order, perhaps in other processes."""

    def __call__(self, function: Callable[[Item], Result], items: Sequence[Item], label: str) -> list[Result]: ...


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

    def relative_errors(self) -> RelativeErrors:
        """Return how well nodes are known relative to each other."""
        ...

    def record(self) -> LinkedPath:
        """Return the path with its covariance."""
        ...


Solved = TypeVar("Solved", bound=SolvedPath)
PathSolver = Callable[[CameraLinks, Solved | None], Solved]  # from the links, and a solution with fewer of them


@dataclass(frozen=True, kw_only=True)
class NavigatedDive:
    """What navigation says; returns: None without a DVL; tray_sigma_rad: of the servo's backlash."""

    trajectory: Trajectory
    errors: TrajectoryErrorModel
    returns: Returns | None
    tray_sigma_rad: float


@dataclass(frozen=True, kw_only=True)
class LinkedImages:
    """The pairs that were compared, the features and relative poses that they gave (of the pairs joined, in their order), what
    the two cameras of each node have in common, and the path; keyframes: nodes that were compared with others."""

    pairs: NodePairs
    features: PairFeatures
    links: CameraLinks
    stereo: NodeStereo
    path: LinkedPath
    keyframes: Ints

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
    worker: MatchWorker, dive: NavigatedDive, solve_path: PathSolver[Solved], map_items: Map, max_rounds: int
) -> LinkedImages:
    """Return the images of a dive linked, with the path that the links and navigation give. max_rounds: across legs."""
    track = track_cameras(dive.trajectory, dive.errors, worker.rig, dive.tray_sigma_rad)
    usable = np.asarray((dive.trajectory.image >= 0).any(axis=1))
    nodes, count = _match_stereo(worker, _nodes(worker, dive, track), np.flatnonzero(usable), map_items)
    scene = _Scene(worker=worker, dive=dive, nodes=nodes, depth_m=np.array([_scene_depth(node) for node in nodes]))
    keyframes = select_keyframes(track, usable, scene.depth_m, scene.camera, worker.options)
    neighbours = propose_neighbours(track, keyframes, scene.depth_m, scene.camera, worker.options)
    compared = _Compared.none().joined_with(neighbours, scene.match(track, neighbours, map_items), number=0)
    solved = solve_path(compared.links(scene), None)
    salient = np.array([worker.saliency(nodes[k]) >= worker.options.min_saliency for k in keyframes], bool)
    if worker.options.across > 0:
        compared, solved = _link_legs(scene, keyframes[salient], compared, solved, solve_path, map_items, max_rounds)
    return _linked(scene, keyframes, count, compared, solved)


def _link_legs(
    scene: _Scene,
    keyframes: Ints,
    compared: _Compared,
    solved: Solved,
    solve_path: PathSolver[Solved],
    map_items: Map,
    max_rounds: int,
) -> tuple[_Compared, Solved]:
    """Return what rounds of comparisons across legs add."""
    options, level = scene.worker.options, 0
    for number in range(1, max_rounds + 1):
        track = scene.track(solved)
        proposal = propose_revisits(
            track, keyframes, scene.depth_m, scene.camera, options, PROBABILITIES[level], compared.keys(len(track))
        )
        found = scene.match(track, proposal, map_items)
        if any(pair.reason is Reason.MATCHED for pair in found):
            compared = compared.joined_with(proposal, found, number)
            links = compared.links(scene)
            compared = compared.rejecting(contradicted_links(links, compared.across()))
            solved = solve_path(compared.links(scene), solved)
            compared = compared.rejecting(solved.rejected)
            continue
        compared = compared.joined_with(proposal, found, number)
        level += 1
        if level == len(PROBABILITIES):
            break
    return compared, solved


@dataclass(frozen=True, kw_only=True)
class _Scene:
    """What every round works on. depth_m (n,): of the scene at each node."""

    worker: MatchWorker
    dive: NavigatedDive
    nodes: list[MatchNode]
    depth_m: Array

    @property
    def camera(self) -> CameraModel:
        return self.worker.rig.model(Camera.TOP)

    def track(self, solved: SolvedPath) -> CameraTrack:
        """Return the leading cameras on a path."""
        poses = leading_cameras(self.worker.rig, solved.path, self.dive.trajectory.image)
        return CameraTrack(global_from_camera=poses, errors=solved.relative_errors())

    def match(self, track: CameraTrack, proposal: Proposal, map_items: Map) -> list[PairMatch]:
        """Return what each proposed pair gives, expected where the track has it."""
        expected = track.motions(proposal.first, proposal.second)
        pairs = [
            NodePair(first=int(a), second=int(b), expected=motion, full_search=not across)
            for a, b, motion, across in zip(proposal.first, proposal.second, expected, proposal.across, strict=True)
        ]
        blocks = []
        for start in range(0, len(pairs), BLOCK):
            part = pairs[start : start + BLOCK]
            touched = sorted({p.first for p in part} | {p.second for p in part})
            blocks.append(({k: self.nodes[k] for k in touched}, part))
        return [match for block in map_items(MatchPairs(self.worker), blocks, "pairs") for match in block]


@dataclass(frozen=True, kw_only=True)
class _Compared:
    """The pairs of all rounds so far, in the order in which they were compared, and which of the matched are rejected (m,)."""

    proposal: Proposal
    found: tuple[PairMatch, ...]
    round: Ints
    rejected: Mask

    @staticmethod
    def none() -> _Compared:
        """Return what there is before the first round."""
        nothing = np.zeros(0, np.int64)
        proposal = Proposal(first=nothing, second=nothing, across=np.zeros(0, bool), overlap=np.zeros(0))
        return _Compared(proposal=proposal, found=(), round=nothing, rejected=np.zeros(0, bool))

    def keys(self, nodes: int) -> Ints:
        """Return first * nodes + second of all pairs."""
        return self.proposal.first * nodes + self.proposal.second

    def joined_with(self, proposal: Proposal, found: Sequence[PairMatch], number: int) -> _Compared:
        """Return these and the pairs of another round."""
        old = self.proposal
        return _Compared(
            proposal=Proposal(
                first=np.concatenate([old.first, proposal.first]),
                second=np.concatenate([old.second, proposal.second]),
                across=np.concatenate([old.across, proposal.across]),
                overlap=np.concatenate([old.overlap, proposal.overlap]),
            ),
            found=(*self.found, *found),
            round=np.concatenate([self.round, np.full(len(proposal), number)]),
            rejected=np.concatenate([self.rejected, np.zeros(len(proposal), bool)]),
        )

    def kept(self) -> Ints:
        """Return the rows of the pairs that matched and are not rejected."""
        matched = np.array([pair.motion is not None for pair in self.found], bool)
        return np.flatnonzero(matched & ~self.rejected)

    def across(self) -> Mask:
        """Return which of the kept pairs are of two legs."""
        return self.proposal.across[self.kept()]

    def rejecting(self, links: Mask) -> _Compared:
        """Return these without some of the kept pairs."""
        rejected = self.rejected.copy()
        rejected[self.kept()[links]] = True
        return replace(self, rejected=rejected)

    def links(self, scene: _Scene) -> CameraLinks:
        """Return the relative poses of the kept pairs."""
        rows = self.kept()
        motions = [pair.motion for pair in (self.found[k] for k in rows) if pair.motion is not None]
        first, second = self.proposal.first[rows], self.proposal.second[rows]
        relative = from_matrix(np.array([m.second_from_first for m in motions]).reshape(-1, 4, 4))
        leads = bottom_leads(scene.worker.rig, scene.dive.trajectory.image)
        return CameraLinks(
            first=first,
            second=second,
            translation=relative.translation,
            quaternion=relative.quaternion,
            covariance=np.array([m.covariance for m in motions]).reshape(-1, 6, 6),
            scaled=np.array([self.found[k].scaled for k in rows], bool),
            bottom=np.column_stack([leads[first], leads[second]]),
        )

    def sorted(self) -> _Compared:
        """Return these by (first, second)."""
        order, p = np.lexsort((self.proposal.second, self.proposal.first)), self.proposal
        return _Compared(
            proposal=Proposal(first=p.first[order], second=p.second[order], across=p.across[order], overlap=p.overlap[order]),
            found=tuple(self.found[k] for k in order),
            round=self.round[order],
            rejected=self.rejected[order],
        )


def _linked(scene: _Scene, keyframes: Ints, count: Ints, compared: _Compared, solved: SolvedPath) -> LinkedImages:
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


def _nodes(worker: MatchWorker, dive: NavigatedDive, track: CameraTrack) -> list[MatchNode]:
    """Return the nodes with the depth of the scene by the DVL, without stereo matches yet."""
    depths = [None] * len(track) if dive.returns is None else depth_priors(
        track, dive.trajectory, dive.returns, worker.rig.rig, worker.options.range_margin
    )  # fmt: skip
    images = [(int(top), int(bottom)) for top, bottom in dive.trajectory.image]
    return [MatchNode(image=image, depth=depth, stereo=no_matches()) for image, depth in zip(images, depths, strict=True)]


def _match_stereo(worker: MatchWorker, nodes: list[MatchNode], usable: Ints, map_items: Map) -> tuple[list[MatchNode], Ints]:
    """Return the nodes with the matches of their two cameras, and the number of the leading camera's features (n,)."""
    count, out = np.zeros(len(nodes), np.int64), list(nodes)
    stereo = map_items(MatchStereo(worker), [nodes[k] for k in usable], "stereo")
    for k, (features, matches) in zip(usable, stereo, strict=True):
        count[k], out[k] = features, replace(nodes[k], stereo=matches)
    return out, count


def _scene_depth(node: MatchNode) -> float:
    """Return the depth of the scene, m: the stereo's median where there is one, else the DVL's, else NaN."""
    if len(node.stereo) >= MIN_STEREO_POINTS:
        return float(np.median(node.stereo.point[:, 2]))
    return node.depth.mean if node.depth else float("nan")
