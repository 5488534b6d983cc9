# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Relative pose of two views without depth [Ozog2016 D.1], [KimEustice2009 III-B].

Its five unknowns are the rotation, perturbed on the right (3), and the direction of the translation
in `tangent_basis` (2). They are refined on matches, get a covariance, and are held to navigation.
Here `motion` is second_from_first (4, 4), and matches are `first` and `second` (n, 2) in ideal
coordinates of the two views.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.rotations import cross_matrix
from hullrecon.typing import Array
from hullrecon.vision.pairs.gating import Motion
from hullrecon.vision.pairs.stereo_adjustment import correlation_inflation
from hullrecon.vision.pairs.two_view import essential_of

ITERATIONS = 10  # of Levenberg-Marquardt
FREEDOMS = 5  # unknowns of a motion without a length
# Prior sigma of the direction: as good as unknown. It matters where matches do not determine the
# direction, as of a vehicle at rest.
DIRECTION_SIGMA_RAD = 1.0
DIRECTION_PRIOR = np.diag([0.0, 0.0, 0.0, DIRECTION_SIGMA_RAD**-2, DIRECTION_SIGMA_RAD**-2])
# Sigmas that information on the direction, or parallax, must exceed what noise alone gives
NOISE_SIGMAS = 3.0
UNKNOWN_LENGTH = 1.0  # sigma of the length, which is set to 1, where it was not measured


def refine(motion: Array, first: Array, second: Array) -> tuple[Array, Array]:
    """Fit a motion to matches (n, 2), and compute its covariance (5, 5)."""
    motion = fit(motion, first, second)
    return motion, covariance_of(motion, first, second)


def fit(motion: Array, first: Array, second: Array) -> Array:
    """Minimise the Sampson distances of matches (n, 2) over second_from_first with |t| = 1.

    It starts from `motion` and iterates by Levenberg-Marquardt. To first order the Sampson distance
    is the residual that a bundle adjustment of two views has once the point of the match is
    eliminated. first, second: the matches in either image, ideal coordinates.
    """
    residual, jacobian = linearise(motion, first, second)
    # Not geometry.pose_solver: five unknowns, and a variance that each step finds anew.
    damping = 1e-6
    for _ in range(ITERATIONS):
        normal = _information(jacobian, _variance(residual))
        gradient = jacobian.T @ residual / _variance(residual)
        step = np.asarray(-np.linalg.solve(normal + damping * np.diag(np.diag(normal)), gradient))
        trial = _apply_step(motion, step)
        trial_residual, trial_jacobian = linearise(trial, first, second)
        if trial_residual @ trial_residual > residual @ residual:
            damping *= 100
            continue
        motion, residual, jacobian, damping = trial, trial_residual, trial_jacobian, damping * 0.1
        if np.abs(step).max() < 1e-10:
            break
    return motion


def covariance_of(motion: Array, first: Array, second: Array) -> Array:
    """Compute the covariance (5, 5) of a motion fitted to matches (n, 2).

    The information is that of a bundle adjustment of two views, reduced for three reasons:
    residuals larger than expected, correlated errors of neighbouring features, and noise in the
    matches, which by itself looks like information on the direction (`noise_share`). Without
    parallax there is no information on the direction at all. first, second: the matches in either
    image, ideal coordinates.
    """
    residual, jacobian = linearise(motion, first, second)
    variance = _variance(residual)
    own = jacobian.T @ jacobian / variance
    moved = has_parallax(motion, first, second, variance)
    information = (
        without_noise_share(own, noise_share(motion, first, second))
        if moved
        else _without_direction(own)
    )
    each = jacobian[:, :, None] * jacobian[:, None]
    inflation = correlation_inflation(each, jacobian * residual[:, None], variance, first)
    return np.asarray(np.linalg.inv(information / inflation + DIRECTION_PRIOR))


def with_length(motion: Array, covariance: Array, prior: Motion | None) -> Motion:
    """Scale a motion to navigation's length, with its uncertainty, or to length 1 without it.

    Two views without depth do not measure the length. So its sigma is that of navigation, or as
    good as unknown (UNKNOWN_LENGTH).

    Parameters
    ----------
    motion
        (4, 4) with |t| = 1.
    covariance
        (5, 5) of rotation and direction.
    prior
        Navigation's motion, which gives the length. None where unknown.
    """
    direction = motion[:3, 3]
    length, length_variance = 1.0, UNKNOWN_LENGTH**2
    if prior is not None:
        length = float(np.linalg.norm(prior.second_from_first[:3, 3]))
        length_variance = float(direction @ prior.covariance[:3, :3] @ direction)
    scaled = motion.copy()
    scaled[:3, 3] = length * direction
    # From (rotation, direction) to (translation, rotation), the order of Motion.
    jacobian = np.zeros((6, 5))
    jacobian[:3, 3:] = length * tangent_basis(direction)
    jacobian[3:, :3] = np.eye(3)
    out = jacobian @ covariance @ jacobian.T
    out[:3, :3] += length_variance * np.outer(direction, direction)
    return Motion(scaled, out)


