# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Comparison of the surveyed hull's form with the CAD model's (docs/methods.md 20).

Any CAD model can be registered to a patch so that most points lie within centimetres of it, and the
deviation field takes up what is left. What is left must then be no larger than the CAD model's
error may be, pattern by pattern. Only a patch that a plane explains far worse can tell one ship
from another.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri  # not scipy.stats, which takes a quarter of a second to load

from hullrecon.adjustment.hull_pose import cad_error, registration
from hullrecon.adjustment.hull_pose.estimate import HullPoseEvidence
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array, Mask

MISTAKEN = 2.0  # factor by which the stated error may be exceeded (docs/adr/0010)
CHANCE = 1e-3  # that a CAD model as good as its package says is refused
# Chance that its sigmas are widened needlessly, which costs less than placing another ship
WIDENING = 1e-2
OUTSIDE_SIGMAS = 3.0  # farther out stand structures and growth; nothing stands in the steel
MIN_POINTS = 30
PASSES = 4  # of refitting without the points outside
SCALE_PRIOR = 0.5  # one sigma of a CAD model's scale along an axis before anything is measured


@dataclass(frozen=True, kw_only=True)
class Form:
    """Comparison of points on the hull with the CAD model's form, after a fit of its pose."""

    patterns: int  # of the CAD model's error that the points resolve
    deviation: float = 0.0  # mean square along them, in the variance that the package allows
    plane: float = 0.0  # the same for distances to a plane
    scale_chi2: float = 0.0  # explained by scaling the CAD model along its three axes
    scale_sigma: tuple[float, ...] = ()  # (3,) sigma of these scales

    @property
    def contradicts(self) -> bool:
        """Whether the hull deviates from it by more than chance and the stated error explain."""
        return self._beyond(1.0, WIDENING)

    @property
    def is_worse_than_stated(self) -> bool:
        """Whether the hull deviates from it beyond the chance at which a CAD model is refused."""
        return self._beyond(1.0, CHANCE)

    @property
    def is_of_another_hull(self) -> bool:
        """Whether the hull deviates by more than a package may be mistaken.

        Or beyond chance, and a plane fits no worse.
        """
        return self.is_worse_than_stated and (self._beyond(MISTAKEN, CHANCE) or not self.confirms)

    @property
    def fits_better_scaled(self) -> bool:
        """Whether the CAD model's scale or proportions differ from the hull's beyond chance."""
        return self.scale_chi2 > float(chdtri(min(3, self.patterns) or 1, CHANCE))

    @property
    def log_odds(self) -> float:
        """Log odds that the points have the CAD model's form rather than a plane's.

        Each form has an error of its own size. Zero where the points cannot tell.
        """
        return 0.5 * self.patterns * float(np.log(max(self.plane, 1.0) / max(self.deviation, 1.0)))

    @property
    def confirms(self) -> bool:
        """Whether the log odds are beyond chance."""
        return self.log_odds > -float(np.log(CHANCE))

    def _beyond(self, times: float, chance: float) -> bool:
        """Test the deviation at a level of chance against a multiple of the stated error."""
        return self.patterns > 0 and self.deviation * self.patterns > times**2 * float(
            chdtri(self.patterns, chance)
        )


