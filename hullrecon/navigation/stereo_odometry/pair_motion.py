# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What stereo odometry needs to be told: the motion of the rig between two pairs of images. Vision tells it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeVar

from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array

Frame = TypeVar("Frame")


@dataclass(frozen=True, kw_only=True)
class StereoMotion:
    """pose: T_i_j of the top camera, one; covariance (6, 6) of (translation in i, m, rotation perturbed on the right, rad);
    inliers: features that agree on it."""

    pose: Poses
    covariance: Array
    inliers: int


class PairMotion(Protocol[Frame]):
    """Reads stereo pairs and tells how the rig moved between two of them."""

    def frame(self, top: int, bottom: int) -> Frame:
        """Return what is needed of the images in those rows of the cameras' indices."""

    def between(self, first: Frame, second: Frame) -> StereoMotion | None:
        """Return the motion from the first pair to the second; None where too few features agree on one."""
