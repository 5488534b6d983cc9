# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether a dive survives an outage of DVL and cameras: python -m benchmarks.outage PACKAGE FOLDER
[--from-s S] [--to-s S]

PACKAGE is a simulated dive with an MCAP log, such as

    hullrecon simulate --no-sonar --heading-drift-deg-per-hour 100 --legs 2 --leg-length-m 20
    --length-m 120 PACKAGE

A copy of it without DVL and images between two times, seconds from the dive's middle, is run to
`links` without recognition by appearance and with it. Prints JSON: rms of the path after rigid
alignment with the truth, parts, pairs joined across legs, and what appearance was asked.
"""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

from benchmarks.arguments import keep, parser_for
from benchmarks.disturbed import Disturbance, disturb, said
from benchmarks.legs import Figures, hullrecon, rigid_rms_mm
from hullrecon.evaluation.truth import read_truth
from hullrecon.steps.artifacts import LinksArtifact, NavigateArtifact


def outage(from_s: float, to_s: float) -> Disturbance:
    """Drop the DVL and all cameras between two times."""

    def lost(topic: str, since_s: float, data: bytes) -> bytes | None:
        return None if (topic == "/dvl" or "camera" in topic) and from_s <= since_s < to_s else data

    return lost


def figures(package: Path, run: Path) -> Figures:
    """Score the path of a run."""
    truth, links = read_truth(package), LinksArtifact(run / "links")
    navigate, pairs = NavigateArtifact(run / "navigate").trajectory, links.pairs
    facts = json.loads((run / "links" / "links.json").read_text())
    return {
        "dead_reckoning_mm": rigid_rms_mm(navigate.t_ns, navigate.translation, truth)[0],
        "links_mm": rigid_rms_mm(navigate.t_ns, links.path.pose[:, :3], truth)[0],
        "part_sigmas_m": links.path.part_sigma.tolist(),
        "joined_across_legs": int((pairs.joined & pairs.across).sum()),
        "appearance": facts.get("appearance", []),
        "said": said(run),
    }


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("package", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--from-s", type=float, default=-20.0)
    parser.add_argument("--to-s", type=float, default=40.0)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    copy, rows = args.folder / f"outage-{args.package.name}", dict[str, Figures]()
    if not copy.exists():
        disturb(args.package, copy, outage(args.from_s, args.to_s))
    for name, value in (("without", "false"), ("with", "true")):
        runs = args.folder / f"runs-{name}"
        if name == "with" and not runs.exists():
            shutil.copytree(args.folder / "runs-without", runs)  # all but the links is the same
        code = hullrecon(
            "run",
            "-q",
            str(copy),
            "--runs",
            str(runs),
            "--to",
            "links",
            "--set",
            f"links.appearance={value}",
        )
        rows[name] = {"exit_code": code} | ({} if code else figures(copy, runs / copy.name))
    print(json.dumps(rows))
    keep(rows, args.json)
    return 0


if __name__ == "__main__":
    sys.exit(main())
