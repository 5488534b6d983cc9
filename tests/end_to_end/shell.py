# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The installed command as a user runs it, and what two runs must have in common."""

import json
import os
import subprocess
import sys
from pathlib import Path

SAMPLE = Path(__file__).resolve().parents[2] / "sample_data" / "demo"
# run: coarse mosaics, where no test asks for their texels; the demo's are as a user has them
COARSE = ("--set", "mosaic-optical.resolution_m=0.02", "--set", "mosaic-sonar.resolution_m=0.1")
# simulate: a dive of some seconds
TINY = ("--legs", 1, "--marks", 0, "--image-width", 320, "--image-height", 256)
# simulate: two legs of 2 m, of which every number of the report can be held against truth
SMALL = ("--legs", 2, "--leg-length-m", 2, "--marks", 1, "--structures", 2, "--barnacles", 0,
         "--views", 5, "--image-width", 400, "--image-height", 320, "--seed", 11)  # fmt: skip


class Shell:
    """The command `hullrecon`, in a folder of its own. Its reports have a PDF, which takes as long
    as the rest of a report, only where it is asked for.
    """

    def __init__(self, folder, *, pdf=False):
        self.folder = folder
        self.program = Path(sys.executable).parent / "hullrecon"
        self.environment = dict(os.environ)
        if not pdf:
            paths = (Path(__file__).parent / "without_pango", os.environ.get("PYTHONPATH", ""))
            self.environment["PYTHONPATH"] = os.pathsep.join(filter(None, map(str, paths)))

    def start(self, *arguments):
        return subprocess.Popen(
            [self.program, *map(str, arguments)],
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def __call__(self, *arguments, code=0):
        done = subprocess.run(
            [self.program, *map(str, arguments)],
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == code, (
            f"exit {done.returncode}, expected "
            f"{code}:\n{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
        )
        return done


def edit(package, old, new):
    """Replaces text of dive.toml, once and for sure."""
    path = package / "dive.toml"
    text = path.read_text()
    assert old in text, f"{old!r} is not in dive.toml"
    path.write_text(text.replace(old, new, 1))


def without_run_blocks(folder):
    """Every file of a run by name, JSON without its volatile `run` block, the report without its
    time.
    """
    found = {}
    for path in sorted(p for p in folder.rglob("*") if p.is_file()):
        name = path.relative_to(folder).as_posix()
        # logs of the runs; the lock and the cache of hashes
        if "/logs/" in name or "/.hullrecon/" in name:
            continue
        found[name] = _steady(path)
    return found


def _steady(path):
    if path.name in ("manifest.json", "summary.json"):
        document = json.loads(path.read_text())
        for volatile in ("run", "seal"):
            document.pop(volatile, None)
        # they hold the run's time: so do their hashes
        for name in ("deliver/summary.json", "deliver/report/index.html"):
            document.get("outputs", {}).pop(name, None)
        document.get("deliverables", {}).pop("report/index.html", None)
        return json.dumps(document, sort_keys=True)
    if path.suffix == ".html":
        return "".join(
            line for line in path.read_text().splitlines() if "data-volatile" not in line
        )
    return path.read_bytes()
