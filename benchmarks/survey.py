# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The truth of a field survey: a ship's side with curvature both ways, swept in horizontal legs
from a metre.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from hullrecon.geometry import poses
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.typing import Array, Ints, Ints32

CAMERA = CameraModel(1360, 1024, 1400.0, 1400.0, 680.0, 512.0)
TRAY_FROM_TOP = poses.from_mount([0.0, 0.0, -0.05, 90.0, 0.0, 90.0])
TOP_FROM_BOTTOM = poses.from_mount([0.0, 0.1, 0.0, 0.0, 0.0, 0.0])
TRAY_FROM_DVL = poses.from_mount([0.0, 0.0, 0.08, 0.0, 90.0, 0.0])
TRAY_ORIGIN = np.array([0.45, 0.0, 0.10])
_TILT, _AZIMUTH = np.pi / 6, np.radians([180, 0, 90, -90])
BEAMS = np.stack(
    [np.sin(_TILT) * np.cos(_AZIMUTH), np.sin(_TILT) * np.sin(_AZIMUTH), np.full(4, np.cos(_TILT))],
    axis=1,
)
STEP_M, LEG_SPACING_M, MIDDLE_M = 0.195, 0.25, 7.6
DEPTH_M = 14.0  # of the hull, from keel to deck
KEEL_CLEARANCE_M, DECK_CLEARANCE_M = 2.5, 1.0  # least distance of a leg from keel and deck


@dataclass(frozen=True)
class Size:
    """The size of a problem. Every pose has four beams of the DVL."""

    poses: int
    imaged: int  # poses with an image or a pair of images
    landmarks: int
    stereo: bool
    legs: int

    @property
    def per_leg(self) -> int:
        return -(-self.poses // self.legs)

    @property
    def middle_m(self) -> float:
        """Height of the middle leg above the keel: higher where there are many legs."""
        return max(MIDDLE_M, KEEL_CLEARANCE_M + LEG_SPACING_M * (self.legs - 1) / 2)

    @property
    def depth_m(self) -> float:
        """Depth of the hull, which is as deep as the legs need."""
        return max(DEPTH_M, self.middle_m + LEG_SPACING_M * (self.legs - 1) / 2 + DECK_CLEARANCE_M)

    def part(self, share: int) -> Size:
        """Make a problem of one `share`-th of the poses at the same density.

        For 16, legs are a quarter as long and a quarter as many.
        """
        cut = round(share**0.5)
        if cut * cut != share:
            raise ValueError("share must be a square")
        return Size(
            self.poses // share,
            self.imaged // share,
            self.landmarks // share,
            self.stereo,
            max(1, self.legs // cut),
        )

    def images(self) -> Ints:
        """List the poses (imaged,) with images, spread evenly."""
        return np.arange(self.imaged) * self.poses // self.imaged


SIZES = {
    "stereo": Size(24236, 22434, 243536, stereo=True, legs=40),
    "mono": Size(9249, 9249, 100597, stereo=False, legs=16),
    "small": Size(400, 372, 4000, stereo=True, legs=4),
    "small_mono": Size(400, 400, 4000, stereo=False, legs=4),
}


def side(x: Array, z: Array) -> Array:
    """Compute the half-breadth y, m, of the port side at x and z.

    x: m from amidships of a hull of 180 m. z: m above the keel of a hull 14 m deep.
    """
    ends = 1 - 0.75 * np.abs(x / 90.0) ** 3
    section = (1 - np.clip(1 - z / 9.0, 0, 1) ** 3) ** 0.5
    return np.asarray(16.0 * ends * np.maximum(section, 0.05))


def hull_mesh(along: int = 201, girth: int = 51, depth_m: float = DEPTH_M) -> tuple[Array, Ints32]:
    """Mesh the port side with 20,000 triangles, which face outward (+y)."""
    x, z = np.meshgrid(np.linspace(-90, 90, along), np.linspace(0.2, depth_m, girth), indexing="ij")
    vertices = np.stack([x, side(x, z), z], -1).reshape(-1, 3)
    n = np.arange(x.size).reshape(x.shape)
    a, b, c, d = n[:-1, :-1].ravel(), n[1:, :-1].ravel(), n[1:, 1:].ravel(), n[:-1, 1:].ravel()
    return vertices, np.vstack([np.stack([a, c, b], 1), np.stack([a, d, c], 1)]).astype(np.int32)


def normals(x: Array, z: Array) -> Array:
    """Compute the outward unit normals (n, 3) of the side."""
    step = 1e-3
    dx = (side(x + step, z) - side(x - step, z)) / (2 * step)
    dz = (side(x, z + step) - side(x, z - step)) / (2 * step)
    normal = np.stack([-dx, np.ones_like(x), -dz], -1)
    return np.asarray(normal / np.linalg.norm(normal, axis=1, keepdims=True))


def tracks(size: Size) -> tuple[Array, Array]:
    """Compute where on the hull each pose looks: x along, z above the keel, both (n,) m.

    Every second leg runs back.
    """
    number = np.arange(size.poses)
    leg, place = number // size.per_leg, (number % size.per_leg + 0.5) / size.per_leg
    x = 0.5 * STEP_M * size.per_leg * (2 * place - 1) * np.where(leg % 2 == 0, 1, -1)
    return x, size.middle_m + LEG_SPACING_M * ((size.legs - 1) / 2 - leg) - 0.03 * np.sin(x / 3)


def fly(size: Size) -> tuple[Poses, Array]:
    """Make the vehicle's poses T_M_v (n), and the tray's angles (n,) that face the hull.

    The tray's axis is a metre off the hull. The vehicle sways by a degree.
    """
    x, z = tracks(size)
    normal, number = normals(x, z), np.arange(size.poses)
    standoff = 1.0 + 0.05 * np.sin(x / 2 + number // size.per_leg)
    pivot = np.stack([x, side(x, z), z], 1) + standoff[:, None] * normal
    # of the vehicle's z-down frame seen in M, where z is up
    heading = np.arctan2(normal[:, 1], -normal[:, 0])
    sway = np.radians(1.0) * np.stack(
        [np.sin(0.13 * number), np.cos(0.11 * number), np.sin(0.07 * number)], 1
    )
    upright = Rotation.from_euler("x", np.pi) * Rotation.from_euler("z", heading[:, None])
    rotation = upright * Rotation.from_euler("xyz", sway)
    tray = np.arctan2(-normal[:, 2], np.linalg.norm(normal[:, :2], axis=1))
    return Poses(rotation.as_quat(), pivot - rotation.apply(TRAY_ORIGIN)), tray
