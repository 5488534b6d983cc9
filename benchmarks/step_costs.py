# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What each step costs, from finished runs:

    python -m benchmarks.step_costs RUN... [--untimed RUN...] [--json hullrecon/api/step_costs.json]

RUN is the folder of a run (RUNS/<dive>) whose every step was made on this machine. For each step a
fixed part and one that grows with the dive are fitted to its manifests: seconds, peak memory (of
the process and of one worker a core) and disk. Of runs that were made beside other work (--untimed)
the seconds of CPU are taken for those of the clock: steps without workers use little more than one
core. Of steps with workers only memory and disk are. The longest dive should be as long as any that
is predicted: a line through short dives says little of long ones. Prints the table by which `check`
and `run` predict, with the worst ratio of prediction to measurement.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hullrecon.api.costs import QUANTITIES, size_of_run
from hullrecon.artifacts.manifest import FILE_NAME
from hullrecon.steps.chain import NAMES

PINGS = frozenset({"mosaic-sonar"})  # all others grow with the images


def fit_line(grown: Sequence[float], measured: Sequence[float]) -> NDArray[np.float64]:
    """Fit the line of a cost, fixed part and slope, both non-negative.

    Relative errors are minimised by least squares. From one measurement, only a slope is fitted.

    Parameters
    ----------
    grown
        Size of each dive.
    measured
        Cost in each.
    """
    from scipy.optimize import nnls

    scale = np.maximum(np.asarray(measured, float), 1e-3)
    columns = np.stack([np.ones(len(scale)), np.asarray(grown, float)], axis=1)
    if len(scale) == 1:
        columns[:, 0] = 0
    found, _ = nnls(columns / scale[:, None], np.asarray(measured, float) / scale)
    return np.asarray(found)


def measured(folder: Path, timed: bool = True) -> dict[str, float] | None:
    """Read what a step took. None if the run lacks it.

    Of the time that a step shared with one beside it, half is its own. Of an untimed step the
    seconds are those of CPU, and left out where it had workers.
    """
    path = folder / FILE_NAME
    if not path.exists():
        return None
    manifest = json.loads(path.read_text(encoding="utf-8"))
    run = manifest["run"]
    workers = run["host"]["cores"] * run["workers_peak_rss_bytes"]
    took = {
        "memory_mb": (run["peak_rss_bytes"] + workers) / 1e6,
        "disk_mb": sum(file["size"] for file in manifest["outputs"].values()) / 1e6,
    }
    if timed:
        took["seconds"] = run["seconds"] - sum(_overlaps(folder)) / 2
    elif not workers:
        took["seconds"] = run["cpu_seconds"]
    return took


def _overlaps(folder: Path) -> list[float]:
    """Measure how long each other step of the run was under way with that of the folder, s."""
    spans = {}
    for path in folder.parent.glob(f"*/{FILE_NAME}"):
        run = json.loads(path.read_text(encoding="utf-8"))["run"]
        spans[path.parent.name] = run["started"], run["started"] + run["seconds"]
    begin, end = spans.pop(folder.name)
    return [max(0.0, min(end, other[1]) - max(begin, other[0])) for other in spans.values()]


def table(timed: list[Path], untimed: list[Path]) -> dict[str, object]:
    """Fit the table of all steps to runs on a quiet machine and to others."""
    sizes = {run: size_of_run(run) for run in (*timed, *untimed)}
    steps, worst = {}, dict.fromkeys(QUANTITIES, 1.0)
    for name in NAMES:
        grows_with = "pings" if name in PINGS else "megapixels"
        spent = {
            run: took for run in sizes if (took := measured(run / name, run in timed)) is not None
        }
        if not spent:
            continue
        row: dict[str, object] = {"grows_with": grows_with}
        for quantity in QUANTITIES:
            counted = [run for run, took in spent.items() if quantity in took]
            grown = [getattr(sizes[run], grows_with) for run in counted]
            values = [spent[run][quantity] for run in counted]
            fixed, slope = fit_line(grown, values)
            row[quantity] = [float(f"{fixed:.3g}"), float(f"{slope:.3g}")]
            for size, value in zip(grown, values, strict=True):
                ratio = (fixed + slope * size) / value
                worst[quantity] = max(worst[quantity], ratio, 1 / ratio)
        steps[name] = row
    return {
        "runs": [
            {"megapixels": size.megapixels, "pings": size.pings, "timed": run in timed}
            for run, size in sizes.items()
        ],
        "worst_ratio": {name: round(ratio, 2) for name, ratio in worst.items()},
        "steps": steps,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN")
    parser.add_argument("--untimed", nargs="+", type=Path, default=[], metavar="RUN")
    parser.add_argument("--json", type=Path, help="write the table to this file")
    given = parser.parse_args()
    text = json.dumps(table(given.runs, given.untimed), indent=1) + "\n"
    print(text, end="")
    if given.json is not None:
        given.json.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
