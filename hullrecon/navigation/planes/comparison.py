# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Compare two patches of one hull: the second with the first extrapolated by its curvature."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from hullrecon.geometry.poses import Poses
from hullrecon.navigation.planes.patches import Patches
from hullrecon.records.trajectory import VehiclePath
from hullrecon.typing import Array, Ints, Mask

# Sigmas of the difference of two patches that curvature does not explain: frames, seams.
ROUGHNESS = np.array([0.003, 0.002, 0.002])  # m, slopes in azimuth and elevation
# The difference of two patches' curvatures shows how fast the curvature changes. As shares of it:
# the error of their mean, and the error of the height that the slopes do not hold. And in m2, how a
# change of curvature within a patch of 0.66 m, a cubic, tilts the plane that is fitted to it.
MEAN_OFF, HEIGHT_OFF, TILT_M2 = 0.5, 0.05, 0.5 * 0.66**2 / 6
MIN_DISTANCE_M = 0.5  # between two patches, where the change of curvature is related to it


@dataclass(frozen=True, kw_only=True)
class PatchPairs:
    """Pairs (m) of patches on a path, and how the second differs from the first extrapolated."""

    first: Ints  # (m,)
    second: Ints  # (m,)
    place: Array  # (m, 3) m, the second's centre in the vehicle frame of the first's anchor
    position: Array  # (m, 2) m, the same in the first's axes
    # (m, 3) height m and slopes there, by the first's plane and the mean of both curvatures
    expected: Array
    by_position: Array  # (m, 3, 2) derivative of expected
    gap: Array  # (m, 3) height and slopes of the second less the expected ones
    noise: Array  # (m, 3, 3) of the gap, by curvature and roughness of the hull
    fit: Array  # (m, 3, 3) of the gap, by the fits of the two planes

    def __len__(self) -> int:
        return len(self.first)

    def roughened(self, factor: Array) -> PatchPairs:
        """Scale the noise of height and slopes by factor (3,)."""
        return replace(self, noise=factor[:, None] * self.noise * factor)

    def rows(self, keep: Mask) -> PatchPairs:
        """Select pairs by mask."""
        return PatchPairs(**{field.name: getattr(self, field.name)[keep] for field in fields(self)})


def compare_patches(patches: Patches, first: Ints, second: Ints, path: VehiclePath) -> PatchPairs:
    """Compare pairs (m,) of patches on a path.

    The first patch is extrapolated to the second's centre, with a curvature that changes evenly
    from its own to the second's. The gap is the difference in height and two slopes there, zero up
    to errors if both are one piece of hull. Its covariance has two parts, `noise` by the curvatures
    and `fit` by the fits of both planes. The path's own errors are in neither.

    Parameters
    ----------
    patches
        All patches along the path.
    first, second
        Rows (m,) of the pairs.
    path
        global_from_vehicle, with the tray, at all nodes.
    """
    motion = path.poses[patches.anchor[first]].inverse() @ path.poses[patches.anchor[second]]
    position, expected, gap, turn = _extrapolate_and_compare(patches, first, second, motion)
    turned_k = _turn_curvature(turn)
    # The second's curvature in the first's axes, and how height and slopes of the first plane carry
    # over to the second's centre.
    other = np.einsum("mij,mj->mi", turned_k, patches.curvature[second])
    carried = _jacobian_by_plane(position)
    # Jacobians of the gap by either curvature, directly and through the fitted planes. Of a
    # curvature that changes evenly, slopes take the mean of both ends, and the height a third of
    # K x^2 by the first and a sixth by the second.
    by_height, by_slopes = _jacobian_by_curvature(position)
    first_by_k = np.concatenate([by_height[:, None] / 3, 0.5 * by_slopes], axis=1)
    second_by_k = np.concatenate([by_height[:, None] / 6, 0.5 * by_slopes], axis=1)
    turned = _turn_plane(turn)
    # the whole derivative of the gap by either patch's own curvature
    m_first = carried @ patches.by_curvature[first] + first_by_k
    m_second = turned @ patches.by_curvature[second] - second_by_k @ turned_k
    # what the evenly changing curvature may be wrong by, as a share of its change
    change = other - patches.curvature[first]
    by_change = second_by_k * (MEAN_OFF * change)[:, None, :]
    noise = (
        m_first @ patches.curvature_covariance[first] @ m_first.swapaxes(1, 2)
        + m_second @ patches.curvature_covariance[second] @ m_second.swapaxes(1, 2)
        + by_change @ by_change.swapaxes(1, 2)
        + _covariance_by_roughness(position, change)
    )
    # the fits of both planes, brought to the second's centre and into the first's axes
    fit = carried @ patches.plane_covariance[first] @ carried.swapaxes(1, 2)
    fit = fit + turned @ patches.plane_covariance[second] @ turned.swapaxes(1, 2)
    return PatchPairs(
        first=first,
        second=second,
        place=motion.apply(patches.center[second]),
        position=position,
        expected=expected,
        by_position=_jacobian_by_position(position, patches.curvature[first], other),
        gap=gap,
        noise=noise,
        fit=fit,
    )


