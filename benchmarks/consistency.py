# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether sigmas hold for an adjustment in parts: python -m benchmarks.consistency [--dives 50]
[--parts 8] [--json FILE]

Small dives on a ship's side whose noise, first guesses and hull are all drawn from the sigmas that
the problem states. Each is solved in so many parts. Prints the mean over the dives of the
normalised squared error (NEES) of the pose at mid-dive, six freedoms, and of its position alone,
beside the band that holds 95 % of such means where sigmas are right. No images are rendered.
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from benchmarks.arguments import keep, parser_for
from benchmarks.partition import pixels_of, views_of
from benchmarks.problems import NOISE_PX, Truth, simulate
from benchmarks.survey import TRAY_FROM_TOP, Size
from hullrecon import native
from hullrecon.adjustment.partition import join
from hullrecon.adjustment.partition.plan import plan_along
from hullrecon.geometry.poses import Poses, pose_from_vector, pose_vector
from hullrecon.typing import Array

SIZE = Size(poses=64, imaged=64, landmarks=1500, stereo=True, legs=4)
VIEWS = 5.0
START_M, LANDMARK_M = 0.005, 0.01  # sigmas of the start
FREEDOMS = {"pose": 6, "position": 3}


def draw(seed: int) -> tuple[native.Problem, Truth]:
    """Simulate a dive of which every prior and measurement errs as its sigma says."""
    problem, truth = simulate(SIZE, seed, scatter_m=native.Options().sigma_on, off_hull=0.0)
    rng = np.random.default_rng(10_000 + seed)

    def drawn(true: Poses, sqrt_information: Array) -> Array:
        error = np.linalg.solve(sqrt_information, rng.standard_normal(6))
        turned = true.rotation * Rotation.from_rotvec(error[3:])
        return pose_vector(Poses(turned.as_quat(), true.translation + error[:3]))

    priors = problem.priors
    hull, camera, first = priors.T_g_M, priors.T_s_ct, priors.pose
    hull = replace(hull, value=drawn(truth.global_from_hull, hull.sqrt_information))
    camera = replace(camera, value=drawn(TRAY_FROM_TOP, camera.sqrt_information))
    held = drawn(truth.nodes[[0]], first.sqrt_information[0])
    tray = truth.tray + problem.tray.sigma * rng.standard_normal(len(truth.tray))
    node, landmark = views_of(SIZE, truth, VIEWS, rng)
    pixel = pixels_of(truth, node, landmark)
    near = START_M * rng.standard_normal((SIZE.poses, 3))
    return replace(
        problem,
        unknowns=replace(
            problem.unknowns,
            pose=np.hstack(
                [truth.nodes.translation + near, truth.nodes.quaternion, truth.tray[:, None]]
            ),
            T_g_M=hull.value,
            T_s_ct=camera.value,
            landmark=truth.landmark + LANDMARK_M * rng.standard_normal(truth.landmark.shape),
        ),
        priors=replace(priors, T_g_M=hull, T_s_ct=camera, pose=replace(first, value=held[None, :])),
        tray=replace(problem.tray, measured=tray),
        stereo=native.StereoTable(
            node=node.astype(np.int32),
            landmark=landmark.astype(np.int32),
            pixel=pixel + NOISE_PX * rng.standard_normal(pixel.shape),
        ),
    ), truth


def squared_errors(seed: int, parts: int) -> dict[str, float]:
    """Solve a drawn dive, and weigh the error of the pose at mid-dive by its covariance."""
    problem, truth = draw(seed)
    options = native.Options(threads=1, max_iterations=50, initial_radius=1e8)
    along = truth.global_from_hull.inverse().apply(truth.nodes.translation)[:, 0]
    plan = plan_along(problem, along, "path", parts)
    unknowns = join.solve(problem, plan, options).unknowns
    solved = problem.started_from(unknowns)
    middle = SIZE.poses // 2
    covariance = join.covariance(solved, plan, options, of_landmarks=False).pose[middle]
    ours, true = pose_from_vector(unknowns.pose[middle, :7]), truth.nodes[[middle]]
    turned = (true.rotation.inv() * ours.rotation).as_rotvec()[0]
    error = np.r_[ours.translation[0] - true.translation[0], turned]
    return {
        name: float(error[:n] @ np.linalg.solve(covariance[:n, :n], error[:n]))
        for name, n in FREEDOMS.items()
    }


def main() -> int:
    """Draw the dives, and print mean squared errors and their bands."""
    parser = parser_for(__doc__)
    parser.add_argument("--dives", type=int, default=50)
    parser.add_argument("--parts", type=int, default=8)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    rows = [squared_errors(seed, args.parts) for seed in range(args.dives)]
    found: dict[str, Any] = {"dives": args.dives, "parts": args.parts}
    for name, n in FREEDOMS.items():
        band = chi2.ppf([0.025, 0.975], n * args.dives) / args.dives
        mean = float(np.mean([row[name] for row in rows]))
        found[name] = {"nees": mean, "band": band.tolist()}
    print(json.dumps(found, indent=1))
    keep(found | {"rows": rows}, args.json)
    return 0


if __name__ == "__main__":
    sys.exit(main())
