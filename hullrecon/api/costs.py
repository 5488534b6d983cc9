# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Predict what a run costs: time, memory and disk of each step, from the size of the dive.

Each is a fixed part plus one proportional to the size, as measured on finished runs. The table is
step_costs.json, which `python -m benchmarks.step_costs RUN... --json FILE` writes anew. It knows
neither this machine's speed nor how much images overlap, so that predictions are approximate.
"""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from importlib import resources
from pathlib import Path

import numpy as np

from hullrecon.findings.finding import Finding
from hullrecon.geometry.cameras import CameraModel
from hullrecon.records.sensors import ImageIndex, SonarPings
from hullrecon.steps.artifacts import IngestArtifact

TABLE = "step_costs.json"
QUANTITIES = ("seconds", "memory_mb", "disk_mb")
DEFAULT_SHARE = 0.5  # of the machine's memory, for a run
# Factor by which a prediction may be too high: it extrapolates from short dives to long ones. A
# dive is refused only if half of the predicted memory is too much.
MAX_ERROR = 2.0


@dataclass(frozen=True, kw_only=True)
class DiveSize:
    """The quantities with which the cost of a dive grows."""

    megapixels: float  # of all images of all cameras
    pings: int  # of the imaging sonar


@dataclass(frozen=True, kw_only=True)
class StepCost:
    """The predicted cost of a step."""

    step: str
    seconds: float
    memory_mb: float  # peak of the process and its workers, one a core
    disk_mb: float  # of its artifact


def size_of(
    images: Mapping[str, ImageIndex], cameras: Mapping[str, CameraModel], sonar: SonarPings | None
) -> DiveSize:
    """Measure the dive from what was read of the package, images and cameras by camera."""
    pixels = [
        len(index.t_ns) * cameras[name].width * cameras[name].height
        for name, index in images.items()
        if name in cameras
    ]
    return DiveSize(megapixels=sum(pixels) / 1e6, pings=0 if sonar is None else len(sonar.t_ns))


def size_of_run(run: Path) -> DiveSize:
    """Measure the dive of a run (RUNS/<dive>) whose package was read."""
    artifact = IngestArtifact(run / "ingest")
    models = artifact.camera_models
    indices = {camera.key: artifact.image_index(camera) for camera in models}
    images = {name: index for name, index in indices.items() if index is not None}
    return size_of(images, {c.key: model for c, model in models.items()}, artifact.sonar)


@cache
def _table() -> Mapping[str, Mapping[str, object]]:
    """Read the table: for each step the quantity that it grows with, and a line for each cost."""
    text = (resources.files("hullrecon.api") / TABLE).read_text(encoding="utf-8")
    steps: Mapping[str, Mapping[str, object]] = json.loads(text)["steps"]
    return steps


def predict(size: DiveSize, steps: Iterable[str]) -> list[StepCost]:
    """Predict the cost of those steps. Steps that the table does not know are left out."""
    costs = []
    for step in steps:
        row = _table().get(step)
        if row is None:
            continue
        grown = getattr(size, str(row["grows_with"]))
        numbers = {name: _line(row[name], grown) for name in QUANTITIES}
        costs.append(StepCost(step=step, **numbers))
    return costs


def _line(coefficients: object, grown: float) -> float:
    """Evaluate a line (fixed part, slope) at the size of the dive."""
    fixed, slope = np.asarray(coefficients, float)
    return float(fixed + slope * grown)


def half_of_machine_gb() -> float:
    """Compute half of the machine's memory, GB: the default of --memory."""
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return DEFAULT_SHARE * machine / 1e9


def fit_together(
    steps: Collection[str], costs: Sequence[StepCost], memory_gb: float | None
) -> bool:
    """Decide whether steps may run at the same time.

    Two may, if the memory of both together is at most what a run may take. More may not, nor steps
    whose cost is not known.

    Parameters
    ----------
    steps
        Their names.
    costs
        Predicted costs of the steps of the run.
    memory_gb
        What a run may take, half of the machine's if None.
    """
    allowed_gb = half_of_machine_gb() if memory_gb is None else memory_gb
    memory_mb = [cost.memory_mb for cost in costs if cost.step in steps]
    return len(memory_mb) == len(steps) == 2 and sum(memory_mb) <= 1000 * allowed_gb


def findings_of(
    costs: Sequence[StepCost],
    memory_gb: float | None,
    beside: Iterable[tuple[str, str]] = (),
) -> list[Finding]:
    """Make the findings about the cost of a run: its figures, and a lack of memory.

    A step that needs more memory than the run may take gives a warning, or an error if it needs
    MAX_ERROR times as much. Two steps at once are not judged, as they run at once only if both fit.
    Empty without costs.

    Parameters
    ----------
    costs
        Predicted costs of the steps that are to be run.
    memory_gb
        What a run may take, half of the machine's if None.
    beside
        Pairs of steps that run at the same time if they fit together.
    """
    if not costs:
        return []
    most = max(costs, key=lambda cost: cost.memory_mb)
    memory_mb = {cost.step: cost.memory_mb for cost in costs}
    at_once = memory_mb | {
        f"{one} beside {other}": memory_mb[one] + memory_mb[other]
        for one, other in beside
        if fit_together((one, other), costs, memory_gb)
    }
    peak = max(at_once, key=at_once.__getitem__)
    found = Finding(
        "run-costs",
        {
            "seconds": sum(cost.seconds for cost in costs),
            "memory_mb": at_once[peak],
            "step": peak,
            "disk_mb": sum(cost.disk_mb for cost in costs),
            "steps": [asdict(cost) for cost in costs],
        },
    )
    allowed_gb = half_of_machine_gb() if memory_gb is None else memory_gb
    if most.memory_mb <= 1000 * allowed_gb:
        return [found]
    is_certain = most.memory_mb > MAX_ERROR * 1000 * allowed_gb
    (least,) = predict(DiveSize(megapixels=0, pings=0), [most.step])
    values = {
        "step": most.step,
        "needed_gb": most.memory_mb / 1000,
        "allowed_gb": allowed_gb,
        "least_gb": least.memory_mb / 1000,  # whatever the dive's length
    }
    return [found, Finding("memory-over-budget" if is_certain else "memory-tight", values)]
