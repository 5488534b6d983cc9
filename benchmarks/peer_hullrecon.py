# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""hullrecon's own solver on a bundle: images and a gauge prior, nothing else."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

from benchmarks import bundle as bundles
from benchmarks.bundle import Bundle
from hullrecon import native

HELD = ("T_g_M", "T_s_ct", "T_ct_cb", "T_s_d", "navigation", "intrinsics_top", "intrinsics_bottom", "tray")
GAUGE = 1e6  # one over sigma: a micrometre, a microradian


def problem_of(bundle: Bundle) -> native.Problem:
    """Camera poses stand for vehicle poses: T_s_ct and the tray are nothing, and held."""
    camera = bundle.camera
    problem = native.Problem(pose=np.c_[bundle.pose, np.zeros(len(bundle.pose))], landmark=bundle.point, constant=HELD)
    problem.intrinsics_top, problem.intrinsics_bottom, problem.T_ct_cb = camera, camera, bundle.T_ct_cb
    nodes = [0]
    if bundle.stereo:
        problem.stereo_node, problem.stereo_landmark, problem.stereo_pixel = bundle.seen_from, bundle.seen, bundle.pixel
    else:
        problem.mono_node, problem.mono_landmark, problem.mono_pixel = bundle.seen_from, bundle.seen, bundle.pixel
        problem.mono_camera = np.zeros(len(bundle.seen), np.int32)
        nodes.append(bundle.baseline()[0])
    problem.prior_pose_node, problem.prior_pose = np.array(nodes, np.int32), bundle.pose[nodes]
    weights = [np.eye(6) * GAUGE, np.zeros((6, 6))]
    if not bundle.stereo:
        # The prior reads in its own axes: turn the far pose's into those of the first.
        _, axis, _ = bundle.baseline()
        turn = bundles.rotation(bundle.pose[0, 3:]).T @ bundles.rotation(bundle.pose[nodes[1], 3:])
        weights[1][0, :3] = GAUGE * turn[axis]
    problem.prior_pose_sqrt = np.array(weights[: len(nodes)])
    return problem


def main(path: Path, threads: int, iterations: int, tolerance: float, out: Path) -> None:
    bundles.keep_to(threads)
    bundle = bundles.load(path)
    options = native.Options(
        method="naive",
        threads=threads,
        max_iterations=iterations,
        function_tolerance=tolerance,
        huber_stereo=np.inf,
        huber_mono=np.inf,
    )
    problem, before = problem_of(bundle), time.process_time()
    result = native.solve(problem, options)
    cpu, peak, record = time.process_time() - before, bundles.peak_mb(), result.iterations
    pose, point = result.unknowns["pose"][:, :7], result.unknowns["landmark"]
    count = len(record.cost) - 1
    bundles.answer(
        out,
        iterations=count,
        solve_s=result.seconds["total"],
        iteration_s=(result.seconds["total"] - result.seconds["preprocess"]) / max(1, count),
        cpu_s=cpu,
        peak_rss_mb=peak,
        rms_px=bundles.rms_px(bundle, pose, point),
        message=result.message,
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4]), Path(sys.argv[5]))
