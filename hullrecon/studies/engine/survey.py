# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The survey of [KimEustice2009 IV] made small: legs by one camera, a blank, a bare stern.

`benchmarks/mono_survey.py` has it in full size: seven legs of 30 m.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from hullrecon.api.dive_run import open_dive
from hullrecon.artifacts.executor import choose_executor
from hullrecon.artifacts.runner import RunContext, run_chain
from hullrecon.evaluation.trajectory import rms_length
from hullrecon.evaluation.truth import Truth, read_truth
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.steps.artifacts import LinksArtifact, NavigateArtifact
from hullrecon.studies.paths.link_plots import (
    LinkedBy,
    horizontal_sigma,
    in_hull,
    path_length,
    sigma_along_path,
    two_view_models,
)
from hullrecon.studies.paths.path_figures import MODEL_WORDS, by_two_view_model, linked_track
from hullrecon.studies.study import ComparedValue, StudyResult
from hullrecon.synthetic.options import Cameras, DiveSpec, Items, Paint, SensorErrors, Survey
from hullrecon.synthetic.package import write_package
from hullrecon.typing import Array

LEGS, LEG_M = 3, 5.0
SPEC = DiveSpec(
    name="survey",
    seed=1,
    sonar=False,
    form="plain",
    survey=Survey(legs=LEGS, leg_length_m=LEG_M, leg_spacing_m=0.5, standoff_m=1.5),
    cameras=Cameras(carried="mono", image_width=400, image_height=320, views=9.1),
    errors=SensorErrors(dvl_scale_error=0.01, heading_drift_deg_per_hour=60.0),
    items=Items(structures=4),
    paint=Paint(bare_share=0.333),
)
BLANK = (1.25, 1.75)  # of a leg's length, from the start: the middle half of the second leg
WAYS = 0.25  # m, over which a drop of the sigma is told


def study() -> StudyResult:
    """Simulate the survey, tie its path by either two-view model and by the choice, and score."""
    with tempfile.TemporaryDirectory() as folder:
        package = Path(folder) / SPEC.name
        write_package(package, SPEC)
        truth = read_truth(package)
        leave_blank(package / "logs" / "camera_top.csv", *blank_s(truth))
        dive = open_dive(package, Path(folder) / "runs")
        with choose_executor(1) as executor:
            context = RunContext(dive.workspace.hashes(), executor)
            run_chain(dive.chain.up_to("links"), dive.workspace, context)
            trajectory = NavigateArtifact(dive.workspace.artifact("navigate")).trajectory
            paths = by_two_view_model(dive, trajectory, context)
        links = LinksArtifact(dive.workspace.artifact("links"))
        tracks = {
            "dead reckoned": trajectory.track(),
            "with links": linked_track(trajectory, links.path),
        }
    return StudyResult(
        figures=(two_view_models(paths, truth), sigma_along_path(tracks)),
        compared=(*_compare_models(paths, truth), *_compare_sigmas(tracks)),
    )


def blank_s(truth: Truth) -> tuple[float, float]:
    """Find the times between which the second leg has no images, s."""
    way = path_length(truth.poses.translation)
    first, last = np.interp(np.array(BLANK) * LEG_M, way, truth.t_s)
    return float(first), float(last)


def leave_blank(table: Path, first_s: float, last_s: float) -> None:
    """Take the rows of a camera's table between two times out of it."""
    head, *rows = table.read_text().splitlines()
    kept = [row for row in rows if not first_s < float(row.partition(",")[0]) < last_s]
    table.write_text("\n".join([head, *kept]) + "\n")


def _compare_models(paths: dict[str, LinkedBy], truth: Truth) -> list[ComparedValue]:
    """Set the paths' errors beside the offset that the paper shows without a choice."""
    off = {model: error_m(paths[words].track, truth) for model, words in MODEL_WORDS.items()}
    values = [
        ComparedValue(
            what=f"error of the path from its true start, {words}",
            unit="mm",
            printed=None,
            ours=1e3 * off[model],
        )
        for model, words in MODEL_WORDS.items()
    ]
    worse = ComparedValue(
        what="further off by the essential matrix alone than by the choice",
        unit="m",
        printed=2.0,
        ours=off["essential"] - off["automatic"],
        note=(
            "printed: over 213 m, by false inliers that turned links. Here links are refined on "
            "inliers that agree with navigation, and cycles and scaling guard the path of "
            f"{LEGS * LEG_M:.0f} m: either model alone does about as well"
        ),
    )
    return [worse, *values]


def error_m(track: VehicleTrack, truth: Truth) -> float:
    """Measure the rms error of a path laid onto the truth at its start, m."""
    true = truth.vehicle_at(track.t_ns / 1e9).translation
    return rms_length(in_hull(track, truth).translation - true)


def _compare_sigmas(tracks: dict[str, VehicleTrack]) -> list[ComparedValue]:
    """Tell of both curves what the paper says of them."""
    sigma = {name: horizontal_sigma(track) for name, track in tracks.items()}
    reckoned, linked = sigma["dead reckoned"], sigma["with links"]
    falls = float(np.mean(np.diff(reckoned) < -1e-6))
    way = path_length(tracks["with links"].poses.translation)
    return [
        ComparedValue(
            what="steps at which dead reckoning's sigma falls",
            unit="%",
            printed=0.0,
            ours=100 * falls,
            note=(
                "increases monotonically, printed; here the DVL's scale and mount are part of it, "
                "whose errors cancel on the way back"
            ),
        ),
        ComparedValue(
            what="sigma at the end, with links over dead reckoned",
            unit="",
            printed=None,
            ours=float(linked[-1] / reckoned[-1]),
            note="bounded",
        ),
        ComparedValue(
            what="largest fall of the sigma with links, of its value",
            unit="%",
            printed=None,
            ours=100 * largest_fall(way, linked),
            note="a saw-tooth: falls where a leg is tied to an earlier one, after the blank too",
        ),
    ]


def largest_fall(way: Array, sigma: Array) -> float:
    """Find the largest share by which a sigma (n,) falls within WAYS of path (n,) m."""
    before = np.interp(way - WAYS, way, sigma)
    return float(np.max(1 - sigma / np.maximum(before, 1e-9)))
