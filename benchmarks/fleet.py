# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Many tiny dives, five of them broken, through a fleet that is killed twice: python -m
benchmarks.fleet [--dives 100]

One dive of two legs of a metre is simulated and copied, each copy with another vessel and sigma;
five copies are broken in five ways. `hullrecon fleet` runs them, is killed with all its processes
(SIGKILL after a third, SIGTERM after two thirds), runs to its end, and is called once more with
nothing to do. Prints JSON: what was delivered, what failed, exit codes, seconds.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.arguments import parser_for

SMALL = (
    "--form plain --no-sonar --legs 2 --leg-length-m 1 --leg-spacing-m 0.4 --image-width 320 "
    "--image-height 256 --views 3"
    " --structures 1 --marks 0 --barnacles 0 --length-m 20 --beam-m 5 --depth-m 3.5 --draught-m "
    "2.5 --bilge-radius-m 0.8"
    " --top-m 0.8"
)
PROGRAM = (
    sys.executable,
    "-c",
    "import sys; from hullrecon_cli.main import main; sys.exit(main())",
)
MARK = "code-has-run"
POLL_S = 0.2


def cut_log(package: Path) -> None:
    for path in (package / "logs").glob("*.csv"):
        os.truncate(path, 40)


def lose_cad(package: Path) -> None:
    (package / "hull.stl").unlink()


def spoil_toml(package: Path) -> None:
    (package / "dive.toml").write_text("[dive\nname = 3")


def lose_imu(package: Path) -> None:
    (package / "logs" / "imu.csv").unlink()


def name_hostile(package: Path) -> None:
    path = package / "dive.toml"
    path.write_text(
        path.read_text().replace(f'"{package.name}"', f'"x$(shell touch {MARK})`touch {MARK}`"')
    )


BREAKS = (cut_log, lose_cad, spoil_toml, lose_imu, name_hostile)


def make_dives(tiny: Path, dives: Path, count: int) -> dict[str, str]:
    """Fill the folder `dives` with copies of a package; return which are broken, and how."""
    broken = {}
    for k in range(count):
        package = dives / f"dive-{k:03d}"
        shutil.copytree(tiny, package)
        path = package / "dive.toml"
        text = path.read_text().replace(f'name = "{tiny.name}"', f'name = "{package.name}"')
        text = text.replace('vessel = "', f'vessel = "No. {k}, ').replace(
            "sigma_deg = 0.8", f"sigma_deg = {0.8 + k / 1e4:.4f}"
        )
        path.write_text(text)
    for k, spoil in enumerate(BREAKS):
        package = dives / f"dive-{(2 * k + 1) * count // (2 * len(BREAKS)):03d}"
        spoil(package)
        broken[package.name] = spoil.__name__
    return broken


def delivered(runs: Path) -> int:
    return len(list(runs.glob("dive-*/deliver")))


class Fleet:
    """`hullrecon fleet` over a folder, in a group of processes of its own."""

    def __init__(self, program: Sequence[str], dives: Path, runs: Path, jobs: int) -> None:
        self._command = [
            *program,
            "--json",
            "fleet",
            str(dives),
            "--runs",
            str(runs),
            "--jobs",
            str(jobs),
        ]
        self._runs = runs

    def call(self, until: int | None = None, number: int = signal.SIGKILL) -> dict[str, Any]:
        """Run a fleet; with `until`, end its process group once so many dives are delivered."""
        begun = time.perf_counter()
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            fleet = subprocess.Popen(self._command, stdout=out, stderr=err, start_new_session=True)
            while until is not None and fleet.poll() is None and delivered(self._runs) < until:
                time.sleep(POLL_S)
            if until is not None:
                os.killpg(fleet.pid, number)
            code = fleet.wait()
            seconds = round(time.perf_counter() - begun, 2)
            out.seek(0)
            err.seek(0)
            document = out.read()
            lines = [
                line for line in err.read().decode().splitlines() if line.startswith("failed: ")
            ]
        found = json.loads(document) if until is None else {}
        return {
            "exit_code": code,
            "seconds": seconds,
            "delivered": delivered(self._runs),
            "failed_lines": lines,
            **_counts(found),
        }


def _counts(document: dict[str, Any]) -> dict[str, Any]:
    if not document:
        return {}
    failed = {
        dive["package"].rpartition("/")[2]: dive["exit_code"]
        for dive in document["dives"]
        if dive["state"] == "failed"
    }
    return {
        "reported": document["delivered"],
        "failed": failed,
        "ran": sum(dive["ran"] for dive in document["dives"]),
    }


def measure(
    folder: Path, tiny: Path, count: int, jobs: int, program: Sequence[str] = PROGRAM
) -> dict[str, Any]:
    """Run a fleet of `count` copies of a package, killed twice."""
    dives, runs = folder / "dives", folder / "runs"
    broken = make_dives(tiny, dives, count)
    fleet = Fleet(program, dives, runs, jobs)
    good = count - len(broken)
    calls = {
        "killed": fleet.call(max(1, good // 3), signal.SIGKILL),
        "ended": fleet.call(max(2, 2 * good // 3), signal.SIGTERM),
        "whole": fleet.call(),
        "again": fleet.call(),
    }
    code_ran = [str(path) for path in folder.rglob(MARK)] + ([MARK] if Path(MARK).exists() else [])
    return {"dives": count, "jobs": jobs, "broken": broken, "calls": calls, "code_ran": code_ran}


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("--dives", type=int, default=100)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--cameras", choices=("stereo", "mono", "none"), default="none")
    args = parser.parse_args()
    if args.dives < 2 * len(BREAKS):
        parser.error(f"give at least {2 * len(BREAKS)} dives")
    with tempfile.TemporaryDirectory(prefix="hullrecon-fleet-") as folder:
        tiny = Path(folder) / "tiny"
        words = [
            "--quiet",
            "simulate",
            str(tiny),
            "--name",
            "tiny",
            "--cameras",
            args.cameras,
            *SMALL.split(),
        ]
        subprocess.run([*PROGRAM, *words], check=True)
        print(json.dumps(measure(Path(folder), tiny, args.dives, args.jobs), indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
