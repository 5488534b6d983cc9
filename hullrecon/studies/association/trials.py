# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which method finds which points of two fields are the same, when one is off by an offset."""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time

import numpy as np

from hullrecon.studies.association.methods import (
    CONFIDENCE,
    joint_compatibility,
    nearest_neighbours,
    randomised_compatibility,
)
from hullrecon.studies.association.point_sets import Association, Pair, PointSets
from hullrecon.typing import Array

NN, JCBB, RJC = "NN", "JCBB", "RJC"
SPACING_M = 1.0  # of the field, all else is relative to it
PLACE_SIGMA = 0.03  # of a point's place, in the spacing


@dataclass(frozen=True, kw_only=True)
class Field:
    """Two surveys of one field of points."""

    sets: PointSets
    true_pairs: frozenset[Pair]


def simulate_field(
    points: int,
    rng: np.random.Generator,
    dimension: int = 2,
    offset: float = 0.4,
    strangers: float = 0.0,
) -> Field:
    """Simulate an irregular field seen twice, the second time moved as a whole.

    Parameters
    ----------
    points
        Points that both surveys hold.
    rng
        Source of draws.
    dimension
        2 or 3.
    offset
        Length of the move, in the spacing of the field. Its sigma is taken to be as large.
    strangers
        Points of either survey that the other does not hold, as a share of those it does.
    """
    extra = round(strangers * points)
    places = _irregular(points + 2 * extra, dimension, rng)
    common, own, other = np.split(places, [points, points + extra])
    move = rng.standard_normal(dimension)
    move *= offset * SPACING_M / np.linalg.norm(move)
    order = rng.permutation(points + extra)
    first = np.concatenate([common, own])
    second = (np.concatenate([common, other]) + move)[order]
    size = (points + extra) * dimension
    noise = PLACE_SIGMA * rng.standard_normal((2, points + extra, dimension))
    shared = np.tile(
        np.eye(dimension) * (offset * SPACING_M) ** 2 / dimension, (points + extra,) * 2
    )
    sets = PointSets(
        first=first + noise[0],
        second=second + noise[1],
        first_covariance=PLACE_SIGMA**2 * np.eye(size),
        second_covariance=PLACE_SIGMA**2 * np.eye(size) + shared,
    )
    pairs = frozenset((int(o), j) for j, o in enumerate(order) if o < points)
    return Field(sets=sets, true_pairs=pairs)


def _irregular(count: int, dimension: int, rng: np.random.Generator) -> Array:
    """Draw points (count, d), a grid whose points are moved by up to 0.3 of its spacing."""
    side = int(np.ceil(count ** (1 / dimension)))
    grid = np.stack(np.meshgrid(*[np.arange(side)] * dimension), axis=-1).reshape(-1, dimension)
    chosen = rng.permutation(len(grid))[:count]
    return np.asarray(SPACING_M * (grid[chosen] + rng.uniform(-0.3, 0.3, (count, dimension))))


@dataclass(frozen=True, kw_only=True)
class Score:
    """A method over many fields."""

    recall: float  # share of the true pairs that it found
    complete: float  # share of the fields of which it found all
    pairs: int  # that it made
    false: float  # share of them that are not true
    tests: float  # joint tests a field
    cpu_s: float  # a field

    @property
    def false_pairs(self) -> int:
        """Pairs that are not true."""
        return round(self.false * self.pairs)


def score(fields: list[Field], method: str, seed: int = 0, confidence: float = CONFIDENCE) -> Score:
    """Run a method (NN, JCBB or RJC) on fields, and compare its pairs with the true ones.

    seed: of random draws. confidence: of the gates.
    """
    rng, start = np.random.default_rng(seed), process_time()
    found = [associate(field.sets, method, rng, confidence) for field in fields]
    cpu_s = process_time() - start
    right = [len(field.true_pairs & {*f.pairs}) for field, f in zip(fields, found, strict=True)]
    made = sum(len(f.pairs) for f in found)
    wanted = [len(field.true_pairs) for field in fields]
    return Score(
        recall=sum(right) / sum(wanted),
        complete=float(np.mean(np.equal(right, wanted))),
        pairs=made,
        false=1.0 - sum(right) / max(made, 1),
        tests=float(np.mean([f.tests for f in found])),
        cpu_s=cpu_s / len(fields),
    )


def associate(
    sets: PointSets, method: str, rng: np.random.Generator, confidence: float
) -> Association:
    """Pair points by the method NN, JCBB or RJC, with gates of this confidence."""
    if method == NN:
        return nearest_neighbours(sets, confidence)
    if method == JCBB:
        return joint_compatibility(sets, confidence)
    return randomised_compatibility(sets, rng, confidence)
