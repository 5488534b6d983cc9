# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Covariance functions that vanish beyond their length, so that their matrices are sparse."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy import sparse

from hullrecon.typing import Array

Form = Literal["product", "radial", "wendland"]


@dataclass(frozen=True)
class Kernel:
    """form; length (along, girth) m at which the covariance becomes zero; sigma m, of the field.

    product: the Melkumyan-Ramos function of each axis, multiplied: positive definite. radial: the
    same of the two-dimensional radius, as [Ozog2016 3.2.2.2] prints it: not positive definite in
    general. wendland: (1 - r)^4 (4 r + 1) of the radius.
    """

    form: Form
    length: tuple[float, float]
    sigma: float

    def matrix(self, a: Array, b: Array) -> sparse.csr_array:
        """Return covariances (n, m) between points (n, 2) and (m, 2) of the chart."""
        from scipy.spatial import cKDTree

        scale = np.array(self.length)
        left, right = np.asarray(a, float) / scale, np.asarray(b, float) / scale
        norm = np.inf if self.form == "product" else 2.0
        pairs = cKDTree(left).sparse_distance_matrix(
            cKDTree(right), 1.0, p=norm, output_type="ndarray"
        )
        row, column = pairs["i"], pairs["j"]
        value = self.sigma**2 * self.correlation(left[row] - right[column])
        return sparse.csr_array((value, (row, column)), shape=(len(left), len(right)))

    def correlation(self, gap: Array) -> Array:
        """Return correlations (k,) at gaps (k, 2) in units of the lengths."""
        if self.form == "product":
            return np.asarray(compact(np.abs(gap[:, 0])) * compact(np.abs(gap[:, 1])))
        radius = np.linalg.norm(gap, axis=1)
        return compact(radius) if self.form == "radial" else wendland(radius)


def compact(r: Array) -> Array:
    """Return the function of [MelkumyanRamos2009]: (2 + cos 2 pi r)/3 (1 - r) + sin(2 pi r)/(2 pi),
    zero from r = 1 on.
    """
    turn = 2 * np.pi * r
    return np.where(r < 1, (2 + np.cos(turn)) / 3 * (1 - r) + np.sin(turn) / (2 * np.pi), 0.0)


def wendland(r: Array) -> Array:
    """Return Wendland's C2 function [Wendland1995], positive definite in up to three dimensions."""
    return np.asarray(np.maximum(0.0, 1 - r) ** 4 * (4 * r + 1))
