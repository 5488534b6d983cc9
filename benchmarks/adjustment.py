# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The field's problem [Ozog2016 Table 4.1] by the three methods: python -m benchmarks.adjustment
--size mono|stereo --json FILE

The problem is made once, in a process of its own; each solve runs in another that does nothing
else, so that its peak memory is the solver's. Prints a table, writes a list `methods` (with
--repeat: the run of median total time, and all runs under `runs`).

--same-iterations N   instead: naive and maxmix N iterations each, in turns, --repeat times; the
median of maxmix / naive
--growth              instead: the whole problem against one of a sixteenth of the poses, ten
iterations each; the ratio
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.arguments import keep, parser_for
from benchmarks.subprocess_runner import call, run

METHODS = ("naive", "geva", "maxmix")
GROWTH, GROWTH_ITERATIONS = 16, 10


def write_problem(size: str, share: int, out: Path) -> None:
    """Write a problem of a size, or of a share of its poses at the same density.

    It runs in the child process that `make` starts.
    """
    from benchmarks.problems import SIZES, simulate
    from benchmarks.subprocess_runner import save

    problem, truth = simulate(SIZES[size].part(share))
    save(out, problem, position=truth.nodes.translation, off_hull=truth.off_hull)


def in_turns(
    path: Path, methods: tuple[str, ...], repeat: int, options: dict[str, Any]
) -> list[dict[str, Any]]:
    """Time each method `repeat` times, in turns, so that other load affects all equally."""
    rows = []
    for _ in range(repeat):
        for method in methods:
            chosen = json.dumps(options | {"method": method})
            rows.append(run("benchmarks.solve_one", path, chosen, threads=options["threads"]))
            print(line(rows[-1]), flush=True)
    return rows


def line(row: dict[str, Any]) -> str:
    return (
        f"{row['method']:7s} {row['total_s']:8.2f} s  {row['cpu_s']:8.2f} s of CPU  "
        f"{row['iterations']:3d} iterations"
        f"  {row['iteration_s']:6.3f} s each  cost {row['final_cost']:.7g}  "
        f"{row['rigid_rmse_m'] * 1000:6.1f} mm"
        f"  {row['peak_rss_mb']:.0f} MB"
    )


def medians(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Select the run of median total time of each method."""
    by_method = {row["method"]: [r for r in rows if r["method"] == row["method"]] for row in rows}
    return [
        sorted(runs, key=lambda r: r["total_s"])[(len(runs) - 1) // 2]
        for runs in by_method.values()
    ]


def solve_all(path: Path, args: argparse.Namespace, options: dict[str, Any]) -> dict[str, Any]:
    rows = in_turns(path, METHODS, args.repeat, options)
    return {"methods": medians(rows)} | ({"runs": rows} if args.repeat > 1 else {})


def overhead(path: Path, args: argparse.Namespace, options: dict[str, Any]) -> dict[str, Any]:
    """Compute the ratio of maxmix to naive in time, for the same number of iterations.

    Of the whole and of an iteration, as medians over pairs of runs.
    """
    rows = in_turns(
        path, ("naive", "maxmix"), args.repeat, unstoppable(options, args.same_iterations)
    )
    pairs = list(zip(rows[::2], rows[1::2], strict=True))
    if any(row["iterations"] != args.same_iterations for row in rows):
        raise SystemExit(f"a solve ended before {args.same_iterations} iterations; ask for fewer")
    ratio = {
        key: statistics.median(m[key] / n[key] for n, m in pairs)
        for key in ("total_s", "cpu_s", "iteration_s")
    }
    print(
        ", ".join(f"{key} {value:.3f}" for key, value in ratio.items())
        + f": maxmix / naive, medians of {len(pairs)} pairs"
    )
    return {"same_iterations": args.same_iterations, "maxmix_over_naive": ratio, "runs": rows}


def unstoppable(options: dict[str, Any], iterations: int) -> dict[str, Any]:
    never = {"function_tolerance": 0.0, "gradient_tolerance": 0.0, "parameter_tolerance": 0.0}
    return options | never | {"max_iterations": iterations}


def growth(path: Path, args: argparse.Namespace, options: dict[str, Any]) -> dict[str, Any]:
    """Compute the ratio of seconds an iteration of the whole to those of a sixteenth."""
    part = path.with_name("part.npz")
    make(args.size, GROWTH, part)
    ratios, rows = [], []
    for _ in range(args.repeat):
        for at in (part, path):
            rows += in_turns(at, ("maxmix",), 1, unstoppable(options, GROWTH_ITERATIONS))
        ratios.append(rows[-1]["iteration_s"] / rows[-2]["iteration_s"])
    print(
        f"{GROWTH} times the poses: {statistics.median(ratios):.1f} times the time of an iteration"
    )
    return {"growth": GROWTH, "iteration_ratio": statistics.median(ratios), "runs": rows}


def make(size: str, share: int, path: Path) -> None:
    """Write the problem's file in another process."""
    call("benchmarks.adjustment", "--write", size, share, path)


def main() -> int:
    if sys.argv[1:2] == ["--write"]:
        write_problem(sys.argv[2], int(sys.argv[3]), Path(sys.argv[4]))
        return 0
    parser = parser_for(__doc__)
    parser.add_argument("--size", choices=("small", "small_mono", "mono", "stereo"), default="mono")
    parser.add_argument("--core", choices=("schur", "ceres"), default="schur")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--iterations", type=int, default=100)
    parser.add_argument("--tolerance", type=float, default=1e-6)
    parser.add_argument("--repeat", type=int, default=1)
    parser.add_argument("--same-iterations", type=int, metavar="N")
    parser.add_argument("--growth", action="store_true")
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    options = {"core": args.core, "threads": args.threads}
    options |= {"max_iterations": args.iterations, "function_tolerance": args.tolerance}
    measure = growth if args.growth else overhead if args.same_iterations else solve_all
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "problem.npz"
        make(args.size, 1, path)
        found = {"size": args.size, "core": args.core, "threads": args.threads} | measure(
            path, args, options
        )
    keep(found, args.json)
    return 0


if __name__ == "__main__":
    sys.exit(main())
