# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The pairs of images compared so far, and the inputs of a further comparison."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import from_matrix
from hullrecon.records.links import CameraLinks, NodePairs
from hullrecon.records.trajectory import VehiclePath
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.pairs.camera_track import CameraTrack, RelativeErrors, leading_cameras
from hullrecon.vision.pairs.expected_links import Compared, ExpectedLinks, learn_links
from hullrecon.vision.pairs.match_worker import MatchNode, MatchWorker, NodePair
from hullrecon.vision.pairs.pair_match import FeatureSpool, PairMatch
from hullrecon.vision.pairs.selection import Proposal

# Pairs that one call of a worker compares: neighbours share views, but few blocks leave workers
# without work.
MOST_IN_BLOCK, LEAST_IN_BLOCK = 48, 8
BLOCKS = 16  # of a round, where that makes blocks of such sizes
Item = TypeVar("Item")
Result = TypeVar("Result")


class Map(Protocol):
    """Applies a function to all items, in order, perhaps in other processes.

    So the function must be picklable. label: names the work for the progress shown.
    """

    def __call__(
        self, function: Callable[[Item], Result], items: Sequence[Item], label: str
    ) -> Iterable[Result]: ...


@dataclass(frozen=True, kw_only=True)
class LinkedScene:
    """The inputs of every round."""

    worker: MatchWorker
    map_items: Map
    spool: FeatureSpool  # of the features that compared pairs have in common
    nodes: list[MatchNode]  # n
    depth_m: Array  # (n,) of the scene at each node, NaN where unknown
    bottom: Mask  # (n,) the leading camera is the bottom one

    @property
    def camera(self) -> CameraModel:
        return self.worker.rig.model(Camera.TOP)

    def track(self, path: VehiclePath, errors: RelativeErrors) -> CameraTrack:
        """Place the leading cameras on a path. errors: the uncertainty of their relative poses."""
        poses = leading_cameras(self.worker.rig, path, self.bottom)
        return CameraTrack(global_from_camera=poses, errors=errors)

    def match(
        self, track: CameraTrack, proposal: Proposal, anywhere: bool = False
    ) -> list[PairMatch]:
        """Match the proposed pairs, searching where the track expects features, or anywhere.

        A pair of neighbours whose features are not found there is searched in the whole image. A
        pair across legs is not. The common features of all pairs are written to the spool.

        Returns the result of each pair, in order. A pair that failed has the reason.
        """
        expected = (
            [None] * len(proposal) if anywhere else track.motions(proposal.first, proposal.second)
        )
        pairs = [
            NodePair(first=int(a), second=int(b), expected=motion, full_search=not across)
            for a, b, motion, across in zip(
                proposal.first, proposal.second, expected, proposal.across, strict=True
            )
        ]
        blocks = []
        size = min(MOST_IN_BLOCK, max(LEAST_IN_BLOCK, math.ceil(len(pairs) / BLOCKS)))
        for start in range(0, len(pairs), size):
            part = pairs[start : start + size]
            touched = sorted({p.first for p in part} | {p.second for p in part})
            blocks.append(({k: self.nodes[k] for k in touched}, part))
        found = self.map_items(self.worker.match_pairs, blocks, "pairs")
        return [self.spool.put(match) for block in found for match in block]


@dataclass(frozen=True, kw_only=True)
class CommonFeatures:
    """The common features of m pairs, read from the spool pair by pair."""

    spool: FeatureSpool
    pairs: tuple[PairMatch, ...]  # (m,) whose features are in the spool

    @property
    def start(self) -> Ints:
        """First row (m + 1,) of each pair among the rows of all pairs, and their number."""
        return np.cumsum([0, *(len(pair.stored or ()) for pair in self.pairs)], dtype=np.int64)

    def blocks(self) -> Iterator[NDArray[np.void]]:
        """Read the rows of each pair."""
        return (self.spool.get(pair) for pair in self.pairs)


