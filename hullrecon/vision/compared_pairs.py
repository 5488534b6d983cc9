# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The pairs of images compared so far, and what a further comparison needs of the dive."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.poses import from_matrix
from hullrecon.records.links import CameraLinks
from hullrecon.records.trajectory import Returns, Trajectory, TrajectoryErrorModel, VehiclePath
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.pair_match import PairMatch
from hullrecon.vision.pairs.camera_track import CameraTrack, RelativeErrors, leading_cameras
from hullrecon.vision.pairs.match_worker import MatchNode, MatchPairs, MatchWorker, NodePair
from hullrecon.vision.pairs.selection import Proposal

BLOCK = 48  # pairs that one call of a worker compares: neighbours share views
Item = TypeVar("Item")
Result = TypeVar("Result")


class Map(Protocol):
    """Applies a function that can be pickled to all items, in order, perhaps in other processes."""

    def __call__(
        self, function: Callable[[Item], Result], items: Sequence[Item], label: str
    ) -> list[Result]: ...


@dataclass(frozen=True, kw_only=True)
class NavigatedDive:
    """What navigation says; returns: None without a DVL; tray_sigma_rad: of the servo's backlash."""

    trajectory: Trajectory
    errors: TrajectoryErrorModel
    returns: Returns | None
    tray_sigma_rad: float


@dataclass(frozen=True, kw_only=True)
class LinkedScene:
    """What every round works on. depth_m (n,): of the scene at each node; bottom (n,): nodes where
    the bottom camera leads.
    """

    worker: MatchWorker
    dive: NavigatedDive
    nodes: list[MatchNode]
    depth_m: Array
    bottom: Mask

    @property
    def camera(self) -> CameraModel:
        return self.worker.rig.model(Camera.TOP)

    def track(self, path: VehiclePath, errors: RelativeErrors) -> CameraTrack:
        """Return the leading cameras on a path."""
        poses = leading_cameras(self.worker.rig, path, self.bottom)
        return CameraTrack(global_from_camera=poses, errors=errors)

    def match(
        self, track: CameraTrack, proposal: Proposal, map_items: Map, anywhere: bool = False
    ) -> list[PairMatch]:
        """Return what each proposed pair gives, expected where the track has it, or anywhere."""
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
        for start in range(0, len(pairs), BLOCK):
            part = pairs[start : start + BLOCK]
            touched = sorted({p.first for p in part} | {p.second for p in part})
            blocks.append(({k: self.nodes[k] for k in touched}, part))
        return [
            match
            for block in map_items(MatchPairs(self.worker), blocks, "pairs")
            for match in block
        ]


@dataclass(frozen=True, kw_only=True)
class ComparedPairs:
    """The pairs of all rounds so far, in the order in which they were compared, and which of the
    matched are rejected (m,).
    """

    proposal: Proposal
    found: tuple[PairMatch, ...]
    round: Ints
    rejected: Mask

    @staticmethod
    def none() -> ComparedPairs:
        """Return what there is before the first round."""
        nothing = np.zeros(0, np.int64)
        proposal = Proposal(
            first=nothing, second=nothing, across=np.zeros(0, bool), overlap=np.zeros(0)
        )
        return ComparedPairs(proposal=proposal, found=(), round=nothing, rejected=np.zeros(0, bool))

    def keys(self, nodes: int) -> Ints:
        """Return first * nodes + second of all pairs."""
        return self.proposal.first * nodes + self.proposal.second

    def joined_with(
        self, proposal: Proposal, found: Sequence[PairMatch], number: int
    ) -> ComparedPairs:
        """Return these and the pairs of another round."""
        old = self.proposal
        return ComparedPairs(
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

    def rejecting(self, links: Mask) -> ComparedPairs:
        """Return these without some of the kept pairs."""
        rejected = self.rejected.copy()
        rejected[self.kept()[links]] = True
        return replace(self, rejected=rejected)

    def links(self, scene: LinkedScene) -> CameraLinks:
        """Return the relative poses of the kept pairs."""
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
            bottom=np.column_stack([scene.bottom[first], scene.bottom[second]]),
        )

    def sorted(self) -> ComparedPairs:
        """Return these by (first, second)."""
        order, p = np.lexsort((self.proposal.second, self.proposal.first)), self.proposal
        return ComparedPairs(
            proposal=Proposal(
                first=p.first[order],
                second=p.second[order],
                across=p.across[order],
                overlap=p.overlap[order],
            ),
            found=tuple(self.found[k] for k in order),
            round=self.round[order],
            rejected=self.rejected[order],
        )
