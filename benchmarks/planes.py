# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Planes of the hull without a camera: python -m benchmarks.planes FOLDER [--dives N] [--json FILE]

Simulates dives without a camera into FOLDER (kept for next time), four legs of 12 m half a metre
apart, heading drifts of 15 to 150 degrees an hour, takes their CAD model away, and solves each path
without planes and with them. Prints JSON: errors of the path after rigid alignment, whole and by
axis of g (across the hull, along it, down), the worst ratio of error to sigma. Of the last dive
FOLDER/distance_to_cad_model.png shows its DVL returns laid onto the CAD model [Ozog2016 Figs 2.22,
2.23].
"""

from __future__ import annotations

import json
import shutil
import statistics
import sys
from pathlib import Path

import numpy as np

from benchmarks.arguments import parser_for
from hullrecon.api.dive_run import run
from hullrecon.evaluation.deliverables import TimedPoses
from hullrecon.evaluation.trajectory import hull_from_start
from hullrecon.evaluation.truth import Truth, read_truth
from hullrecon.geometry.rigid_fit import fit_rigid
from hullrecon.records.links import LinkedPath
from hullrecon.steps.artifacts import IngestArtifact, LinksArtifact
from hullrecon.studies.methods.comparison import DeadReckoning
from hullrecon.studies.methods.variants import read_dead_reckoning
from hullrecon.studies.paths.path_figures import (
    ReturnsOnHull,
    distance_to_cad_model,
    lay_onto_cad_model,
)
from hullrecon.synthetic.options import spec_from
from hullrecon.synthetic.package import write_package
from hullrecon.typing import Ints

DRIFTS = tuple(range(15, 151, 15))  # deg/h
SETTLED = 20  # nodes from the start, where sigmas are nothing


def simulate(folder: Path, number: int) -> Path:
    """Simulate a dive with its CAD model unless it exists."""
    package = folder / f"dive{number}"
    if not (package / "truth").exists():
        spec = spec_from(
            name=package.name,
            seed=number,
            cameras="none",
            sonar=False,
            legs=4,
            leg_length_m=12.0,
            leg_spacing_m=0.5,
            heading_drift_deg_per_hour=float(DRIFTS[(number - 1) % len(DRIFTS)]),
        )
        write_package(package, spec)
    return package


def without_cad_model(package: Path) -> Path:
    """Copy the package without its CAD model unless that exists."""
    bare = package.with_name(f"{package.name}-bare")
    if not bare.exists():
        shutil.copytree(package, bare)
        whole = (bare / "dive.toml").read_text()
        (bare / "dive.toml").write_text(whole[: whole.index("[hull]")])
    return bare


def solve(package: Path, runs: Path, planes: bool) -> tuple[LinkedPath, DeadReckoning]:
    """Return the path of the step links, and what it started from."""
    name = "with" if planes else "without"
    dive = run(
        package, runs / name, last_step="links", overrides=[f"links.planes={str(planes).lower()}"]
    )
    return LinksArtifact(dive.workspace.artifact("links")).path, read_dead_reckoning(dive)


def score(path: LinkedPath, t_ns: Ints, truth: Truth) -> dict[str, float]:
    """Return the errors of a path (m), in whole and by axis, and its worst error over sigma, from
    where it begins.
    """
    track = TimedPoses(t_s=t_ns / 1e9, poses=path.path().poses)
    inside = (track.t_s >= truth.t_s[0]) & (track.t_s <= truth.t_s[-1])
    true_poses = hull_from_start(track, truth).inverse() @ truth.vehicle_at(track.t_s[inside])
    at, true = path.pose[inside, :3], true_poses.translation
    error = fit_rigid(at, true).apply(at) - true
    sigma = np.sqrt(np.einsum("nii->ni", path.covariance))[inside, :3]
    ratio = np.sqrt(np.mean(((at - true) / np.maximum(sigma, 1e-6))[SETTLED:] ** 2, axis=0))
    across, along, down = np.sqrt(np.mean(error**2, axis=0))
    whole = float(np.sqrt(np.mean(np.sum(error**2, axis=1))))
    return {
        "rigid_m": whole, "across_m": float(across), "along_m": float(along), "down_m": float(down),
        "error_over_sigma": float(ratio.max()),
    }  # fmt: skip


def main() -> int:
    """Print the figures of all dives; write the picture of the last."""
    parser = parser_for(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--dives", type=int, default=len(DRIFTS))
    parser.add_argument("--json", type=Path)
    chosen = parser.parse_args()
    chosen.folder.mkdir(parents=True, exist_ok=True)
    rows: dict[str, dict[str, dict[str, float]]] = {}
    on_hull: dict[str, ReturnsOnHull] = {}
    for number in range(1, chosen.dives + 1):
        package = simulate(chosen.folder, number)
        truth, bare = read_truth(package), without_cad_model(package)
        rows[package.name] = {}
        for planes, name in ((False, "without planes"), (True, "with planes")):
            path, start = solve(bare, chosen.folder / "runs", planes)
            rows[package.name][name] = score(path, start.trajectory.t_ns, truth)
            if number == chosen.dives:
                ingest = run(package, chosen.folder / "cad", last_step="ingest").workspace.artifact(
                    "ingest"
                )
                mesh = IngestArtifact(ingest).hull
                assert mesh is not None
                on_hull[name] = lay_onto_cad_model(path.path(), start, mesh, truth.global_from_hull)
    ratio = {
        name: row["with planes"]["rigid_m"] / row["without planes"]["rigid_m"]
        for name, row in rows.items()
    }
    text = json.dumps(
        {"dives": rows, "ratio": ratio, "median_ratio": statistics.median(ratio.values())}, indent=1
    )
    print(text)
    if chosen.json:
        chosen.json.write_text(text)
    figure = distance_to_cad_model(on_hull)
    (chosen.folder / f"{figure.name}.png").write_bytes(figure.png)
    (chosen.folder / f"{figure.name}.csv").write_text(figure.csv)
    print(figure.caption, file=sys.stderr)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
