# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Choose the inliers of two views without depth with the help of navigation.

On a nearly plane hull a turn and a shift of the camera look alike. A motion that is degrees off
leaves residuals of only a tenth of a pixel in the right matches, and RANSAC may prefer it for a few
wrong matches that it happens to fit. Navigation knows the motion better than that, and with it the
wrong matches stand out. Navigation only chooses the inliers: the motion is refined on them without
it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.robust import robust_sigma
from hullrecon.typing import Array, Mask
from hullrecon.vision.pairs import mono_motion
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.stereo_adjustment import OUTLIER_SIGMAS
from hullrecon.vision.pairs.two_view import PossibleMotion, essential_of, sampson_squared

ITERATIONS = 25  # iteratively reweighted steps at most
GATHERINGS = 5  # times that inliers are chosen anew at most: they settle in two or three
LEAST_SIGMA = 1e-7  # of a match, ideal coordinates; avoids a division by zero
LEAST_LENGTH_M = 1e-3  # of a motion that has a direction
WELL_KNOWN_RAD = 0.1  # largest sigma of navigation's rotation and direction to choose inliers by it
# Largest difference of rotation or direction from navigation's. The two motions of a plane differ
# by more.
NEAR_RAD = 0.3
LARGEST_STEP = 0.1  # rad, m: limits steps where the matches hardly determine the motion


def choose(
    possible: Sequence[PossibleMotion],
    matches: tuple[Array, Array],
    prior: Motion | None,
    surface_normal: tuple[float, float, float] | None,
) -> Motion:
    """Choose the right one among the motions of a two-view model, each refined on its inliers.

    A homography stands for two motions, with different normals of the plane. The one whose normal
    is nearest to the DVL's is taken, else the one nearest to navigation's motion, else the first.

    Parameters
    ----------
    possible
        The motions.
    matches
        The model's inliers (n, 2) of both views, ideal coordinates.
    prior
        Navigation's motion, by which inliers are chosen and which gives the length. None where
        unknown.
    surface_normal
        Unit normal of the hull by the DVL, in the first camera. None where not measured.
    """
    if surface_normal is not None and all(p.normal is not None for p in possible):
        possible = [max(possible, key=lambda p: float(np.dot(surface_normal, p.normal)))]  # type: ignore[arg-type]
    found = [
        mono_motion.with_length(*refine_on_inliers(p.motion, *matches, prior), prior)
        for p in possible
    ]
    if prior is None:
        return found[0]
    return min(found, key=lambda motion: mono_motion.navigation_chi2(motion, prior))


def gather(
    motion: Motion, first: Array, second: Array, prior: Motion | None, tolerance: float
) -> tuple[Motion, Mask]:
    """Refine a motion on all matches (n, 2) near their epipolar lines.

    The inliers of a homography are not enough: on a curved hull they are the matches whose noise
    makes the hull look flatter, which turns the motion. Where too few matches are near their lines,
    the first guess is returned unchanged.

    Parameters
    ----------
    motion
        First guess.
    first, second
        Matches (n, 2) in both images, ideal coordinates.
    prior
        Navigation's motion, by which inliers are chosen and which gives the length. None where
        unknown: the length is then 1.
    tolerance
        Largest distance of an inlier from its epipolar line, ideal coordinates.

    Returns
    -------
    motion
        Refined, with navigation's length, and its covariance.
    inlier
        Matches (n,) near the epipolar lines of the refined motion.
    """
    inlier = on_lines(motion.second_from_first, first, second, tolerance)
    found: _OnInliers | None = None
    for _ in range(GATHERINGS):
        if inlier.sum() <= 2 * mono_motion.FREEDOMS:
            break
        start = _unit(motion.second_from_first) if found is None else found.motion
        found = _fit_on_inliers(start, first[inlier], second[inlier], prior)
        before, inlier = inlier, on_lines(found.motion, first, second, tolerance)
        if (inlier == before).all():
            break
    if found is None:
        return motion, inlier
    return mono_motion.with_length(found.motion, found.covariance(), prior), inlier