@dataclass(frozen=True, kw_only=True)
class ComparedPairs:
    """The pairs of all rounds so far, in the order of comparison."""

    proposal: Proposal  # of m pairs
    found: tuple[PairMatch, ...]  # (m,) the result of each
    round: Ints  # (m,) number of the round that compared each
    rejected: Mask  # (m,) matched, but contradicted by other links or the path

    @staticmethod
    def none() -> ComparedPairs:
        """Make the empty set of pairs before the first round."""
        nothing = np.zeros(0, np.int64)
        proposal = Proposal(
            first=nothing, second=nothing, across=np.zeros(0, bool), overlap=np.zeros(0)
        )
        return ComparedPairs(proposal=proposal, found=(), round=nothing, rejected=np.zeros(0, bool))

    def keys(self, nodes: int) -> Ints:
        """Encode all pairs as first * nodes + second, so that none is proposed again.

        nodes: number of all nodes.
        """
        return self.proposal.first * nodes + self.proposal.second

    def followed_by(
        self, proposal: Proposal, found: Sequence[PairMatch], number: int
    ) -> ComparedPairs:
        """Append the pairs of another round, whose number is `number`, with their results.

        None of them is rejected yet.
        """
        return ComparedPairs(
            proposal=self.proposal.followed_by(proposal),
            found=(*self.found, *found),
            round=np.concatenate([self.round, np.full(len(proposal), number)]),
            rejected=np.concatenate([self.rejected, np.zeros(len(proposal), bool)]),
        )

    def kept(self) -> Ints:
        """List the rows of the pairs that matched and are not rejected: those that give links."""
        matched = np.array([pair.motion is not None for pair in self.found], bool)
        return np.flatnonzero(matched & ~self.rejected)

    def across(self) -> Mask:
        """Select among the k kept pairs (k,) those between two legs."""
        return self.proposal.across[self.kept()]

    def rejecting(self, links: Mask) -> ComparedPairs:
        """Reject those of the k kept pairs that `links` (k,) selects."""
        rejected = self.rejected.copy()
        rejected[self.kept()[links]] = True
        return replace(self, rejected=rejected)

    def keeping_recognised(self, accepted: Mask) -> ComparedPairs:
        """Reject those of the newest pairs that place recognition did not accept.

        Recognition proposed and compared the last a pairs, and accepts a group that confirms
        itself, or none. The others stay listed as rejected: they give no link, and are not compared
        again.

        accepted: (a,) one for each of the last a pairs. Earlier pairs stay as they are.
        """
        accepted_of_all = np.ones(len(self.found), bool)
        accepted_of_all[len(self.found) - len(accepted) :] = accepted
        return self.rejecting(~accepted_of_all[self.kept()])

    def sorted(self) -> ComparedPairs:
        """Sort the pairs by (first, second), the order in which they are stored."""
        order = np.lexsort((self.proposal.second, self.proposal.first))
        return ComparedPairs(
            proposal=self.proposal.take(order),
            found=tuple(self.found[k] for k in order),
            round=self.round[order],
            rejected=self.rejected[order],
        )

    def links(self, bottom: Mask) -> CameraLinks:
        """Collect the relative poses of the k kept pairs as links to solve the path with.

        bottom: (n,) nodes whose leading camera is the bottom one.
        """
        rows = self.kept()
        motions = [pair.motion for pair in (self.found[k] for k in rows) if pair.motion is not None]
        first, second = self.proposal.first[rows], self.proposal.second[rows]
        relative = from_matrix(np.array([m.second_from_first for m in motions]).reshape(-1, 4, 4))
        return CameraLinks(
            first=first,
            second=second,
            translation=relative.translation,
            quaternion=relative.quaternion,
            covariance=np.array([m.covariance for m in motions]).reshape(-1, 6, 6),
            scaled=np.array([self.found[k].scaled for k in rows], bool),
            bottom=np.column_stack([bottom[first], bottom[second]]),
        )

    def expected_links(self, bottom: Mask, min_common: int) -> ExpectedLinks:
        """Learn from the results so far to predict the links of pairs not compared yet.

        With it the next round chooses the pairs worth a comparison. bottom: (n,) nodes whose
        leading camera is the bottom one. min_common: features that two images must have in common
        to be linked.
        """
        common, kept = np.zeros(len(self.found), np.int64), self.kept()
        common[kept] = [len(self.found[k].stored or ()) for k in kept]
        compared = Compared(
            first=self.proposal.first,
            second=self.proposal.second,
            overlap=self.proposal.overlap,
            common=common,
        )
        return learn_links(len(bottom), compared, self.links(bottom), common[kept], min_common)

    def features(self, spool: FeatureSpool) -> CommonFeatures:
        """Give access to the common features of the kept pairs, which lie in the spool."""
        return CommonFeatures(spool=spool, pairs=tuple(self.found[k] for k in self.kept()))

    def record(self) -> NodePairs:
        """Convert to the record of the compared pairs, with the reason why each failed."""
        return NodePairs(
            first=self.proposal.first,
            second=self.proposal.second,
            across=self.proposal.across,
            overlap=self.proposal.overlap,
            round=self.round,
            putative=np.array([pair.putative for pair in self.found], np.int64),
            reason=np.array([pair.reason for pair in self.found], np.int64),
            rejected=self.rejected,
        )
