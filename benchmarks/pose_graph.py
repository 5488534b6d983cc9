# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A pose graph of the field's size: python -m benchmarks.pose_graph [--nodes N] [--threads T]
[--json FILE]

45,000 nodes on 30 legs of 156 m along a wall, 200,000 links (sequential and to the neighbouring
legs), 97,000 sightings of 9,000 planes, each held in its anchor; started from dead reckoning.
Solved by our core with the options of the step links, and, where `make bench-peers` has made the
peers' environment, by GTSAM's Levenberg-Marquardt on the same graph. One process each on the same
cores, one after the other; prints JSON. `error_m` is that of the nodes after the rigid motion that
brings them nearest to the truth.
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

from benchmarks.arguments import parser_for
from benchmarks.bundle import HELD, peak_mb
from benchmarks.peers import THEIRS
from benchmarks.subprocess_runner import call, load, load_truth, run, save
from hullrecon import native
from hullrecon.geometry.poses import Poses, exp, from_rpy
from hullrecon.navigation.pose_graph.graph import OPTIONS
from hullrecon.typing import Array, Ints

LINKS_A_NODE, SIGHTINGS_A_NODE = 200_000 / 45_000, 97_000 / 45_000
# 4,661 m of path [Ozog2016 Table 4.1] along a ship of 160 m
LEG_NODES, SPACING_M, LEG_SPACING_M = 1500, 0.104, 0.5
LINK_SIGMA = np.repeat([0.005, 0.001], 3)  # m, rad
PLANE_SIGMA_M = 0.01
HEADING_WALK_RAD, DVL_SCALE = 1e-4, 0.003  # a step; of dead reckoning


def path_of(nodes: int) -> tuple[Poses, Ints]:
    """Lay poses back and forth along a wall.

    Returns them, and the node (legs, columns) at each place.
    """
    legs = nodes // LEG_NODES
    order = np.arange(legs * LEG_NODES).reshape(legs, LEG_NODES)
    order[1::2] = order[1::2, ::-1]
    leg, column = np.divmod(np.arange(legs * LEG_NODES), LEG_NODES)
    column = np.where(leg % 2 == 0, column, LEG_NODES - 1 - column)
    along, down = SPACING_M * column, LEG_SPACING_M * leg
    place = np.c_[along, 1.5 + 0.2 * np.sin(0.3 * along + leg), down + 0.05 * np.cos(0.5 * along)]
    turn = np.c_[
        0.05 * np.sin(0.2 * along), 0.05 * np.cos(0.3 * along + leg), 0.1 * np.sin(0.1 * along)
    ]
    return from_rpy(place, turn), order


def link_ends(at: Ints) -> tuple[Ints, Ints]:
    """List the nodes (m,) that links join.

    Sequential links come first, then those to the leg below, then those over one node, up to the
    number that the field's problem has.
    """
    n = at.size
    ends = [np.c_[np.arange(n - 1), np.arange(1, n)], np.c_[at[:-1].ravel(), at[1:].ravel()]]
    ends += [
        np.c_[at[:-1, 1:].ravel(), at[1:, :-1].ravel()],
        np.c_[at[:-1, :-1].ravel(), at[1:, 1:].ravel()],
    ]
    ends.append(np.c_[np.arange(n - 2), np.arange(2, n)])
    first, second = np.vstack(ends)[: round(LINKS_A_NODE * n)].T
    return first, second


