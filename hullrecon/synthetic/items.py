# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Items of a simulated hull: structures, recesses, painted marks and growth, and their heights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from hullrecon.typing import Array

Kind = Literal["cylinder", "dome", "box", "lump", "recess", "barnacles", "digits", "stripe", "ring"]
STRUCTURES: tuple[Kind, ...] = ("cylinder", "dome", "box", "lump", "recess")
MARKS: tuple[Kind, ...] = ("digits", "stripe", "ring")


@dataclass(frozen=True)
class Item:
    """Something added to the CAD model: a structure, a painted mark or a patch of barnacles."""

    kind: Kind
    along_m: float  # its middle in the chart
    girth_m: float
    height_m: float  # over the steel, negative for a recess, 0 for a mark
    size_m: tuple[float, float]  # full extent along and across
    turn_rad: float = 0.0  # in the chart

    def reach_m(self) -> float:
        """Compute the radius of a circle around it."""
        return 0.5 * float(np.hypot(*self.size_m))


def height_of(item: Item, along_m: Array, girth_m: Array) -> Array:
    """Compute the height (n,), m, of an item at chart points (n,); zero off it, and for paint."""
    u, v = local(item, along_m, girth_m)
    radius = np.hypot(u, v)
    if item.kind in ("cylinder", "recess"):
        return item.height_m * _wall((1 - radius) * 0.5 * item.size_m[0])
    if item.kind == "box":
        inside_m = [
            (1 - np.abs(x)) * 0.5 * size for x, size in zip((u, v), item.size_m, strict=True)
        ]
        return item.height_m * _wall(np.minimum(*inside_m))
    if item.kind == "dome":
        return np.asarray(item.height_m * np.sqrt(np.clip(1 - radius**2, 0, None)))
    if item.kind == "lump":
        return _lump(item, u, v, radius)
    if item.kind == "barnacles":
        return _barnacles(item, along_m, girth_m, radius)
    return np.zeros_like(radius)


def _wall(inside_m: Array, width_m: float = 0.008) -> Array:
    """Rise from 0 outside to 1 inside by a ramp that a 6 mm grid can hold without teeth."""
    return np.clip(0.5 + inside_m / width_m, 0, 1)


def local(item: Item, along_m: Array, girth_m: Array) -> tuple[Array, Array]:
    """Convert chart points to the item's own axes, 1 at its edge."""
    c, s = np.cos(item.turn_rad), np.sin(item.turn_rad)
    a, g = along_m - item.along_m, girth_m - item.girth_m
    return (c * a + s * g) / (0.5 * item.size_m[0]), (c * g - s * a) / (0.5 * item.size_m[1])


def _lump(item: Item, u: Array, v: Array, radius: Array) -> Array:
    """Compute the height of a bump with an uneven back, highest in the middle.

    u, v: places in the item's own axes, as of `local`. radius: of these, 1 at the edge.
    """
    back = (
        1 - 0.12 * (1 - np.cos(5 * u + item.along_m)) * radius - 0.08 * (1 - np.cos(7 * v)) * radius
    )
    return np.asarray(
        item.height_m
        * np.where(radius < 1, np.cos(0.5 * np.pi * np.minimum(radius, 1)) ** 1.2 * back, 0)
    )


def _barnacles(item: Item, along_m: Array, girth_m: Array, radius: Array) -> Array:
    """Compute the height of cones of one to two centimetres, none beyond radius 1.

    radius: (n,) of the chart points in the item's own axes, 1 at its edge.
    """
    # Drawn by the place of the patch: the same barnacles for whatever points are asked
    random = np.random.default_rng([round(1e4 * abs(item.along_m)), round(1e4 * abs(item.girth_m))])
    count = int(900 * item.size_m[0] * item.size_m[1])
    middles = random.uniform(-0.5, 0.5, (count, 2)) * item.size_m + [item.along_m, item.girth_m]
    width = random.uniform(0.008, 0.018, count)
    tall = random.uniform(0.3, 1.0, count) * item.height_m
    out = np.zeros_like(radius)
    for (a, g), w, h in zip(middles, width, tall, strict=True):
        near = np.flatnonzero((np.abs(along_m - a) < w) & (np.abs(girth_m - g) < w))
        cone = h * np.clip(1.6 * (1 - np.hypot(along_m[near] - a, girth_m[near] - g) / w), 0, 1)
        out[near] = np.maximum(out[near], cone)
    return np.where(radius < 1, out, 0.0)