def on_lines(motion: Array, first: Array, second: Array, tolerance: float) -> Mask:
    """Select matches (n, 2) within a tolerance of their epipolar lines by second_from_first."""
    return np.asarray(sampson_squared(essential_of(motion), first, second) < tolerance**2)


def refine_on_inliers(
    start: Array, first: Array, second: Array, prior: Motion | None
) -> tuple[Array, Array]:
    """Refine a motion on the matches that agree with the most likely motion.

    The most likely motion is that of matches and navigation together. It shows which matches are
    wrong, and has no further part in the result. All matches are taken where navigation does not
    know the motion well, or contradicts the one fitted without it.

    The covariance is enlarged for wrong matches that happen to lie within the limit and stay. It is
    scaled by the mean square of the residuals of all matches, those of rejected ones set to the
    limit, over that of the inliers.

    Parameters
    ----------
    start
        Motion (4, 4), second_from_first, with |t| = 1.
    first, second
        Matches (n, 2) in both images, ideal coordinates.
    prior
        Navigation's motion. None where it is not known: all matches are then taken.

    Returns
    -------
    motion
        (4, 4), second_from_first, with |t| = 1.
    covariance
        (5, 5) of its rotation and direction.
    """
    found = _fit_on_inliers(start, first, second, prior)
    return found.motion, found.covariance()


@dataclass(frozen=True, kw_only=True)
class _OnInliers:
    """A motion fitted to the inliers of some matches."""

    motion: Array  # second_from_first (4, 4) with |t| = 1
    first: Array  # (n, 2) the matches, ideal coordinates
    second: Array
    good: Mask | None  # (n,) the inliers, None for all
    limit: float  # largest Sampson distance of an inlier, ideal coordinates

    def covariance(self) -> Array:
        """Compute the covariance (5, 5) of rotation and direction.

        It is enlarged for wrong matches that may be left among the inliers (`refine_on_inliers`).
        """
        if self.good is None:
            return mono_motion.covariance_of(self.motion, self.first, self.second)
        covariance = mono_motion.covariance_of(
            self.motion, self.first[self.good], self.second[self.good]
        )
        squares = mono_motion.linearise(self.motion, self.first, self.second)[0] ** 2
        own = max(float(squares[self.good].mean()), LEAST_SIGMA**2)
        return np.asarray(
            covariance * max(1.0, float(np.minimum(squares, self.limit**2).mean()) / own)
        )


def _fit_on_inliers(start: Array, first: Array, second: Array, prior: Motion | None) -> _OnInliers:
    """Fit a motion to the matches that agree with the most likely motion, as `refine_on_inliers`.

    The covariance, which takes as long again, is computed only when it is asked for. start:
    RANSAC's second_from_first (4, 4), |t| = 1. first, second: matches (n, 2), ideal coordinates.
    prior: navigation's motion.
    """
    motion = mono_motion.fit(start, first, second)
    alone = _OnInliers(motion=motion, first=first, second=second, good=None, limit=np.inf)
    if prior is None or not is_well_known(prior) or not _is_near(motion, prior):
        return alone
    likely, sigma = most_likely_motion(motion, first, second, prior)
    limit = OUTLIER_SIGMAS * sigma
    good = np.abs(mono_motion.linearise(likely, first, second)[0]) < limit
    if good.sum() <= 2 * mono_motion.FREEDOMS:
        return alone
    return replace(
        alone, motion=mono_motion.fit(likely, first[good], second[good]), good=good, limit=limit
    )


def is_well_known(prior: Motion) -> bool:
    """Decide whether navigation knows rotation and direction well enough to choose inliers.

    Its sigmas must be small enough to rule out the wrong one of a plane's two motions, and motions
    that only the noise of nearly plane matches suggests.
    """
    length = float(np.linalg.norm(prior.second_from_first[:3, 3]))
    if length < LEAST_LENGTH_M:
        return False
    across = mono_motion.tangent_basis(prior.second_from_first[:3, 3] / length)
    direction = across.T @ prior.covariance[:3, :3] @ across / length**2
    worst = max(np.linalg.eigvalsh(part)[-1] for part in (direction, prior.covariance[3:, 3:]))
    return bool(worst < WELL_KNOWN_RAD**2)


