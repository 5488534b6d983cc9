# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Which submaps may overlap, and which of their landmarks are the same [Aulinas2011 3.3.4]."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.studies.association.methods import joint_compatibility, randomised_compatibility
from hullrecon.studies.association.point_sets import Association, PointSets
from hullrecon.studies.submaps.global_map import GlobalMap
from hullrecon.studies.submaps.models import place
from hullrecon.typing import Array

CONFIDENCE = 0.99
SEARCHED_WHOLE = 25  # points in the overlap up to which joint compatibility is searched through
MOST_TESTS = 3000

Place = tuple[int, Array]  # a map's frame, and its landmarks (n, 2) in it


def possible_loops(world: GlobalMap, maps: list[Place], newest: Place) -> list[int]:
    """Find the maps that may overlap the newest, the nearest first.

    The thesis says `by proximity at the global level`. Here: the circles around the landmarks
    touch within three standard deviations of the distance of their middles.
    """
    middle, radius = _circle(newest[1])
    found = []
    for number, (base, points) in enumerate(maps):
        other, other_radius = _circle(points)
        pose, jacobian = world.relative(base, newest[0])
        distance = float(np.linalg.norm(place(pose, middle[None])[0] - other))
        spread = jacobian[:2] @ world.covariance @ jacobian[:2].T
        if distance < radius + other_radius + 3 * np.sqrt(np.trace(spread)):
            found.append((distance, number))
    return [number for _, number in sorted(found)]


def _circle(points: Array) -> tuple[Array, float]:
    middle = points.mean(axis=0)
    return middle, float(np.linalg.norm(points - middle, axis=1).max())


def pair_maps(sets: PointSets, rng: np.random.Generator) -> Association:
    """Pair landmarks of two maps: jointly where the overlap is small, else at random."""
    compatible = sets.compatible(CONFIDENCE)
    firsts, seconds = (np.flatnonzero(compatible.any(axis=axis)) for axis in (1, 0))
    overlap = sets.part(firsts, seconds)
    if len(seconds) <= SEARCHED_WHOLE:
        found = joint_compatibility(overlap, CONFIDENCE, most_tests=MOST_TESTS)
    else:
        found = randomised_compatibility(overlap, rng, CONFIDENCE, good_share=0.5)
    pairs = tuple((int(firsts[i]), int(seconds[j])) for i, j in found.pairs)
    return replace(found, pairs=pairs)
