# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Memory and time of a long dive's last round by parts: python -m benchmarks.partition --json FILE

Synthetic tracks on a ship's side at a real density: legs 0.25 m apart, some seven views a landmark
by both cameras, lenses free, started some millimetres off. No images are rendered. Each number of
parts runs in a process of its own: `solver_mb` is the peak beyond the problem that it was given,
`peak_mb` of the whole process. Poses and sigmas are compared with those of one part.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.arguments import keep, parser_for
from benchmarks.problems import NOISE_PX, Truth, project, simulate, within
from benchmarks.subprocess_runner import call, load, run, save
from benchmarks.survey import CAMERA, STEP_M, TRAY_FROM_TOP, Size, tracks
from hullrecon import native
from hullrecon.adjustment.partition import join
from hullrecon.adjustment.partition.plan import plan_along
from hullrecon.adjustment.problem.lens import mode_shares
from hullrecon.typing import Array, Ints

REACH_M = 0.45  # of what a pose sees from where it looks: some 35 poses share landmarks
AT_A_TIME = 250_000  # landmarks whose views are chosen
START_M, START_RAD, LANDMARK_M = 0.005, 0.001, 0.01  # sigmas of the start
LENS_PX = 0.1


def make(poses: int, landmarks: int, legs: int, views: float, seed: int = 0) -> native.Problem:
    """Make a problem in which each landmark has about so many views."""
    size = Size(poses, poses, landmarks, stereo=True, legs=legs)
    problem, truth = simulate(size, seed)
    rng = np.random.default_rng(seed + 1)
    node, landmark = views_of(size, truth, views, rng)
    pixel = pixels_of(truth, node, landmark) + NOISE_PX * rng.standard_normal((len(node), 4))
    start = truth.nodes.translation + START_M * rng.standard_normal((poses, 3))
    pose = np.hstack([start, truth.nodes.quaternion, truth.tray[:, None]])
    pose[:, 3:6] += 0.5 * START_RAD * rng.standard_normal((poses, 3))
    pose[:, 3:7] /= np.linalg.norm(pose[:, 3:7], axis=1, keepdims=True)
    unknowns = replace(
        problem.unknowns,
        pose=pose,
        landmark=truth.landmark + LANDMARK_M * rng.standard_normal(truth.landmark.shape),
    )
    width = 2 * native.LENS_MODES
    lenses = native.LensTable(
        image_size=np.tile([float(CAMERA.width), float(CAMERA.height)], (2, 1)),
        sigma_px=np.tile(LENS_PX * mode_shares(), (2, 1)),
        expected_px=np.zeros((2, width)),
    )
    stereo = native.StereoTable(
        node=node.astype(np.int32), landmark=landmark.astype(np.int32), pixel=pixel
    )
    return replace(problem, unknowns=unknowns, stereo=stereo, lenses=lenses)


def views_of(size: Size, truth: Truth, views: float, rng: np.random.Generator) -> tuple[Ints, Ints]:
    """Choose who sees what, (m,) nodes and landmarks, of all views that there are."""
    tree = cKDTree(np.stack(tracks(size), axis=1))
    in_hull = truth.global_from_hull.inverse().apply(truth.landmark)
    nodes, landmarks = [], []
    for first in range(0, size.landmarks, AT_A_TIME):
        near = tree.query_ball_point(in_hull[first : first + AT_A_TIME, [0, 2]], REACH_M)
        landmark = first + np.repeat(np.arange(len(near)), [len(k) for k in near])
        node = np.concatenate([np.asarray(k, np.int64) for k in near])
        whole = within(pixels_of(truth, node, landmark))
        node, landmark = node[whole], landmark[whole]
        kept = rng.random(len(node)) < views * len(near) / max(1, len(node))
        twice = np.bincount(landmark[kept] - first, minlength=len(near))[landmark - first] < 2
        kept |= twice
        nodes.append(node[kept])
        landmarks.append(landmark[kept])
    return np.concatenate(nodes), np.concatenate(landmarks)


def pixels_of(truth: Truth, node: Ints, landmark: Ints) -> Array:
    return project(
        truth.nodes[node], truth.tray[node], truth.landmark[landmark], TRAY_FROM_TOP, stereo=True
    )


def status_mb(name: str) -> float:
    """Read a figure of this process in MB: VmRSS, or VmHWM, its peak."""
    text = Path("/proc/self/status").read_text(encoding="utf-8")
    return float(text.split(f"{name}:")[1].split()[0]) * 1024 / 1e6


