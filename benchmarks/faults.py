# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Faults during runs of a small dive: python -m benchmarks.faults FOLDER [--to STEP] [--kills N]
[--full N] [--json FILE]

Simulates a dive of two short legs into FOLDER (kept for next time) and runs it once undisturbed.
Then: runs under limits of the address space; kill -9 in every step; a disk that is full at ever
later moments (a tmpfs for root, else a limit of the size of files); Ctrl-C at different moments, in
the import of libraries too; a package that changes meanwhile; one bit flipped in every file of a
copied workspace, deliver/ included. Each must end in at most one line with the exit code of its
kind, and the next run must leave the bytes of the undisturbed one. Prints a line a case and the
sum; ends with 1 where a case fails.
"""

from __future__ import annotations

import json
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.arguments import keep, parser_for
from benchmarks.lasting_bytes import different_files, flip_bit
from hullrecon.artifacts.checking import check_workspace
from hullrecon.artifacts.workspace import Workspace
from hullrecon.steps.chain import NAMES

DIVE = (
    "--legs 2 --leg-length-m 2 --marks 0 --structures 2 --barnacles 1 --image-width 320 "
    "--image-height 256"
)
LIMITS_GB = (0.5, 1.0, 1.5)
MOUNT = ["mount", "-t", "tmpfs", "-o"]
PROGRAM = [sys.executable, "-m", "hullrecon_cli.start"]
Preparation = Callable[[], None]


@dataclass(frozen=True, kw_only=True)
class Case:
    """What was done to a run, its exit code, what it said (last line), and why that is wrong; empty
    where it is right.
    """

    fault: str
    exit_code: int | None
    said: str
    wrong: str = ""


@dataclass(frozen=True, kw_only=True)
class Bench:
    """A package, the undisturbed run of it, and how far the chain is run."""

    folder: Path
    last: str
    seconds: dict[str, float]

    @property
    def package(self) -> Path:
        return self.folder / "dive"

    @property
    def steps(self) -> tuple[str, ...]:
        """Return the steps that are run."""
        return NAMES[: NAMES.index(self.last) + 1]

    def command(self, runs: Path, *more: str) -> list[str]:
        """Return the command of a run."""
        return [*PROGRAM, "run", str(self.package), "--runs", str(runs), "--to", self.last, *more]

    def run(
        self, fault: str, runs: Path, code: int, *more: str, prepare: Preparation | None = None
    ) -> Case:
        """Run to the end and hold the exit code and the one line against what is due."""
        done = subprocess.run(
            self.command(runs, "--quiet", *more),
            capture_output=True,
            text=True,
            check=False,
            preexec_fn=prepare,
        )
        return judge(fault, done.returncode, done.stderr, code)

    def healed(self, fault: str, runs: Path, *more: str) -> Case:
        """Run once more without a fault, and compare every file with the undisturbed run's."""
        case = self.run(f"{fault}: the run after it", runs, 0, *more)
        different = different_files(self.folder / "whole" / "faults", runs / "faults")
        return (
            case
            if not different
            else replace_wrong(case, f"not the same bytes: {', '.join(different[:3])}")
        )


def judge(fault: str, code: int, err: str, due: int) -> Case:
    """Judge a case: the exit code must be the one due, with at most one line of error."""
    lines = [line for line in err.splitlines() if line.strip()]
    wrong = [] if code == due else [f"exit code {code}, not {due}"]
    wrong += [] if len(lines) == (due != 0) else [f"{len(lines)} lines"]
    return Case(
        fault=fault, exit_code=code, said=lines[-1] if lines else "", wrong="; ".join(wrong)
    )


def replace_wrong(case: Case, wrong: str) -> Case:
    """Return the case with another reason."""
    return Case(
        fault=case.fault,
        exit_code=case.exit_code,
        said=case.said,
        wrong="; ".join(filter(None, (case.wrong, wrong))),
    )


