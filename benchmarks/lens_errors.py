# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether sigmas hold for lenses that are off: python -m benchmarks.lens_errors PACKAGE RUN
[--px 0.05 0.1 0.2] [--seeds 1 2 3 4 5] [--cameras stereo mono] [--landmarks N] [--json FILE]

Takes the tracks of a simulated dive from what RUN (its folder of results) holds, moves the features
by a smooth displacement of each lens that the calibration lacks (waves of at most one period over
the image, without what a calibration finds), adjusts and makes the hull as found anew. Links and
tracks stay, so a case costs an adjustment. Prints a line a case, errors over their delivered sigmas
by kind, and for each size and rig the rms over its seeds. `mono` takes the lower camera away,
--landmarks takes so many of them, evenly, to be sooner done.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np

from benchmarks.arguments import keep, parser_for
from benchmarks.legs import in_sigmas, rigid_rms_mm
from benchmarks.wrong_cad import measurements
from hullrecon.adjustment.bundle_adjustment import adjust
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.problem.measurements import Measurements
from hullrecon.adjustment.results.summary import summarise_adjustment
from hullrecon.detection.as_found.hull_as_found import as_found_surface, estimate_hull_as_found
from hullrecon.detection.as_found.landmarks import FieldBackground, measure_surface
from hullrecon.detection.deviation import split_deviation
from hullrecon.detection.find_structures import MAX_OFFSET_M
from hullrecon.detection.options import MIN_OFFSET_M, DetectOptions
from hullrecon.detection.views import views_of_top_camera
from hullrecon.evaluation.truth import Truth, read_truth
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.rigid_fit import fit_rigid
from hullrecon.records.solution import Solution
from hullrecon.typing import Array

Row = dict[str, float]
MOST_SIGMAS = 2.5
COARSE = DetectOptions(max_edge_m=0.05)  # of the hull as found, whose form alone is judged


def lens_error(pixels: Array, camera: CameraModel, rms_px: float, seed: int) -> Array:
    """Return the displacement (n, 2) of a lens at pixels (n, 2)."""
    rng = np.random.default_rng([seed, camera.width])
    waves = rng.uniform(-np.pi, np.pi, (2, 6, 3))

    def field(at: Array) -> Array:
        phase = waves[:, :, :2] @ at.T + waves[:, :, 2:]
        return np.asarray(np.cos(phase).sum(axis=1).T)

    sides = [np.linspace(-1, 1, 60)] * 2
    grid = np.stack(np.meshgrid(*sides), -1).reshape(-1, 2)
    plane = np.linalg.lstsq(np.c_[np.ones(len(grid)), grid], field(grid), rcond=None)[0]
    left = field(grid) - np.c_[np.ones(len(grid)), grid] @ plane
    scale = rms_px / np.sqrt((left**2).sum(axis=1).mean())
    at = (2 * pixels + 1) / [camera.width, camera.height] - 1
    return np.asarray(scale * (field(at) - np.c_[np.ones(len(at)), at] @ plane))


def through_wrong_lenses(measured: Measurements, rms_px: float, seed: int) -> Measurements:
    """Move the features by errors of both lenses."""
    tracks = measured.tracks
    assert tracks is not None
    for camera, model in measured.rig.camera_models.items():
        pixels = np.array(getattr(tracks, camera.value), float)
        seen = np.isfinite(pixels[:, 0])
        pixels[seen] -= lens_error(pixels[seen], model, rms_px, 2 * seed + camera.column)
        tracks = replace(tracks, **{camera.value: pixels})
    return replace(measured, tracks=tracks)


