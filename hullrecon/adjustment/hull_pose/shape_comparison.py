# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Comparison of the surveyed hull's shape with the CAD model's (docs/methods.md 20).

Any CAD model can be registered to a patch so that most points lie within centimetres of it, and the
deviation field takes up what is left. What is left must then be no larger than the CAD model's
error may be, pattern by pattern. Only a patch that a plane explains far worse can tell one ship
from another.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri  # not scipy.stats, which takes a quarter of a second to load

from hullrecon.adjustment.hull_pose import cad_error, pose_cost
from hullrecon.adjustment.hull_pose.estimate import HullPoseEvidence
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array, Mask

MISTAKEN = 2.0  # factor by which the stated error may be exceeded (docs/adr/0010)
CHANCE = 1e-3  # probability that a CAD model as good as its package states is refused
# Probability that its sigmas are widened needlessly, which costs less than a wrong ship
WIDENING = 1e-2
# Points farther outside are structures and growth. Points inside are kept, as no structure lies
# inside the steel.
OUTSIDE_SIGMAS = 3.0
MIN_POINTS = 30  # left after the points outside are dropped
PASSES = 4  # of refitting without the points outside
SCALE_PRIOR = 0.5  # prior sigma of a CAD model's scale along each axis


@dataclass(frozen=True, kw_only=True)
class ShapeComparison:
    """Comparison of points on the hull with the CAD model's shape, after a fit of its pose.

    The distances of the points to the CAD model are split into independent patterns of the model's
    error, each with the variance that the package states.
    """

    patterns: int  # number of patterns that the points resolve
    deviation: float = 0.0  # mean square of the patterns' amplitudes, in their stated variances
    plane: float = 0.0  # the same for distances to the best plane instead of the CAD model
    scale_chi2: float = 0.0  # chi-square that scaling the CAD model along its axes explains
    scale_sigma: tuple[float, ...] = ()  # (3,) sigma of these scales

    @property
    def needs_wider_sigma(self) -> bool:
        """Whether the hull deviates beyond the stated error, at the level WIDENING."""
        return self._beyond(1.0, WIDENING)

    @property
    def exceeds_stated_error(self) -> bool:
        """Whether the hull deviates beyond the stated error, at the stricter level CHANCE."""
        return self._beyond(1.0, CHANCE)

    @property
    def is_of_another_hull(self) -> bool:
        """Whether the CAD model is of another hull.

        The hull deviates beyond MISTAKEN times the stated error, or beyond the stated error where
        the CAD model does not fit better than a plane.
        """
        return self.exceeds_stated_error and (
            self._beyond(MISTAKEN, CHANCE) or not self.fits_better_than_plane
        )

    @property
    def fits_better_scaled(self) -> bool:
        """Whether other scales along the axes fit better, at the level CHANCE."""
        return self.scale_chi2 > float(chdtri(min(3, self.patterns) or 1, CHANCE))

    @property
    def log_odds(self) -> float:
        """Log odds that the points have the CAD model's shape rather than a plane's.

        The size of the error is estimated for each of the two. Zero where the points cannot tell.
        """
        return 0.5 * self.patterns * float(np.log(max(self.plane, 1.0) / max(self.deviation, 1.0)))

    @property
    def fits_better_than_plane(self) -> bool:
        """Whether the CAD model explains the points better than a plane, at the level CHANCE."""
        return self.log_odds > -float(np.log(CHANCE))

    def _beyond(self, times: float, chance: float) -> bool:
        """Test whether the deviation exceeds a multiple of the stated error.

        Parameters
        ----------
        times
            The multiple.
        chance
            Probability that a hull within that error fails the chi-square test.
        """
        return self.patterns > 0 and self.deviation * self.patterns > times**2 * float(
            chdtri(self.patterns, chance)
        )


def compare_shape(evidence: HullPoseEvidence, pose: Poses) -> ShapeComparison:
    """Compare the shape of points that lie on the hull with the CAD model's.

    Parameters
    ----------
    evidence
        Points and CAD model.
    pose
        global_from_hull, fitted to the points.
    """
    cad_model, expected = evidence.cad_model, evidence.cad_error_model
    distance, jacobian = pose_cost.signed_distances(
        evidence.points, pose, evidence.center, cad_model.mesh
    )
    at = pose.inverse().apply(evidence.points)
    noise = expected.noise**2 + cad_error.facet_variance(cad_model, at, sigmas=1.0)
    plane = _distance_to_plane(at)
    loose = evidence.distances_by_segments(pose)
    # How distances move where the pose or a segment follows the points, and with a common offset:
    # the fit has taken out what lies along these, so they hold no information on the shape
    fitted = np.c_[
        _distances_by_open_directions(jacobian, cad_model, noise),
        _beyond_noise(loose, noise),
        np.ones(len(at)),
    ]
    used = _without_structures(
        distance, fitted, OUTSIDE_SIGMAS * float(np.hypot(expected.sigma, np.sqrt(noise)))
    )
    field = cad_error.matern32(
        cad_error.chart_coordinates(cad_model, at[used]), expected.sigma, expected.length
    )
    patterns, variance = _resolved_patterns(field, fitted[used], noise)
    if not len(variance):
        return ShapeComparison(patterns=0)
    whitened = patterns.T / np.sqrt(variance)[:, None]
    # Unit normals in M: a shift of the hull in g changes a distance by minus its normal
    outward = -jacobian[:, :3] @ pose.rotation.as_matrix()[0]
    # The scales' derivatives are taken at the feet of the points on the CAD model: at the points
    # themselves, their noise would correlate with the distances.
    on_cad = at - distance[:, None] * outward
    by_ratio = -outward * (on_cad - evidence.center)
    chi2, sigma = scale_test(whitened @ distance[used], whitened @ by_ratio[used])
    deviation, flat = (float(np.mean((whitened @ h[used]) ** 2)) for h in (distance, plane))
    return ShapeComparison(
        patterns=len(variance),
        deviation=deviation,
        plane=flat,
        scale_chi2=chi2,
        scale_sigma=sigma,
    )


