# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One method on one problem in this process, which does nothing else: python -m
benchmarks.solve_one PROBLEM OPTIONS OUT

PROBLEM: an .npz of benchmarks.subprocess_runner; OPTIONS: native.Options as JSON; OUT: the row as
JSON.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.bundle import Array, peak_mb
from benchmarks.subprocess_runner import load, load_truth
from hullrecon import native


def rigid_rmse_m(points: Array, truth: Array) -> float:
    """Compute the RMSE, m, of points (n, 3) after rigid alignment with the truth (n, 3)."""
    a, b = points - points.mean(0), truth - truth.mean(0)
    u, _, vt = np.linalg.svd(a.T @ b)
    turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    return float(np.sqrt(((a @ turn - b) ** 2).sum(1).mean()))


def row_of(
    problem: native.Problem, options: native.Options, truth: dict[str, Array]
) -> dict[str, Any]:
    """Solve, and collect the figures that the benchmark prints.

    Seconds an iteration leave out the preparation.
    """
    began, before = time.perf_counter(), time.process_time()
    result = native.solve(problem, options)
    total, cpu, peak = time.perf_counter() - began, time.process_time() - before, peak_mb()
    record = result.iterations
    iterations = len(record.cost) - 1
    on = result.label == 1
    return {
        "method": options.method,
        "total_s": total,
        "cpu_s": cpu,
        "iterations": iterations,
        "final_cost": float(record.cost[-1]),
        "peak_rss_mb": peak,
        "seconds_by_part": result.seconds,
        "iteration_s": (result.seconds["total"] - result.seconds["preprocess"])
        / max(1, iterations),
        "first_cost": float(record.cost[0]),
        "rejected": int((~record.accepted).sum()),
        "converged": result.converged,
        "message": result.message,
        "final_cost_by_factor": {
            name: float(cost[-1]) for name, cost in record.cost_by_factor.items()
        },
        "on_surface": int(on.sum()),
        "labels_wrong": float(np.mean(on == truth["off_hull"]))
        if options.method != "naive"
        else None,
        "start_rmse_m": rigid_rmse_m(problem.unknowns.pose[:, :3], truth["position"]),
        "rigid_rmse_m": rigid_rmse_m(result.unknowns.pose[:, :3], truth["position"]),
    }


def main(path: Path, options: str, out: Path) -> None:
    out.write_text(
        json.dumps(row_of(load(path), native.Options(**json.loads(options)), load_truth(path)))
    )


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3]))
