# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Links of one camera beside the truth: how far off each is, and whether its covariance says so."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry.poses import Poses
from hullrecon.records.links import CameraLinks
from hullrecon.typing import Array, Ints
from hullrecon.vision.pairs import mono_motion


@dataclass(frozen=True, kw_only=True)
class LinkErrors:
    """Errors of links, whose lengths one camera does not measure."""

    pairs: Ints  # (m, 2) nodes
    rotation_rad: Array  # (m,)
    direction_rad: Array  # (m,) of the translation
    chi2: Array  # (m,) of both together, by their covariance: five degrees of freedom

    def rows_of_same_pairs(self, other: LinkErrors) -> tuple[Ints, Ints]:
        """Find the pairs that both have: their rows (k,) here, and in the other."""
        # One number for each pair of nodes, so that pairs can be intersected
        count = 1 + int(max(self.pairs.max(initial=0), other.pairs.max(initial=0)))
        _, here, there = np.intersect1d(
            self.pairs @ [count, 1], other.pairs @ [count, 1], return_indices=True
        )
        return here, there


def link_errors(links: CameraLinks, hull_from_camera: Poses) -> LinkErrors:
    """Compare links (m,) with the true poses (n,) of the camera at the nodes."""
    true = hull_from_camera[links.second].inverse() @ hull_from_camera[links.first]
    turn = true.rotation.inv() * Rotation.from_quat(links.quaternion)
    errors = []
    for k, rotation in enumerate(turn.as_rotvec()):
        length = float(np.linalg.norm(links.translation[k]))
        # Across the true direction, two shifts of the measured one, as angles
        wanted = true.translation[k] / np.linalg.norm(true.translation[k])
        across = mono_motion.tangent_basis(wanted)
        off = across.T @ links.translation[k] / length
        # the covariance (6, 6) of the link, of these two and of the rotation
        by = np.zeros((5, 6))
        by[:2, :3], by[2:, 3:] = across.T / length, np.eye(3)
        whole = np.concatenate([off, rotation])
        chi2 = whole @ np.linalg.solve(by @ links.covariance[k] @ by.T, whole)
        errors.append((np.linalg.norm(rotation), np.linalg.norm(off), chi2))
    rotation, direction, chi2 = np.array(errors).reshape(-1, 3).T
    return LinkErrors(
        pairs=np.column_stack([links.first, links.second]),
        rotation_rad=rotation,
        direction_rad=direction,
        chi2=chi2,
    )
