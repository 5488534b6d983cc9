# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Directions of the hull's pose that its shape does not resolve, with a sentence for each."""

from __future__ import annotations

import numpy as np

from hullrecon.typing import Array

_DIRECTIONS = ("along the hull", "across the hull", "vertically")  # of the ship's axes
_ANGLES = ("heel", "trim", "heading")  # about them


def find_weak_directions(
    covariance_in_hull: Array,
    ship_axes: Array,
    least_sigma_m: float = 0.05,
    least_sigma_deg: float = 0.5,
) -> list[dict[str, object]]:
    """Find the directions of the hull's pose whose sigma is above a limit.

    They are eigenvectors of the covariance, positions before attitudes, each from the worst on.
    Empty where the hull's shape resolves all.

    Parameters
    ----------
    covariance_in_hull
        Covariance (6, 6) of translation and rotation in M's axes.
    ship_axes
        Rows (3, 3): unit vectors forward, port and up in M, whose axes a CAD file may order freely.
    least_sigma_m, least_sigma_deg
        The limits.

    Returns
    -------
    list
        Each with `kind` (position or attitude), `direction` (unit eigenvector in M), `sigma` (m or
        rad) along it, and a `sentence` with the sigma of the ship's axis that is assigned to it.
        Each axis is assigned to one eigenvector of a kind.
    """
    from scipy.optimize import linear_sum_assignment  # a quarter of a second, for every command

    found: list[dict[str, object]] = []
    for kind, block, least in (
        ("position", slice(0, 3), least_sigma_m),
        ("attitude", slice(3, 6), np.radians(least_sigma_deg)),
    ):
        covariance = ship_axes @ covariance_in_hull[block, block] @ ship_axes.T
        values, vectors = np.linalg.eigh(covariance)
        # Pair eigenvectors with the ship's axes so that they are as parallel as possible
        _, axes = linear_sum_assignment(np.abs(vectors.T), maximize=True)
        for k in np.argsort(values)[::-1]:
            sigma = float(np.sqrt(max(values[k], 0)))
            if sigma >= least:
                direction = vectors[:, k] @ ship_axes
                # Of the two signs, that with which the largest component is positive
                direction = direction * np.sign(direction[np.argmax(np.abs(direction))])
                found.append(
                    {
                        "kind": kind,
                        "direction": direction.tolist(),
                        "sigma": sigma,
                        "sentence": _sentence(
                            kind, axes[k], float(np.sqrt(covariance[axes[k], axes[k]]))
                        ),
                    }
                )
    return found


def _sentence(kind: str, axis: int, sigma: float) -> str:
    """Write the warning of a weak direction. axis: of the ship, 0 forward. sigma: m or rad."""
    if kind == "position":
        return (
            f"The position {_DIRECTIONS[axis]} is uncertain by {sigma:.2f} m (one sigma): the "
            "hull's form does not resolve it better."
        )
    return (
        f"The {_ANGLES[axis]} of the hull is uncertain by {np.degrees(sigma):.2f} degrees (one "
        "sigma)."
    )