def prepare(folder: Path, last: str) -> Bench:
    """Simulate the dive and run it undisturbed, where that is not done yet."""
    package, whole = folder / "dive", folder / "whole"
    if not package.exists():
        subprocess.run(
            [*PROGRAM, "simulate", str(package), "--name", "faults", *DIVE.split(), "--quiet"],
            check=True,
        )
    bench = Bench(folder=folder, last=last, seconds={})
    subprocess.run(bench.command(whole, "--quiet"), check=True)
    seconds = {
        name: json.loads((whole / "faults" / name / "manifest.json").read_text())["run"]["seconds"]
        for name in bench.steps
    }
    return Bench(folder=folder, last=last, seconds=seconds)


def memory(bench: Bench) -> Iterator[Case]:
    """Run with too little address space."""
    runs = fresh(bench.folder / "memory")
    for limit_gb in LIMITS_GB:
        limit = int(limit_gb * 1e9)
        yield bench.run(
            f"address space of {limit_gb} GB", runs, 4,
            prepare=lambda limit=limit: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
        )  # fmt: skip
    yield bench.healed("address space", runs)


def kills(bench: Bench, count: int, chance: random.Random) -> Iterator[Case]:
    """Kill runs in step after step, at random moments; each goes on where the one before was
    killed.
    """
    runs = fresh(bench.folder / "killed")
    for k in range(count):
        step = bench.steps[k * len(bench.steps) // count]
        after_s = chance.uniform(0, bench.seconds[step])
        with start(bench, runs, step) as process:
            time.sleep(after_s)
            process.kill()
        found = check_workspace(Workspace(runs / "faults"), NAMES, read_data=True).damaged
        harmed = [sentence for sentence in found if not sentence.startswith("deliver/")]
        yield Case(
            fault=f"kill -9 in {step} after {after_s:.1f} s",
            exit_code=None,
            said="",
            wrong="; ".join(harmed),
        )
    yield bench.healed("kill -9", runs)


def full_disks(bench: Bench, count: int) -> Iterator[Case]:
    """Run on ever larger disks that are each too small."""
    runs = fresh(bench.folder / "full")
    whole = sum(p.stat().st_size for p in (bench.folder / "whole").rglob("*") if p.is_file())
    largest = max(p.stat().st_size for p in (bench.folder / "whole").rglob("*") if p.is_file())
    runs.mkdir()
    mounted = subprocess.run(
        [*MOUNT, "size=4k", "hullrecon-faults", str(runs)], capture_output=True, check=False
    )
    if mounted.returncode == 0:
        yield from _full_tmpfs(bench, runs, count, whole)
        return
    for k in range(count):
        limit = largest * k // count
        yield bench.run(
            f"files of at most {limit} bytes", runs, 6,
            prepare=lambda limit=limit: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)),
        )  # fmt: skip
    yield bench.healed("files of limited size", runs)


def _full_tmpfs(bench: Bench, runs: Path, count: int, whole: int) -> Iterator[Case]:
    try:
        for k in range(count):
            size = 4096 + int(0.95 * whole * k / count)
            subprocess.run(["mount", "-o", f"remount,size={size}", str(runs)], check=True)
            yield bench.run(f"disk of {size / 1e6:.1f} MB", runs, 6)
        subprocess.run(
            ["mount", "-o", f"remount,size={4 * whole + (64 << 20)}", str(runs)], check=True
        )
        yield bench.healed("full disk", runs)
    finally:
        subprocess.run(["umount", str(runs)], check=True)


