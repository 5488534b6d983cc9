# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How long the motion between two stereo nodes takes: python -m benchmarks.pair_motion [--features
N]

The normal equations of triangulated points seen by the other node, the adjustment's features with
their points eliminated, and the squared errors of a block of hypotheses, in C++ and in plain NumPy,
in turn. Prints JSON: median of the CPU seconds of each, and the largest difference between the two,
relative to the largest number.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.arguments import parser_for
from hullrecon import native
from hullrecon.geometry.poses import exp
from hullrecon.geometry.rotations import cross
from hullrecon.typing import Array, Mask

HYPOTHESES = 128
SIGMA = 0.3 / 650  # ideal units
MOTION = exp(np.array([[0.2, -0.05, 0.03, 0.02, -0.08, 0.04]])).matrix()[0]
BOTTOM_FROM_TOP = exp(np.array([[0.002, -0.1, 0.001, -0.003, 0.002, -0.004]])).matrix()[0]
BASELINE_M = 0.1
POINT_DAMPING = 1e-9


@dataclass(frozen=True, kw_only=True)
class Scene:
    """points (m, 3) in the first leading camera, and where the four cameras saw them (m, 8)."""

    points: Array
    seen: Array


def moved(transform: Array, points: Array) -> Array:
    return points @ transform[:3, :3].T + transform[:3, 3]


def scene(features: int) -> Scene:
    rng = np.random.default_rng(1)
    points = np.column_stack(
        [rng.uniform(-0.5, 0.5, (features, 2)), rng.uniform(1.2, 1.6, features)]
    )
    there = moved(MOTION, points)
    cameras = (points, moved(BOTTOM_FROM_TOP, points), there, moved(BOTTOM_FROM_TOP, there))
    seen = np.hstack([at[:, :2] / at[:, 2:] for at in cameras]) + SIGMA * rng.standard_normal(
        (features, 8)
    )
    # a tenth was missed by each camera
    seen[rng.random((features, 4)).repeat(2, axis=1) < 0.1] = np.nan
    return Scene(points=points, seen=seen)


def projected(camera: Array, points: Array) -> tuple[Array, Array]:
    """Return the image (m, 2) of points, NaN behind the camera, and its derivative (m, 2, 3) by
    them.
    """
    at = moved(camera, points)
    depth = np.where(at[:, 2] > 1e-6, at[:, 2], np.nan)
    image = at[:, :2] / depth[:, None]
    return image, (camera[:2, :3] - image[:, :, None] * camera[2, :3]) / depth[:, None, None]


def plain_squared(camera_from_points: Array, points: Array, xy: Array) -> Array:
    at = points @ camera_from_points[:, :3, :3].swapaxes(1, 2) + camera_from_points[:, None, :3, 3]
    ahead = at[..., 2] > 1e-6
    across, down = (at[..., k] / np.where(ahead, at[..., 2], 1.0) - xy[:, k] for k in range(2))
    return np.where(np.isnan(xy[:, 0]), 0.0, np.where(ahead, across * across + down * down, np.inf))


def plain_normal(
    motion: Array,
    points: Array,
    xy: Array,
    camera: Array,
    backward: bool,
    baseline_m: float,
    counts: Mask,
) -> tuple[Array, Array, float]:
    points, xy, turn = points[counts], xy[counts], motion[:3, :3]
    there = (points - motion[:3, 3]) @ turn if backward else moved(motion, points)
    image, by_moved = projected(camera, there)
    behind = ~np.isfinite(image[:, 0])
    image[behind], by_moved[behind] = 0, 0
    by_point = by_moved @ (turn.T if backward else turn)
    by_turn = cross(by_moved, there[:, None]) if backward else cross(points[:, None], by_point)
    jacobian = np.concatenate([-by_point if backward else by_moved, by_turn], axis=2)
    by_depth = np.einsum("nij,nj->ni", by_point, points * (np.sqrt(2) / baseline_m * points[:, 2:]))
    residual, jacobian = (
        plain_whitened((image - xy)[:, :, None], by_depth),
        plain_whitened(jacobian, by_depth),
    )
    flat, left = jacobian.reshape(-1, 6), residual.ravel()
    return flat.T @ flat, flat.T @ left, float(left @ left)


def plain_whitened(values: Array, u: Array) -> Array:
    """Return values (n, 2, k) times the inverse root of I + u u^T, u (n, 2)."""
    square = np.maximum((u * u).sum(axis=1), 1e-12)
    shrink = (1 - 1 / np.sqrt(1 + square)) / square
    along = np.einsum("ni,nik->nk", u, values) * shrink[:, None]
    return np.asarray(values - u[:, :, None] * along[:, None, :])