def navigation_chi2(found: Motion, prior: Motion) -> float:
    """Compute chi-square between the rotation and direction of a motion and navigation's motion.

    A large one means that the two images do not show the same place, or that it is the wrong one of
    a plane's two motions. It has five degrees of freedom. The length in `found` is navigation's own
    and is not used. In its place is the non-negative one that agrees best, so that a direction says
    little where the vehicle hardly moved.
    """
    own, wanted = found.second_from_first, prior.second_from_first
    turn = Rotation.from_matrix(wanted[:3, :3].T @ own[:3, :3]).as_rotvec()
    direction = own[:3, 3] / max(float(np.linalg.norm(own[:3, 3])), 1e-12)
    # The length in `found` is navigation's own and must not count twice: remove it from the
    # covariance.
    across = np.eye(6)
    across[:3, :3] -= np.outer(direction, direction)
    information = np.linalg.inv(prior.covariance + across @ found.covariance @ across)
    # Residual as a function of the length: length * along - target. The rotation part does not
    # depend on the length.
    along = np.concatenate([direction, np.zeros(3)])
    target = np.concatenate([wanted[:3, 3], -turn])
    length = max(float(along @ information @ target) / float(along @ information @ along), 0.0)
    gap = length * along - target
    return float(gap @ information @ gap)


def has_parallax(motion: Array, first: Array, second: Array, variance: float) -> bool:
    """Decide whether matches (n, 2) differ by more than the rotation and noise.

    If not, they say nothing of the translation's direction. The differences that the rotation
    leaves are 2-vectors, and noise of both images adds: their expected square is four times
    `variance`, that of a coordinate in one image. The mean square scatters by 1 / sqrt(n) of
    itself, the variance found from n residuals by sqrt(2 / n). motion: second_from_first (4, 4).
    first, second: ideal coordinates.
    """
    turned = np.hstack([first, np.ones((len(first), 1))]) @ motion[:3, :3].T
    gap = second - turned[:, :2] / turned[:, 2:]
    return bool(
        (gap**2).sum() > (1 + NOISE_SIGMAS * np.sqrt(3 / len(gap))) * 4 * variance * len(gap)
    )


def noise_share(motion: Array, first: Array, second: Array) -> Array:
    """Compute the information (n, 2, 2) on the direction that noise in matches (n, 2) simulates.

    The derivative of a residual by the direction is the match's shift after the rotation,
    (R x1) x x2. Noise of sigma in both images gives it the covariance
    sigma^2 ([x2]x R P R' [x2]x' + [R x1]x P [R x1]x'), P = diag(1, 1, 0). The Sampson distance has
    the variance sigma^2, which cancels in the information. A vehicle at rest shows this information
    and no more. motion: second_from_first (4, 4). first, second: ideal coordinates.
    """
    a, b = (np.hstack([xy, np.ones((len(xy), 1))]) for xy in (first, second))
    turned, basis = a @ motion[:3, :3].T, tangent_basis(motion[:3, 3])
    by_first = basis.T @ cross_matrix(b) @ motion[:3, :2]
    by_second = (basis.T @ cross_matrix(turned))[:, :, :2]
    both = (
        np.concatenate([by_first, by_second], axis=2)
        / _line_length(*_epipolar_lines(motion, a, b))[:, None, None]
    )
    return np.asarray(both @ both.swapaxes(1, 2))


def without_noise_share(information: Array, share: Array) -> Array:
    """Subtract the information that noise simulates from the information (5, 5) on the direction.

    What is left is what the matches really say of it, none where the vehicle was at rest. The share
    of noise is subtracted from the marginal information of the direction, with NOISE_SIGMAS of its
    scatter, and negative eigenvalues are set to zero. share: (n, 2, 2) of `noise_share`. Its sum
    scatters as a sum of squares, by the root of twice the sum of their squares. That is far more
    than 1 / sqrt(n) where the epipole lies in the image and the few matches next to it have most of
    the weight.
    """
    scatter = np.sqrt(2 * np.einsum("nij,nij->", share, share))
    noise = share.sum(axis=0) + NOISE_SIGMAS * scatter * np.eye(2)
    carried = information[3:, :3] @ np.linalg.solve(information[:3, :3], information[:3, 3:])
    own = information[3:, 3:] - carried - noise
    values, vectors = np.linalg.eigh(own)
    out = information.copy()
    out[3:, 3:] = carried + (vectors * np.maximum(values, 0)) @ vectors.T
    return out


