# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The result of matching two nodes: common features and a motion, or the reason for none."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from io import SEEK_END
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from hullrecon.records.links import COMMON_FEATURE
from hullrecon.typing import Floats32, Ints
from hullrecon.vision.pairs import mono_motion
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.stereo_adjustment import CalibrationEvidence


class Reason(IntEnum):
    """Why a pair was not matched, as stored in pairs.npz."""

    MATCHED = 0
    NO_FEATURES = 1
    FEW_PUTATIVE = 2
    FEW_INLIERS = 3
    AGAINST_NAVIGATION = 4
    SMALL_OVERLAP = 5
    NO_MOTION = 6


REASON_TEXTS = {
    Reason.MATCHED: "matched",
    Reason.NO_FEATURES: "too few features in one of the images",
    Reason.FEW_PUTATIVE: "too few putative matches",
    Reason.FEW_INLIERS: "too few inliers",
    Reason.AGAINST_NAVIGATION: "inconsistent with navigation",
    Reason.SMALL_OVERLAP: "overlap too small",
    Reason.NO_MOTION: "one place seen twice: no direction of motion",
}


@dataclass(frozen=True, kw_only=True)
class PairMatch:
    """The result of matching two nodes."""

    # (m,) rows of the two views' features that show one point; none when the pair failed, but for
    # NO_MOTION
    first: Ints
    second: Ints
    distance: Floats32  # (m,) of their descriptors
    putative: int  # matches before verification
    reason: Reason
    motion: Motion | None = None  # between the leading cameras, None when the pair failed
    scaled: bool = True  # the motion's length is measured; with one camera it is navigation's, or 1
    calibration: CalibrationEvidence | None = None  # of a scaled motion
    stored: range | None = None  # where a `FeatureSpool` has the features, in place of the above


class FeatureSpool:
    """The common features of compared pairs in a file, until it is known which pairs are kept."""

    def __init__(self, file: BinaryIO) -> None:
        self._file, self._rows = file, 0

    def put(self, found: PairMatch) -> PairMatch:
        """Write the features of a pair to the file, and return the pair with their rows there.

        The returned pair holds no features, so that those of a long dive need no memory.
        """
        rows = np.empty(len(found.first), COMMON_FEATURE)
        for name in COMMON_FEATURE.names or ():
            rows[name] = getattr(found, name)
        self._file.seek(0, SEEK_END)
        self._file.write(rows.tobytes())
        stored = range(self._rows, self._rows + len(rows))
        self._rows = stored.stop
        nothing = np.zeros(0, np.int64)
        return replace(
            found,
            first=nothing,
            second=nothing,
            distance=np.zeros(0, np.float32),
            stored=stored,
        )

    def get(self, found: PairMatch) -> NDArray[np.void]:
        """Read the features (m,) of a pair that was put here."""
        if found.stored is None:
            raise ValueError("the features of this pair were not stored")
        self._file.seek(found.stored.start * COMMON_FEATURE.itemsize)
        data = self._file.read(len(found.stored) * COMMON_FEATURE.itemsize)
        return np.frombuffer(data, COMMON_FEATURE)


def failed_match(putative: int, reason: Reason) -> PairMatch:
    """Build the result of a pair that was not matched. putative: matches before verification."""
    return PairMatch(
        first=np.zeros(0, np.int64),
        second=np.zeros(0, np.int64),
        distance=np.zeros(0, np.float32),
        putative=putative,
        reason=reason,
    )


def agrees(found: PairMatch, prior: Motion, max_chi2: float) -> bool:
    """Test whether the motion of a matched pair agrees with a prior, by the covariances of both.

    A pair that did not match never agrees.

    Parameters
    ----------
    found
        The matched pair. A length that was not measured does not count.
    prior
        Motion between the same two nodes, by navigation or other links.
    max_chi2
        Largest chi-square of six degrees of freedom. A motion without a measured length has five,
        and five sixths of the limit.
    """
    if found.motion is None:
        return False
    if not found.scaled:
        limit = max_chi2 * mono_motion.FREEDOMS / 6
        return mono_motion.navigation_chi2(found.motion, prior) <= limit
    own, wanted = found.motion.second_from_first, prior.second_from_first
    turn = np.linalg.inv(wanted[:3, :3]) @ own[:3, :3]
    gap = np.concatenate([own[:3, 3] - wanted[:3, 3], Rotation.from_matrix(turn).as_rotvec()])
    covariance = prior.covariance + found.motion.covariance
    return bool(gap @ np.linalg.solve(covariance, gap) <= max_chi2)
