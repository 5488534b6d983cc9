# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The field's problem (O Table 4.1) by the three methods: python -m benchmarks.adjustment --size mono|stereo --json FILE

Each method is solved in a process of its own, so that its peak memory is its own. Prints a table, writes a list `methods`.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import resource
import sys
import time
from pathlib import Path
from typing import Any

METHODS = ("naive", "geva", "maxmix")


def solve_one(size: str, method: str, threads: int, iterations: int, tolerance: float) -> dict[str, Any]:
    """One method's row."""
    from benchmarks.problems import SIZES, make
    from hullrecon import native

    problem = make(SIZES[size])
    options = native.Options(method=method, threads=threads, max_iterations=iterations, function_tolerance=tolerance)
    began = time.perf_counter()
    result = native.solve(problem, options)
    total = time.perf_counter() - began
    record = result.iterations
    return {
        "method": method,
        "total_s": total,
        "iterations": len(record.cost) - 1,
        "final_cost": float(record.cost[-1]),
        "first_cost": float(record.cost[0]),
        "converged": result.converged,
        "on_surface": int((result.label == 1).sum()),
        "peak_rss_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
        "seconds_by_part": result.seconds,
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", choices=("small", "mono", "stereo"), default="mono")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--iterations", type=int, default=100)
    parser.add_argument("--tolerance", type=float, default=1e-6)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    rows = []
    for method in METHODS:
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            rows.append(pool.apply(solve_one, (args.size, method, args.threads, args.iterations, args.tolerance)))
        row = rows[-1]
        print(
            f"{args.size} {method:7s} {row['total_s']:8.2f} s  {row['iterations']:3d} iterations  cost {row['final_cost']:.6g}"
            f"  {row['peak_rss_mb']:.0f} MB"
        )
    if args.json:
        args.json.write_text(json.dumps({"size": args.size, "threads": args.threads, "methods": rows}, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
