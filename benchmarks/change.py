# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Find what changed between two simulated dives of one hull: three objects added, one removed, one
grown by 3 cm.

    python -m benchmarks.change FOLDER --seeds 10

Each seed draws a hull with four structures and a patch of barnacles, and two dives of it whose
errors are drawn apart. Packages and runs stay in FOLDER; what is there is not made again. Prints
JSON: by seed what was found, missed and false, and the growth.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.arguments import parser_for
from hullrecon.api.change import RunComparison, diff
from hullrecon.api.dive_run import run
from hullrecon.geometry.poses import Poses, from_matrix
from hullrecon.records.change import HullChange, HullSurvey
from hullrecon.synthetic.options import spec_from
from hullrecon.synthetic.package import write_package

SMALLEST: dict[str, Any] = {
    "legs": 2,
    "leg_length_m": 4.0,
    "sonar": False,
    "structures": 4,
    "marks": 0,
    "image_width": 480,
    "image_height": 384,
    "views": 4.5,
}
CHANGES: dict[str, Any] = {"added": 3, "removed": 1, "grown_m": 0.03}
SECOND_SEED = 1000  # what is added to the seed of the first dive
NEAR_M = 0.2  # a change so near to a true one is that one
Truth = dict[str, list[tuple[np.ndarray, float]]]


def simulate(folder: Path, seed: int, options: dict[str, Any]) -> tuple[Path, Path]:
    """Simulate a hull's two dives unless their packages exist."""
    packages = []
    for part, drawn in (
        ("a", {"seed": seed}),
        ("b", {"seed": SECOND_SEED + seed, "hull_seed": seed, **CHANGES}),
    ):
        package = folder / "p" / f"s{seed}{part}"
        if not package.exists():
            write_package(package, spec_from(name=package.name, **options, **drawn))
        packages.append(package)
    return packages[0], packages[1]


def true_changes(first: Path, second: Path) -> Truth:
    """Return the true changes by status: centers in M and change of height, m."""
    before, after = (structures(package) for package in (first, second))
    out: Truth = {"new": [], "gone": [], "grown": []}
    for place, height in before:
        match = [h for p, h in after if np.linalg.norm(p - place) < 0.1]
        if not match:
            out["gone"].append((place, -height))
        elif abs(match[0] - height) > 1e-6:
            out["grown"].append((place, match[0] - height))
    out["new"] = [(p, h) for p, h in after if all(np.linalg.norm(p - q) >= 0.1 for q, _ in before)]
    return out


def structures(package: Path) -> list[tuple[np.ndarray, float]]:
    """Return center in M and height, m, of what stands on a package's hull or is sunken into
    it.
    """
    rows = json.loads((package / "truth" / "objects.json").read_text())["objects"]
    return [(np.array(row["center"]), row["height"]) for row in rows if not row["painted"]]


def score(change: HullChange, truth: Truth, placed: Poses) -> dict[str, Any]:
    """Match the changes found with the true ones.

    placed: from the true hull frame to that in which the first dive reports; they differ by the
    error of its hull pose.
    """
    found, missed, growth = 0, [], []
    left = list(change.changed())
    for status, rows in truth.items():
        for place, height in rows:
            there = placed.apply(place[None])[0]
            near = [
                row
                for row in left
                if row.status == status and np.linalg.norm(row.center - there) < NEAR_M
            ]
            if not near:
                missed.append(
                    {
                        "status": status,
                        "center": place.round(2).tolist(),
                        "change_m": round(height, 3),
                    }
                )
                continue
            found += 1
            left = [row for row in left if row is not near[0]]
            if status == "grown":
                growth.append([round(near[0].change, 4), round(near[0].change_sigma, 4)])
    false = [
        {
            "status": row.status,
            "center": row.center.round(2).tolist(),
            "change_m": round(row.change, 3),
        }
        for row in left
    ]
    false += [
        {"status": "surface moved", "change_m": round(move.move, 4), "area_m2": round(move.area, 2)}
        for move in change.moves
    ]
    return {"found": found, "missed": missed, "false": false, "grown_m": growth}


def reported_from_true(survey: HullSurvey, package: Path) -> Poses:
    """Return the transform from the true hull frame to that of a dive's report."""
    stated = json.loads((package / "truth" / "alignment.json").read_text())["T_g_M"]["matrix"]
    return survey.hull_pose.global_from_hull.inverse() @ from_matrix(np.array(stated))


def run_both(folder: Path, seed: int, options: dict[str, Any]) -> RunComparison:
    """Run a hull's two dives, unless they have been, and compare them."""
    packages = simulate(folder, seed, options)
    first, second = (
        run(package, folder / "runs", last_step="detect").workspace.root for package in packages
    )
    return diff(first, second)


def compare(folder: Path, seed: int, options: dict[str, Any]) -> dict[str, Any]:
    """Score the changes found between a hull's two dives."""
    result, packages = run_both(folder, seed, options), simulate(folder, seed, options)
    return {
        "seed": seed,
        **score(
            result.change,
            true_changes(*packages),
            reported_from_true(result.first.survey, packages[0]),
        ),
    }


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first-seed", type=int, default=1)
    args = parser.parse_args()
    rows = []
    for seed in range(args.first_seed, args.first_seed + args.seeds):
        rows.append(compare(args.folder, seed, SMALLEST))
        print(json.dumps(rows[-1]), file=sys.stderr, flush=True)
    whole = sum(row["found"] == 5 and not row["missed"] and not row["false"] for row in rows)
    print(
        json.dumps(
            {
                "changes": CHANGES,
                "seeds": len(rows),
                "all_found_and_nothing_else": whole,
                "by_seed": rows,
            },
            indent=1,
        )
    )
    return 0 if whole == len(rows) else 1


if __name__ == "__main__":
    sys.exit(main())
