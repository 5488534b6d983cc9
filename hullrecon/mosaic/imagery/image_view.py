# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the mosaic asks of one image, be it of a camera or of a sonar."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.poses import Poses
from hullrecon.mosaic.mosaic_surface import MosaicSurface
from hullrecon.typing import Array, Floats32


class ImageView(Protocol):
    """One image and where it was taken. center: (3,) of the instrument in the surface's frame."""

    @property
    def center(self) -> Array: ...

    def project(self, points: Array) -> tuple[Array, Array]:
        """Project points (n, 3) into the picture; NaN where it does not hold them.

        Returns
        -------
        pixel
            (n, 2).
        ratio
            r / R (n,), distance from the best place in the image over the largest considered
            (docs/methods.md 13, 14).
        """

    def outline(self, surface: MosaicSurface) -> Array:
        """Cast rays all over the image onto the surface (n, 3). NaN where they miss."""

    def picture(self) -> Floats32 | None:
        """Read the image (h, w, channels), corrected, 0 to 255. None if unreadable."""


@dataclass(frozen=True, kw_only=True)
class CameraView:
    """A camera's image."""

    pose: Poses  # one result_from_camera
    camera: CameraModel
    load: Callable[[], Floats32 | None]  # gives the correct picture

    @property
    def center(self) -> Array:
        return np.asarray(self.pose.translation[0])

    def project(self, points: Array) -> tuple[Array, Array]:
        """Project points. The best place is the image's middle, R half its diagonal."""
        rotation = self.pose.rotation.as_matrix()[0]
        inside = (points - self.center) @ rotation
        pixel = self.camera.project(inside)
        x, y, z = inside.T
        u, v = pixel.T
        width, height = self.camera.width, self.camera.height
        near_axis = np.maximum(np.abs(x), np.abs(y)) < self._widest() * z
        held = near_axis & (u >= 1) & (u <= width - 2) & (v >= 1) & (v <= height - 2)
        away = np.hypot(u - (width - 1) / 2, v - (height - 1) / 2) / (0.5 * np.hypot(width, height))
        return pixel, np.where(held, away, np.nan)

    def outline(self, surface: MosaicSurface) -> Array:
        u, v = np.meshgrid(
            np.linspace(1, self.camera.width - 2, 7), np.linspace(1, self.camera.height - 2, 7)
        )
        rays = (
            self.camera.rays(np.stack([u.ravel(), v.ravel()], axis=1))
            @ self.pose.rotation.as_matrix()[0].T
        )
        gone = surface.scene.cast(np.tile(self.center, (len(rays), 1)), rays)
        return np.asarray(self.center + np.where(np.isfinite(gone), gone, np.nan)[:, None] * rays)

    def picture(self) -> Floats32 | None:
        return self.load()

    def _widest(self) -> float:
        """Find the tangent beyond which the distortion would fold points back."""
        c = self.camera
        return 1.5 * max(
            c.cx / c.fx, (c.width - c.cx) / c.fx, c.cy / c.fy, (c.height - c.cy) / c.fy
        )