def sightings(at: Ints) -> tuple[Ints, Ints, Ints]:
    """List anchors of planes, and node and plane of each sighting.

    There is one plane for five columns of a leg. Its anchor is no sighting.
    """
    legs, columns = at.shape
    anchor = at[:, 2::5].ravel()
    plane = np.arange(anchor.size).reshape(legs, columns // 5)
    seen = []
    for below, offsets in ((0, (-2, -1, 1, 2)), (1, (-2, -1, 0, 1, 2)), (-1, (0, -1, 1))):
        for offset in offsets:
            rows = np.arange(max(0, -below), legs - max(0, below))
            seen.append(
                np.c_[
                    at[rows + below, 2 + offset :: 5][:, : plane.shape[1]].ravel(),
                    plane[rows].ravel(),
                ]
            )
    node, of = np.vstack(seen)[: round(SIGHTINGS_A_NODE * at.size)].T
    return anchor, node, of


def make(nodes: int, seed: int = 0) -> tuple[native.Problem, Poses]:
    """Make the problem and its true poses."""
    rng = np.random.default_rng(seed)
    truth, at = path_of(nodes)
    first, second = link_ends(at)
    measured = (
        truth[first].inverse() @ truth[second] @ exp(LINK_SIGMA * rng.normal(size=(len(first), 6)))
    )
    start = dead_reckoned(truth, rng)
    anchor, node, plane = sightings(at)

    def wall(poses: Poses) -> Array:
        """Compute the plane y = 0 of g in the frames of poses, (n, 3)."""
        return poses.rotation.inv().apply(poses.translation * [0, 1, 0])

    m = len(first)
    links = native.LinkTable(
        first=first.astype(np.int32),
        second=second.astype(np.int32),
        camera_first=np.zeros(m, np.int32),
        camera_second=np.zeros(m, np.int32),
        measured=np.c_[measured.translation, measured.quaternion],
        sqrt_information=np.tile(np.diag(1 / LINK_SIGMA), (m, 1, 1)),
        scaled=np.ones(m, np.bool_),
        kernel=np.zeros(m, np.int32),
    )
    seen = native.PlaneSightingTable(
        node=node.astype(np.int32),
        plane=plane.astype(np.int32),
        measured=wall(truth[node]) + PLANE_SIGMA_M * rng.normal(size=(len(node), 3)),
        sqrt_information=np.tile(np.eye(3) / PLANE_SIGMA_M, (len(node), 1, 1)),
    )
    pose = np.c_[start.translation, start.quaternion, np.zeros(at.size)]
    problem = native.Problem(
        unknowns=native.Unknowns(
            pose=pose, plane=wall(truth[anchor]) + 0.05 * rng.normal(size=(len(anchor), 3))
        ),
        constant=HELD,
        priors=native.Priors(
            pose=native.PosePriors(
                node=np.zeros(1, np.int32),
                value=pose[:1, :7],
                sqrt_information=1e3 * np.eye(6)[None],
            )
        ),
        links=links,
        planes=native.PlaneTable(anchor=anchor.astype(np.int32)),
        plane_sightings=seen,
    )
    return problem, truth


def dead_reckoned(truth: Poses, rng: np.random.Generator) -> Poses:
    """Reckon the path: heading and horizontal position drift, depth, roll and pitch do not."""
    n = len(truth)
    rpy = truth.rotation.as_euler("xyz") + 0.002 * rng.normal(size=(n, 3))
    rpy[:, 2] += np.cumsum(HEADING_WALK_RAD * rng.normal(size=n))
    found = from_rpy(truth.translation, rpy)
    step = (truth[:-1].inverse() @ truth[1:]).translation * (1 + DVL_SCALE) + 0.001 * rng.normal(
        size=(n - 1, 3)
    )
    place = np.vstack(
        [
            truth.translation[:1],
            truth.translation[0] + np.cumsum(found[:-1].rotation.apply(step), axis=0),
        ]
    )
    place[:, 2] = truth.translation[:, 2] + 0.01 * rng.normal(size=n)
    return Poses(found.quaternion, place)


def solve(path: Path, threads: int, out: Path) -> None:
    """Solve the problem of a file by our core, in this process, and write its figures."""
    from benchmarks.solve_one import rigid_rmse_m

    problem = load(path)
    options = replace(OPTIONS, threads=threads)
    began, cpu = time.perf_counter(), time.process_time()
    result = native.solve(problem, options)
    row = {
        "solve_s": time.perf_counter() - began,
        "cpu_s": time.process_time() - cpu,
        "peak_rss_mb": peak_mb(),
    }
    record, truth = result.iterations, load_truth(path)["position"]
    row |= {
        "iterations": len(record.cost) - 1,
        "first_cost": float(record.cost[0]),
        "final_cost": float(record.cost[-1]),
    }
    row |= {"start_error_m": rigid_rmse_m(problem.unknowns.pose[:, :3], truth)}
    row |= {"error_m": rigid_rmse_m(result.unknowns.pose[:, :3], truth)}
    began = time.perf_counter()
    pairs = np.random.default_rng(1).integers(0, len(truth), (200, 2)).astype(np.int32)
    native.pair_covariance(problem.started_from(result.unknowns), pairs, options)
    row |= {"covariance_of_200_pairs_s": time.perf_counter() - began}
    out.write_text(json.dumps(row | {"message": result.message, "seconds_by_part": result.seconds}))


def measure(nodes: int, threads: int) -> dict[str, Any]:
    """Run both solvers, and collect their figures. A missing solver is explained in words."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "graph.npz"
        call("benchmarks.pose_graph", "--write", nodes, path)
        with np.load(path) as tables:
            found: dict[str, Any] = {
                "nodes": len(tables["unknowns.pose"]),
                "links": len(tables["links.first"]),
                "plane_sightings": len(tables["plane_sightings.node"]),
                "planes": len(tables["unknowns.plane"]),
                "threads": threads,
            }
        found["hullrecon"] = run("benchmarks.pose_graph", "--solve", path, threads, threads=threads)
        if THEIRS.exists():
            found["gtsam"] = run(
                "benchmarks.peer_gtsam_graph", path, threads, python=str(THEIRS), threads=threads
            )
        else:
            found["gtsam"] = "not run: the peers' environment is missing (make bench-peers)"
    return found


def main() -> int:
    if sys.argv[1:2] == ["--write"]:
        problem, truth = make(int(sys.argv[2]))
        save(Path(sys.argv[3]), problem, position=truth.translation)
        return 0
    if sys.argv[1:2] == ["--solve"]:
        solve(Path(sys.argv[2]), int(sys.argv[3]), Path(sys.argv[4]))
        return 0
    parser = parser_for(__doc__)
    parser.add_argument("--nodes", type=int, default=45_000, help=f"a multiple of {LEG_NODES}")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    if args.nodes < LEG_NODES or args.nodes % LEG_NODES:
        parser.error(f"--nodes must be a multiple of {LEG_NODES}")
    found = json.dumps(measure(args.nodes, args.threads), indent=1)
    print(found)
    if args.json:
        args.json.write_text(found + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
