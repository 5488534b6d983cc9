# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Directions that the geometry does not resolve, with a sentence each for the report."""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array

_DIRECTIONS = ("along the hull", "across the hull", "vertically")  # of M's axes
_ANGLES = ("heel", "trim", "heading")  # about them
MAIN = 0.5  # of a unit direction, along each axis that its sentence names: there is always one


def find_weak_directions(
    covariance_in_hull: Array, least_sigma_m: float = 0.05, least_sigma_deg: float = 0.5
) -> list[dict[str, object]]:
    """Return eigenvectors of T_g_M's covariance (6, 6: translation and rotation in M's axes) beyond the given sigmas, worst
    first.

    Each: `kind` position or attitude, `direction` unit vector in M, `sigma` (m or rad) and a `sentence`.
    """
    found: list[dict[str, object]] = []
    for kind, block, least in (
        ("position", slice(0, 3), least_sigma_m),
        ("attitude", slice(3, 6), np.radians(least_sigma_deg)),
    ):
        values, vectors = np.linalg.eigh(covariance_in_hull[block, block])
        for k in np.argsort(values)[::-1]:
            sigma = float(np.sqrt(max(values[k], 0)))
            if sigma >= least:
                direction = vectors[:, k] * np.sign(vectors[np.argmax(np.abs(vectors[:, k])), k])
                found.append(
                    {
                        "kind": kind,
                        "direction": direction.tolist(),
                        "sigma": sigma,
                        "sentence": _sentence(kind, direction, sigma),
                    }
                )
    return found


def _sentence(kind: str, direction: Array, sigma: float) -> str:
    axes = np.flatnonzero(np.abs(direction) >= MAIN)
    opposed = len(np.unique(np.sign(direction[axes]))) > 1
    together = "" if len(axes) == 1 else ", against each other," if opposed else ", taken together,"
    if kind == "position":
        return (
            f"The position {' and '.join(_DIRECTIONS[k] for k in axes)}{together} is uncertain by {sigma:.2f} m (one sigma): "
            "the hull's form does not resolve it better."
        )
    return (
        f"The {' and '.join(_ANGLES[k] for k in axes)} of the hull{together} {'are' if together else 'is'} uncertain by "
        f"{np.degrees(sigma):.2f} degrees (one sigma)."
    )
