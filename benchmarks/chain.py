# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Seconds and memory of each step, and how they grow: python -m benchmarks.chain [FOLDER]
[--sizes patch side hull] [--runs RUNS/<dive> ...] [--json FILE]

Simulates dives of some 250, 1,000 and 4,000 stereo pairs along a hull of 180 m into FOLDER (kept
for next time) and runs the chain on each, or reads finished runs. Figures are those of the steps'
manifests. The growth is the exponent of the number of stereo pairs, from the smallest dive to the
largest: 1 is in proportion.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from benchmarks.arguments import parser_for
from benchmarks.legs import hullrecon
from hullrecon.steps.artifacts import NavigateArtifact
from hullrecon.steps.chain import NAMES
from hullrecon.synthetic.options import spec_from
from hullrecon.synthetic.package import write_package

SIZES: dict[str, dict[str, Any]] = {
    "patch": {"legs": 4, "leg_length_m": 9.0},
    "side": {"legs": 6, "leg_length_m": 24.0},
    "hull": {"legs": 10, "leg_length_m": 60.0},
}
Figures = dict[str, float]


def run_size(size: str, folder: Path) -> Path:
    """Simulate a dive unless it exists, run the chain on it, and return the run's folder."""
    package, runs = folder / size, folder / "runs"
    if not package.exists():
        write_package(package, spec_from(name=size, length_m=180.0, **SIZES[size]))
    if hullrecon("run", "-q", str(package), "--runs", str(runs)):
        raise RuntimeError(f"the chain failed on {package}")
    return runs / size


def step_figures(run: Path) -> dict[str, Figures]:
    """Read seconds and peaks of each step of a run from their manifests."""
    rows = {}
    for name in NAMES:
        manifest = run / name / "manifest.json"
        if manifest.is_file():
            spent = json.loads(manifest.read_text(encoding="utf-8"))["run"]
            rows[name] = {
                "seconds": spent["seconds"],
                "cpu_seconds": spent["cpu_seconds"],  # of the main process
                "peak_mb": round(spent["peak_rss_bytes"] / 1e6),
                "workers_peak_mb": round(spent["workers_peak_rss_bytes"] / 1e6),  # of one worker
            }
    return rows


def dive_figures(run: Path) -> dict[str, Any]:
    """Collect the size of a dive and the figures of its steps."""
    track = NavigateArtifact(run / "navigate").trajectory.track()
    steps = step_figures(run)
    return {
        "pairs": int((track.image >= 0).any(axis=1).sum()),
        "dive_s": round(float(track.t_ns[-1] - track.t_ns[0]) / 1e9, 1),
        "seconds": round(sum(row["seconds"] for row in steps.values()), 1),
        "peak_mb": max(row["peak_mb"] for row in steps.values()),
        "steps": steps,
    }


def growth(dives: Mapping[str, dict[str, Any]]) -> dict[str, Figures]:
    """Compute exponents of seconds and peak by step, from the smallest dive to the largest."""
    small, large = (choose(dives.values(), key=lambda d: int(d["pairs"])) for choose in (min, max))
    times = math.log(large["pairs"] / small["pairs"]) if large["pairs"] > small["pairs"] else 0.0
    if not times:
        return {}
    return {
        name: {
            what: round(math.log(row[what] / small["steps"][name][what]) / times, 2)
            for what in ("seconds", "peak_mb")
        }
        for name, row in large["steps"].items()
        if name in small["steps"]
    }


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("--sizes", nargs="+", choices=SIZES, default=["patch", "side"])
    parser.add_argument("--runs", nargs="+", type=Path, default=[], help="finished runs instead")
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    if args.folder is None and not args.runs:
        parser.error("give a folder to simulate into, or --runs")
    runs = args.runs or [run_size(size, args.folder) for size in args.sizes]
    dives = {run.name: dive_figures(run) for run in runs}
    text = json.dumps({"dives": dives, "growth": growth(dives)}, indent=1)
    print(text)
    if args.json:
        args.json.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
