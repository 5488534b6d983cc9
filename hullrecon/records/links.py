# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Pairs of nodes whose images were compared, what they have in common, and the path that this ties
together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.geometry.poses import Poses
from hullrecon.records.trajectory import VehiclePath
from hullrecon.rows import Rows
from hullrecon.typing import Array, Floats32, Ints, Mask


@dataclass(frozen=True, kw_only=True)
class CameraLinks(Rows):
    """Relative poses of the leading cameras of pairs of nodes, as images measured them.

    first, second (m,): nodes. translation (m, 3) m, in the second camera's axes, and quaternion (m,
    4): second_from_first. covariance (m, 6, 6) of (translation, rotation perturbed on the right).
    scaled (m,): the length of the translation was measured; where it was not, its direction alone
    says something. bottom (m, 2): the bottom camera leads at either node.
    """

    first: Ints
    second: Ints
    translation: Array
    quaternion: Array
    covariance: Array
    scaled: Mask
    bottom: Mask


def no_links() -> CameraLinks:
    """Return what a dive without images has."""
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
    """All pairs that were compared, sorted by (first, second). first < second (m,): nodes; across
    (m,): of another leg; overlap (m,): of the footprints as predicted, NaN where no depth is known;
    round (m,): 0 of neighbours, 1, 2, ... across; putative (m,): matches before verification;
    reason (m,): why it gave nothing, 0 where it matched; rejected (m,): matched, but its motion
    contradicts other pairs or the path, or lies across an outage on a hull that looks alike
    elsewhere.
    """

    first: Ints
    second: Ints
    across: Mask
    overlap: Array
    round: Ints
    putative: Ints
    reason: Ints
    rejected: Mask

    @property
    def joined(self) -> Mask:
        """Return which pairs (m,) matched and were kept."""
        return np.asarray((self.reason == 0) & ~self.rejected)


@dataclass(frozen=True, kw_only=True)
class PairFeatures:
    """Features that the pairs have in common. start (m + 1,): where each pair's rows begin; first,
    second (k,): rows of the leading camera's features at either node; distance (k,) of their
    descriptors.
    """

    start: Ints
    first: Ints
    second: Ints
    distance: Floats32


@dataclass(frozen=True, kw_only=True)
class NodeStereo:
    """What the two cameras of each node have in common. features (n,): number of the leading
    camera's features; start (n + 1,): where each node's rows begin; top, bottom (k,): rows of the
    cameras' features; point (k, 3) m in the top camera.
    """

    features: Ints
    start: Ints
    top: Ints
    bottom: Ints
    point: Array


@dataclass(frozen=True, kw_only=True)
class LinkedPath:
    """The vehicle as navigation and links have it: pose (n, 7) T_g_v as x y z qx qy qz qw, tray
    (n,) rad, covariance (n, 6, 6) of (translation in g, rotation perturbed on the right); part
    (n,): nodes of one number are tied to each other by images, 0 the largest; -1 where no image of
    the node matched. part_sigma (parts,) m: of the middle of each part relative to that of the
    largest.
    """

    pose: Array
    tray: Array
    covariance: Array
    part: Ints
    part_sigma: Array

    def path(self) -> VehiclePath:
        """Return the vehicle and its tray."""
        return VehiclePath(
            poses=Poses(self.pose[:, 3:].copy(), self.pose[:, :3].copy()), tray=self.tray
        )