def plain_rows(
    motion: Array, bottom_from_top: Array, field: float, points: Array, seen: Array
) -> native.StereoRows:
    count, there, same = len(points), moved(motion, points), np.eye(4)
    residual, by_point = np.empty((count, 4, 2)), np.empty((count, 4, 2, 3))
    by_motion, by_calibration = np.zeros((count, 4, 2, 6)), np.zeros((count, 4, 2, 12))
    for k, (at, camera) in enumerate(
        [(points, same), (points, bottom_from_top), (there, same), (there, bottom_from_top)]
    ):
        image, by_lead = projected(camera, at)
        residual[:, k] = image - seen[:, 2 * k : 2 * k + 2]
        by_point[:, k] = by_lead if k < 2 else by_lead @ motion[:3, :3]
        if k >= 2:
            by_motion[:, k] = np.concatenate(
                [by_lead, cross(points[:, None], by_point[:, k])], axis=2
            )
        if k % 2:
            by_calibration[:, k] = plain_calibration(
                camera, at, by_lead, seen[:, 2 * k - 2 : 2 * k] / field
            )
    hidden = ~np.isfinite(residual)
    for values in (residual, by_point, by_motion, by_calibration):
        values[hidden] = 0
    return native.StereoRows(
        residual=residual.reshape(count, 8),
        by_point=by_point.reshape(count, 8, 3),
        by_motion=by_motion.reshape(count, 8, 6),
        by_calibration=by_calibration.reshape(count, 8, 12),
    )


def plain_calibration(bottom_from_top: Array, at: Array, by_lead: Array, place: Array) -> Array:
    """Return (m, 2, 12) of one node's bottom camera. at (m, 3): the points in its leading one;
    place (m, 2): there, in units of the field.
    """
    along = np.einsum("mij,mj->mi", by_lead, at)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    x, y = place.T
    shape = np.stack([np.ones(len(x)), x, y, x * x, x * y, y * y], axis=1)
    by_turn = cross(by_lead, (at + bottom_from_top[:3, :3].T @ bottom_from_top[:3, 3])[:, None])
    return np.concatenate([-by_lead, by_turn, along[:, :, None] * shape[:, None]], axis=2)


def plain_reduced(
    motion: Array, bottom_from_top: Array, points: Array, seen: Array
) -> native.ReducedFeatures:
    rows = plain_rows(motion, bottom_from_top, 1.0, points, seen)
    own = rows.by_point.swapaxes(1, 2) @ rows.by_point
    trace = np.trace(own, axis1=1, axis2=2)
    damping = POINT_DAMPING * np.where(trace > 0, trace, 1.0)
    inverse = np.asarray(np.linalg.inv(own + damping[:, None, None] * np.eye(3)), float)
    gradient = np.einsum("mri,mr->mi", rows.by_point, rows.residual)
    turned = rows.by_motion.swapaxes(1, 2)
    of_motion = turned @ rows.by_point
    carried = of_motion @ inverse
    return native.ReducedFeatures(
        information=turned @ rows.by_motion - carried @ of_motion.swapaxes(1, 2),
        gradient=np.einsum("mri,mr->mi", rows.by_motion, rows.residual)
        - np.einsum("mij,mj->mi", carried, gradient),
        cost=(rows.residual**2).sum(axis=1)
        - np.einsum("mi,mij,mj->m", gradient, inverse, gradient),
        freedom=(rows.by_point != 0).any(axis=2).sum(axis=1) - 3,
        point_inverse=inverse,
        point_gradient=gradient,
        point_by_motion=of_motion,
    )


def compared(data: Scene) -> dict[str, tuple[Callable[[], list[Array]], Callable[[], list[Array]]]]:
    """Return the functions to time by name, in C++ and in plain NumPy."""
    xy = data.seen[:, 4:6]
    counts = np.isfinite(xy[:, 0])
    steps = 0.02 * np.random.default_rng(2).standard_normal((HYPOTHESES, 6))
    hypotheses = MOTION @ exp(steps).matrix()
    normal = MOTION, data.points, xy, np.eye(4), False, BASELINE_M, counts
    reduced = MOTION, BOTTOM_FROM_TOP, data.points, data.seen
    rows = MOTION, BOTTOM_FROM_TOP, 0.5, data.points, data.seen
    return {
        "squared_errors": (
            lambda: [native.squared_reprojections(hypotheses, data.points, xy)],
            lambda: [plain_squared(hypotheses, data.points, xy)],
        ),
        "normal": (
            lambda: [np.asarray(v) for v in native.normal_of_reprojections(*normal)],
            lambda: [np.asarray(v) for v in plain_normal(*normal)],
        ),
        "reduced": (
            lambda: list(vars(native.reduce_stereo(*reduced)).values()),
            lambda: list(vars(plain_reduced(*reduced)).values()),
        ),
        "rows": (
            lambda: list(vars(native.linearise_stereo(*rows)).values()),
            lambda: list(vars(plain_rows(*rows)).values()),
        ),
    }


def difference(found: list[Array], plain: list[Array]) -> float:
    """Return the largest difference, relative to the largest number of its array."""
    return max(
        float(np.abs(a - b).max() / max(np.abs(b).max(), 1e-300))
        for a, b in zip(found, plain, strict=True)
    )


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("--features", type=int, default=500, help="that both nodes have")
    parser.add_argument("--repeat", type=int, default=50)
    args = parser.parse_args()
    out = {}
    for name, ways in compared(scene(args.features)).items():
        seconds: tuple[list[float], list[float]] = ([], [])
        found: list[list[Array]] = [[], []]
        for _ in range(args.repeat):
            for k, way in enumerate(ways):
                start = time.process_time()
                found[k] = way()
                seconds[k].append(time.process_time() - start)
        compiled, plain = (float(np.median(s)) for s in seconds)
        out[name] = {"compiled_s": compiled, "plain_s": plain, "difference": difference(*found)}
    print(json.dumps({"features": args.features, **out}, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
