# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run a dive, score it against its truth, and compare the methods: python
examples/compare_methods.py [PACKAGE] [RUNS]

PACKAGE is a simulated dive (default: the sample in the repository). Remove `compare_methods` to
stop after the chain: it solves the adjustment six times.
"""

from __future__ import annotations

import sys
from pathlib import Path

import hullrecon
from hullrecon import studies

DEMO = Path(__file__).resolve().parents[1] / "sample_data" / "demo"


def run_and_score(package: Path, runs: Path) -> dict[str, float]:
    """Run the chain and return three figures of the score, in metres."""
    result = hullrecon.run(package, runs)
    score = hullrecon.evaluate(result.workspace.root, package)
    return {
        "path, after rigid alignment": score["trajectory"]["rigid_rmse_m"],
        "hull as found, after alignment": score["as_found"]["aligned_rmse_m"],
        "worst height of an object": score["objects"]["height_error_worst_m"],
    }


def print_comparison(package: Path, runs: Path) -> None:
    """Print naive, geva and maxmix side by side."""
    comparison = studies.compare_methods(hullrecon.open_dive(package, runs))
    for line in (comparison.heads, *comparison.rows):
        print("  ".join(f"{cell:>18}" for cell in line))


def main(arguments: list[str]) -> None:
    package = Path(arguments[0]) if arguments else DEMO
    runs = Path(arguments[1]) if len(arguments) > 1 else Path("runs")
    for name, value in run_and_score(package, runs).items():
        print(f"{name}: {1000 * value:.1f} mm")
    print_comparison(package, runs)


if __name__ == "__main__":
    main(sys.argv[1:])