def measure(problem: native.Problem, parts: int, iterations: int, threads: int) -> dict[str, Any]:
    """Solve some iterations and compute the marginals in so many parts."""
    options = native.Options(threads=threads, max_iterations=iterations, initial_radius=1e8)
    centred = problem.unknowns.pose[:, :3] - problem.unknowns.pose[:, :3].mean(axis=0)
    along = centred @ np.linalg.svd(centred, full_matrices=False)[2][0]
    plan = plan_along(problem, along, "path", parts)
    row: dict[str, Any] = {"parts": plan.parts, "predicted_mb": float(plan.predicted_mb.max())}
    given_mb = status_mb("VmRSS")
    row |= {"given_mb": given_mb}
    for name, work in (
        ("solve", lambda: join.solve(problem, plan, options)),
        ("covariance", lambda: join.covariance(problem, plan, options)),
    ):
        Path("/proc/self/clear_refs").write_text("5", encoding="utf-8")  # the peak begins anew
        wall, cpu = time.perf_counter(), time.process_time()
        found = work()
        row[name] = {
            "wall_s": time.perf_counter() - wall,
            "cpu_s": time.process_time() - cpu,
            "solver_mb": status_mb("VmHWM") - given_mb,
            "peak_mb": status_mb("VmHWM"),
        }
        if isinstance(found, native.Result):
            row["cost"] = found.iterations.cost.tolist()
            row["pose"] = found.unknowns.pose[:, :3].tolist()
        else:
            row["sigma"] = np.sqrt(np.diagonal(found.pose, axis1=1, axis2=2)).tolist()
        del found
    return row


def compare(row: dict[str, Any], one: dict[str, Any]) -> dict[str, Any]:
    """Replace poses and sigmas by how far they are from those of one part."""
    apart = {name: np.abs(np.array(row[name]) - np.array(one[name])) for name in ("pose", "sigma")}
    sigma: Array = np.array(one["sigma"])
    share = apart["sigma"] / np.where(sigma > 0, sigma, 1)
    return {
        **{name: value for name, value in row.items() if name not in apart},
        "pose_apart_m": float(apart["pose"].max()),
        "sigma_apart": float(share.max()),
        "cost_apart": float(np.abs(np.array(row["cost"]) / np.array(one["cost"]) - 1).max()),
    }


def line(row: dict[str, Any]) -> str:
    """Format a row of the table."""
    cells = [f"{row['parts']:2d} parts"]
    cells += [
        f"{name} {row[name]['cpu_s']:.1f} s CPU, +{row[name]['solver_mb']:.0f} MB"
        for name in ("solve", "covariance")
    ]
    return "  ".join([*cells, f"predicted {row['predicted_mb']:.0f} MB"])


def main() -> int:
    """Measure each number of parts, or do the work of a child."""
    if sys.argv[1:2] == ["--make"]:
        out, poses, landmarks, legs, views = sys.argv[2:]
        save(Path(out), make(int(poses), int(landmarks), int(legs), float(views)))
        return 0
    if sys.argv[1:2] == ["--measure"]:
        path, parts, iterations, threads, out = sys.argv[2:]
        found = measure(load(Path(path)), int(parts), int(iterations), int(threads))
        Path(out).write_text(json.dumps(found), encoding="utf-8")
        return 0
    parser = parser_for(__doc__)
    parser.add_argument("--poses", type=int, default=1000)
    parser.add_argument("--landmarks", type=int, default=100_000)
    parser.add_argument("--legs", type=int, default=8)
    parser.add_argument("--views", type=float, default=7.0)
    parser.add_argument("--parts", type=int, nargs="+", default=[1, 8])
    parser.add_argument("--iterations", type=int, default=3)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "problem.npz"
        call("benchmarks.partition", "--make", path, *(getattr(args, n) for n in SIZE))
        rows = []
        for parts in args.parts:
            child = ("--measure", path, parts, args.iterations, args.threads)
            rows.append(run("benchmarks.partition", *child, threads=args.threads))
            print(line(rows[-1]), flush=True)
    size = {name: getattr(args, name) for name in SIZE} | {
        "leg_m": args.poses // args.legs * STEP_M
    }
    found = size | {"rows": [compare(row, rows[0]) for row in rows]}
    print(json.dumps(found, indent=1))
    keep(found, args.json)
    return 0


SIZE = ("poses", "landmarks", "legs", "views")

if __name__ == "__main__":
    sys.exit(main())
