# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two-view geometry without depth: essential matrix or homography, chosen by the geometric
information criterion [KimEustice2009 III-B].
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from hullrecon.geometry.rotations import cross_matrix
from hullrecon.typing import Array, Mask
from hullrecon.vision.options import TwoViewModel

Model = Literal["essential", "homography"]

# dimension of the manifold of matches, parameters [KimEustice2009 III-B]
ESSENTIAL, HOMOGRAPHY = (3, 5), (2, 8)


@dataclass(frozen=True)
class TwoView:
    """model: which one explains the matches better. matrix (3, 3) in ideal coordinates, second from
    first; inlier (n,).
    """

    model: Model
    matrix: Array
    inlier: Mask


@dataclass(frozen=True)
class ScoredModel:
    """One model of the matches. matrix (3, 3) as in TwoView; squared_error (n,) in ideal
    coordinates; criterion: its geometric information criterion.
    """

    model: Model
    matrix: Array
    squared_error: Array
    criterion: float


@dataclass(frozen=True, kw_only=True)
class BothModels:
    """Both models of the same matches; that of the smaller criterion explains them better."""

    essential: ScoredModel
    homography: ScoredModel


@dataclass(frozen=True)
class PossibleMotion:
    """motion (4, 4) second from first, |t| = 1; normal (3,) of the plane in the first camera's
    axes, pointing away from it, where the motion is that of a homography.
    """

    motion: Array
    normal: Array | None = None


def fit(
    first: Array, second: Array, tolerance: float, model: TwoViewModel = "automatic"
) -> TwoView | None:
    """Return the better of both models by RANSAC on ideal coordinates (n, 2), scored on all
    matches, or the one asked for; None when fewer than 8 or neither fits.
    """
    both = fit_both(first, second, tolerance)
    if both is None:
        return None
    flat = (
        both.homography.criterion < both.essential.criterion
        if model == "automatic"
        else model == "homography"
    )
    taken = both.homography if flat else both.essential
    return TwoView(taken.model, taken.matrix, taken.squared_error < tolerance**2)


def fit_both(first: Array, second: Array, tolerance: float) -> BothModels | None:
    """Return both models with their scores; arguments and None as `fit` has them."""
    import cv2

    if len(first) < 8:
        return None
    cv2.setRNGSeed(0)
    eye = np.eye(3)
    essential, _ = cv2.findEssentialMat(
        first, second, eye, method=cv2.RANSAC, prob=0.9999, threshold=tolerance
    )
    homography, _ = cv2.findHomography(
        first, second, cv2.RANSAC, tolerance, maxIters=2000, confidence=0.9999
    )
    if essential is None or homography is None:
        return None
    errors = (
        sampson_squared(essential[:3], first, second),
        homography_squared(homography, first, second),
    )
    sigma = 0.5 * tolerance
    gic_e = criterion(errors[0] / sigma**2, *ESSENTIAL)
    gic_h = criterion(errors[1] / sigma**2, *HOMOGRAPHY)
    return BothModels(
        essential=ScoredModel("essential", essential[:3], errors[0], gic_e),
        homography=ScoredModel("homography", homography, errors[1], gic_h),
    )


def criterion(whitened_squared: Array, dimension: int, parameters: int) -> float:
    """Return sum e^2/sigma^2 + 2 d N + 4 P [Torr1998; KimEustice2009 III-B], an outlier's share
    capped at 2 (4 - d) so that one cannot decide alone.
    """
    capped = np.minimum(whitened_squared, 2.0 * (4 - dimension))
    return float(capped.sum() + 2.0 * dimension * len(whitened_squared) + 4.0 * parameters)


def sampson_squared(essential: Array, first: Array, second: Array) -> Array:
    """Return the (n,) squared Sampson distance in ideal coordinates; essential: x_second^T E
    x_first = 0.
    """
    a, b = first.T, second.T
    # by column: ten times faster than (n, 3)
    line_second = [row[0] * a[0] + row[1] * a[1] + row[2] for row in essential]
    line_first = [column[0] * b[0] + column[1] * b[1] + column[2] for column in essential.T[:2]]
    algebraic = b[0] * line_second[0] + b[1] * line_second[1] + line_second[2]
    scale = line_second[0] ** 2 + line_second[1] ** 2 + line_first[0] ** 2 + line_first[1] ** 2
    return np.asarray(algebraic**2 / np.maximum(scale, 1e-18))


def homography_squared(homography: Array, first: Array, second: Array) -> Array:
    """Return the (n,) mean of the squared transfer errors both ways, halved: of the size of a
    point's error in each image.
    """
    forward = _apply(homography, first) - second
    backward = _apply(np.asarray(np.linalg.inv(homography)), second) - first
    return np.asarray(0.25 * ((forward**2).sum(axis=1) + (backward**2).sum(axis=1)))


def essential_of(second_from_first: Array) -> Array:
    """Return [t]x R of a motion (4, 4)."""
    return np.asarray(cross_matrix(second_from_first[:3, 3]) @ second_from_first[:3, :3])


def motions_of(found: TwoView, first: Array, second: Array) -> list[PossibleMotion]:
    """Return the motions that the matrix may stand for; points ahead of both cameras. A homography
    that is a turn alone has no translation.
    """
    import cv2

    a, b = first[found.inlier], second[found.inlier]
    if found.model == "essential":
        _, rotation, translation, _ = cv2.recoverPose(found.matrix, a, b, np.eye(3))
        return [PossibleMotion(_motion(rotation, translation.ravel()))]
    _, rotations, translations, normals = cv2.decomposeHomographyMat(found.matrix, np.eye(3))
    seen = a[:, None].astype(np.float32), b[:, None].astype(np.float32)
    kept = cv2.filterHomographyDecompByVisibleRefpoints(rotations, normals, *seen)
    keep = range(len(rotations)) if kept is None else kept.ravel()
    return [
        PossibleMotion(_motion(rotations[k], translations[k].ravel()), normals[k].ravel())
        for k in keep
    ]


def _motion(rotation: Array, translation: Array) -> Array:
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = rotation, translation / max(float(np.linalg.norm(translation)), 1e-12)
    return out


def _apply(homography: Array, xy: Array) -> Array:
    moved = np.hstack([xy, np.ones((len(xy), 1))]) @ homography.T
    return np.asarray(moved[:, :2] / np.where(np.abs(moved[:, 2:]) < 1e-12, 1e-12, moved[:, 2:]))