def some_landmarks(measured: Measurements, most: int) -> Measurements:
    """Take every k-th landmark."""
    tracks = measured.tracks
    assert tracks is not None
    every = -(-len(np.unique(tracks.landmark)) // most)
    return replace(measured, tracks=tracks.take(tracks.landmark % every == 0))


def by_top_camera(measured: Measurements) -> Measurements:
    """Take the lower camera away."""
    tracks, rig = measured.tracks, measured.rig
    assert tracks is not None
    kept = tracks.take(np.isfinite(tracks.top[:, 0]))
    models = {Camera.TOP: rig.camera_models[Camera.TOP]}
    return replace(
        measured,
        tracks=replace(kept, bottom=np.full_like(kept.bottom, np.nan)),
        rig=replace(rig, camera_models=models, top_from_bottom=None),
    )


def judge_form(solution: Solution, measured: Measurements, truth: Truth) -> Row:
    """Return errors of offset, tilt, form and landmarks, laid on the truth, in sigmas and mm."""
    cad, track, field = measured.cad_model, solution.track(), solution.deviation_field
    assert cad is not None
    assert field is not None
    assert solution.hull_pose is not None
    marks, scene = solution.landmarks, Scene(cad.mesh)
    rig = measured.rig.with_mounts(solution.mounts)
    place = solution.result_from_global().apply(marks.position)
    on_hull = measure_surface(
        scene, place, marks.covariance, marks.views,
        MAX_OFFSET_M, 0.5 * MIN_OFFSET_M, solution.hull_pose,
    )  # fmt: skip
    views = views_of_top_camera(rig, track, np.arange(track.image.max() + 1), place)
    assert views is not None
    background = FieldBackground(chart=cad.chart, field=field)
    found = estimate_hull_as_found(cad.mesh, on_hull, background, views, COARSE)
    surface = as_found_surface(found, on_hull)
    bare = np.abs(found.height) < MIN_OFFSET_M
    own = np.where(found.measured, found.sigma, 0.0)
    true = true_deviation(surface.vertices, scene, truth)
    surface = replace(surface, support=np.where(np.isfinite(true), surface.support, 0))
    ours, real = (
        split_deviation(s, own, bare, cad.mesh, cad.chart, solution.hull_pose)
        for s in (surface, replace(surface, deviation=true))
    )
    assert ours is not None
    assert real is not None
    error, seen = ours.form - real.form, bare & np.isfinite(ours.form)
    motion = fit_rigid(track.poses.translation, truth.vehicle_at(solution.t_ns / 1e9).translation)
    aligned = np.abs(truth.built.closest(motion.apply(surface.vertices[seen])).distance)
    seen_marks = truth.near(on_hull.position, 0.25) & (np.abs(on_hull.offset) < MIN_OFFSET_M)
    beside = truth.built.closest(motion.apply(on_hull.position)).distance
    return {
        "offset": float((ours.offset - real.offset) / ours.offset_sigma),
        "tilt": float(rms((ours.tilt - real.tilt) / ours.tilt_sigma)),
        "form": rms(error[seen] / ours.form_sigma[seen]),
        "landmarks": rms((beside / on_hull.sigma)[seen_marks]),
        "landmarks_aligned_mm": 1e3 * rms(beside[seen_marks]),
        "form_mm": 1e3 * rms(error[seen]),
        "form_sigma_mm": 1e3 * float(np.median(ours.form_sigma[seen])),
        "as_found_aligned_mm": 1e3 * rms(aligned),
    }


def true_deviation(points: Array, cad_model: Scene, truth: Truth) -> Array:
    """Return by how much the true hull stands off the CAD model at points (n, 3); NaN off it."""
    near = truth.built.closest(points)
    known = truth.near(points, 0.25) & (np.abs(near.distance) < 0.1)
    return np.where(known, cad_model.closest(near.foot).distance, np.nan)


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def judge(measured: Measurements, options: AdjustOptions, truth: Truth) -> Row:
    """Adjust, and compare with the truth."""
    began = time.process_time()
    adjusted = adjust(measured, options, lambda sentence: None)
    solution = summarise_adjustment(measured, adjusted, options).solution
    row: Row = {"cpu_s": time.process_time() - began}
    for name, value in zip("xyz", in_sigmas(solution, truth), strict=True):
        row[f"path_{name}"] = value
    row["rigid_mm"] = rigid_rms_mm(solution.t_ns, solution.global_from_vehicle.translation, truth)[
        0
    ]
    if solution.hull_pose is not None:
        row |= judge_form(solution, measured, truth)
    return row


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("package", type=Path)
    parser.add_argument("run", type=Path)
    parser.add_argument("--px", type=float, nargs="+", default=[0.05, 0.1, 0.2])
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5])
    parser.add_argument("--cameras", nargs="+", default=["stereo", "mono"])
    parser.add_argument("--landmarks", type=int, default=10**9)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    measured, options = measurements(args.package, args.run)
    measured = some_landmarks(measured, args.landmarks)
    truth, rows, failed = read_truth(args.package), {}, False
    for px, cameras in product(args.px, args.cameras):
        dive = by_top_camera(measured) if cameras == "mono" else measured
        cases = []
        for seed in args.seeds:
            cases.append(judge(through_wrong_lenses(dive, px, seed), options, truth))
            figures = " ".join(f"{name} {value:.2f}" for name, value in cases[-1].items())
            print(f"{px:g} px {cameras} seed {seed}: {figures}", flush=True)
        names = [n for n in cases[0] if n not in ("cpu_s",) and not n.endswith("_mm")]
        worst = {n: rms(np.array([case.get(n, np.inf) for case in cases])) for n in names}
        print(f"{px:g} px {cameras}: " + " ".join(f"{n} {v:.2f}" for n, v in worst.items()))
        failed |= max(worst.values()) > MOST_SIGMAS
        rows[f"{px:g} px {cameras}"] = {"cases": cases, "rms": worst}
    keep(rows, args.json)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
