# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What is made of a wrong CAD model: python -m benchmarks.wrong_cad PACKAGE RUN [--other MESH] [--json FILE]

Adjusts a simulated dive once more, from what RUN (its folder of results) holds, with its CAD model as given, mirrored end for
end, in the wrong units (those that the ship's length does not tell: others end where the mesh is read), stretched, of another
ship (--other, scaled to this one's length), and with a first guess of its pose that is 5 m and 15 degrees off. Each must be
found (the vehicle's errors in the hull within four of their sigmas) or refused.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.legs import in_sigmas, rigid_rms_mm
from hullrecon.adjustment.bundle_adjustment import adjust
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.problem.measurements import CadModel, Measurements
from hullrecon.adjustment.results.summary import summarise_adjustment
from hullrecon.dive.config import schema
from hullrecon.dive.config.load import load_config
from hullrecon.errors import StageError
from hullrecon.estimation.rig_priors import RIG_SECTIONS, rig_priors_from_settings
from hullrecon.evaluation.scoring.truth import Truth, read_mesh, read_truth
from hullrecon.geometry import poses
from hullrecon.geometry.charts.chart import chart_for_hull
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.steps.artifacts import IngestArtifact, LinksArtifact, MatchesArtifact, NavigateArtifact
from hullrecon.steps.chain import stages
from hullrecon.typing import Array

Change = Callable[[CadModel], CadModel]
FAR = (5.0, 15.0)  # m along the hull, deg of heading
NEAR_SIGMAS = 4.0


def measurements(package: Path, run: Path) -> tuple[Measurements, AdjustOptions]:
    """Return what the adjustment of a run was given."""
    config = load_config(package, {stage.name: stage.parameters for stage in stages()})
    ingest, navigate = IngestArtifact(run / "ingest"), NavigateArtifact(run / "navigate")
    hull = config.value("hull")
    if not isinstance(hull, schema.Hull) or ingest.hull is None:
        raise SystemExit(f"{package} has no CAD model")
    measured = Measurements(
        trajectory=navigate.trajectory,
        odometry=navigate.odometry,
        returns=navigate.returns,
        attitude=navigate.attitude,
        tracks=MatchesArtifact(run / "matches").tracks,
        start=LinksArtifact(run / "links").path.path(),
        rig=rig_priors_from_settings({name: config.value(name) for name in RIG_SECTIONS}, ingest.camera_models),
        cad_model=CadModel(
            mesh=ingest.hull,
            chart=chart_for_hull(ingest.hull),
            guess=poses.from_mount(hull.pose),
            guess_sigma=np.array(hull.pose_sigma) * np.r_[np.ones(3), np.full(3, np.pi / 180)],
            deviation_sigma=hull.deviation_sigma,
            deviation_length=hull.deviation_length,
        ),
    )
    return measured, AdjustOptions()


def with_vertices(cad_model: CadModel, vertices: Array, flip: bool = False) -> CadModel:
    """Return the model with other vertices; flip: the faces' sense too."""
    faces = cad_model.mesh.faces[:, ::-1].copy() if flip else cad_model.mesh.faces
    mesh = Mesh(vertices, faces)
    return replace(cad_model, mesh=mesh, chart=chart_for_hull(mesh))


def other_ship(cad_model: CadModel, path: Path) -> CadModel:
    """Return the model with another ship's mesh, of the same length, its middle where this one's is."""
    mesh = read_mesh(path)
    ours, theirs = (np.array([m.vertices.min(axis=0), m.vertices.max(axis=0)]) for m in (cad_model.mesh, mesh))
    scale = (ours[1, 0] - ours[0, 0]) / (theirs[1, 0] - theirs[0, 0])
    vertices = (mesh.vertices - theirs.mean(axis=0)) * scale + ours.mean(axis=0)
    placed = Mesh(vertices, mesh.faces)
    return replace(cad_model, mesh=placed, chart=chart_for_hull(placed))


def far_guess(cad_model: CadModel, vehicle: Array) -> CadModel:
    """Return the model with a first guess that is off by FAR, turned about the middle of the survey (3,) in g."""
    turn = poses.from_rpy([0.0, 0.0, 0.0], [0.0, 0.0, np.radians(FAR[1])])
    about = poses.from_rpy(vehicle, [0.0, 0.0, 0.0])
    along = cad_model.guess.rotation.apply([FAR[0], 0.0, 0.0]).ravel()
    moved = poses.from_rpy(along, [0.0, 0.0, 0.0])
    return replace(cad_model, guess=moved @ about @ turn @ about.inverse() @ cad_model.guess)


def cases(measured: Measurements, other: Path | None) -> Iterator[tuple[str, Change]]:
    """Yield the changes by name."""
    yield "as given", lambda c: c
    middle = measured.trajectory.translation.mean(axis=0)
    yield "guess 5 m and 15 deg off", lambda c: far_guess(c, middle)
    yield (
        "mirrored end for end",
        lambda c: with_vertices(
            c, c.mesh.vertices * [-1, 1, 1] + [c.mesh.vertices[:, 0].min() + c.mesh.vertices[:, 0].max(), 0, 0], flip=True
        ),
    )
    for name, factor in (("feet as metres", 3.28084), ("metres as feet", 0.3048), ("a fifth too large", 1.2)):
        yield name, lambda c, factor=factor: with_vertices(c, c.mesh.vertices * factor)
    yield "stretched by 0.8 and 1.3", lambda c: with_vertices(c, c.mesh.vertices * [1, 0.8, 1.3])
    if other is not None:
        yield f"another ship ({other.name})", lambda c: other_ship(c, other)


def outcome(measured: Measurements, options: AdjustOptions, truth: Truth) -> dict[str, object]:
    """Return what became of one model."""
    try:
        adjusted = adjust(measured, options, lambda sentence: None)
    except StageError as error:
        return {"verdict": "refused", "why": str(error)}
    solution = summarise_adjustment(measured, adjusted, options).solution
    rms = rigid_rms_mm(solution.t_ns, solution.global_from_vehicle.translation, truth)[0]
    if adjusted.refusal is not None:
        return {"verdict": "refused", "why": adjusted.refusal, "rigid_mm": rms}
    sigmas = in_sigmas(solution, truth)
    error = solution.track().poses.translation - truth.vehicle_at(solution.t_ns / 1e9).translation
    verdict = "found" if max(sigmas) < NEAR_SIGMAS else "WRONG"
    return {
        "verdict": verdict, "errors_in_sigmas": sigmas, "error_m": np.abs(error).mean(axis=0).tolist(), "rigid_mm": rms,
    }  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("package", type=Path)
    parser.add_argument("run", type=Path)
    parser.add_argument("--other", type=Path)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    measured, options = measurements(args.package, args.run)
    truth, rows = read_truth(args.package), {}
    for name, change in cases(measured, args.other):
        assert measured.cad_model is not None
        rows[name] = outcome(replace(measured, cad_model=change(measured.cad_model)), options, truth)
        print(f"{name}: {rows[name]}", flush=True)
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1))
    return int(any(row["verdict"] == "WRONG" for row in rows.values()))


if __name__ == "__main__":
    sys.exit(main())
