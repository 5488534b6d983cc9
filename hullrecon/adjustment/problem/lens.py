# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Smooth errors of the lens calibrations as unknowns (docs/methods.md 6).

A calibration is off by some tenths of a pixel, in the same way in every image. All landmarks share
this error, and it does not average out as their noise does. It is estimated as a displacement: the
pixel p shows what the calibrated camera model would show at p plus the displacement. A displacement
is a sum of products of Legendre polynomials along the image's axes, the modes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from hullrecon import native
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.rig import Rig
from hullrecon.typing import Array

# Least rms of a displacement: with exact lenses, the mean residual of features in 8 x 8 cells is
# 0.003 px (docs/methods.md 4)
LEAST_PX = 0.005
MOST_CALIBRATIONS = 3.0  # largest prior rms, as a multiple of the calibration's stated sigma
LENGTH = 1 / 4  # correlation length of a displacement, as a share of the image's width or height
# Degrees of the modes along u and v, in the order of the modes. Constant and linear modes are left
# out, as every calibration finds them.
_DEGREES = [
    (n, degree - n) for degree in range(2, native.LENS_DEGREE + 1) for n in range(degree + 1)
]
_BLOCKS = ("lens_top", "lens_bottom")


def displacement(pixels: Array, camera: CameraModel, lens: Array) -> Array:
    """Compute the displacement (n, 2) px of a lens at pixels (n, 2).

    Polynomials are summed along u first. That takes a fifth of the time of a sum over all modes.

    lens (2 LENS_MODES,): amplitudes of the modes in px, for u and then for v.
    """
    # Over the image -1 to 1. The first pixel's centre is at 0, its edge at -0.5
    at = (2 * pixels + 1) / [camera.width, camera.height] - 1
    degrees = native.LENS_DEGREE + 1
    amplitude = np.zeros((2, degrees, degrees))
    along_u, along_v = np.array(_DEGREES).T
    amplitude[:, along_u, along_v] = lens.reshape(2, native.LENS_MODES)
    # With this factor a Legendre polynomial has rms 1 over the image, so amplitudes are px rms
    rms = np.sqrt(2 * np.arange(degrees) + 1)
    u, v = _legendre_polynomials(at[:, 0]), _legendre_polynomials(at[:, 1])
    along_axes = [((rms[:, None] * by * rms).T @ u * v).sum(axis=0) for by in amplitude]
    return np.stack(along_axes, axis=1)


def _legendre_polynomials(at: Array) -> Array:
    """Compute the Legendre polynomials (LENS_DEGREE + 1, n) at positions (n,) in -1 to 1."""
    values = np.empty((native.LENS_DEGREE + 1, len(at)))
    values[0], values[1] = 1.0, at
    for k in range(2, len(values)):
        values[k] = ((2 * k - 1) * at * values[k - 1] - (k - 1) * values[k - 2]) / k
    return values


@cache
def mode_shares() -> Array:
    """Compute the prior sigma (2 LENS_MODES,) of each mode for a displacement of 1 px rms.

    The displacement is a Gaussian field of correlation length LENGTH, projected onto the modes.
    Finer parts of the field, and its constant and linear parts, are left out.
    """
    at, weight = np.polynomial.legendre.leggauss(40)
    # Integrals over -1 to 1, where the image is 2 wide, of the field's covariance along one axis
    by_mode = _unit_legendre(at) * weight[:, None] / 2
    field = np.exp(-0.5 * ((at[:, None] - at) / (2 * LENGTH)) ** 2)
    variance = np.diag(by_mode.T @ field @ by_mode)
    along_u, along_v = np.array(_DEGREES).T
    of_mode = variance[along_u] * variance[along_v]
    return np.tile(np.sqrt(of_mode / (2 * of_mode.sum())), 2)


