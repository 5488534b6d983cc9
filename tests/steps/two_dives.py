# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Runs of simulated dives of one hull, with the files that a comparison reads and no others."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import msgspec
import numpy as np
from change.conftest import ADDED, GROWN
from change.simulated_surveys import BEFORE, cad_model, chart, drawn, survey

from hullrecon.artifacts.chain import Chain
from hullrecon.artifacts.executor import Executor
from hullrecon.artifacts.manifest import Manifest, Recipe, hash_file, write_manifest
from hullrecon.artifacts.runner import RunContext, StepOutcome, run_chain
from hullrecon.artifacts.stage import Context, Stage
from hullrecon.artifacts.workspace import Workspace
from hullrecon.change.options import EarlierDive
from hullrecon.dive.config.schema import Dive, Hull
from hullrecon.geometry.poses import identity
from hullrecon.records.change import HullSurvey
from hullrecon.records.serialisation import to_arrays
from hullrecon.records.solution import Landmarks, Mounts, Solution
from hullrecon.records.surface import DeviationSplit
from hullrecon.steps.chain import stage

STAGE = stage("change")

T_NS = 1_780_000_000_000_000_000
# three structures more, the lump gone, the cylinder 3 cm higher
AFTER = (GROWN, *BEFORE[1:3], *ADDED)
INPUTS = {"ingest": (), "adjust": ("ingest",), "surface": ("adjust",), "detect": ("surface",)}
Files = dict[str, dict[str, bytes]]


@cache
def may() -> HullSurvey:
    return survey(BEFORE, drawn(2), name="may")


@cache
def june() -> HullSurvey:
    return survey(AFTER, drawn(102), name="june")


def survey_files(found: HullSurvey, *, fits: bool = True) -> Files:
    """What the steps leave of a survey, by step and name. fits: the CAD model was not refused."""
    zero = np.zeros
    split = DeviationSplit(
        offset=zero(()),
        offset_sigma=zero(()),
        tilt=zero(2),
        tilt_sigma=zero(2),
        form=zero(len(found.form_sigma)),
        form_sigma=found.form_sigma,
    )
    landmarks = Landmarks(
        position=zero((0, 3)),
        covariance=zero((0, 3, 3)),
        label=zero(0, int),
        deviation=zero(0),
        views=zero(0, int),
        color=zero((0, 3), np.uint8),
    )
    solution = Solution(
        t_ns=np.array([T_NS]),
        image=np.full((1, 2), -1),
        global_from_vehicle=identity(),
        tray=zero(1),
        tray_sigma=zero(1),
        pose_covariance=zero((1, 6, 6)),
        landmarks=landmarks,
        mounts=Mounts(tray_from_dvl=identity(), tray_from_top=None, top_from_bottom=None),
        navigation_errors=zero(6),
        hull_pose=found.hull_pose if fits else None,
        deviation_field=None,
    )
    mesh = cad_model()
    return {
        "ingest": {"hull.npz": _npz(vertices=mesh.vertices, faces=mesh.faces)},
        "adjust": {"solution.npz": _npz(**to_arrays(solution))},
        "surface": {"chart.npz": _npz(**chart().to_arrays())},
        "detect": {
            "as_found.npz": _npz(**to_arrays(found.as_found)),
            "deviation.npz": _npz(**to_arrays(split)),
            "objects.json": json.dumps({"objects": msgspec.to_builtins(found.objects)}).encode(),
        },
    }


def _npz(**arrays: np.ndarray) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def write_run(folder: Path, *, cad_model: bool = True) -> Path:
    """The run of a dive with manifests, as a chain would have left it."""
    (folder / ".hullrecon").mkdir(parents=True)
    for step, files in survey_files(replace(may(), name=folder.name), fits=cad_model).items():
        (folder / step).mkdir()
        for name, data in files.items():
            (folder / step / name).write_bytes(data)
        outputs = {name: hash_file(folder / step / name) for name in files}
        recipe = Recipe(stage=step, version=1, settings={})
        write_manifest(folder / step, Manifest(recipe=recipe, key=recipe.key, outputs=outputs))
    return folder


class NoOptions(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A step without options."""


def _step(name: str, files: dict[str, bytes], fails: bool) -> Stage:
    def write(context: Context[NoOptions]) -> None:
        if fails:
            raise RuntimeError("out of order")
        for file, data in files.items():
            context.out.bytes(file, data)

    return Stage(
        name=name,
        summary=name,
        inputs=INPUTS[name],
        parameters=NoOptions,
        version=1,
        run=write,
        fails_alone=fails,
    )


def _report(context: Context[NoOptions]) -> None:
    """Deliver which inputs there were, and why others were not."""
    context.out.json(
        "deliver/summary.json", {"inputs": sorted(context.inputs), "absent": dict(context.failures)}
    )


class SimulatedDive:
    """A dive whose steps up to detect write what a survey holds; `change` is the library's own,
    `report` a stand-in.
    """

    def __init__(
        self,
        folder: Path,
        found: HullSurvey,
        earlier: str | None = None,
        *,
        no_detect: bool = False,
    ) -> None:
        self.package = folder / "packages" / found.name
        self.package.mkdir(parents=True, exist_ok=True)
        self.workspace = Workspace(folder / "runs" / found.name)
        self.earlier, self.hull = (
            earlier,
            Hull(mesh="hull.stl", pose=(0, 0, 0, 0, 0, 0), pose_sigma=(1, 1, 1, 1, 1, 1)),
        )
        self.name = found.name
        self.steps = tuple(
            _step(name, files, no_detect and name == "detect")
            for name, files in survey_files(found).items()
        )

    @property
    def chain(self) -> Chain:
        report = Stage(
            name="report",
            summary="report",
            inputs=("ingest",),
            optional=("detect", "change"),
            parameters=NoOptions,
            version=1,
            run=_report,
        )
        sections = {
            "dive": Dive(name=self.name),
            "hull": self.hull,
            "change": EarlierDive(earlier=self.earlier),
        }
        return Chain((*self.steps, STAGE, report), sections, self.package)

    def run(self, *, from_scratch: bool = False) -> dict[str, StepOutcome]:
        context = RunContext(self.workspace.hashes(), Executor())
        outcomes = run_chain(
            self.chain, self.workspace, context, from_scratch=from_scratch, keep_going=True
        )
        return {outcome.before.stage.name: outcome for outcome in outcomes}

    def summary(self) -> dict:
        return json.loads((self.workspace.root / "deliver" / "summary.json").read_text())

    def rewrite(
        self, step: str, edit: Callable[[dict[str, bytes]], dict[str, bytes]], found: HullSurvey
    ) -> None:
        """Have a step write other files from now on."""
        files = survey_files(found)
        changed = replace(_step(step, edit(files[step]), False), version=2)
        self.steps = tuple(changed if stage.name == step else stage for stage in self.steps)