def _distance_to_plane(at: Array) -> Array:
    """Compute the signed distances (n,) of points (n, 3) to the plane that fits them best."""
    from_middle = at - at.mean(axis=0)
    # Few points are left where the others contradict them. Through two of them planes are many, and
    # only the whole basis has a normal of one.
    axes = np.linalg.svd(from_middle, full_matrices=len(at) < 3)[2]
    return np.asarray(from_middle @ axes[2])


def _distances_by_open_directions(jacobian: Array, cad_model: CadModel, noise: float) -> Array:
    """Find how distances change (n, k) in directions that the pose's prior leaves open.

    A direction is open if one sigma of the prior along it moves the distances beyond the noise.

    Parameters
    ----------
    jacobian
        (n, 6) of the distances by the step of `perturb_pose`.
    cad_model
        The prior of its pose says how far each direction is open.
    noise
        Variance of the distances, m2.
    """
    return _beyond_noise(jacobian @ np.linalg.inv(pose_cost.prior_rows(cad_model)), noise)


def _beyond_noise(by_sigma: Array, noise: float) -> Array:
    """Find an orthonormal basis (n, k) of the motions of distances that exceed the noise.

    by_sigma (n, q): how distances move by one sigma of each unknown. noise: variance, m2.
    """
    left, size, _ = np.linalg.svd(by_sigma, full_matrices=False)
    return np.asarray(left[:, size > np.sqrt(noise)])


def _without_structures(distance: Array, fitted: Array, most: float) -> Mask:
    """Select points that do not stand out of the hull, as structures and growth do.

    A linear fit to the selected distances and the selection by its residuals alternate.

    Parameters
    ----------
    distance
        (n,) m, outward positive.
    fitted
        (n, k) columns of the fit.
    most
        Largest residual, m, of a selected point.
    """
    used = np.ones(len(distance), bool)
    for _ in range(PASSES):
        residual = distance - fitted @ np.linalg.lstsq(fitted[used], distance[used])[0]
        if (residual <= most).sum() < MIN_POINTS:
            break
        used = residual <= most
    return used


def _resolved_patterns(field: Array, fitted: Array, noise: float) -> tuple[Array, Array]:
    """Find the independent patterns of a field that stand out of the noise (Karhunen-Loeve).

    Parameters
    ----------
    field
        Covariance (n, n) of the field.
    fitted
        Columns (n, k) that a fit has taken out. Patterns are orthogonal to them.
    noise
        Variance of the noise.

    Returns
    -------
    patterns, variances
        Orthonormal (n, p), and their variances (p,) m2, with the noise.
    """
    basis, size, _ = np.linalg.svd(fitted, full_matrices=True)
    # Directions orthogonal to what the fit has taken out
    free = basis[:, int((size > 1e-9 * size[0]).sum()) :]
    variance, vectors = np.linalg.eigh(free.T @ field @ free)
    resolved = variance > noise
    return np.asarray(free @ vectors[:, resolved]), np.asarray(variance[resolved] + noise)


def scale_test(deviation: Array, by_ratio: Array) -> tuple[float, tuple[float, ...]]:
    """Test whether other scales of the CAD model explain how the hull deviates from it.

    Parameters
    ----------
    deviation
        Whitened amplitudes (p,) of the patterns.
    by_ratio
        Derivatives (p, 3) of these by the scales along three axes.

    Returns
    -------
    chi2, sigmas
        Chi-square that the three scales explain, and the sigma of each. Where the variance of the
        residuals is above one, both are relative to it.
    """
    information = by_ratio.T @ by_ratio + np.eye(3) / SCALE_PRIOR**2
    gradient = by_ratio.T @ deviation
    explained = float(gradient @ np.linalg.solve(information, gradient))
    variance = max((float(deviation @ deviation) - explained) / max(len(deviation) - 3, 1), 1.0)
    sigma = np.sqrt(np.diag(np.linalg.inv(information)) * variance)
    return explained / variance, tuple(float(s) for s in sigma)
