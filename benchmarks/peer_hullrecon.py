# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""hullrecon's own solver on a bundle: images and a gauge prior, nothing else."""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks import bundle as bundles
from benchmarks.bundle import HELD, Bundle
from hullrecon import native

GAUGE = 1e6  # one over sigma: a micrometre, a microradian


def problem_of(bundle: Bundle) -> native.Problem:
    """Make the problem: camera poses take the place of vehicle poses.

    T_s_ct and the tray's angles are zero, and held.
    """
    unknowns = native.Unknowns(
        pose=np.c_[bundle.pose, np.zeros(len(bundle.pose))],
        landmark=bundle.point,
        T_ct_cb=bundle.top_from_bottom,
        intrinsics_top=bundle.camera,
        intrinsics_bottom=bundle.camera,
    )
    problem = native.Problem(
        unknowns=unknowns, constant=HELD, priors=native.Priors(pose=_gauge(bundle))
    )
    if bundle.stereo:
        return replace(
            problem,
            stereo=native.StereoTable(
                node=bundle.seen_from, landmark=bundle.seen, pixel=bundle.pixel
            ),
        )
    top = np.zeros(len(bundle.seen), np.int32)
    return replace(
        problem,
        mono=native.MonoTable(
            node=bundle.seen_from, landmark=bundle.seen, camera=top, pixel=bundle.pixel
        ),
    )


def _gauge(bundle: Bundle) -> native.PosePriors:
    """Make priors of the first pose and, with one camera, of the length of one baseline."""
    nodes, weights = [0], [np.eye(6) * GAUGE]
    if not bundle.stereo:
        far, axis, _ = bundle.baseline()
        # The prior reads in its own axes: turn the far pose's into those of the first.
        turn = bundles.rotation(bundle.pose[0, 3:]).T @ bundles.rotation(bundle.pose[far, 3:])
        nodes.append(far)
        weights.append(np.zeros((6, 6)))
        weights[1][0, :3] = GAUGE * turn[axis]
    return native.PosePriors(
        node=np.array(nodes, np.int32), value=bundle.pose[nodes], sqrt_information=np.array(weights)
    )


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
    pose, point = result.unknowns.pose[:, :7], result.unknowns.landmark
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
    main(
        Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4]), Path(sys.argv[5])
    )
