# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What becomes of wrong inputs: python -m benchmarks.faulty_inputs FOLDER [--dives N] [--seed S]
[--faultless N] [--only NAME ...] [--cameras KIND ...] [--json FILE]

Random dives (stereo, one camera, none) are simulated into FOLDER, and in each one input is made
wrong by a random size (benchmarks/input_faults.py): a unit, an axis, a sign, a clock, a
calibration, the CAD model. `check` and `run --to adjust` see it, and the path is compared with the
truth. An outcome is

  right    the path is as good as without the fault, and nobody else is accused
  refused  check or run ends with an exit code, and names the sensor that is wrong
  named    the path is worse, within its sigmas, and a warning names that sensor
  given    the path is off by more than MANY_SIGMAS of its own, which the run says hold for an
           input that is right, and names it
  unsure   the path is off by more than MANY_SIGMAS of its own, whoever is named
  blamed   ended or warned, and only another sensor is named
  silent   the path is worse, and no warning is given

--faultless runs dives without a fault: a warning of theirs that accuses an input is one too many.
What says how well something is known accuses nobody.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import subprocess
import sys
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.disturbed import said
from benchmarks.input_faults import corrupt, faults
from benchmarks.legs import figures

KINDS = {
    "none": "--cameras none --legs 3 --leg-length-m 4 --structures 0",
    "mono": "--cameras mono --legs 2 --leg-length-m 3 --structures 2 --marks 0 --barnacles 0",
    "stereo": "--cameras stereo --legs 2 --leg-length-m 3 --structures 2 --marks 0 --barnacles 0",
}
COMMON = "--no-sonar --image-width 400 --image-height 320 --leg-spacing-m 0.5"
AS_GOOD, AS_GOOD_MM = 1.5, 3.0  # times the error without the fault, or so much more
MANY_SIGMAS = 4.0
# words by which a sentence names the sensor that is wrong
NAMES = {
    "pressure": r"pressure|depths?\b|atmospher",
    "dvl": r"\bdvl\b|speed of sound",
    "imu": r"\bimu\b|attitude|orientation|heading|gyro",
    "joints": r"\btray|joint|servo",
    "camera": r"camera|calibrat|focal|lens|distortion|matrix|stereo|baseline",
    "clock": r"\bclocks?\b|stamp|time_offset|\bms\b|\blate\b|\bearl",
    "cad": r"\bcad\b|\bmesh\b|hull\.|faces",
}
# of sentences on how well something is known, and on readings that any log has
NEUTRAL = (
    r"is uncertain by|clock agrees with the \S+ is known to|too plain to tell"
    r"|for a model that is to scale|for a speed of sound that is right|rejected as outliers"
    r"|fall into \d+ parts|^to fill in"
)
# that sigmas hold if an input is right: what no other measurement of a dive tells
GIVEN = {
    "cad": r"sigmas of the position (on the hull )?hold for a model that is",
    "dvl": r"sigmas hold for a speed of sound that is right",
}
# what was compared is no accusation, and what a dive without cameras is mapped by
EVIDENCE = r"\([^()]*\)|(?<=is not known): .*|a dive with a DVL is mapped by that alone"


@dataclass(frozen=True, kw_only=True)
class Seen:
    """What check and run made of a package."""

    check_code: int
    run_code: int
    sentences: list[str]  # warnings and errors of both
    error_mm: float  # of the path, NaN where none came out
    sigmas: float  # of the worst axis

    @property
    def accusations(self) -> list[str]:
        """List what accuses an input, without the evidence."""
        accusing = [s for s in self.sentences if not re.search(NEUTRAL, s, re.I)]
        return [re.sub(EVIDENCE, "", sentence) for sentence in accusing]


def hullrecon(*words: str) -> tuple[int, str, str]:
    program = "import sys; from hullrecon_cli.main import main; sys.exit(main())"
    done = subprocess.run(
        [sys.executable, "-c", program, *words], check=False, capture_output=True, text=True
    )
    return done.returncode, done.stdout, done.stderr


def look(package: Path, runs: Path, jobs: int) -> Seen:
    """Check and run a package, and compare the path with the truth."""
    check_code, out, err = hullrecon("check", str(package), "--json")
    try:
        found = json.loads(out)["findings"]
        sentences = [f["sentence"] for f in found if f["severity"] in ("warning", "error")]
    except (json.JSONDecodeError, KeyError):
        sentences = [err.strip()]
    words = ("run", "-q", str(package), "--runs", str(runs), "--to", "adjust", "--jobs", str(jobs))
    run_code, _, err = hullrecon(*words)
    run = runs / package.name
    sentences += [err.strip()] * (run_code != 0) + (said(run) if run.exists() else [])
    row: dict[str, Any] = figures(run, package) if run_code == 0 else {}
    if row.get("cad_model_refused"):
        sentences.append(f"the CAD model is refused: {row['cad_model_refused']}")
    return Seen(
        check_code=check_code,
        run_code=run_code,
        sentences=list(dict.fromkeys(sentences)),
        error_mm=row.get("adjust_mm", float("nan")),
        sigmas=max(row.get("errors_in_sigmas", [float("nan")])),
    )


