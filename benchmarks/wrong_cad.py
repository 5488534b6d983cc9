# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What is made of a wrong CAD model: python -m benchmarks.wrong_cad PACKAGE RUN [--other MESH ...]
[--only NAME ...]

Lays CAD models under the path of a simulated dive, from what RUN (its folder of results) holds: the
one that is given, mirrored end for end, in the wrong units (those that the ship's length does not
tell: others end where the mesh is read), too large, stretched along one axis, of other ships, and
with a first guess of its pose that is 5 m and 15 degrees off. Other ships are analytic ones and the
meshes of --other, scaled to this one's length. Too large and stretched ones, and other ships, pass
through the place where the guess has the survey: only their form can speak against them. Each must
be found (the vehicle's errors in the hull within four of their sigmas) or refused; of another ship,
whose frame is not that of the truth, what is printed is by how much the path's place differs from
where the guess has it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from benchmarks.arguments import keep, parser_for
from benchmarks.legs import in_sigmas, rigid_rms_mm
from hullrecon.adjustment.bundle_adjustment import (
    join_path_and_place,
    solve_all_landmarks,
    solve_path,
)
from hullrecon.adjustment.cad_placement import place_cad_model
from hullrecon.adjustment.options import PRODUCT, AdjustOptions
from hullrecon.adjustment.problem.measurements import CadModel, Measurements
from hullrecon.adjustment.results.summary import summarise_adjustment
from hullrecon.adjustment.rounds import Phase, RoundSolver
from hullrecon.dive.config import schema
from hullrecon.dive.config.load import load_config
from hullrecon.dive.config.mounts import guess_sigma
from hullrecon.dive.config.schema import RIG_SECTIONS
from hullrecon.errors import StageError
from hullrecon.evaluation.truth import Truth, read_truth
from hullrecon.geometry import poses
from hullrecon.geometry.charts.chart import chart_for_hull
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.rig import rig_with_priors
from hullrecon.steps.artifacts import (
    IngestArtifact,
    LinksArtifact,
    MatchesArtifact,
    NavigateArtifact,
)
from hullrecon.steps.chain import stages
from hullrecon.synthetic.hull_shapes import hull_from_mesh, ship_form
from hullrecon.synthetic.options import Ship
from hullrecon.typing import Array

Change = Callable[[CadModel], CadModel]
FAR = (5.0, 15.0)  # m along the hull, deg of heading
NEAR_SIGMAS = 4.0
# length, beam, depth, bilge radius, m
SHIPS = ((30.0, 6.5, 4.0, 1.0), (90.0, 15.0, 9.0, 2.0), (50.0, 12.0, 5.5, 2.6))


def measurements(package: Path, run: Path) -> tuple[Measurements, AdjustOptions]:
    """Read the inputs of a run's adjustment."""
    config = load_config(package, {stage.name: stage.parameters for stage in stages()})
    ingest, navigate = IngestArtifact(run / "ingest"), NavigateArtifact(run / "navigate")
    hull = config.value("hull")
    if not isinstance(hull, schema.Hull) or ingest.hull is None:
        raise SystemExit(f"{package} has no CAD model")
    links, matches = run / "links", run / "matches"
    measured = Measurements(
        trajectory=navigate.trajectory,
        odometry=navigate.odometry,
        returns=navigate.returns,
        attitude=navigate.attitude,
        tracks=MatchesArtifact(matches).tracks if matches.exists() else None,
        start=LinksArtifact(links).path.path() if links.exists() else None,
        rig=rig_with_priors(
            {name: config.value(name) for name in RIG_SECTIONS}, ingest.camera_models
        ),
        cad_model=CadModel(
            mesh=ingest.hull,
            chart=chart_for_hull(ingest.hull),
            guess=poses.from_mount(hull.pose),
            guess_sigma=guess_sigma(hull.pose, hull.pose_sigma)
            * np.r_[np.ones(3), np.full(3, np.pi / 180)],
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


def survey_center(measured: Measurements, cad_model: CadModel) -> Array:
    """Return the point (3,) of the CAD model, in M, that the guess lays nearest to the middle of
    the path.
    """
    middle = cad_model.guess.inverse().apply(measured.trajectory.translation).mean(axis=0)
    found = cad_model.mesh.index.closest(middle[None])
    return np.asarray(middle - found.distance[0] * found.gradient[0])


def scaled(cad_model: CadModel, factors: Array, about: Array) -> CadModel:
    """Return the model stretched by factors (3,) along its axes about a point (3,) of M."""
    return with_vertices(cad_model, (cad_model.mesh.vertices - about) * factors + about)


def other_ship(cad_model: CadModel, mesh: Mesh, place: Array) -> CadModel:
    """Return the model with another ship's mesh, whose side passes through `place` (3,) where its
    length and depth have the same shares.
    """
    ours, theirs = (
        np.array([m.vertices.min(axis=0), m.vertices.max(axis=0)]) for m in (cad_model.mesh, mesh)
    )
    at = theirs[0] + (place - ours[0]) / (ours[1] - ours[0]) * (theirs[1] - theirs[0])
    side = np.sign(place[1] - ours.mean(axis=0)[1]) or 1.0
    outside = np.array(
        [at[0], theirs.mean(axis=0)[1] + side * (theirs[1, 1] - theirs[0, 1]), at[2]]
    )
    distance = float(Scene(mesh).cast(outside[None], np.array([[0.0, -side, 0.0]]))[0])
    at[1] = outside[1] - side * distance
    moved = Mesh(mesh.vertices - at + place, mesh.faces)
    return replace(cad_model, mesh=moved, chart=chart_for_hull(moved))


def far_guess(cad_model: CadModel, vehicle: Array) -> CadModel:
    """Return the model with a first guess that is off by FAR, turned about the middle of the survey
    (3,) in g.
    """
    turn = poses.from_rpy([0.0, 0.0, 0.0], [0.0, 0.0, np.radians(FAR[1])])
    about = poses.from_rpy(vehicle, [0.0, 0.0, 0.0])
    along = cad_model.guess.rotation.apply([FAR[0], 0.0, 0.0]).ravel()
    moved = poses.from_rpy(along, [0.0, 0.0, 0.0])
    return replace(cad_model, guess=moved @ about @ turn @ about.inverse() @ cad_model.guess)


def cases(
    measured: Measurements, cad_model: CadModel, others: Sequence[Path]
) -> Iterator[tuple[str, Change]]:
    """Yield the changes by name."""
    path, place = measured.trajectory.translation.mean(axis=0), survey_center(measured, cad_model)
    low, high = cad_model.mesh.vertices.min(axis=0), cad_model.mesh.vertices.max(axis=0)
    yield "as given", lambda c: c
    yield "guess 5 m and 15 deg off", lambda c: far_guess(c, path)
    mirrored = cad_model.mesh.vertices * [-1, 1, 1] + [low[0] + high[0], 0, 0]
    yield "mirrored end for end", lambda c: with_vertices(c, mirrored, flip=True)
    for name, factor in (
        ("feet as metres", 3.28084),
        ("metres as feet", 0.3048),
        ("a fifth too large from its origin", 1.2),
    ):
        yield name, lambda c, factor=factor: scaled(c, np.full(3, factor), np.zeros(3))
    for factor in (1.05, 1.2):
        yield (
            f"too large by {factor}",
            lambda c, factor=factor: scaled(c, np.full(3, factor), place),
        )
    for factor in (1.1, 1.3):
        for axis, way in enumerate(("length", "beam", "depth")):
            factors = np.where(np.arange(3) == axis, factor, 1.0)
            yield (
                f"stretched in {way} by {factor}",
                lambda c, factors=factors: scaled(c, factors, place),
            )
    yield "stretched by 0.8 and 1.3", lambda c: scaled(c, np.array([1, 0.8, 1.3]), np.zeros(3))
    for length, beam, depth, bilge in SHIPS:
        ship = Ship(
            length_m=length, beam_m=beam, depth_m=depth, draught_m=0.7 * depth, bilge_radius_m=bilge
        )
        yield (
            f"another ship ({length:.0f} m)",
            lambda c, ship=ship: other_ship(c, ship_form(ship), place),
        )
    for mesh in others:
        yield (
            f"another ship ({mesh.name})",
            lambda c, mesh=mesh: other_ship(c, hull_from_mesh(mesh, high[0] - low[0]), place),
        )


def outcome(
    path: Phase, measured: Measurements, solver: RoundSolver, truth: Truth
) -> dict[str, object]:
    """Adjust a dive with one model and return the outcome."""
    assert measured.cad_model is not None
    estimate = replace(path.estimate, measured=replace(measured, rig=path.estimate.measured.rig))
    on_path = replace(path, estimate=estimate)
    try:
        placed = place_cad_model(on_path, measured.cad_model, solver)
    except StageError as error:
        return {"verdict": "refused", "why": str(error)}
    assert placed.placement is not None
    registered, form = placed.placement.registration, placed.placement.shape
    row: dict[str, object] = {
        "fitness": registered.fitness,
        "guess_in_sigmas": registered.sigmas_off,
    }
    if form is not None:
        row["form"] = asdict(form) | {"log_odds": form.log_odds}
    if not placed.verdict.accepted:
        return row | {"verdict": "refused", "why": placed.verdict.reason}
    adjusted = solve_all_landmarks(join_path_and_place(on_path, placed), solver)
    summary = summarise_adjustment(measured, adjusted, solver.options)
    solution = summary.solution
    sigmas = in_sigmas(solution, truth)
    track = solution.track()
    error = track.poses.translation - truth.vehicle_at(solution.t_ns / 1e9).translation
    return row | {
        "verdict": "found" if max(sigmas) < NEAR_SIGMAS else "WRONG",
        "errors_in_sigmas": sigmas,
        "error_m": np.abs(error).mean(axis=0).tolist(),
        "sigma_m": np.median(track.sigma[:, :3], axis=0).tolist(),
        "rigid_mm": rigid_rms_mm(solution.t_ns, solution.global_from_vehicle.translation, truth)[0],
        "warnings": summary.warnings,
    }


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("package", type=Path)
    parser.add_argument("run", type=Path)
    parser.add_argument("--other", type=Path, nargs="+", default=[], help="meshes of other ships")
    parser.add_argument("--only", nargs="+", default=[""], help="cases whose name begins so")
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    measured, options = measurements(args.package, args.run)
    assert measured.cad_model is not None
    truth, rows = read_truth(args.package), {}
    solver = RoundSolver(
        calibrated=measured.rig, options=options, strategy=PRODUCT, report=lambda sentence: None
    )
    path = solve_path(measured, solver)
    for name, change in cases(measured, measured.cad_model, args.other):
        if not name.startswith(tuple(args.only)):
            continue
        rows[name] = outcome(
            path, replace(measured, cad_model=change(measured.cad_model)), solver, truth
        )
        print(f"{name}: {rows[name]}", flush=True)
    keep(rows, args.json)
    return int(any(row["verdict"] == "WRONG" for row in rows.values()))


if __name__ == "__main__":
    sys.exit(main())
