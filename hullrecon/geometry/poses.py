# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Rigid motions in batches. `Poses` holds a_from_b of n frames b in one frame a: p_a = R p_b + t.

Quaternions are x y z w. Small rotations are perturbed on the right, R Exp(w), everywhere in
hullrecon (native included). A 6-vector of a motion is (translation, rotation): `log` gives (t, w)
with R = Exp(w), not the coupled logarithm of SE(3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from hullrecon.geometry.rotations import compose, mount_angles_deg, multiply
from hullrecon.typing import Array, Ints, Ints32, Mask


@dataclass(frozen=True)
class Poses:
    """Poses a_from_b of n frames: they map coordinates in b to a."""

    quaternion: Array  # (n, 4) x y z w, unit
    translation: Array  # (n, 3) m

    def __len__(self) -> int:
        return len(self.quaternion)

    def __getitem__(
        self, index: int | slice | NDArray[np.integer] | Mask | Sequence[int] | Sequence[np.integer]
    ) -> Poses:
        """Select rows by slice, mask or index array. An integer gives a batch of one."""
        rows = np.atleast_1d(
            np.arange(len(self))[index if isinstance(index, slice) else np.asarray(index)]
        )
        return Poses(self.quaternion[rows], self.translation[rows])

    def __matmul__(self, other: Poses) -> Poses:
        """Compose a_from_b @ b_from_c = a_from_c. A batch of one broadcasts."""
        return Poses(_multiply(self.quaternion, other.quaternion), self.apply(other.translation))

    @property
    def rotation(self) -> Rotation:
        """Rotations of b in a (n)."""
        return Rotation.from_quat(self.quaternion)

    def matrix(self) -> Array:
        """Convert to homogeneous matrices (n, 4, 4)."""
        out = np.tile(np.eye(4), (len(self), 1, 1))
        out[:, :3, :3], out[:, :3, 3] = _rotation_matrices(self.quaternion), self.translation
        return out

    def apply(self, points: ArrayLike) -> Array:
        """Transform points (n, 3) from b to a: each by its own pose, or all by a batch of one."""
        return _turn(self.quaternion, np.asarray(points, float)) + self.translation

    def apply_rows(self, rows: Ints | Ints32, points: Array) -> Array:
        """Transform points (n, 3), each by the pose of its row: `self[rows].apply(points)`.

        It is faster than that where there are many points for each pose, as the rotation matrices
        are computed once for each pose.
        """
        return self.turn_rows(rows, points) + self.translation[rows]

    def turn_rows(self, rows: Ints | Ints32, vectors: Array) -> Array:
        """Rotate vectors (n, 3), each by the pose of its row."""
        matrix = _rotation_matrices(self.quaternion)
        return np.asarray(np.einsum("ijk,ik->ij", matrix[rows], vectors))

    def inverse(self) -> Poses:
        """Invert to b_from_a (n)."""
        back = self.quaternion * [-1.0, -1.0, -1.0, 1.0]
        return Poses(back, -_turn(back, self.translation))

    def vectors(self) -> Array:
        """Convert to x y z qx qy qz qw (n, 7)."""
        return np.hstack([self.translation, self.quaternion])

    def log(self) -> Array:
        """Convert to translation and rotation vector (n, 6)."""
        return np.hstack([self.translation, self.rotation.as_rotvec()])


# The functions below compute the same as SciPy's rotations, which take longer to check their
# arguments than to compute. A search for the hull's pose, which composes thousands of single poses,
# spent a third of its time in these checks.


def _components(quaternion: Array) -> list[Array]:
    """Normalise quaternions (n, 4) and split them: x, y, z, w, (n,) each, floats for n = 1."""
    x, y, z, w = quaternion[0].tolist() if len(quaternion) == 1 else quaternion.T
    norm = np.sqrt(x * x + y * y + z * z + w * w)
    return [x / norm, y / norm, z / norm, w / norm]


def _multiply(first: Array, second: Array) -> Array:
    """Multiply quaternions (n, 4) (x, y, z, w): the rotation `second` and then `first`.

    A batch of one broadcasts.
    """
    product = multiply(_components(first), _components(second))
    return np.stack(_components(product.reshape(4, -1).T), axis=-1).reshape(-1, 4)


def _rotation_matrices(quaternion: Array) -> Array:
    """Convert unit quaternions (n, 4) (x, y, z, w) to rotation matrices (n, 3, 3)."""
    x, y, z, w = _components(quaternion)
    xx, yy, zz, ww = x * x, y * y, z * z, w * w
    xy, xz, yz, xw, yw, zw = x * y, x * z, y * z, x * w, y * w, z * w
    rows = [
        [xx - yy - zz + ww, 2 * (xy - zw), 2 * (xz + yw)],
        [2 * (xy + zw), -xx + yy - zz + ww, 2 * (yz - xw)],
        [2 * (xz - yw), 2 * (yz + xw), -xx - yy + zz + ww],
    ]
    return np.ascontiguousarray(np.array(rows).reshape(3, 3, -1).transpose(2, 0, 1))


def _turn(quaternion: Array, points: Array) -> Array:
    """Rotate points (n, 3): the i-th by the i-th quaternion, or all by a batch of one."""
    matrix = _rotation_matrices(quaternion)
    if len(matrix) == 1:
        return np.asarray(np.einsum("jk,ik->ij", matrix[0], np.atleast_2d(points)))
    return np.asarray(np.einsum("ijk,ik->ij", matrix, np.atleast_2d(points)))


def identity(n: int = 1) -> Poses:
    """Make n identities."""
    return Poses(np.tile([0.0, 0.0, 0.0, 1.0], (n, 1)), np.zeros((n, 3)))


def stacked(batches: Sequence[Poses]) -> Poses:
    """Concatenate batches of poses."""
    return Poses(
        np.concatenate([batch.quaternion for batch in batches]),
        np.concatenate([batch.translation for batch in batches]),
    )


def exp(vectors: ArrayLike) -> Poses:
    """Make poses of translation and rotation vector (n, 6): the inverse of `Poses.log`."""
    v = np.atleast_2d(np.asarray(vectors, float))
    return Poses(Rotation.from_rotvec(v[:, 3:]).as_quat(), v[:, :3].copy())


def from_matrix(matrices: ArrayLike) -> Poses:
    """Make poses of homogeneous matrices (n, 4, 4) or (4, 4)."""
    m = np.asarray(matrices, float).reshape(-1, 4, 4)
    return Poses(Rotation.from_matrix(m[:, :3, :3]).as_quat(), m[:, :3, 3].copy())


def from_rpy(translation: ArrayLike, roll_pitch_yaw_rad: ArrayLike) -> Poses:
    """Make poses (n,) from translations and roll, pitch, yaw, both (n, 3) or (3,).

    The rotation is R = Rz(yaw) Ry(pitch) Rx(roll).
    """
    rpy = np.atleast_2d(np.asarray(roll_pitch_yaw_rad, float))
    return Poses(
        Rotation.from_euler("xyz", rpy).as_quat(),
        np.atleast_2d(np.asarray(translation, float)).copy(),
    )


def up_in(global_from_frame: Poses) -> Array:
    """Compute the unit vector (3,) that points up in a frame. Its pose in g is a batch of one."""
    return np.asarray(global_from_frame.rotation.inv().apply([0.0, 0.0, -1.0])[0])


def from_mount(mount: ArrayLike) -> Poses:
    """Make a pose of dive.toml's six numbers: x y z in m, roll pitch yaw in degrees."""
    m = np.asarray(mount, float)
    return from_rpy(m[:3], np.radians(m[3:]))


def to_mount(pose: Poses) -> list[float]:
    """Write one pose (a batch of one) as dive.toml's six numbers, the inverse of `from_mount`.

    Rounded to millimetres and hundredths of a degree, for a user to copy.
    """
    return [*pose.translation[0].round(3).tolist(), *mount_angles_deg(pose.rotation)]


def pose_vector(pose: Poses) -> Array:
    """Convert a batch of one to x y z qx qy qz qw (7,)."""
    return np.asarray(pose.vectors()[0])


def pose_from_vector(values: Array) -> Poses:
    """Make a batch of one of x y z qx qy qz qw (7,), its quaternion normalised."""
    return Poses(values[None, 3:] / np.linalg.norm(values[3:]), values[None, :3].copy())


def tray_poses(origin_m: ArrayLike, angle_rad: ArrayLike) -> Poses:
    """Compute vehicle_from_tray = Trans(origin) Ry(theta) for angles (n,)."""
    angle = np.atleast_1d(np.asarray(angle_rad, float))
    zero = np.zeros(len(angle))
    return Poses(
        np.stack([zero, np.sin(0.5 * angle), zero, np.cos(0.5 * angle)], axis=1),
        np.tile(np.asarray(origin_m, float), (len(angle), 1)),
    )


def interpolate(t_ns: Ints, poses: Poses, wanted_ns: Ints) -> Poses:
    """Interpolate poses at times: translations linearly, rotations by slerp.

    Outside the span of the poses, the nearest end is taken.

    Parameters
    ----------
    t_ns, poses
        Times (n,), ascending, and the poses at them.
    wanted_ns
        Times (m,) of the result.
    """
    at = np.clip(wanted_ns, t_ns[0], t_ns[-1])
    right = np.clip(np.searchsorted(t_ns, at, side="right"), 1, max(1, len(t_ns) - 1))
    if len(t_ns) == 1:
        return poses[np.zeros(len(at), int)]
    left = right - 1
    share = (at - t_ns[left]) / np.maximum(1, t_ns[right] - t_ns[left])
    a, b = poses[left], poses[right]
    # The rotation from one pose to the next, in the axes of the first, of which a share is taken
    start = a.rotation
    turn = compose(start.inv(), b.rotation).as_rotvec() * share[:, None]
    rotation = compose(start, Rotation.from_rotvec(turn))
    return Poses(
        rotation.as_quat(), a.translation + share[:, None] * (b.translation - a.translation)
    )
