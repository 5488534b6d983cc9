# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Zernike moments [Zernike1934], [Teague1980] of patches, in a basis orthonormal on the disc.

A patch is sampled on rings, Gauss-Legendre in the square of the radius and evenly in the angle.
Thus products of any two of the functions are integrated exactly, and a turn of the patch by a step
of the angle moves its samples round.
"""

from __future__ import annotations

from functools import cache
from math import factorial

import numpy as np
from numpy.typing import NDArray

from hullrecon.typing import Array, Floats32, Ints

ORDER = 12  # largest n: 48 moments without the mean
RINGS, ANGLES = 8, 48  # exact from ORDER / 2 + 1 rings and 2 ORDER + 1 angles


@cache
def disc_points() -> Array:
    """List the sample points (RINGS * ANGLES, 2) of the unit disc, ring by ring from inside."""
    radius, angle = np.sqrt(_rings()[0])[:, None], _angles()
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1).reshape(-1, 2)


@cache
def orders() -> Ints:
    """List n and m (k, 2) of the moments: n from 1 to ORDER, m >= 0 of the same parity.

    The mean (0, 0) is not among them.
    """
    return np.array([(n, m) for n in range(1, ORDER + 1) for m in range(n % 2, n + 1, 2)], np.int64)


@cache
def basis() -> NDArray[np.complex128]:
    """Evaluate the functions V_nm (k, RINGS * ANGLES) at the sample points.

    The integral of |V|^2 over the disc is 1.
    """
    radius, turn = np.sqrt(_rings()[0]), np.exp(1j * _angles())
    rows = [
        np.sqrt((n + 1) / np.pi) * np.outer(radial(n, m, radius), turn**m)
        for n, m in orders().tolist()
    ]
    return np.array(rows).reshape(len(rows), -1)


@cache
def weights() -> Array:
    """Weight the sample points (RINGS * ANGLES,) by the area for which each stands."""
    return np.repeat(_rings()[1] * np.pi / ANGLES, ANGLES)


def radial(n: int, m: int, radius: Array) -> Array:
    """Evaluate the radial polynomial R_nm at each radius."""
    half, less = (n + m) // 2, (n - m) // 2
    terms = [
        (-1) ** k
        * factorial(n - k)
        / (factorial(k) * factorial(half - k) * factorial(less - k))
        * radius ** (n - 2 * k)
        for k in range(less + 1)
    ]
    return np.asarray(np.sum(terms, axis=0), np.float64)


def zernike_moments(patches: Floats32) -> NDArray[np.complex128]:
    """Compute the moments A_nm (p, k) of patches (p, RINGS * ANGLES) sampled at the disc's points.

    A patch turned by an angle has the same moments times exp(-i m angle): their magnitudes stay.
    """
    return np.asarray(patches.astype(np.float64) @ (weights() * basis().conj()).T)


def zernike_magnitudes(patches: Floats32) -> Floats32:
    """Compute the magnitudes (p, k) of the moments. Those of m > 0 stand for -m too."""
    twice = np.where(orders()[:, 1] > 0, np.sqrt(2.0), 1.0)
    return np.asarray(np.abs(zernike_moments(patches)) * twice, np.float32)


def _rings() -> tuple[Array, Array]:
    """Compute squares of the radii and their weights (RINGS,), which sum to 1."""
    node, weight = np.polynomial.legendre.leggauss(RINGS)
    return np.asarray(0.5 * (node + 1), np.float64), np.asarray(0.5 * weight, np.float64)


def _angles() -> Array:
    return np.asarray(np.arange(ANGLES) * (2 * np.pi / ANGLES), np.float64)