def outcome(seen: Seen, without: Seen, sensor: str) -> str:
    """Judge what was made of a fault."""
    new = [sentence for sentence in seen.accusations if sentence not in without.accusations]
    named = any(re.search(NAMES[sensor], sentence, re.I) for sentence in new)
    if seen.check_code or seen.run_code:
        return "refused" if named else "blamed"
    if seen.sigmas > max(MANY_SIGMAS, without.sigmas):
        given = sensor in GIVEN and any(re.search(GIVEN[sensor], s) for s in seen.sentences)
        return "given" if given else "unsure"
    if new and not named:
        return "blamed"
    as_good = seen.error_mm <= max(AS_GOOD * without.error_mm, without.error_mm + AS_GOOD_MM)
    return "right" if as_good else "named" if named else "silent"


def simulate(kind: str, seed: int, folder: Path) -> Path:
    """Simulate a random dive of a kind, unless it exists."""
    random = np.random.default_rng([seed, list(KINDS).index(kind)])
    package = folder / f"{kind}-{seed}"
    if not (package / "truth").exists():
        words = [
            f"--speed-m-per-s={random.uniform(0.2, 0.4):.2f}",
            f"--standoff-m={random.uniform(1.0, 1.4):.2f}",
            f"--top-m={random.uniform(0.9, 1.5):.2f}",
            f"--length-m={random.choice([40, 60, 90])}",
            f"--heading-drift-deg-per-hour={random.choice([1, 10])}",
        ]
        code, _, err = hullrecon(
            *("simulate", "-q", str(package), "--name", package.name, "--seed", str(seed)),
            *(*COMMON.split(), *KINDS[kind].split(), *words),
        )
        if code:
            raise SystemExit(err)
    return package


def row_of(
    package: Path, fault: str, size: str, judged: str, seen: Seen, without: Seen
) -> dict[str, Any]:
    """Tabulate an outcome, and print it."""
    told = " | ".join(" ".join(sentence.split())[:160] for sentence in seen.accusations[:4])
    print(
        f"{package.name:12s} {fault:20s} {size:24s} {judged:8s} check {seen.check_code} run "
        f"{seen.run_code} path {seen.error_mm:.1f} mm ({without.error_mm:.1f}), "
        f"{seen.sigmas:.1f} sigmas: {told}",
        flush=True,
    )
    row = {"dive": package.name, "fault": fault, "size": size, "outcome": judged}
    return row | {"without_mm": without.error_mm, **asdict(seen)}


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--dives", type=int, default=20, help="faults to try")
    parser.add_argument("--per-dive", type=int, default=5, help="faults of one simulated dive")
    parser.add_argument("--faultless", type=int, default=0, help="dives without a fault")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="+", default=[""], help="faults whose name begins so")
    parser.add_argument("--cameras", nargs="+", choices=KINDS, default=list(KINDS))
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    runs, faulty = args.folder / "runs", args.folder / "faulty"
    faulty.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(args.seed)
    rows: list[dict[str, Any]] = []
    tried = dive = 0
    while dive < args.faultless or tried < args.dives:
        kind = args.cameras[dive % len(args.cameras)]
        package = simulate(kind, args.seed * 1000 + dive, args.folder)
        without = look(package, runs, args.jobs)
        accused = without.accusations or without.check_code or without.run_code
        judged = "accused" if accused else "right"
        rows.append(row_of(package, "none", "", judged, without, without))
        drawn = {n: f for n, f in faults(kind, random).items() if n.startswith(tuple(args.only))}
        if tried < args.dives and not drawn:
            raise SystemExit(f"a dive of kind {kind} has no such fault")
        for name in random.permutation(list(drawn))[: min(args.per_dive, args.dives - tried)]:
            copy = faulty / f"{package.name}-{name}"
            shutil.rmtree(copy, ignore_errors=True)
            corrupt(package, copy, drawn[name])
            seen = look(copy, runs, args.jobs)
            shutil.rmtree(runs / copy.name, ignore_errors=True)
            judged = outcome(seen, without, drawn[name].sensor)
            rows.append(row_of(package, str(name), drawn[name].size, judged, seen, without))
            tried += 1
        dive += 1
    for title, some in (
        ("faultless", [row for row in rows if row["fault"] == "none"]),
        ("faulty", [row for row in rows if row["fault"] != "none"]),
    ):
        print(title, dict(Counter(row["outcome"] for row in some)))
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1, default=float))
    return 0


if __name__ == "__main__":
    sys.exit(main())
