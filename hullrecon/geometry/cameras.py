# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The camera of ROS's camera_info: a pinhole with plumb_bob distortion, as in OpenCV."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hullrecon.typing import Array


@dataclass(frozen=True)
class CameraModel:
    """A pinhole with plumb_bob distortion."""

    width: int  # px
    height: int  # px
    fx: float  # px
    fy: float  # px
    cx: float  # px
    cy: float  # px
    k1: float = 0.0  # radial, as are k2 and k3, in OpenCV's order
    k2: float = 0.0
    p1: float = 0.0  # tangential, as is p2
    p2: float = 0.0
    k3: float = 0.0

    def matrix(self) -> Array:
        """Build the pinhole's matrix (3, 3), px."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]])

    def distortion(self) -> Array:
        """List k1, k2, p1, p2, k3 (5,)."""
        return np.array([self.k1, self.k2, self.p1, self.p2, self.k3])

    def parameters(self) -> Array:
        """List fx, fy, cx, cy, k1, k2, p1, p2, k3 (9,), in the native module's order."""
        return np.array(
            [self.fx, self.fy, self.cx, self.cy, self.k1, self.k2, self.p1, self.p2, self.k3]
        )

    def project(self, points: ArrayLike) -> Array:
        """Project points (n, 3) in the camera frame to pixels (n, 2). NaN behind the camera."""
        x, y, z = np.atleast_2d(np.asarray(points, float)).T
        depth = np.where(z > 1e-9, z, np.nan)
        return np.stack(self._distorted(x / depth, y / depth), axis=1)

    def distort(self, xy: ArrayLike) -> Array:
        """Map ideal coordinates x/z, y/z (n, 2) to pixels (n, 2)."""
        x, y = np.asarray(xy, float).T
        return np.stack(self._distorted(x, y), axis=1)

    def _distorted(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Apply distortion and intrinsics to ideal coordinates x, y (n,): columns, rows px (n,)."""
        r2 = x * x + y * y
        radial = 1 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3))
        u = x * radial + 2 * self.p1 * x * y + self.p2 * (r2 + 2 * x * x)
        v = y * radial + self.p1 * (r2 + 2 * y * y) + 2 * self.p2 * x * y
        return self.fx * u + self.cx, self.fy * v + self.cy

    def largest_slope(self, radius: Array) -> Array:
        """Compute an upper bound (n,), px, of how far a pixel moves by a step of a ray.

        It is for a unit change of ideal coordinates (x/z, y/z), anywhere within a radius (n,) of
        the optical axis. With it a whole block of texels is ruled out from a view without
        projecting each. Radially, pixels move by the derivative of r + k1 r^3 + k2 r^5 + k3 r^7. In
        the other direction the same bound holds.
        """
        r2 = np.square(radius)
        terms = [3 * self.k1 * r2, 5 * self.k2 * r2**2, 7 * self.k3 * r2**3]
        # Terms of either sign are summed apart: they may cancel at the radius, but not within it
        more, less = (sum(np.maximum(way * term, 0) for term in terms) for way in (1, -1))
        tangential = 6 * (abs(self.p1) + abs(self.p2)) * radius
        return np.asarray(max(self.fx, self.fy) * (np.maximum(1 + more, less - 1) + tangential))

    def undistort(self, pixels: ArrayLike, iterations: int = 12) -> Array:
        """Map pixels (n, 2) to ideal coordinates x/z, y/z (n, 2), by fixed-point iteration.

        Far out, where a strong distortion folds the image, it does not converge. This is not
        checked: `undistortion` refuses such cameras.
        """
        p = np.atleast_2d(np.asarray(pixels, float))
        want = (p - [self.cx, self.cy]) / [self.fx, self.fy]
        x, y = want.T.copy()
        for _ in range(iterations):
            r2 = x * x + y * y
            radial = 1 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3))
            dx = 2 * self.p1 * x * y + self.p2 * (r2 + 2 * x * x)
            dy = self.p1 * (r2 + 2 * y * y) + 2 * self.p2 * x * y
            x, y = (want[:, 0] - dx) / radial, (want[:, 1] - dy) / radial
        return np.stack([x, y], axis=1)

    def rays(self, pixels: ArrayLike) -> Array:
        """Compute unit directions (n, 3) of the rays through pixels (n, 2), in the camera frame."""
        xy = self.undistort(pixels)
        ray = np.hstack([xy, np.ones((len(xy), 1))])
        return np.asarray(ray / np.linalg.norm(ray, axis=1, keepdims=True))
