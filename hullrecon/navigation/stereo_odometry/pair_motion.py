# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The motion of a stereo rig between two pairs of images, which vision measures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeVar

from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array

Frame = TypeVar("Frame")


@dataclass(frozen=True, kw_only=True)
class CalibrationEffect:
    """The effect of the k errors of the cameras' calibration, one unknown each for the dive."""

    by_error: Array  # (6, k) derivative of a motion by the errors
    # (k, k) information of the motion's features on the errors, with the motion marginalised
    information: Array
    gradient: Array  # (k,) of the features' cost by the errors, likewise


@dataclass(frozen=True, kw_only=True)
class StereoMotion:
    """The motion of the top camera between two pairs."""

    pose: Poses  # first_from_second
    # (6, 6) white, of (translation in first, m, rotation perturbed on the right, rad)
    covariance: Array
    inliers: int  # features that agree on it
    calibration: CalibrationEffect  # effect of the calibration's errors on it


class PairMotion(Protocol[Frame]):
    """Reads stereo pairs and tells how the rig moved between two of them."""

    def frame(self, top: int, bottom: int) -> Frame:
        """Read what motions need of the images in these rows of the cameras' indices."""

    def between(self, first: Frame, second: Frame) -> StereoMotion | None:
        """Measure the motion between two pairs. None where too few features agree on one."""
