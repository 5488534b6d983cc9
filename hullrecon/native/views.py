# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The operations of a mosaic on every view at every texel, in C++: project, rank and blend."""

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
    """Project points to pixels of an image, with their distances from the image's middle.

    Parameters
    ----------
    points
        (n, 3) m.
    camera_from_frame, center
        Rotation (3, 3) into the camera, and its position (3,) m in the points' frame.
    lens
        fx, fy, cx, cy, k1, k2, p1, p2, k3 (9,).
    size
        Width and height of the image, px.
    widest
        x / z and y / z beyond which the distortion would fold points back.

    Returns
    -------
    pixel
        (n, 2) px, NaN behind the camera.
    ratio
        (n,) distance from the image's middle over half its diagonal, NaN where the image does not
        show the point.
    """
    from hullrecon.native.compiled import native  # loads the solver's libraries

    pixel, ratio = native.project_into(points, camera_from_frame, center, lens, *size, widest)
    return pixel, ratio


def incidence(points: Array, normals: Array, sensor: Array) -> Array:
    """Compute the cosine (n,) of a sensor's (3,) incidence at points (n, 3) with normals (n, 3)."""
    from hullrecon.native.compiled import native

    cosine: Array = native.incidence(points, normals, sensor)
    return cosine


def insert_view(best_view: Ints32, best_cost: Floats32, view: int, cost: Floats32) -> None:
    """Insert a view into the list of best views of each texel at which it costs less than another.

    Both lists are changed in place. They stay sorted by cost, and of views with equal costs that
    which was inserted first comes first.

    Parameters
    ----------
    best_view, best_cost
        Views, and their costs, (k, n): the k best of each of n texels.
    view, cost
        Number of the view, and its cost (n,).
    """
    from hullrecon.native.compiled import native

    native.insert_view(best_view, best_cost, view, cost)


def least_tangents(
    top: Array,
    top_normal: Array,
    limits: tuple[float, float, float],
    points: Array,
    normals: Array,
) -> Array:
    """Bound the tangents (n,) of the incidence below which nothing occludes blocks of a surface.

    Parameters
    ----------
    top, top_normal
        The outermost point of each cell of the chart (c, 3), with the chart's normal there (c, 3).
    limits
        Side of a cell, the distance beyond which points do not occlude, and the height up to which
        they do not, m.
    points, normals
        Of each block (n, k, 3): points of the surface and normals of the chart, NaN where there is
        no surface.

    Returns
    -------
    Array
        The least ratio of a cell's distance to its height above the block, with a lower bound of
        the distance and an upper bound of the height. inf where no cell is high enough, and for a
        block without a point.
    """
    from hullrecon.native.compiled import native

    least: Array = native.least_tangents(top, top_normal, *limits, points, normals)
    return least


@dataclass(frozen=True, kw_only=True)
class BlendSums:
    """Sums over the views that were blended so far, at each of n texels."""

    value: Floats32  # (n, bands, channels) weight x band
    weight: Floats32  # (n, bands)
    moment: Floats32  # (n, 3) of weight, weight x intensity, weight x intensity squared
    views: NDArray[np.uint8]  # (n,) number of views

    @classmethod
    def zero(cls, bands: int, channels: int, texels: int) -> BlendSums:
        """Make empty sums for a number of bands, channels and texels."""
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
        """Add a view at k texels.

        Parameters
        ----------
        bands
            (h, w, channels) each, which sum to the picture, of one or three channels.
        rows
            (k,) texels, each once.
        pixel
            (k, 2) px in the picture. It is sampled bilinearly, and continued beyond its border by
            the border's values.
        ratio
            (k,) r / R of each texel.
        steepness
            k of B_k(r) = exp(-k r/R) / (1 + exp(-2 k r/R)), the weight in each band.
        """
        from hullrecon.native.compiled import native

        native.add_view(
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
