# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Make the native table of links: their measurements, and how much each weighs."""

from __future__ import annotations

import numpy as np

from hullrecon import native
from hullrecon.geometry.poses import Poses
from hullrecon.records.links import CameraLinks
from hullrecon.typing import Array, Ints

# links of a node that count as independent; with more, they share the noise of its features
SHARED_IMAGES = 2.0


def link_table(links: CameraLinks, nodes: int, kernel: native.LinkKernel) -> native.LinkTable:
    """Make the native table of link factors.

    Links of one node share the noise of its features. So the more links a node has, the less each
    weighs (`shared_noise`).

    Rejected links are not left out: the kernel reduces their weight.

    Parameters
    ----------
    links
        Relative poses.
    nodes
        Number of nodes.
    kernel
        Robust kernel of all links.
    """
    degree = np.bincount(np.concatenate([links.first, links.second]), minlength=nodes)
    shared = shared_noise(degree, links.first, links.second)
    # in the native table, `first` is the camera in whose axes the motion is given
    return native.LinkTable(
        first=links.second.astype(np.int32),
        second=links.first.astype(np.int32),
        camera_first=links.bottom[:, 1].astype(np.int32),
        camera_second=links.bottom[:, 0].astype(np.int32),
        measured=Poses(links.quaternion, links.translation).vectors(),
        sqrt_information=_square_root_information(links) / np.sqrt(shared)[:, None, None],
        scaled=links.scaled,
        kernel=np.full(len(links), int(kernel), np.int32),
    )


def shared_noise(degree: Ints, first: Ints, second: Ints) -> Array:
    """Compute the factor (m,) by which the variance of links is inflated, 1 or more.

    Links of one node all hold the noise of its features, but are taken as independent. From
    SHARED_IMAGES links on, the factor keeps them from seeming better than these features are.

    degree (n,): links of each node. first, second (m,): nodes of the links.
    """
    return np.asarray(np.maximum(0.5 * (degree[first] + degree[second]) / SHARED_IMAGES, 1.0))


def _square_root_information(links: CameraLinks) -> Array:
    """Compute the square root of the links' information (m, 6, 6), from the Cholesky factor.

    Multiplied by it residuals are in sigmas. A link without a length measures five numbers, two of
    the direction and three of the rotation. Their square root is in the leading block (5, 5).
    """
    covariance = links.covariance.copy()
    free = np.flatnonzero(~links.scaled)
    out = np.zeros_like(covariance)
    full = np.flatnonzero(links.scaled)
    out[full] = np.linalg.inv(np.linalg.cholesky(covariance[full]))
    length = np.linalg.norm(links.translation[free], axis=1)
    # derivative of the five by translation and rotation: two directions across the translation
    to_five = np.zeros((len(free), 5, 6))
    to_five[:, :2, :3] = (
        native.bearing_basis(links.translation[free]).swapaxes(1, 2) / length[:, None, None]
    )
    to_five[:, 2:, 3:] = np.eye(3)
    five = to_five @ covariance[free] @ to_five.swapaxes(1, 2)
    out[free, :5, :5] = np.linalg.inv(np.linalg.cholesky(five))
    return out
