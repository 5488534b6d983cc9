# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A problem from the process that makes it to those that solve it.

A solving process loads the tables alone, so that its peak memory is the solver's: no generator, no
SciPy.
"""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from hullrecon.native import Problem
from hullrecon.records.serialisation import from_arrays, to_arrays

ROOT = Path(__file__).resolve().parent.parent


def save(path: Path, problem: Problem, **truth: Any) -> None:
    """Save every table of a problem, and arrays under names truth_*."""
    np.savez(
        path, **to_arrays(problem), **{f"truth_{name}": array for name, array in truth.items()}
    )  # type: ignore[arg-type]


def load(path: Path) -> Problem:
    """Load the problem that `save` wrote, without the truth."""
    with np.load(path) as archive:
        problem = from_arrays(
            Problem,
            {name: archive[name] for name in archive.files if not name.startswith("truth_")},
        )
    return dataclasses.replace(
        problem, constant=tuple(str(c) for c in problem.constant), sigma_px=float(problem.sigma_px)
    )


def load_truth(path: Path) -> dict[str, np.ndarray[Any, Any]]:
    """Load the arrays that `save` was given as truth."""
    with np.load(path) as archive:
        return {
            name.removeprefix("truth_"): archive[name]
            for name in archive.files
            if name.startswith("truth_")
        }


def run(
    module: str, *arguments: object, python: str = sys.executable, threads: int = 2
) -> dict[str, Any]:
    """Run a module's main in a process of its own, and read the JSON that it writes.

    It is given the path for that as its last argument. Raises RuntimeError with the end of its
    standard error when it fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        answer = Path(folder) / "answer.json"
        call(module, *arguments, answer, python=python, threads=threads)
        return dict(json.loads(answer.read_text()))


def call(module: str, *arguments: object, python: str = sys.executable, threads: int = 2) -> None:
    """Run a module's main in a process of its own, as `run` does, without an answer."""
    command = [python, "-m", module, *(str(a) for a in arguments)]
    limits = {"OMP_NUM_THREADS": str(threads), "OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        command, cwd=ROOT, env=os.environ | limits, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(f"{module}: {done.stderr.strip()[-2000:]}")