def compare_form(evidence: HullPoseEvidence, pose: Poses) -> Form:
    """Compare the form of points that lie on the hull with the CAD model's at a pose."""
    cad_model, expected = evidence.cad_model, evidence.cad_error_model
    distance, jacobian = registration.signed_distances(
        evidence.points, pose, evidence.center, cad_model.mesh
    )
    at = pose.inverse().apply(evidence.points)
    noise = expected.noise**2 + cad_error.facet_variance(cad_model, at, sigmas=1.0)
    plane = _distance_to_plane(at)
    loose = evidence.distances_by_segments(pose)
    fitted = np.c_[
        _open_directions(jacobian, cad_model, noise), _beyond_noise(loose, noise), np.ones(len(at))
    ]
    used = _within_structures(
        distance, fitted, OUTSIDE_SIGMAS * float(np.hypot(expected.sigma, np.sqrt(noise)))
    )
    field = cad_error.matern32(
        cad_error.chart_coordinates(cad_model, at[used]), expected.sigma, expected.length
    )
    patterns, variance = _resolved_patterns(field, fitted[used], noise)
    if not len(variance):
        return Form(patterns=0)
    whitened = patterns.T / np.sqrt(variance)[:, None]
    outward = -jacobian[:, :3] @ pose.rotation.as_matrix()[0]
    # where the points lie themselves, their noise would correlate with the distances
    on_cad = at - distance[:, None] * outward
    by_ratio = -outward * (on_cad - evidence.center)
    chi2, sigma = scale_test(whitened @ distance[used], whitened @ by_ratio[used])
    deviation, flat = (float(np.mean((whitened @ h[used]) ** 2)) for h in (distance, plane))
    return Form(
        patterns=len(variance),
        deviation=deviation,
        plane=flat,
        scale_chi2=chi2,
        scale_sigma=sigma,
    )


def _distance_to_plane(at: Array) -> Array:
    """Compute the signed distances (n,) of points (n, 3) to the plane that fits them best."""
    from_middle = at - at.mean(axis=0)
    return np.asarray(from_middle @ np.linalg.svd(from_middle, full_matrices=False)[2][2])


def _open_directions(jacobian: Array, cad_model: CadModel, noise: float) -> Array:
    """Find how distances change (n, k) in directions that the pose's prior leaves open.

    Open means to more than the noise. jacobian (n, 6): by the step of `perturb_pose`.
    """
    return _beyond_noise(jacobian @ np.linalg.inv(registration.prior_rows(cad_model)), noise)


def _beyond_noise(by_sigma: Array, noise: float) -> Array:
    """Find the directions (n, k) in which one sigma (n, q) moves distances beyond the noise."""
    left, size, _ = np.linalg.svd(by_sigma, full_matrices=False)
    return np.asarray(left[:, size > np.sqrt(noise)])


def _within_structures(distance: Array, fitted: Array, most: float) -> Mask:
    """Select distances (n,) that exceed a fit (n, k) to the selected ones by at most `most`."""
    used = np.ones(len(distance), bool)
    for _ in range(PASSES):
        left = distance - fitted @ np.linalg.lstsq(fitted[used], distance[used])[0]
        if (left <= most).sum() < MIN_POINTS:
            break
        used = left <= most
    return used


def _resolved_patterns(field: Array, fitted: Array, noise: float) -> tuple[Array, Array]:
    """Find the independent patterns (n, m) of a field that stand out of the noise.

    Parameters
    ----------
    field
        Covariance (n, n) of the field.
    fitted
        What was fitted (n, k). Patterns are orthogonal to it.
    noise
        Variance of the noise.

    Returns
    -------
    patterns, variances
        Orthonormal (n, m), and their variances (m,) with the noise.
    """
    basis, size, _ = np.linalg.svd(fitted, full_matrices=True)
    free = basis[:, int((size > 1e-9 * size[0]).sum()) :]
    variance, vectors = np.linalg.eigh(free.T @ field @ free)
    resolved = variance > noise
    return np.asarray(free @ vectors[:, resolved]), np.asarray(variance[resolved] + noise)


def scale_test(deviation: Array, by_ratio: Array) -> tuple[float, tuple[float, ...]]:
    """Test whether other scales of the CAD model explain how the hull deviates from it.

    Returns the chi-square that three scales explain, with their sigmas. Where what they leave has a
    variance above one, both are relative to that.

    Parameters
    ----------
    deviation
        Whitened (m,).
    by_ratio
        Derivatives (m, 3) by the scales along three axes.
    """
    information = by_ratio.T @ by_ratio + np.eye(3) / SCALE_PRIOR**2
    gradient = by_ratio.T @ deviation
    explained = float(gradient @ np.linalg.solve(information, gradient))
    left = max((float(deviation @ deviation) - explained) / max(len(deviation) - 3, 1), 1.0)
    sigma = np.sqrt(np.diag(np.linalg.inv(information)) * left)
    return explained / left, tuple(float(s) for s in sigma)
