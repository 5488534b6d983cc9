# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two-view geometry without depth: essential matrix or homography.

The geometric information criterion chooses between them [Torr1998], [KimEustice2009 III-B].
Matches are `first` and `second` (n, 2) in ideal coordinates of the two views.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from hullrecon.geometry.rotations import cross_matrix
from hullrecon.typing import Array, Mask

Model = Literal["essential", "homography"]

# Dimension of the manifold of matches, number of parameters [KimEustice2009 III-B].
ESSENTIAL, HOMOGRAPHY = (3, 5), (2, 8)
LEAST_MATCHES = 8


@dataclass(frozen=True)
class TwoView:
    """A model of the matches of two views."""

    model: Model
    matrix: Array  # (3, 3) in ideal coordinates, second from first
    inlier: Mask  # (n,)


@dataclass(frozen=True)
class ScoredModel:
    """A model of the matches, with how well it explains them."""

    model: Model
    matrix: Array  # (3, 3) as in TwoView
    squared_error: Array  # (n,) in ideal coordinates
    criterion: float  # geometric information criterion, smaller is better

    def within(self, tolerance: float) -> TwoView:
        """Take the matches within a tolerance as inliers."""
        return TwoView(self.model, self.matrix, self.squared_error < tolerance**2)


@dataclass(frozen=True, kw_only=True)
class BothModels:
    """Both models of the same matches."""

    essential: ScoredModel
    homography: ScoredModel


@dataclass(frozen=True)
class PossibleMotion:
    """A motion that a two-view model may stand for."""

    motion: Array  # (4, 4) second from first, |t| = 1
    # (3,) of a homography's plane, in the first camera's axes, pointing away from it
    normal: Array | None = None


def fit(first: Array, second: Array, tolerance: float) -> TwoView | None:
    """Fit an essential matrix or a homography to matches, whichever has the smaller criterion.

    Both are fitted by RANSAC. On a flat hull the essential matrix is not determined, and the
    homography wins. None with fewer than LEAST_MATCHES, or where one of the models cannot be
    fitted.

    first, second: (n, 2) in ideal coordinates. tolerance: largest error of an inlier.
    """
    both = fit_both(first, second, tolerance)
    if both is None:
        return None
    flat = both.homography.criterion < both.essential.criterion
    return (both.homography if flat else both.essential).within(tolerance)


def fit_both(first: Array, second: Array, tolerance: float) -> BothModels | None:
    """Fit an essential matrix and a homography to the same matches, and score both.

    The one of smaller criterion explains them better. None with fewer than LEAST_MATCHES, or where
    one of them cannot be fitted. first, second: (n, 2) in ideal coordinates. tolerance: largest
    error of an inlier.
    """
    import cv2

    if len(first) < LEAST_MATCHES:
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
    sigma = 0.5 * tolerance  # of a match: the tolerance of RANSAC is taken as two sigmas
    gic_e = criterion(errors[0] / sigma**2, *ESSENTIAL)
    gic_h = criterion(errors[1] / sigma**2, *HOMOGRAPHY)
    return BothModels(
        essential=ScoredModel("essential", essential[:3], errors[0], gic_e),
        homography=ScoredModel("homography", homography, errors[1], gic_h),
    )


def criterion(whitened_squared: Array, dimension: int, parameters: int) -> float:
    """Compute the geometric information criterion of a model, smaller is better.

    It is sum e^2/sigma^2 + 2 d N + 4 P [Torr1998], [KimEustice2009 III-B], with e the error of a
    match, sigma its sigma, d the dimension of the manifold of matches, N their number and P the
    number of parameters. The term of a match is capped at 2 (4 - d), so that a single outlier
    cannot decide. whitened_squared: (N,) e^2/sigma^2.
    """
    capped = np.minimum(whitened_squared, 2.0 * (4 - dimension))
    return float(capped.sum() + 2.0 * dimension * len(whitened_squared) + 4.0 * parameters)


def sampson_squared(essential: Array, first: Array, second: Array) -> Array:
    """Compute squared Sampson distances (n,) of matches first, second (n, 2) in ideal coordinates.

    essential: (3, 3). They are about the squared distances from the epipolar lines, x_second^T E
    x_first = 0.
    """
    a, b = first.T, second.T
    # By column, ten times faster than (n, 3).
    line_second = [row[0] * a[0] + row[1] * a[1] + row[2] for row in essential]
    line_first = [column[0] * b[0] + column[1] * b[1] + column[2] for column in essential.T[:2]]
    algebraic = b[0] * line_second[0] + b[1] * line_second[1] + line_second[2]
    scale = line_second[0] ** 2 + line_second[1] ** 2 + line_first[0] ** 2 + line_first[1] ** 2
    return np.asarray(algebraic**2 / np.maximum(scale, 1e-18))


def homography_squared(homography: Array, first: Array, second: Array) -> Array:
    """Compute how far matches (n, 2) are from a homography: the squared transfer error (n,).

    It is the mean of both directions, halved. Halved, it has the size of a point's squared error in
    one image.
    """
    forward = _apply(homography, first) - second
    backward = _apply(np.asarray(np.linalg.inv(homography)), second) - first
    return np.asarray(0.25 * ((forward**2).sum(axis=1) + (backward**2).sum(axis=1)))


def essential_of(second_from_first: Array) -> Array:
    """Compute the essential matrix [t]x R (3, 3) of a motion second_from_first (4, 4)."""
    return np.asarray(cross_matrix(second_from_first[:3, 3]) @ second_from_first[:3, :3])


def motions_of(found: TwoView, first: Array, second: Array) -> list[PossibleMotion]:
    """List the motions that a model may stand for, with the inliers in front of both cameras.

    An essential matrix stands for one, a homography for up to two, of which none may be left. One
    that is a pure rotation gives a motion with translation 0. first, second: the matches (n, 2) to
    which the model was fitted.
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
    """Build second_from_first (4, 4) with |t| = 1, or 0 where the translation is 0."""
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = rotation, translation / max(float(np.linalg.norm(translation)), 1e-12)
    return out


def _apply(homography: Array, xy: Array) -> Array:
    moved = np.hstack([xy, np.ones((len(xy), 1))]) @ homography.T
    return np.asarray(moved[:, :2] / np.where(np.abs(moved[:, 2:]) < 1e-12, 1e-12, moved[:, 2:]))
