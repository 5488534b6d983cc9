# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How long searching and comparing the features of two images takes: python -m
benchmarks.feature_pairs [--features N]

Random features, each sought in an ellipse in the other image: the pairs in the ellipses, the
distances of their descriptors and the best of each feature, in C++ and in plain NumPy, in turn.
Prints JSON: median of the CPU seconds that a pair of images takes either, and whether they found
the same.
"""

from __future__ import annotations

import json
import sys
import time

import numpy as np

from benchmarks.arguments import parser_for
from hullrecon import native
from hullrecon.typing import Array, Floats32, Ints
from hullrecon.vision.features.descriptors import sparse_distance
from hullrecon.vision.pairs.gating import in_ellipse

CHI2 = 9.21
SIGMA = 0.03  # ideal units, of where a feature is sought
CHUNK = 256  # pairs whose descriptors fit the cache together
Scene = tuple[Array, Array, Array, Floats32, Floats32]
Found = tuple[Ints, Floats32]


def scene(features: int) -> Scene:
    """Draw where features are sought (n, 2), its covariance, where features are (n, 2), and the
    descriptors of both.
    """
    rng = np.random.default_rng(1)
    size = np.array([1.0, 0.8])  # of an image in ideal coordinates
    points = rng.uniform(0, 1, (features, 2)) * size
    root = SIGMA * (np.eye(2) + 0.5 * rng.standard_normal((features, 2, 2)))
    descriptors = rng.random((features, 128), dtype=np.float32)
    descriptors /= np.linalg.norm(descriptors, axis=1, keepdims=True)
    order = rng.permutation(features)
    wanted = points[order] + SIGMA * rng.standard_normal((features, 2))
    return (
        wanted,
        root @ root.swapaxes(1, 2),
        points,
        descriptors[order] + np.float32(0.01),
        descriptors,
    )


def compiled(scene: Scene) -> Found:
    wanted, covariance, points, here, there = scene
    first, second = in_ellipse(wanted, covariance, points, CHI2)
    distance = sparse_distance(here, there, first, second)
    best, _ = native.best_and_next(first, distance)
    return second[best], distance[best]


def plain(scene: Scene) -> Found:
    wanted, covariance, points, here, there = scene
    half = np.sqrt(CHI2 * covariance[:, [0, 1], [0, 1]])
    order = np.argsort(points[:, 0])
    start = np.searchsorted(points[order, 0], wanted[:, 0] - half[:, 0], "left")
    count = np.searchsorted(points[order, 0], wanted[:, 0] + half[:, 0], "right") - start
    first = np.repeat(np.arange(len(wanted)), count)
    second = order[np.arange(len(first)) + np.repeat(start - (np.cumsum(count) - count), count)]
    near = np.abs(points[second, 1] - wanted[first, 1]) <= half[first, 1]
    first, second = first[near], second[near]
    gap, inverse = points[second] - wanted[first], np.linalg.inv(covariance)
    xx, xy, yy = (np.take(inverse[:, i, j], first) for i, j in ((0, 0), (0, 1), (1, 1)))
    near = (xx * gap[:, 0] + 2 * xy * gap[:, 1]) * gap[:, 0] + yy * gap[:, 1] ** 2 <= CHI2
    pair = np.sort(first[near] * len(points) + second[near])
    first, second = pair // len(points), pair % len(points)
    distance = np.empty(len(first), np.float32)
    for begin in range(0, len(first), CHUNK):
        rows = slice(begin, begin + CHUNK)
        apart = here[first[rows]] - there[second[rows]]
        distance[rows] = np.sqrt(np.einsum("ij,ij->i", apart, apart))
    ranked = np.lexsort([distance, first])
    best = ranked[np.flatnonzero(np.diff(first[ranked], prepend=-1))]
    return second[best], distance[best]


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("--features", type=int, default=2000, help="of an image")
    parser.add_argument("--repeat", type=int, default=15)
    args = parser.parse_args()
    data = scene(args.features)
    seconds: dict[str, list[float]] = {"compiled": [], "plain": []}
    same = []
    for _ in range(args.repeat):
        found = {}
        for name, search in (("compiled", compiled), ("plain", plain)):
            start = time.process_time()
            found[name] = search(data)
            seconds[name].append(time.process_time() - start)
        same.append(bool((found["compiled"][0] == found["plain"][0]).all()))
    median = {name: float(np.median(values)) for name, values in seconds.items()}
    pairs = len(in_ellipse(*data[:3], CHI2)[0])
    print(
        json.dumps(
            {"features": args.features, "pairs": pairs, "seconds": median, "same": all(same)},
            indent=1,
        )
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