def _covariance_by_roughness(position: Array, change: Array) -> Array:
    """Compute the covariance (m, 3, 3) of gaps by roughness and by the change of curvature.

    It covers what the patches' own curvatures do not describe: frames and seams of the plating, and
    a curvature that does not change evenly.

    position (m, 2): of the second patch in the first's axes, m. change (m, 3): second curvature
    minus the first.
    """
    distance = np.maximum(np.linalg.norm(position, axis=1), MIN_DISTANCE_M)
    # Change of the curvature that tilts in azimuth (K_aa, K_ae) and in elevation (K_ee, K_ae)
    of_axes = np.sqrt(change[:, [0, 2]] ** 2 + change[:, [1]] ** 2)
    height = HEIGHT_OFF * distance**2 * np.linalg.norm(change, axis=1)
    sigma = np.column_stack([height, TILT_M2 / distance[:, None] * of_axes])
    return np.asarray((ROUGHNESS**2 + sigma**2)[:, :, None] * np.eye(3))


def gap_by_poses(
    patches: Patches, pairs: PatchPairs, path: VehiclePath, tray_origin: Array
) -> Array:
    """Compute the Jacobian (m, 3, 14) of the gaps by both anchors' poses and trays.

    Through it the path's covariance predicts how large gaps may be. Of each anchor there are
    (translation in g, rotation on the right, tray angle). tray_origin (3,): m, in the vehicle.
    """
    return position_and_gap_by_poses(patches, pairs, path, tray_origin)[:, 2:]


