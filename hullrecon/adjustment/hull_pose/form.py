# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether the surveyed hull has the CAD model's form, and whether it has any form by which one hull
differs from another (docs/methods.md 20).

Any CAD model can be laid onto a patch so that most points lie within centimetres of it, and the
deviation field takes up what is left. What is left must then be no larger than the CAD model's
error may be, pattern by pattern; and only a patch that a plane explains far worse can tell one ship
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

MISTAKEN = 2.0  # times the CAD model may be worse than its package says (docs/adr/0010)
CHANCE = 1e-3  # at which a CAD model that is as good as its package says is refused
# at which its sigmas are widened, which costs less than a place that is another ship's
WIDENING = 1e-2
OUTSIDE_SIGMAS = 3.0  # farther out stand structures and growth; nothing stands in the steel
MIN_POINTS = 30
PASSES = 4  # of leaving out what stands outside what was fitted without it
LARGEST_STRETCH = 0.5  # one sigma of what a CAD model's ratios may be before anything is measured


@dataclass(frozen=True, kw_only=True)
class Form:
    """patterns: of the CAD model's error that the points resolve, when its pose has been fitted;
    deviation: mean square of what they show, in the variance that they may have; plane: the same of
    the distances to a plane; stretch: chi-square of what stretching the CAD model along its three
    axes explains of that; stretch_sigma (3,): how well they are told.
    """

    patterns: int
    deviation: float = 0.0
    plane: float = 0.0
    stretch: float = 0.0
    stretch_sigma: tuple[float, ...] = ()

    @property
    def contradicts(self) -> bool:
        """Whether the hull leaves the CAD model by more than chance and its stated error explain."""
        return self._beyond(1.0, WIDENING)

    @property
    def is_worse_than_stated(self) -> bool:
        """Whether it does so beyond the chance at which a CAD model is refused."""
        return self._beyond(1.0, CHANCE)

    @property
    def is_of_another_hull(self) -> bool:
        """Whether it does so by more than a package may be mistaken, or has no more of the CAD
        model's form than a plane.
        """
        return self.is_worse_than_stated and (self._beyond(MISTAKEN, CHANCE) or not self.confirms)

    @property
    def fits_better_stretched(self) -> bool:
        """Whether the CAD model has other proportions or another scale than the hull, beyond
        chance.
        """
        return self.stretch > float(chdtri(min(3, self.patterns) or 1, CHANCE))

    @property
    def log_odds(self) -> float:
        """Logarithm of the odds by which the points have the CAD model's form rather than none,
        each with an error of its own size; zero where they cannot tell.
        """
        return 0.5 * self.patterns * float(np.log(max(self.plane, 1.0) / max(self.deviation, 1.0)))

    @property
    def confirms(self) -> bool:
        """Whether those odds are beyond chance."""
        return self.log_odds > -float(np.log(CHANCE))

    def _beyond(self, times: float, chance: float) -> bool:
        """Return whether the deviation is beyond that chance for so many times the stated error."""
        return self.patterns > 0 and self.deviation * self.patterns > times**2 * float(
            chdtri(self.patterns, chance)
        )


def compare_form(evidence: HullPoseEvidence, pose: Poses) -> Form:
    """Return how the points that lie on the hull have the form of the CAD model at T_g_M."""
    cad_model, expected = evidence.cad_model, evidence.cad_error_model
    distance, jacobian = registration.signed_distances(
        evidence.points, pose, evidence.center, cad_model.mesh
    )
    at = pose.inverse().apply(evidence.points)
    noise = expected.noise**2 + cad_error.facet_variance(cad_model, at, sigmas=1.0)
    plane = _distance_to_plane(at)
    loose = evidence.distances_by_stretches(pose)
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
    stretch, sigma = _stretch(whitened @ distance[used], whitened @ by_ratio[used])
    deviation, flat = (float(np.mean((whitened @ h[used]) ** 2)) for h in (distance, plane))
    return Form(
        patterns=len(variance),
        deviation=deviation,
        plane=flat,
        stretch=stretch,
        stretch_sigma=sigma,
    )


def _distance_to_plane(at: Array) -> Array:
    """Return the signed distances (n,) of points (n, 3) to the plane nearest to them."""
    from_middle = at - at.mean(axis=0)
    return np.asarray(from_middle @ np.linalg.svd(from_middle, full_matrices=False)[2][2])


def _open_directions(jacobian: Array, cad_model: CadModel, noise: float) -> Array:
    """Return how distances change (n, k) in the directions of the hull pose that its prior leaves
    open to more than the noise.

    jacobian (n, 6): by the step of `perturb_pose`.
    """
    return _beyond_noise(jacobian @ np.linalg.inv(registration.prior_rows(cad_model)), noise)


def _beyond_noise(by_sigma: Array, noise: float) -> Array:
    """Return the directions (n, k) in which one sigma of unknowns (n, q) moves distances by more
    than such a noise.
    """
    left, size, _ = np.linalg.svd(by_sigma, full_matrices=False)
    return np.asarray(left[:, size > np.sqrt(noise)])


def _within_structures(distance: Array, fitted: Array, most: float) -> Mask:
    """Return which distances (n,), less what is fitted (n, k) to those, are at most so large
    outward.
    """
    used = np.ones(len(distance), bool)
    for _ in range(PASSES):
        left = distance - fitted @ np.linalg.lstsq(fitted[used], distance[used])[0]
        if (left <= most).sum() < MIN_POINTS:
            break
        used = left <= most
    return used


def _resolved_patterns(field: Array, fitted: Array, noise: float) -> tuple[Array, Array]:
    """Return orthonormal patterns (n, m) of a field with covariance (n, n) that are independent of
    each other and of what was fitted (n, k), as far as noise of that variance leaves them; and
    their variances (m,), noise included.
    """
    basis, size, _ = np.linalg.svd(fitted, full_matrices=True)
    free = basis[:, int((size > 1e-9 * size[0]).sum()) :]
    variance, vectors = np.linalg.eigh(free.T @ field @ free)
    resolved = variance > noise
    return np.asarray(free @ vectors[:, resolved]), np.asarray(variance[resolved] + noise)


def _stretch(deviation: Array, by_ratio: Array) -> tuple[float, tuple[float, ...]]:
    """Return the chi-square that three ratios explain of whitened deviations (m,), in the variance
    that they leave where that is more than one, and the ratios' sigmas; by_ratio (m, 3): the
    derivatives.
    """
    information = by_ratio.T @ by_ratio + np.eye(3) / LARGEST_STRETCH**2
    gradient = by_ratio.T @ deviation
    explained = float(gradient @ np.linalg.solve(information, gradient))
    left = max((float(deviation @ deviation) - explained) / max(len(deviation) - 3, 1), 1.0)
    sigma = np.sqrt(np.diag(np.linalg.inv(information)) * left)
    return explained / left, tuple(float(s) for s in sigma)
