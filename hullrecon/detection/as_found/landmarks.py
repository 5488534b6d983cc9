# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Landmarks as measurements of the hull's surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.estimation.landmark_variance import variance_along_normals
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.records.solution import HullPose
from hullrecon.rows import Rows
from hullrecon.typing import Array, Ints


@dataclass(frozen=True, kw_only=True)
class SurfaceLandmarks(Rows):
    """Landmarks (n) that measure the base surface, in its frame."""

    row: Ints  # (n,) in the Solution
    position: Array  # (n, 3)
    foot: Array  # (n, 3) on the base
    normal: Array  # (n, 3) of the base there, outward
    offset: Array  # (n,) m, signed distance to the base
    sigma: Array  # (n,) m along the normal, of each on its own
    common: Array  # (n,) m, what it shares with its neighbours: the dive's place on the hull
    covariance: Array  # (n, 3, 3)
    views: Ints  # (n,)


def measure_surface(
    scene: Scene,
    position: Array,
    covariance: Array,
    views: Ints,
    farthest_m: float,
    largest_sigma_m: float,
    hull_pose: HullPose | None = None,
) -> SurfaceLandmarks:
    """Measure the surface of `scene` by landmarks near it.

    Left out are landmarks that are not finite, seen by one image only, farther off than
    `farthest_m`, less certain along the normal than `largest_sigma_m`, and those whose closest
    point is the rim of the base, beside which they lie rather than above it.

    Parameters
    ----------
    position
        of the landmarks (n, 3).
    covariance
        of the landmarks (n, 3, 3).
    hull_pose
        whose error is part of the covariances, None where it is not. It moves all landmarks as
        one, and is no noise of theirs however large it is.
    """
    row = np.flatnonzero(np.isfinite(position).all(axis=1) & (views >= 2))
    near = scene.closest(position[row])
    gap = position[row] - near.foot
    sideways = np.linalg.norm(
        gap - near.normal * np.einsum("ni,ni->n", gap, near.normal)[:, None], axis=1
    )
    variance = np.einsum("ni,nij,nj->n", near.normal, covariance[row], near.normal)
    near_it = (np.abs(near.distance) <= farthest_m) & (
        sideways <= 0.005 + 0.7 * np.abs(near.distance)
    )
    good = np.flatnonzero(near_it & (variance > 0))
    along = variance_along_normals(
        position[row[good]], near.normal[good], covariance[row[good]], hull_pose
    )
    sigma = np.sqrt(along.own)
    kept = SurfaceLandmarks(
        row=row[good], position=position[row[good]], foot=near.foot[good], normal=near.normal[good],
        offset=near.distance[good], sigma=sigma, common=np.sqrt(along.common),
        covariance=covariance[row[good]], views=views[row[good]],
    )  # fmt: skip
    return kept.take(sigma <= largest_sigma_m)