def position_and_gap_by_poses(
    patches: Patches, pairs: PatchPairs, path: VehiclePath, tray_origin: Array
) -> Array:
    """Compute the Jacobian (m, 5, 14) of positions and gaps by both anchors' poses and trays.

    Rows are the two of `PatchPairs.position` and the three of `PatchPairs.gap`. Columns are of each
    anchor (translation in g, rotation on the right, tray angle). Derivatives are central
    differences. tray_origin (3,): m, in the vehicle.
    """
    anchors = [patches.anchor[pairs.first], patches.anchor[pairs.second]]
    out = np.zeros((len(pairs), 5, 14))
    step = 1e-5  # m, or rad
    for k in range(14):
        values = []
        # columns 0 to 6 are the first anchor's, 7 to 13 the second's
        for sign in (1, -1):
            moved = [path.poses[a] for a in anchors]
            moved[k // 7] = _perturb(moved[k // 7], k % 7, sign * step, tray_origin)
            position, _, gap, _ = _extrapolate_and_compare(
                patches, pairs.first, pairs.second, moved[0].inverse() @ moved[1]
            )
            values.append(np.hstack([position, gap]))
        out[:, :, k] = (values[0] - values[1]) / (2 * step)
    return out


def _perturb(poses: Poses, column: int, step: float, tray_origin: Array) -> Poses:
    """Perturb the poses of what carries the patches by one coordinate of vehicle or tray.

    The tray's angle moves the DVL, and so the patches that it saw, about the tray's axis.

    column: 0 to 2 translation in g, 3 to 5 rotation on the right, 6 the tray's angle. step: m or
    rad. tray_origin: (3,) m, in the vehicle.
    """
    vector = np.zeros((1, 6))
    if column < 3:
        return Poses(poses.quaternion, poses.translation + step * np.eye(3)[column])
    vector[0, column if column < 6 else 4] = step
    turn = _exp(vector)
    if column < 6:
        return poses @ turn
    origin = Poses(np.array([[0, 0, 0, 1.0]]), np.asarray(tray_origin, float)[None])
    return poses @ (origin @ turn @ origin.inverse())


def _exp(vector: Array) -> Poses:
    """Make poses from small twists (n, 6), to second order."""
    half = 0.5 * vector[:, 3:]
    return Poses(np.c_[half, np.sqrt(1 - np.sum(half**2, axis=1))], vector[:, :3].copy())


def _extrapolate_and_compare(
    patches: Patches, first: Ints, second: Ints, motion: Poses
) -> tuple[Array, Array, Array, Array]:
    """Extrapolate the first patch of each pair to the second, and compute the difference.

    motion: first_from_second (m) of the vehicles whose frames the patches are in.

    Returns
    -------
    tuple
        Position (m, 2) of the second's centre in the first's axes, m. Expected height and slopes
        (m, 3) there. The gap (m, 3), those of the second minus these. And the turn (m, 2, 2) of the
        second's axes along the hull into the first's.
    """
    axes = patches.axes[first]
    rotation = axes.swapaxes(1, 2) @ motion.rotation.as_matrix() @ patches.axes[second]
    center = np.einsum(
        "mji,mj->mi", axes, motion.apply(patches.center[second]) - patches.center[first]
    )
    position, turn = center[:, :2], rotation[:, :2, :2]
    by_height, by_slopes = _jacobian_by_curvature(position)
    own = patches.curvature[first]
    other = np.einsum("mij,mj->mi", _turn_curvature(turn), patches.curvature[second])
    height = np.sum(by_height * (own / 3 + other / 6), axis=1)
    slopes = np.einsum("mij,mj->mi", by_slopes, 0.5 * (own + other))
    # slopes of the second plane in the first's axes, from its normal (-p, -q, 1)
    normal = rotation[:, :, 2]
    seen = -normal[:, :2] / np.maximum(normal[:, 2:], 1e-3)
    expected = np.column_stack([height, slopes])
    return position, expected, np.column_stack([center[:, 2], seen]) - expected, turn


def _jacobian_by_curvature(position: Array) -> tuple[Array, Array]:
    """Compute the Jacobians of x' K x (m, 3) and of K x (m, 2, 3) by (K_aa, K_ae, K_ee).

    At x from its centre a patch of constant curvature K stands 0.5 x' K x over its tangent plane,
    and has the slopes K x.

    position (m, 2): x, m, in azimuth and elevation.
    """
    a, e = position.T
    zero = np.zeros_like(a)
    slopes = np.stack([np.stack([a, e, zero], axis=1), np.stack([zero, a, e], axis=1)], axis=1)
    return np.stack([a**2, 2 * a * e, e**2], axis=1), slopes


def _jacobian_by_position(position: Array, own: Array, other: Array) -> Array:
    """Compute the Jacobian (m, 3, 2) of expected height and slopes by the position.

    own, other (m, 3): curvatures of the first and of the second patch, in the first's axes.
    """
    by_height = 2 * np.einsum("mij,mj->mi", _curvature_matrices(own / 3 + other / 6), position)
    return np.concatenate([by_height[:, None], _curvature_matrices(0.5 * (own + other))], axis=1)


def _curvature_matrices(curvature: Array) -> Array:
    """Arrange (K_aa, K_ae, K_ee) (m, 3) as matrices (m, 2, 2)."""
    return np.asarray(curvature[:, [0, 1, 1, 2]].reshape(-1, 2, 2))


def _jacobian_by_plane(position: Array) -> Array:
    """Compute the Jacobian (m, 3, 3) of a plane's height and slopes at positions by its own."""
    out = np.tile(np.eye(3), (len(position), 1, 1))
    out[:, 0, 1:] = position
    return out


def _turn_plane(turn: Array) -> Array:
    """Build the matrices (m, 3, 3) that turn height and slopes, by turns (m, 2, 2)."""
    out = np.zeros((len(turn), 3, 3))
    out[:, 0, 0], out[:, 1:, 1:] = 1.0, turn
    return out


def _turn_curvature(turn: Array) -> Array:
    """Build the matrices (m, 3, 3) that turn (K_aa, K_ae, K_ee) as Q K Q' turns K."""
    (p, q), (r, s) = turn[:, 0].T, turn[:, 1].T
    rows = [[p * p, 2 * p * q, q * q], [p * r, p * s + q * r, q * s], [r * r, 2 * r * s, s * s]]
    return np.asarray(np.stack([np.stack(row, axis=1) for row in rows], axis=1))


@dataclass(frozen=True, kw_only=True)
class PlaneDifference:
    """The difference between the planes of two patches, as vectors of TiedPlanes."""

    difference: Array  # (m, 3) m
    information: Array  # (m, 3, 3) square root of the information on it
    by_place: Array  # (m, 3, 3) derivative by the second's centre


def difference_of_planes(patches: Patches, pairs: PatchPairs, noise: Array) -> PlaneDifference:
    """Compute the plane expected at the second's centre minus the first's plane.

    A plane is its unit normal times its distance from the origin of the first anchor's vehicle
    frame. The native graph compares the planes of a pair by this difference.

    noise (m, 3, 3): covariance of the gaps, which is propagated to the difference.
    """
    axes, slopes = patches.axes[pairs.first], pairs.expected[:, 1:]
    length = np.sqrt(1 + np.sum(slopes**2, axis=1))[:, None, None]
    in_patch = np.concatenate([-slopes, np.ones((len(pairs), 1))], axis=1)[:, :, None] / length
    normal = (axes @ in_patch)[:, :, 0]
    local = np.column_stack([pairs.position, pairs.expected[:, 0]])
    point = patches.center[pairs.first] + np.einsum("mij,mj->mi", axes, local)
    # from the plane to the frame's origin, along the normal
    distance = -np.sum(normal * point, axis=1)[:, None]
    difference = distance * normal - patches.plane[pairs.first]
    # derivative by height and slopes at the second's centre: the plane is raised, or turned there.
    # `by_normal` (m, 3, 2) is that of the unit normal by the slopes, across the normal
    turned = -axes[:, :, :2]
    along = np.einsum("mij,mi->mj", turned, normal)
    by_normal = (turned - normal[:, :, None] * along[:, None, :]) / length
    by_slopes = (
        distance[:, :, None] * by_normal
        - normal[:, :, None] * np.einsum("mij,mi->mj", by_normal, point)[:, None, :]
    )
    by_height = -normal * in_patch[:, 2]
    by_gap = np.concatenate([by_height[:, :, None], by_slopes], axis=2)
    covariance = by_gap @ noise @ by_gap.swapaxes(1, 2)
    # derivative by the position: height and slopes change with it, and so does the point through
    # which the plane passes
    by_position = (
        by_gap @ pairs.by_position
        - normal[:, :, None] * np.einsum("mi,mij->mj", normal, axes[:, :, :2])[:, None, :]
    )
    return PlaneDifference(
        difference=difference,
        information=np.asarray(np.linalg.inv(np.linalg.cholesky(covariance))),
        by_place=by_position @ axes[:, :, :2].swapaxes(1, 2),
    )