def _without_direction(information: Array) -> Array:
    """Keep the information (5, 5) on the rotation alone."""
    out = np.zeros((5, 5))
    out[:3, :3] = information[:3, :3]
    return out


def tangent_basis(direction: Array) -> Array:
    """Compute two unit vectors (3, 2) across a unit vector (3,) and across each other.

    A small change of a direction has two numbers, its parts along these vectors.
    """
    # Plain numbers, as the arithmetic of a small array takes ten times as long.
    x, y, z = (float(part) for part in direction)
    least = min(range(3), key=lambda k: abs((x, y, z)[k]))
    # The cross product of the direction and the axis that it is least along.
    a, b, c = ((0.0, z, -y), (-z, 0.0, x), (y, -x, 0.0))[least]
    length = math.sqrt(a * a + b * b + c * c)
    a, b, c = a / length, b / length, c / length
    return np.array([[a, y * c - z * b], [b, z * a - x * c], [c, x * b - y * a]])


def linearise(motion: Array, first: Array, second: Array) -> tuple[Array, Array]:
    """Compute signed Sampson distances (n,) of matches (n, 2), and their derivatives (n, 5).

    These are the residuals of a motion without a length. The derivatives are by rotation (3) and
    direction (2), with the denominator of the distance held constant. motion: (4, 4) with |t| = 1.
    first, second: the matches in either image, ideal coordinates.
    """
    essential, rotation = essential_of(motion), motion[:3, :3]
    a0, a1 = np.ascontiguousarray(first.T)  # by column: several times faster than rows of three
    b0, b1 = np.ascontiguousarray(second.T)
    line_second = [row[0] * a0 + row[1] * a1 + row[2] for row in essential]
    line_first = [column[0] * b0 + column[1] * b1 + column[2] for column in essential.T]
    turned = [row[0] * a0 + row[1] * a1 + row[2] for row in rotation]
    out = np.empty((5, len(a0)))
    out[0] = a1 * line_first[2] - line_first[1]  # x2' E [w]x x1 = w . (x1 x E' x2)
    out[1] = line_first[0] - a0 * line_first[2]
    out[2] = a0 * line_first[1] - a1 * line_first[0]
    across = np.array(
        [turned[1] - turned[2] * b1, turned[2] * b0 - turned[0], turned[0] * b1 - turned[1] * b0]
    )
    out[3:] = tangent_basis(motion[:3, 3]).T @ across  # x2 . (d x R x1) = d . (R x1 x x2)
    squared = line_second[0] ** 2 + line_second[1] ** 2 + line_first[0] ** 2 + line_first[1] ** 2
    scale = np.sqrt(np.maximum(squared, 1e-18))
    out /= scale
    residual = (b0 * line_second[0] + b1 * line_second[1] + line_second[2]) / scale
    return residual, out.T


def _epipolar_lines(motion: Array, a: Array, b: Array) -> tuple[Array, Array]:
    """Compute epipolar lines (n, 3): of a (n, 3) in the second image, of b (n, 3) in the first."""
    essential = essential_of(motion)
    return a @ essential.T, b @ essential


def _line_length(line_second: Array, line_first: Array) -> Array:
    """Compute the denominator (n,) of the Sampson distance from both epipolar lines."""
    squared = (line_second[:, :2] ** 2).sum(axis=1) + (line_first[:, :2] ** 2).sum(axis=1)
    return np.asarray(np.sqrt(np.maximum(squared, 1e-18)))


def _variance(residual: Array) -> float:
    """Estimate the variance of residuals (n,) left by a fit of five unknowns."""
    return max(float(residual @ residual) / max(1, len(residual) - 5), 1e-14)


def _information(jacobian: Array, variance: float) -> Array:
    """Compute the information (5, 5) of matches, with a weak prior of the direction."""
    return np.asarray(jacobian.T @ jacobian / variance + DIRECTION_PRIOR)


def _apply_step(motion: Array, step: Array) -> Array:
    """Apply a step (5,) to a motion (4, 4) with |t| = 1.

    It is a rotation on the right (3), and a move of the translation's direction across it (2).
    """
    out = motion.copy()
    out[:3, :3] = motion[:3, :3] @ Rotation.from_rotvec(step[:3]).as_matrix()
    direction = motion[:3, 3] + tangent_basis(motion[:3, 3]) @ step[3:]
    out[:3, 3] = direction / np.linalg.norm(direction)
    return out
