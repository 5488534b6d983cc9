# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Convert OpenCV's rational model of a lens to plumb_bob, where that describes the lens as well.

A moderate lens is the same curve in both. The coefficients and the focal length that come closest
over the image follow by linear least squares, and the largest difference in pixels tells whether
they may stand for the lens.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from hullrecon.errors import InputError
from hullrecon.geometry.cameras import CameraModel
from hullrecon.typing import Array

# px, at the worst pixel, mostly in a corner: half the error of a calibration under water
LARGEST_DIFFERENCE_PX = 0.05
# both models are compared on rays up to this angle off the axis, on this many rings and spokes
WIDEST_DEG, RINGS, SPOKES = 80.0, 160, 72
PLUMB_BOB_COUNT, THIN_PRISM_COUNT = 5, 12  # coefficients, in OpenCV's order
Distort = Callable[[Array], Array]  # ideal to distorted coordinates x/z, y/z (n, 2)


def convert_rational(
    pinhole: CameraModel, coefficients: Sequence[float], where: str
) -> CameraModel:
    """Convert OpenCV's rational model with thin prisms to plumb_bob, the only model used here.

    The focal lengths change slightly, too. Raises InputError for a tilted sensor, and where
    plumb_bob does not describe the lens.

    Parameters
    ----------
    pinhole : camera without distortion
    coefficients : up to 14, in OpenCV's order
    where : the calibration's file, for errors
    """
    if any(coefficients[THIN_PRISM_COUNT:]):
        raise InputError(
            "the distortion has a tilted sensor, which is not modelled",
            where=where,
            remedy="calibrate with plumb_bob",
        )
    values = np.zeros(THIN_PRISM_COUNT)
    values[: min(len(coefficients), THIN_PRISM_COUNT)] = coefficients[:THIN_PRISM_COUNT]
    k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = values

    def distort(xy: Array) -> Array:
        """Distort ideal coordinates (n, 2) by the rational model."""
        x, y = xy.T
        r2 = x * x + y * y
        radial = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
        u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x) + r2 * (s1 + r2 * s2)
        v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y + r2 * (s3 + r2 * s4)
        return np.stack([u, v], axis=1)

    return _as_plumb_bob(pinhole, distort, where)


@np.errstate(all="ignore")  # coefficients of any size
def _as_plumb_bob(pinhole: CameraModel, distort: Distort, where: str) -> CameraModel:
    """Fit focal length and coefficients of plumb_bob to another lens model, by least squares.

    Raises InputError if the fit is off by more than LARGEST_DIFFERENCE_PX, or if the other model
    does not reach an edge of the image within WIDEST_DEG.
    """
    rays = _rays_in_image(pinhole, distort)
    worst = np.inf
    if len(rays):
        # f times plumb_bob is linear in f, f k1, f k2, f p1, f p2 and f k3: one column for each
        x, y = rays.T
        r2 = x * x + y * y
        basis = np.stack(
            [
                np.r_[x, y],
                np.r_[x * r2, y * r2],
                np.r_[x * r2**2, y * r2**2],
                np.r_[2 * x * y, r2 + 2 * y * y],
                np.r_[r2 + 2 * x * x, 2 * x * y],
                np.r_[x * r2**3, y * r2**3],
            ],
            axis=1,
        )
        bent = distort(rays)
        found = np.linalg.lstsq(basis, bent.T.ravel(), rcond=None)[0]
        scale, (k1, k2, p1, p2, k3) = float(found[0]), (found[1:] / found[0]).tolist()
        lens = replace(pinhole, fx=pinhole.fx * scale, fy=pinhole.fy * scale)
        fitted = replace(lens, k1=k1, k2=k2, p1=p1, p2=p2, k3=k3)
        differ = fitted.distort(rays) - pinhole.distort(bent)
        worst = float(np.linalg.norm(differ, axis=1).max())
    if not worst <= LARGEST_DIFFERENCE_PX:
        by = f"by up to {worst:.2g} px" if np.isfinite(worst) else "without bounds"
        raise InputError(
            f"it has more than five distortion coefficients, and plumb_bob differs {by} from them",
            where=where,
            remedy="calibrate with plumb_bob",
        )
    return fitted


def _rays_in_image(pinhole: CameraModel, distort: Distort) -> Array:
    """Spread rays x/z, y/z (n, 2) over the image, on which the two lens models are compared.

    Rays lie on spokes from the optical axis outward, each as far as the image's edge. Empty where
    along some spoke the model does not leave the image within WIDEST_DEG.
    """
    angle = np.radians(np.linspace(0, WIDEST_DEG, RINGS + 1)[1:])
    azimuth = np.linspace(0, 2 * np.pi, SPOKES, endpoint=False)
    spokes = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    rays = (np.tan(angle)[:, None, None] * spokes).reshape(-1, 2)
    pixels = pinhole.distort(distort(rays)).reshape(RINGS, SPOKES, 2)
    inside = ((pixels > -0.5) & (pixels < [pinhole.width - 0.5, pinhole.height - 0.5])).all(axis=2)
    # beyond the edge a polynomial may turn back into the image: such rays are not seen there
    inside = np.logical_and.accumulate(inside, axis=0)
    if inside[-1].any():
        return np.empty((0, 2))
    return np.asarray(rays.reshape(RINGS, SPOKES, 2)[inside])
