# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How a landmark by inverse depth finds its depth from little parallax [Civera2008]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.studies.vehicles.inverse_depth import DOWN, Pinhole, new_landmark, see_landmark
from hullrecon.studies.vehicles.transforms import rotation
from hullrecon.typing import Array, Mask

CAMERA = Pinhole(focal_px=1200.0, centre_px=(680.0, 512.0), size_px=(1360, 1024))
PIXEL_SIGMA = 1.0
RHO_SIGMA = 0.5  # 1/m: two sigmas reach infinity from the published 0.1
STEP_SHARE = 0.01  # of the depth, from frame to frame: the b/Z of a pair
STEPS = 30
DEPTH_M = (0.75, 3.0)


@dataclass(frozen=True, kw_only=True)
class Trials:
    """Inverse depths of many landmarks, frame by frame."""

    truth: Array  # (t,) 1/m, along the first ray
    rho: Array  # (t, STEPS + 1) 1/m
    sigma: Array  # (t, STEPS + 1) 1/m

    @property
    def converged(self) -> Mask:
        """Mark landmarks (t,) that end within 3 sigma, and within a tenth, of the truth."""
        off = np.abs(self.rho[:, -1] - self.truth)
        return np.asarray((off < 3 * self.sigma[:, -1]) & (off < 0.1 * self.truth))


def converge(seed: int, trials: int, rho: float) -> Trials:
    """Move sideways past landmarks at known poses, and filter the inverse depth of each.

    Parameters
    ----------
    seed
        Of places and noise.
    trials
        Number of landmarks.
    rho
        Inverse depth from which all start, 1/m.
    """
    rng = np.random.default_rng(seed)
    truth = np.empty(trials)
    found, sigma = np.empty((2, trials, STEPS + 1))
    for trial in range(trials):
        depth = rng.uniform(*DEPTH_M)
        pixel = rng.uniform(0.2, 0.8, 2) * CAMERA.size_px
        point = depth * DOWN @ CAMERA.ray(pixel)
        attitude = np.append(rng.normal(0, 0.05, 2), rng.uniform(-np.pi, np.pi))
        point = rotation(attitude) @ point
        truth[trial] = 1 / np.linalg.norm(point)
        heading = rotation(attitude) @ np.array([1.0, 0.0, 0.0])
        noisy = pixel + PIXEL_SIGMA * rng.standard_normal(2)
        # Each step is the same share of the depth, so that parallax grows alike in all trials
        poses = [np.r_[k * STEP_SHARE * depth * heading, attitude] for k in range(STEPS + 1)]
        found[trial], sigma[trial] = _follow(rng, point, noisy, poses, rho)
    return Trials(truth=truth, rho=found, sigma=sigma)


def _follow(
    rng: np.random.Generator, point: Array, pixel: Array, poses: list[Array], rho: float
) -> tuple[Array, Array]:
    """Filter the inverse depth of a point over images from known poses.

    Parameters
    ----------
    rng
        Draws the noise of the pixels.
    point
        (3,) m, where it truly is.
    pixel
        (2,) of the first image.
    poses
        (6,) of the vehicle at each image.
    rho
        Inverse depth at the first image, 1/m.

    Returns
    -------
    Array
        Inverse depth after each image, 1/m.
    Array
        Its sigma.
    """
    noise = PIXEL_SIGMA**2 * np.eye(2)
    landmark, _, by_seen = new_landmark(CAMERA, poses[0], pixel, rho)
    covariance = by_seen @ np.diag([PIXEL_SIGMA**2] * 2 + [RHO_SIGMA**2]) @ by_seen.T
    estimates = [(rho, RHO_SIGMA)]
    # Update a Kalman filter of the landmark alone by the pixel of each image
    for pose in poses[1:]:
        ray = DOWN.T @ rotation(pose[3:]).T @ (point - pose[:3])
        seen = CAMERA.project(ray)[0] + PIXEL_SIGMA * rng.standard_normal(2)
        expected, _, jacobian = see_landmark(CAMERA, pose, landmark)
        spread = jacobian @ covariance @ jacobian.T + noise
        gain = np.linalg.solve(spread, jacobian @ covariance).T
        landmark = landmark + gain @ (seen - expected)
        covariance = covariance - gain @ jacobian @ covariance
        estimates.append((landmark[5], np.sqrt(covariance[5, 5])))
    rho_found, sigma = np.array(estimates).T
    return rho_found, sigma
