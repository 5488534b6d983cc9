# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a mosaic does with every view at every texel: project, rank, blend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hullrecon.typing import Array, Floats32, Ints, Ints32


def project_into(
    points: Array,
    camera_from_frame: Array,
    center: Array,
    lens: Array,
    size: tuple[int, int],
    widest: float,
) -> tuple[Array, Array]:
    """Project points (n, 3) to pixels (n, 2) of an image.

    Parameters
    ----------
    camera_from_frame, center
        Rotation (3, 3) into the camera, and where it is in the points' frame (3,).
    lens
        fx, fy, cx, cy, k1, k2, p1, p2, k3 (9,).
    size
        Width and height of the image, px.
    widest
        x / z and y / z beyond which the distortion would fold points back.

    Returns
    -------
    pixel
        NaN behind the camera.
    ratio
        Distance from the image's middle over half its diagonal (n,), NaN where the image does not
        hold the point.
    """
    import hullrecon._native as _native  # compiled; loads the solver's libraries

    pixel, ratio = _native.project_into(points, camera_from_frame, center, lens, *size, widest)
    return pixel, ratio


def incidence(points: Array, normals: Array, sensor: Array) -> Array:
    """Compute cosines of the incidence (n,) of a sensor (3,) at points with normals (n, 3)."""
    import hullrecon._native as _native

    cosine: Array = _native.incidence(points, normals, sensor)
    return cosine


def insert_view(best_view: Ints32, best_cost: Floats32, view: int, cost: Floats32) -> None:
    """Put a view into the list of best views (places, n) of each texel that it costs less at.

    Changes both lists, which are sorted by cost (n,). Of equals the first view comes first.
    """
    import hullrecon._native as _native

    _native.insert_view(best_view, best_cost, view, cost)


def least_tangents(
    top: Array,
    top_normal: Array,
    limits: tuple[float, float, float],
    points: Array,
    normals: Array,
) -> Array:
    """Bound tangents (n,) of the incidence up to which nothing hides blocks of a surface.

    Parameters
    ----------
    top, top_normal
        The outermost point of each cell of the chart (m, 3), with the chart's normal there (m, 3).
    limits
        Side of a cell, the distance from which on nothing stands in the way, and the relief up to
        which nothing is hidden, m.
    points, normals
        Of each block (n, k, 3), on the surface and of the chart; NaN where there is no surface.

    Returns
    -------
    Array
        The least distance of a cell over its height above the block, both on the safe side. inf
        where no cell stands out, and for a block without a point.
    """
    import hullrecon._native as _native

    least: Array = _native.least_tangents(top, top_normal, *limits, points, normals)
    return least


@dataclass(frozen=True, kw_only=True)
class BlendSums:
    """Sums over the views that were blended so far, at each of n texels."""

    value: Floats32  # (n, bands, channels) weight x band
    weight: Floats32  # (n, bands)
    moment: Floats32  # (n, 3) of weight, weight x intensity, weight x intensity squared
    views: NDArray[np.uint8]  # (n,) how many

    @classmethod
    def zero(cls, bands: int, channels: int, texels: int) -> BlendSums:
        """Make the sums over no view."""
        return cls(
            value=np.zeros((texels, bands, channels), np.float32),
            weight=np.zeros((texels, bands), np.float32),
            moment=np.zeros((texels, 3), np.float32),
            views=np.zeros(texels, np.uint8),
        )

    def add(
        self,
        bands: Sequence[Floats32],
        rows: Ints,
        pixel: Floats32,
        ratio: Array,
        steepness: ArrayLike,
    ) -> None:
        """Add a view at some texels (rows, each once).

        Parameters
        ----------
        bands
            (h, w, channels) of the picture, which they sum to; one channel or three.
        pixel
            (rows, 2) in the picture, which is sampled bilinearly and goes on past its border as it
            ends.
        ratio
            r / R of each row.
        steepness
            k of B_k(r) = exp(-k r/R) / (1 + exp(-2 k r/R)), the weight in each band.
        """
        import hullrecon._native as _native

        _native.add_view(
            self.value,
            self.weight,
            self.moment,
            self.views,
            rows,
            pixel,
            ratio,
            np.asarray(steepness, float),
            list(bands),
        )
