# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Axes in which sensors log: as dive.toml states them, and as they may be instead."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.streams.imu import FRD_FROM_FLU, NED_FROM_ENU
from hullrecon.geometry.rotations import mount_angles_deg
from hullrecon.typing import Array

# Between two turns that are tried, of a DVL about its axis or an IMU about the vehicle's. Small
# enough for comparisons to agree at the nearest
TURN_STEP_DEG = 5


@dataclass(frozen=True, kw_only=True)
class Conventions:
    """What dive.toml says of a vehicle's sensors."""

    imu_frame: str = "ned"  # or "enu"
    imu_mount_deg: tuple[float, float, float] | None = None  # roll, pitch, yaw in the vehicle
    tray_positive: str = "up"  # or "down"
    tray_offset_deg: float = 0.0

    @property
    def vehicle_from_imu(self) -> Rotation:
        """The mount of the IMU, with its axes forward, starboard, down."""
        angles = (self.imu_mount_deg or (0.0, 0.0, 0.0))[::-1]
        return Rotation.from_euler("ZYX", angles, degrees=True)

    @property
    def logged_from_vehicle(self) -> Rotation:
        """The turn from the vehicle's axes to those that the IMU logs in."""
        turned = self.vehicle_from_imu.inv()
        return turned if self.imu_frame == "ned" else FRD_FROM_FLU.inv() * turned

    @property
    def global_from_logged(self) -> Rotation:
        """The turn from the global axes that the IMU logs in to those of `global`."""
        return Rotation.identity() if self.imu_frame == "ned" else NED_FROM_ENU

    def logged(self, attitude: Rotation) -> Rotation:
        """Turn attitudes (n,) of the vehicle back into the orientations that were logged."""
        return self.global_from_logged.inv() * attitude * self.logged_from_vehicle.inv()

    def read(self, logged: Rotation) -> Rotation:
        """Turn logged orientations (n,) into attitudes, as `imu_samples` does."""
        return self.global_from_logged * logged * self.logged_from_vehicle


BY_DEFAULT = Conventions()


def signed_axes() -> list[tuple[str, Array]]:
    """List the 47 signed permutations of axes beside the identity, with their names."""
    out = []
    for order in itertools.permutations(range(3)):
        for signs in itertools.product([1.0, -1.0], repeat=3):
            turn = np.diag(signs) @ np.eye(3)[list(order)]
            if not np.array_equal(turn, np.eye(3)):
                axes = zip(signs, order, strict=True)
                name = " ".join(f"{'+' if s > 0 else '-'}{'xyz'[k]}" for s, k in axes)
                out.append((name, turn))
    return out


def is_mirrored(axes: Array) -> bool:
    """Tell whether axes (3, 3) are left-handed."""
    return bool(np.linalg.det(axes) < 0)


def mounts_on_side() -> Iterator[tuple[str, Rotation]]:
    """Yield how an instrument may be mounted by right angles with its z axis across the vehicle's.

    Yields
    ------
    tuple
        Roll, pitch and yaw of the instrument in the vehicle, deg, as text, and vehicle_from_imu.
    """
    for _, turn in signed_axes():
        if np.linalg.det(turn) > 0 and turn[2, 2] == 0:
            rotation = Rotation.from_matrix(turn)
            yield ", ".join(f"{angle:g}" for angle in mount_angles_deg(rotation)), rotation


def uprightness(attitude: Rotation) -> float:
    """Compute the mean cosine of the tilt of attitudes (n,) with x forward, z down."""
    return float(np.mean(attitude.apply([0.0, 0.0, 1.0])[:, 2]))


def orientations_of_other_axes(attitude: Rotation) -> Iterator[tuple[str, Array]]:
    """Yield orientations corrected for wrong axes of the vehicle, of `global`, or of both.

    Exchanged components of a quaternion, and rotations chained in the wrong order, have the same
    effect as wrong axes. Global axes that differ only in heading cannot be distinguished, so one
    set is tried for each axis that may point down.

    Yields
    ------
    tuple
        Name of the axes, and quaternions (n, 4).
    """
    turns = [("+x +y +z", np.eye(3)), *signed_axes()]
    proper = [(name, turn) for name, turn in turns if np.linalg.det(turn) > 0]
    own = {name: Rotation.from_matrix(turn) for name, turn in proper}
    downwards = {name[-2:]: name for name in reversed(own)}
    for inverse, logged in (("", attitude), (", and it is inverted", attitude.inv())):
        quaternion = logged.as_quat()
        for down, globally in downwards.items():
            for name, turn in own.items():
                if inverse or (down, name) != ("+z", "+x +y +z"):
                    turned = multiply_both_sides(own[globally], quaternion, turn)
                    yield f"{name} for those of the vehicle, {down} downwards{inverse}", turned


def multiply_both_sides(first: Rotation, quaternion: Array, last: Rotation) -> Array:
    """Multiply quaternions (n, 4) by one rotation from the left and one from the right.

    Both products are linear in the quaternion, so they are applied as one 4x4 matrix. This is
    faster than two products of rotations, and hundreds of hypotheses turn all readings of an IMU.
    """
    x, y, z, w = first.as_quat()
    left = np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])
    x, y, z, w = last.as_quat()
    right = np.array([[w, z, -y, x], [-z, w, x, y], [y, -x, w, z], [-x, -y, -z, w]])
    return np.asarray(quaternion @ (left @ right).T)
