# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Bundle adjusters on the reprojection part of the field's problem: python -m benchmarks.peers
--size mono|stereo --json FILE

The same start, no robust loss, the same gauge, one process each on the same cores, one after the
other; `make bench-peers` makes the peers' environment. Stops by the relative change of the cost. An
iteration's seconds leave out the preparation (orderings, symbolic factors) and everything in
Python.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.arguments import keep, parser_for
from benchmarks.bundle import Bundle
from benchmarks.subprocess_runner import ROOT, run

THEIRS = ROOT / "build" / "peers" / "bin" / "python"
SOLVERS: dict[str, tuple[str, list[str], bool]] = {
    "hullrecon": ("benchmarks.peer_hullrecon", [], True),
    "pycolmap": ("benchmarks.peer_pycolmap", [], False),
    "pycolmap-default": ("benchmarks.peer_pycolmap", ["--default"], False),
    "gtsam": ("benchmarks.peer_gtsam", [], False),
    "gtsam-stereo-factor": ("benchmarks.peer_gtsam", ["--stereo-factor"], False),
}


def bundle_of(problem: Any) -> Bundle:
    """Make the bundle of a field problem: top cameras of the poses with images.

    They are placed by dead reckoning, with the tray's angle as measured.
    """
    from benchmarks.survey import TOP_FROM_BOTTOM, TRAY_ORIGIN
    from hullrecon.geometry import poses
    from hullrecon.geometry.poses import Poses

    stereo = len(problem.stereo.node) > 0
    node = problem.stereo.node if stereo else problem.mono.node
    used, seen_from = np.unique(node, return_inverse=True)
    start = Poses(problem.unknowns.pose[used, 3:7], problem.unknowns.pose[used, :3])
    mount = poses.pose_from_vector(problem.unknowns.T_s_ct)
    top = start @ poses.tray_poses(TRAY_ORIGIN, problem.unknowns.pose[used, 7]) @ mount
    return Bundle(
        pose=np.hstack([top.translation, top.quaternion]),
        point=np.ascontiguousarray(problem.unknowns.landmark),
        camera=problem.unknowns.intrinsics_top,
        top_from_bottom=np.r_[TOP_FROM_BOTTOM.translation[0], TOP_FROM_BOTTOM.quaternion[0]],
        seen_from=seen_from.astype(np.int32),
        seen=problem.stereo.landmark if stereo else problem.mono.landmark,
        pixel=problem.stereo.pixel if stereo else problem.mono.pixel,
    )


def write_bundle(size: str, path: Path, libmv: Path | None) -> None:
    from benchmarks.libmv import read
    from benchmarks.problems import SIZES, make

    (read(libmv) if libmv else bundle_of(make(SIZES[size]))).save(path)


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument(
        "--libmv", type=Path, help="a libmv problem file instead of a field problem"
    )
    parser.add_argument("--size", choices=("small", "small_mono", "mono", "stereo"), default="mono")
    parser.add_argument(
        "--solvers", default="hullrecon,pycolmap,gtsam", help=f"of {', '.join(SOLVERS)}"
    )
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--iterations", type=int, default=100)
    parser.add_argument("--tolerance", type=float, default=1e-6)
    parser.add_argument("--repeat", type=int, default=1, help="rounds; each solver once a round")
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    if not THEIRS.exists():
        parser.error("the peers' environment is missing: make bench-peers")
    name = args.libmv.stem if args.libmv else args.size
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bundle.npz"
        write_bundle(args.size, path, args.libmv)
        for solver in args.repeat * args.solvers.split(","):
            rows.append(solve(solver, path, args))
            print(f"{name} {line(rows[-1])}", flush=True)
    keep({"problem": name, "threads": args.threads, "solvers": rows}, args.json)
    return 0


def solve(solver: str, path: Path, args: argparse.Namespace) -> dict[str, Any]:
    module, flags, ours = SOLVERS[solver]
    python = sys.executable if ours else str(THEIRS)
    row = run(
        module,
        path,
        args.threads,
        args.iterations,
        args.tolerance,
        *flags,
        python=python,
        threads=args.threads,
    )
    return {"solver": solver} | row


def line(row: dict[str, Any]) -> str:
    return (
        f"{row['solver']:20s} {row['iteration_s']:7.3f} s an iteration  {row['iterations']:3d} "
        f"iterations"
        f"  {row['solve_s']:7.2f} s  {row['cpu_s']:7.2f} s of CPU  {row['rms_px']:.8f} px  "
        f"{row['peak_rss_mb']:.0f} MB"
    )


if __name__ == "__main__":
    sys.exit(main())
