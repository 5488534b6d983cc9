# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The cost of a hull pose: distances of surveyed points to the CAD model, and the package's prior.

Steps are of (translation in g, rotation in M), about a centre in M.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_solve

from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry import poses
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.pose_solver import LinearisedCost
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array, CholeskyFactor


def frame_at(center: Array) -> Poses:
    """Return the pose in M of a frame whose origin is `center` (3,) and whose axes are M's."""
    return Poses(np.array([[0.0, 0, 0, 1]]), center[None])


def perturb_pose(global_from_hull: Poses, center: Array, step: Array) -> Poses:
    """Move a hull pose by a step (6,): a translation in g, and a turn about `center` (3,) in M.

    The turn is on the right, in the axes of M.
    """
    turned = global_from_hull @ poses.exp(np.r_[center, step[3:]])  # its origin is the centre
    return Poses(turned.quaternion, turned.translation + step[:3]) @ frame_at(-center)


def prior_step(global_from_hull: Poses, cad_model: CadModel, center: Array) -> Array:
    """Compute the step (6,) from the guess to a pose: m and rad in M's axes, about the centre.

    Divided by `guess_sigma` it is the whitened residual of the prior.
    """
    apart = cad_model.guess.inverse() @ global_from_hull
    return np.asarray(np.r_[apart.apply(center)[0] - center, apart.log()[0, 3:]])


@dataclass(frozen=True, kw_only=True)
class HullPoseCost:
    """Generalised least-squares cost of the hull's pose, from distances and its prior."""

    points: Array  # (n, 3) m in g
    cad_model: CadModel
    center: Array  # (3,) m in M, about which steps turn
    factor: CholeskyFactor  # Cholesky factor of the distances' covariance

    def linearise(self, pose: Poses) -> LinearisedCost:
        """Compute the cost, its gradient and information with respect to `perturb_pose`'s step."""
        distance, jacobian = signed_distances(self.points, pose, self.center, self.cad_model.mesh)
        weighted = cho_solve(self.factor, np.c_[jacobian, distance])
        whitened = prior_rows(self.cad_model)
        prior = prior_step(pose, self.cad_model, self.center) / self.cad_model.guess_sigma
        return LinearisedCost(
            cost=0.5 * float(distance @ weighted[:, 6] + prior @ prior),
            gradient=jacobian.T @ weighted[:, 6] + whitened.T @ prior,
            information=jacobian.T @ weighted[:, :6] + whitened.T @ whitened,
        )

    def update(self, pose: Poses, step: Array) -> Poses:
        """Move a pose by a step (6,)."""
        return perturb_pose(pose, self.center, step)


def prior_rows(cad_model: CadModel) -> Array:
    """Compute the Jacobian (6, 6) of the whitened `prior_step` by the step of `perturb_pose`."""
    to_hull = cad_model.guess.rotation.as_matrix()[0].T  # steps are in g, the prior in M's axes
    rows = np.zeros((6, 6))
    rows[:3, :3], rows[3:, 3:] = to_hull, np.eye(3)
    return np.asarray(rows / cad_model.guess_sigma[:, None])


def signed_distances(
    points: Array, global_from_hull: Poses, center: Array, mesh: Mesh
) -> tuple[Array, Array]:
    """Compute signed distances of points to a mesh, and their Jacobian.

    Parameters
    ----------
    points
        (n, 3) m in g.
    global_from_hull
        Pose of the mesh.
    center
        (3,) m in M, about which steps turn.
    mesh
        The CAD model, in M.

    Returns
    -------
    distance, jacobian
        (n,) m, outward positive, and (n, 6) by the step of `perturb_pose`.
    """
    local = global_from_hull.inverse().apply(points)
    nearest = mesh.index.closest(local)
    rotation = global_from_hull.rotation.as_matrix()[0]
    # A hull that moves outward under a point shortens its distance. One that turns by w moves the
    # point by -w x (local - center) in M
    by_shift = -nearest.gradient @ rotation.T
    by_turn = np.cross(nearest.gradient, local - center)
    return nearest.distance, np.hstack([by_shift, by_turn])
