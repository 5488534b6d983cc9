# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""GTSAM's Levenberg-Marquardt (Ceres' defaults, multifrontal Cholesky) on the graph of
benchmarks.pose_graph, in the peers' environment: BetweenFactorPose3, and LocalOrientedPlane3Factor,
whose planes are held in an anchor as ours are. Its residual of a plane is a direction and a
distance; sigmas are ours, over the distance for the direction.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import gtsam  # type: ignore[import-not-found]
import gtsam_unstable  # type: ignore[import-not-found]
import numpy as np
from gtsam.symbol_shorthand import L, X  # type: ignore[import-not-found]

from benchmarks import bundle as bundles
from benchmarks.bundle import Array


def _pose3(seven: Array) -> Any:
    x, y, z, w = seven[3:7]
    return gtsam.Pose3(gtsam.Rot3.Quaternion(w, x, y, z), seven[:3])


def _plane3(pi: Array) -> Array:
    """Convert a plane to unit normal and d with n . x + d = 0."""
    distance = np.linalg.norm(pi)
    return np.r_[pi / distance, distance]


def _sigmas(root: Array) -> Any:
    """Make the noise model of a pose. GTSAM has the rotation first."""
    sigma = 1 / np.diagonal(root)
    return gtsam.noiseModel.Diagonal.Sigmas(np.r_[sigma[3:], sigma[:3]])


def graph_of(tables: Any) -> Any:
    graph = gtsam.NonlinearFactorGraph()
    pose, sigma = tables["priors.pose.value"][0], _sigmas(tables["priors.pose.sqrt_information"][0])
    graph.add(gtsam.PriorFactorPose3(X(0), _pose3(pose), sigma))
    noise = _sigmas(tables["links.sqrt_information"][0])
    ends = zip(
        tables["links.first"].tolist(),
        tables["links.second"].tolist(),
        tables["links.measured"],
        strict=True,
    )
    for first, second, measured in ends:
        graph.add(gtsam.BetweenFactorPose3(X(first), X(second), _pose3(measured), noise))
    anchor, of = tables["planes.anchor"].tolist(), tables["plane_sightings.plane"].tolist()
    sigma_m = 1 / tables["plane_sightings.sqrt_information"][0, 0, 0]
    for node, plane, pi in zip(
        tables["plane_sightings.node"].tolist(), of, tables["plane_sightings.measured"], strict=True
    ):
        away = np.linalg.norm(pi)
        sigma = gtsam.noiseModel.Diagonal.Sigmas(
            np.array([sigma_m / away, sigma_m / away, sigma_m])
        )
        seen = gtsam_unstable.LocalOrientedPlane3Factor(
            _plane3(pi), sigma, X(node), X(anchor[plane]), L(plane)
        )
        graph.add(seen)
    return graph


def main(path: Path, threads: int, out: Path) -> None:
    bundles.keep_to(threads)
    with np.load(path) as archive:
        tables = {name: archive[name] for name in archive.files}
    values = gtsam.Values()
    for k, pose in enumerate(tables["unknowns.pose"]):
        values.insert(X(k), _pose3(pose))
    for k, pi in enumerate(tables["unknowns.plane"]):
        values.insert(L(k), gtsam.OrientedPlane3(_plane3(pi)))
    graph = graph_of(tables)
    parameters = gtsam.LevenbergMarquardtParams.CeresDefaults()
    parameters.setRelativeErrorTol(1e-6)
    parameters.setMaxIterations(100)
    first = graph.error(values)
    began, cpu = time.perf_counter(), time.process_time()
    optimizer = gtsam.LevenbergMarquardtOptimizer(graph, values, parameters)
    found = optimizer.optimizeSafely()
    ended, cpu = time.perf_counter(), time.process_time() - cpu
    peak = bundles.peak_mb()
    place = np.array(
        [found.atPose3(X(k)).translation() for k in range(len(tables["unknowns.pose"]))]
    )
    bundles.answer(
        out,
        solve_s=ended - began,
        cpu_s=cpu,
        peak_rss_mb=peak,
        iterations=optimizer.iterations(),
        first_cost=first,
        final_cost=optimizer.error(),
        error_m=_rigid_rmse_m(place, tables["truth_position"]),
        version=gtsam.__version__ if hasattr(gtsam, "__version__") else "",
    )


def _rigid_rmse_m(points: Array, truth: Array) -> float:
    a, b = points - points.mean(0), truth - truth.mean(0)
    u, _, vt = np.linalg.svd(a.T @ b)
    turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    return float(np.sqrt(((a @ turn - b) ** 2).sum(1).mean()))


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[-1]))