def _is_near(motion: Array, prior: Motion) -> bool:
    """Decide whether a motion (4, 4) is near navigation's, and not a plane's second solution."""
    wanted = prior.second_from_first
    turn = Rotation.from_matrix(wanted[:3, :3].T @ motion[:3, :3]).magnitude()
    cosine = motion[:3, 3] @ wanted[:3, 3] / np.linalg.norm(wanted[:3, 3])
    return bool(max(turn, np.arccos(np.clip(cosine, -1, 1))) < NEAR_RAD)


def most_likely_motion(
    start: Array, first: Array, second: Array, prior: Motion
) -> tuple[Array, float]:
    """Minimise the robust cost of matches (n, 2) and navigation together, from RANSAC's motion.

    It does not start from navigation's motion: from there the steps may lead to either of the two
    motions of a plane. Matches are weighted by Tukey's biweight with a sigma that falls from step
    to step, so that the costs of two steps cannot be compared. That is why geometry.pose_solver,
    which compares them, is not used. first, second: ideal coordinates.

    Returns
    -------
    motion
        second_from_first (4, 4) with |t| = 1.
    sigma
        Robust sigma of the matches about it, ideal coordinates.
    """
    motion = start.copy()
    motion[:3, 3] *= np.linalg.norm(prior.second_from_first[:3, 3])
    whitening = np.linalg.inv(np.linalg.cholesky(prior.covariance + LEAST_SIGMA**2 * np.eye(6)))
    of_navigation = whitening.T @ whitening
    for _ in range(ITERATIONS):
        length, unit = float(np.linalg.norm(motion[:3, 3])), _unit(motion)
        residual, derivative = mono_motion.linearise(unit, first, second)
        weight = _biweight(residual)
        # By translation (m), then rotation, as in Motion: a shift across the direction turns it by
        # the shift over the length.
        jacobian = np.hstack(
            [
                derivative[:, 3:] @ mono_motion.tangent_basis(unit[:3, 3]).T / length,
                derivative[:, :3],
            ]
        )
        weighted = (jacobian * weight[:, None]).T
        normal = weighted @ jacobian + of_navigation
        # Damp the translation, with its own length as sigma: matches do not determine the length,
        # and at rest not the direction either.
        normal[:3, :3] += np.eye(3) / length**2
        step = np.asarray(
            -np.linalg.solve(normal, weighted @ residual + of_navigation @ _gap(motion, prior))
        )
        step *= min(1.0, LARGEST_STEP / max(float(np.abs(step).max()), 1e-12))
        motion[:3, :3] = motion[:3, :3] @ Rotation.from_rotvec(step[3:]).as_matrix()
        motion[:3, 3] += step[:3]
        if np.abs(step).max() < 1e-7:
            break
    return _unit(motion), _sigma(mono_motion.linearise(_unit(motion), first, second)[0])


def _biweight(residual: Array) -> Array:
    """Weight residuals (n,) by Tukey's biweight over the squared robust sigma of all of them."""
    sigma = _sigma(residual)
    return np.asarray(
        np.clip(1 - (residual / (OUTLIER_SIGMAS * sigma)) ** 2, 0, None) ** 2 / sigma**2
    )


def _sigma(residual: Array) -> float:
    """Estimate the robust sigma of residuals (n,) about zero, LEAST_SIGMA at least."""
    return max(float(robust_sigma(residual, about=0.0)), LEAST_SIGMA)


def _gap(motion: Array, prior: Motion) -> Array:
    """Compute the difference (6,) of a motion (4, 4) from navigation's, in the order of Motion."""
    wanted = prior.second_from_first
    turn = Rotation.from_matrix(wanted[:3, :3].T @ motion[:3, :3]).as_rotvec()
    return np.concatenate([motion[:3, 3] - wanted[:3, 3], turn])


def _unit(motion: Array) -> Array:
    """Scale the translation of a motion (4, 4) to length 1."""
    out = motion.copy()
    out[:3, 3] /= np.linalg.norm(out[:3, 3])
    return out
