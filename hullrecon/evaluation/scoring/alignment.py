# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Rigid motions and similarities between point sets, and what is left after them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hullrecon.typing import Array


@dataclass(frozen=True)
class Motion:
    """p -> rotation p + shift; rotation (3, 3), shift (3,) m."""

    rotation: Array
    shift: Array

    def apply(self, points: Array) -> Array:
        return np.asarray(points @ self.rotation.T + self.shift)


STILL = Motion(np.eye(3), np.zeros(3))


def rigid(ours: Array, true: Array) -> Motion:
    """The motion that takes points (n, 3) onto others in the least-squares sense (Kabsch)."""
    a, b = ours.mean(axis=0), true.mean(axis=0)
    u, _, vt = np.linalg.svd((ours - a).T @ (true - b))
    mirror = np.array([1.0, 1.0, np.sign(np.linalg.det(vt.T @ u.T))])
    rotation = (vt.T * mirror) @ u.T
    return Motion(rotation, b - rotation @ a)


def scale_after(ours: Array, true: Array, motion: Motion) -> float:
    """The factor about the middle that fits best once `motion` is applied."""
    a, b = ours - ours.mean(axis=0), true - true.mean(axis=0)
    return float(np.sum((a @ motion.rotation.T) * b) / np.sum(a**2))


def rms(values: Array) -> float:
    """Root of the mean square; NaN of nothing."""
    return float(np.sqrt(np.mean(np.square(values)))) if np.size(values) else float("nan")


def rms_length(vectors: Array) -> float:
    return rms(np.linalg.norm(vectors, axis=1))