def free_lenses(problem: native.Problem, m: Measurements, sigma_px: Array) -> native.Problem:
    """Make the displacements of the lenses unknowns of a problem.

    Pixels are read with the displacements of earlier rounds applied, so the unknown is what is
    missing to the true displacement. The prior is on the whole displacement, so its mean is minus
    what was applied.

    Parameters
    ----------
    problem, m
        A round's problem, and the measurements of which it was made.
    sigma_px
        (2,) prior rms of the displacement of top and bottom lens. 0: the lens is exact.
    """
    models = m.rig.camera_models
    if m.tracks is None or not any(sigma_px[camera.column] > 0 for camera in models):
        return problem
    size = {camera: [model.width, model.height] for camera, model in models.items()}
    table = native.LensTable(
        image_size=np.array([size.get(camera, [1, 1]) for camera in Camera], float),
        sigma_px=np.outer(np.where(sigma_px > 0, sigma_px, 1.0), mode_shares()),
        expected_px=-m.lenses,
    )
    held = [_BLOCKS[camera.column] for camera in models if sigma_px[camera.column] == 0]
    return replace(problem, lenses=table).hold(*held)


def apply_lenses(m: Measurements, problem: native.Problem, result: native.Result) -> Measurements:
    """Add the displacements of a solve to those by which pixels are moved when they are read."""
    if not len(problem.lenses.image_size) or m.tracks is None:
        return m
    found = np.stack([result.unknowns.lens_top, result.unknowns.lens_bottom])
    return replace(m, lens_steps=np.concatenate([m.lens_steps, found[None]]))


def estimate_lens_sigma(found: Array, calibration_sigma_px: Array) -> Array:
    """Estimate the rms (2,) px of the lenses' displacements, as prior of the next round.

    The images determine most modes to thousandths of a pixel, but a few modes look like a bend of
    the path. These keep to the prior, whose rms follows from the well determined modes.

    Parameters
    ----------
    found
        Estimated modes (2, 2 LENS_MODES) px of top and bottom lens.
    calibration_sigma_px
        (2,) stated sigma of the calibrations. The result is at most MOST_CALIBRATIONS times it, and
        0 where it is 0.
    """
    rms_px = np.sqrt(np.mean((found / mode_shares()) ** 2, axis=1))
    least, most = np.minimum(LEAST_PX, calibration_sigma_px), MOST_CALIBRATIONS
    return np.asarray(np.clip(rms_px, least, most * calibration_sigma_px))


def summarise_lenses(rig: Rig, found: Array, marginals: native.Covariance) -> dict[str, Any]:
    """Tabulate by camera: estimated displacement, its sigma and the calibration's sigma, px rms.

    found: estimated modes (2, 2 LENS_MODES) px of top and bottom lens. marginals: gives their
    covariances. Lenses that were held have no variance, and are left out.
    """
    out: dict[str, Any] = {}
    for camera in rig.camera_models:
        variance_px2 = float(np.trace(getattr(marginals, _BLOCKS[camera.column])))
        if variance_px2 > 0:
            out[camera.value] = {
                "displacement_px": float(np.linalg.norm(found[camera.column])),
                "sigma_px": float(np.sqrt(variance_px2)),
                "calibration_sigma_px": rig.priors.calibration_sigma_px[camera.column],
            }
    return out


def lens_warnings(lenses: Mapping[str, Mapping[str, float]]) -> list[str]:
    """Warn of each lens whose displacement is larger than the widest prior expects.

    lenses: as of `summarise_lenses`.
    """
    return [
        f"The images fit with the {camera} camera's lens {found['displacement_px']:.2f} ± "
        f"{found['sigma_px']:.2f} px (rms) off its calibration, "
        f"{found['displacement_px'] / found['calibration_sigma_px']:.0f} times "
        f"camera.{camera}.calibration_sigma_px: its calibration does not hold. What the images "
        "tell of that was taken out."
        for camera, found in lenses.items()
        if found["displacement_px"]
        > MOST_CALIBRATIONS * max(found["calibration_sigma_px"], found["sigma_px"])
    ]


def _unit_legendre(at: Array) -> Array:
    """Compute Legendre polynomials (n, LENS_DEGREE + 1) of unit rms at points (n,) in [-1, 1]."""
    degree = native.LENS_DEGREE
    values = np.polynomial.legendre.legvander(at, degree)
    return np.asarray(values * np.sqrt(2 * np.arange(degree + 1) + 1), float)
