# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What stereo odometry asks for: the motion of the rig between two pairs of images. Vision measures
it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeVar

from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array

Frame = TypeVar("Frame")


@dataclass(frozen=True, kw_only=True)
class CalibrationEffect:
    """The k errors of the cameras' calibration, one unknown each for the dive. by_error (6, k):
    derivative of a motion by them; information (k, k), gradient (k,): what its features say of them
    once the motion is free.
    """

    by_error: Array
    information: Array
    gradient: Array


@dataclass(frozen=True, kw_only=True)
class StereoMotion:
    """pose: T_i_j of the top camera, one; covariance (6, 6) of (translation in i, m, rotation
    perturbed on the right, rad), of its white part; inliers: features that agree on it;
    calibration: what the errors of the calibration do to it.
    """

    pose: Poses
    covariance: Array
    inliers: int
    calibration: CalibrationEffect


class PairMotion(Protocol[Frame]):
    """Reads stereo pairs and tells how the rig moved between two of them."""

    def frame(self, top: int, bottom: int) -> Frame:
        """Return what is needed of the images in those rows of the cameras' indices."""

    def between(self, first: Frame, second: Frame) -> StereoMotion | None:
        """Return the motion from the first pair to the second; None where too few features agree on
        one.
        """
