# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Pairs of nodes whose images were compared, what they share, and the path that links constrain.

The leading camera of a node is the one whose images are compared with those of other nodes: the top
one, or the bottom one where the top one is dark or missing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hullrecon.geometry.poses import Poses
from hullrecon.records.trajectory import VehiclePath
from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints, Mask


@dataclass(frozen=True, kw_only=True)
class CameraLinks(Rows):
    """Relative poses of the leading cameras of pairs of nodes, as images measured them."""

    first: Ints  # (m,) nodes
    second: Ints  # (m,) nodes
    translation: Array  # (m, 3) m, in the second camera's axes
    quaternion: Array  # (m, 4) second_from_first
    covariance: Array  # (m, 6, 6) of (translation, rotation perturbed on the right)
    scaled: Mask  # (m,) the length of the translation was measured, else its direction alone
    bottom: Mask  # (m, 2) the bottom camera leads at either node


def no_links() -> CameraLinks:
    """Make the links of a dive without images: none, but with arrays of the right shapes."""
    none = np.zeros(0, np.int64)
    return CameraLinks(
        first=none,
        second=none,
        translation=np.zeros((0, 3)),
        quaternion=np.zeros((0, 4)),
        covariance=np.zeros((0, 6, 6)),
        scaled=np.zeros(0, bool),
        bottom=np.zeros((0, 2), bool),
    )


@dataclass(frozen=True, kw_only=True)
class NodePairs(Rows):
    """All pairs that were compared, sorted by (first, second)."""

    first: Ints  # (m,) nodes, first < second
    second: Ints  # (m,) nodes
    across: Mask  # (m,) the nodes belong to different legs
    overlap: Array  # (m,) of the footprints as predicted, NaN where no depth is known
    round: Ints  # (m,) in which the pair was compared: 0 for neighbours, 1, 2, ... across legs
    putative: Ints  # (m,) matches before verification
    reason: Ints  # (m,) code of why the pair did not match, 0 if it matched
    # (m,) matched, but its motion contradicts other pairs or the path, or lies across an outage on
    # a hull that looks alike elsewhere
    rejected: Mask

    @property
    def joined(self) -> Mask:
        """Which pairs (m,) matched and were kept."""
        return np.asarray((self.reason == 0) & ~self.rejected)


# A feature that two nodes have in common: the rows of it among the leading cameras' features, and
# the distance of its two descriptors.
COMMON_FEATURE = np.dtype([("first", "<i4"), ("second", "<i4"), ("distance", "<f4")])


@dataclass(frozen=True, kw_only=True)
class PairFeatures:
    """Features that pairs have in common."""

    start: Ints  # (m + 1,) where each pair's rows begin
    rows: NDArray[np.void]  # (k,) of COMMON_FEATURE, mapped from their file


@dataclass(frozen=True, kw_only=True)
class NodeStereo:
    """What the two cameras of each node have in common."""

    features: Ints  # (n,) number of the leading camera's features
    start: Ints  # (n + 1,) where each node's rows begin
    top: Ints  # (k,) rows of the top camera's features
    bottom: Ints  # (k,) rows of the bottom camera's
    point: Array  # (k, 3) m in the top camera


@dataclass(frozen=True, kw_only=True)
class LinkedPath:
    """The vehicle's path from navigation and links."""

    pose: Array  # (n, 7) global_from_vehicle as x y z qx qy qz qw
    tray: Array  # (n,) rad
    covariance: Array  # (n, 6, 6) of (translation in g, rotation perturbed on the right)
    # (n,) connected part that images link the node to, 0 the largest, -1 if no image matched
    part: Ints
    part_sigma: Array  # (parts,) m, of the middle of each part relative to that of the largest

    def path(self) -> VehiclePath:
        """Select the poses of vehicle and tray."""
        return VehiclePath(
            poses=Poses(self.pose[:, 3:].copy(), self.pose[:, :3].copy()), tray=self.tray
        )
