# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""GTSAM's Levenberg-Marquardt (Ceres' defaults, multifrontal Cholesky, COLAMD) on a bundle.

A pair is two projection factors on one pose, the bottom camera as `body_P_sensor`: the same four
rows as everywhere else. With `--stereo-factor` it is GTSAM's own GenericStereoFactor3D instead, in
axes whose x runs along the baseline: three rows a pair, because the coordinate across the baseline
is given once (the mean of both, sigma 1/sqrt 2).
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import gtsam  # type: ignore[import-not-found]
import numpy as np
from gtsam.symbol_shorthand import L, X  # type: ignore[import-not-found]

from benchmarks import bundle as bundles
from benchmarks.bundle import Array, Bundle


def _pose3(seven: Array) -> Any:
    x, y, z, w = seven[3:]
    return gtsam.Pose3(gtsam.Rot3.Quaternion(w, x, y, z), seven[:3])


def graph_of(bundle: Bundle, stereo_factor: bool) -> Any:
    graph = gtsam.NonlinearFactorGraph()
    graph.add(
        gtsam.PriorFactorPose3(
            X(0), _pose3(bundle.pose[0]), gtsam.noiseModel.Isotropic.Sigma(6, 1e-6)
        )
    )
    if not bundle.stereo:
        _hold_scale(graph, bundle)
    if stereo_factor:
        _add_pairs(graph, bundle)
        return graph
    fx, fy, cx, cy, *distortion, k3 = bundle.camera
    camera, factor = gtsam.Cal3_S2(fx, fy, 0.0, cx, cy), gtsam.GenericProjectionFactorCal3_S2
    if any(distortion):
        camera, factor = (
            gtsam.Cal3DS2(fx, fy, 0.0, cx, cy, *distortion),
            gtsam.GenericProjectionFactorCal3DS2,
        )
    if k3:
        raise ValueError("GTSAM's Cal3DS2 has no k3")
    bottom, noise = _pose3(bundle.top_from_bottom), gtsam.noiseModel.Isotropic.Sigma(2, 1.0)
    for pixel, pose, point in zip(
        bundle.pixel, bundle.seen_from.tolist(), bundle.seen.tolist(), strict=True
    ):
        graph.add(factor(pixel[:2], noise, X(pose), L(point), camera))
        if bundle.stereo:
            graph.add(factor(pixel[2:], noise, X(pose), L(point), camera, bottom))
    return graph


def _hold_scale(graph: Any, bundle: Bundle) -> None:
    """Hold one coordinate of the far pose in the axes of the first.

    A prior of GTSAM is in the axes of its own pose, so the coordinate is turned.
    """
    far, axis, _ = bundle.baseline()
    offset = bundles.rotation(bundle.pose[0, 3:])[:, axis]
    in_far = bundles.rotation(bundle.pose[far, 3:]).T @ offset
    rows = np.zeros((6, 6))
    rows[3, 3:] = 1e6 * in_far  # GTSAM has the rotation first
    rows += 1e-9 * np.eye(6)  # its square root must be regular
    noise = gtsam.noiseModel.Gaussian.SqrtInformation(rows)
    graph.add(gtsam.PriorFactorPose3(X(far), _pose3(bundle.pose[far]), noise))


# x of the stereo factor's camera runs along our y (the baseline), its y against our x.
_TURNED = np.array([0.0, 0.0, 0.0, 0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)])


def _add_pairs(graph: Any, bundle: Bundle) -> None:
    fx, fy, cx, cy = bundle.camera[:4]
    camera = gtsam.Cal3_S2Stereo(fy, fx, 0.0, cy, -cx, float(bundle.top_from_bottom[1]))
    noise = gtsam.noiseModel.Diagonal.Sigmas(np.array([1.0, 1.0, np.sqrt(0.5)]))
    turned = _pose3(_TURNED)
    for pixel, pose, point in zip(
        bundle.pixel, bundle.seen_from.tolist(), bundle.seen.tolist(), strict=True
    ):
        seen = gtsam.StereoPoint2(pixel[1], pixel[3], -0.5 * (pixel[0] + pixel[2]))
        graph.add(gtsam.GenericStereoFactor3D(seen, noise, X(pose), L(point), camera, turned))


def main(
    path: Path, threads: int, iterations: int, tolerance: float, out: Path, stereo_factor: bool
) -> None:
    bundles.keep_to(threads)
    bundle = bundles.load(path)
    values = gtsam.Values()
    for k, pose in enumerate(bundle.pose):
        values.insert(X(k), _pose3(pose))
    for k, point in enumerate(bundle.point):
        values.insert(L(k), point)
    parameters = gtsam.LevenbergMarquardtParams.CeresDefaults()
    parameters.setRelativeErrorTol(tolerance)
    parameters.setMaxIterations(iterations)
    graph = graph_of(bundle, stereo_factor)
    began, before = time.perf_counter(), time.process_time()
    optimizer = gtsam.LevenbergMarquardtOptimizer(graph, values, parameters)
    ordered = time.perf_counter()
    found = optimizer.optimizeSafely()
    ended, cpu = time.perf_counter(), time.process_time() - before
    peak, count = bundles.peak_mb(), optimizer.iterations()
    poses = [found.atPose3(X(k)) for k in range(len(bundle.pose))]
    turns = [p.rotation().toQuaternion() for p in poses]
    pose = np.array(
        [
            np.r_[p.translation(), q.x(), q.y(), q.z(), q.w()]
            for p, q in zip(poses, turns, strict=True)
        ]
    )
    point = np.array([found.atPoint3(L(k)) for k in range(len(bundle.point))])
    bundles.answer(
        out,
        iterations=count,
        solve_s=ended - began,
        iteration_s=(ended - ordered) / max(1, count),
        cpu_s=cpu,
        peak_rss_mb=peak,
        rms_px=bundles.rms_px(bundle, pose, point),
        message=f"error {optimizer.error():.6g}",
    )


if __name__ == "__main__":
    main(
        Path(sys.argv[1]),
        int(sys.argv[2]),
        int(sys.argv[3]),
        float(sys.argv[4]),
        Path(sys.argv[-1]),
        "--stereo-factor" in sys.argv,
    )