def interruptions(bench: Bench, count: int, chance: random.Random) -> Iterator[Case]:
    """Press Ctrl-C while a run imports its libraries, and in each of its steps."""
    runs = fresh(bench.folder / "interrupted")
    for k in range(count):
        step = bench.steps[k * len(bench.steps) // count]
        after_s = chance.uniform(0, min(2.0, bench.seconds[step]))
        with start(bench, runs, step) as process:
            time.sleep(after_s)
            process.send_signal(signal.SIGINT)
            rest = process.communicate()[1]
        errors = "\n".join(
            line for line in rest.splitlines() if line.startswith(("error:", "Traceback"))
        )
        ended = process.returncode == 0 and step == bench.last  # before it came
        yield judge(
            f"Ctrl-C in {step} after {after_s:.1f} s",
            process.returncode,
            errors,
            0 if ended else 130,
        )
    yield bench.healed("Ctrl-C", runs)


def changes(bench: Bench) -> Iterator[Case]:
    """Write to the log while each step runs, then put it back."""
    log = next((bench.package / "logs").iterdir())
    whole = log.read_bytes()
    for step in bench.steps:
        runs = fresh(bench.folder / "changed")
        shutil.copytree(bench.folder / "whole", runs)
        shutil.rmtree(runs / "faults" / step)
        shutil.rmtree(runs / "faults" / "deliver", ignore_errors=True)
        with start(
            bench, runs, step, "--from-scratch" if step == "ingest" else "--wait=0"
        ) as process:
            log.write_bytes(whole + b"\0")
            rest = process.communicate()[1]
        errors = "\n".join(
            line for line in rest.splitlines() if line.startswith(("error:", "Traceback"))
        )
        case = judge(f"the log grows in {step}", process.returncode, errors, 3)
        log.write_bytes(whole)
        yield replace_wrong(case, "delivered") if (runs / "faults" / "deliver").exists() else case
    yield bench.healed("a log that changed", runs)


def flips(bench: Bench, chance: random.Random) -> Iterator[Case]:
    """Flip one bit in every file of a copied workspace; then in all of deliver/, in one file a
    step, and in every file.
    """
    runs = fresh(bench.folder / "flipped")
    shutil.copytree(bench.folder / "whole", runs)
    workspace = Workspace(runs / "faults")
    files = sorted(p for p in workspace.root.rglob("*") if p.is_file() and p.stat().st_size)
    missed = []
    for path in files:
        bit = flip_bit(path, chance)
        if not any(
            path.name in sentence
            for sentence in check_workspace(workspace, NAMES, read_data=True).damaged
        ):
            missed.append(str(path.relative_to(workspace.root)))
        flip_bit(path, chance, bit)
    yield Case(
        fault=f"a bit in each of {len(files)} files",
        exit_code=None,
        said="",
        wrong=f"not found: {missed}" if missed else "",
    )
    delivered = [
        p for p in files if p.is_relative_to(workspace.root / "deliver") or ".hullrecon" in p.parts
    ]
    one_each = [
        chance.choice([p for p in files if p.is_relative_to(workspace.root / step)])
        for step in bench.steps
    ]
    for what, group in {
        "deliver/ and .hullrecon/": delivered,
        "one file a step": one_each,
        "every file": files,
    }.items():
        for path in group:
            flip_bit(path, chance)
        yield bench.healed(f"a bit in {what}", runs, "--read-data")


def start(bench: Bench, runs: Path, step: str, *more: str) -> subprocess.Popen[str]:
    """Start a run and wait until it begins a step, or ends because the step is done."""
    process = subprocess.Popen(
        bench.command(runs, *more), stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True
    )
    assert process.stderr is not None
    for line in process.stderr:
        if f"{step}: started" in line:
            break
    return process


def fresh(folder: Path) -> Path:
    """Return the folder, which is not there."""
    shutil.rmtree(folder, ignore_errors=True)
    return folder


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument(
        "--to", default="report", choices=NAMES, help="last step of the chain that is run"
    )
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--full", type=int, default=20)
    parser.add_argument("--interruptions", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    bench, chance = prepare(arguments.folder.resolve(), arguments.to), random.Random(arguments.seed)
    cases = []
    for group in (
        memory(bench), flips(bench, chance), changes(bench), kills(bench, arguments.kills, chance),
        full_disks(bench, arguments.full), interruptions(bench, arguments.interruptions, chance),
    ):  # fmt: skip
        for case in group:
            cases.append(case)
            print(
                f"{'WRONG' if case.wrong else 'ok':6}{case.fault}: "
                f"{case.wrong or case.said or 'no damage'}",
                flush=True,
            )
    failed = sum(bool(case.wrong) for case in cases)
    print(f"{len(cases)} cases, {failed} wrong")
    keep([asdict(case) for case in cases], arguments.json)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
