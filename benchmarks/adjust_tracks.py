# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Memory and time of the whole adjustment of a long dive: python -m benchmarks.adjust_tracks
[--pairs 250 1000 4000] [--landmarks-a-pair 100] [--json FILE]

Synthetic tracks of both cameras on a ship's side at a real density: seven views a landmark, some 35
poses that share landmarks with a pose. No images are rendered. Every round runs, then covariances,
solution and COLMAP model, as in the step `adjust`; each dive in a process of its own. `peak_mb` is
of the whole process, `given_mb` what it held before: the tracks and the libraries. `growth` has the
exponents of the number of pairs from the smallest dive to the largest.
"""

from __future__ import annotations

import json
import math
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.arguments import keep, parser_for
from benchmarks.partition import pixels_of, status_mb, views_of
from benchmarks.problems import NOISE_PX, Truth, simulate
from benchmarks.subprocess_runner import call, run
from benchmarks.survey import (
    CAMERA,
    TOP_FROM_BOTTOM,
    TRAY_FROM_DVL,
    TRAY_FROM_TOP,
    TRAY_ORIGIN,
    Size,
    hull_mesh,
)
from hullrecon import native
from hullrecon.adjustment.bundle_adjustment import adjust
from hullrecon.adjustment.options import AdjustOptions
from hullrecon.adjustment.problem.measurements import CadModel, Measurements
from hullrecon.adjustment.problem.triangulation import camera_poses
from hullrecon.adjustment.results.colmap_export import SparseModel, write_model
from hullrecon.adjustment.results.summary import summarise_adjustment
from hullrecon.artifacts.stage import map_arrays
from hullrecon.geometry import poses
from hullrecon.geometry.charts.chart import chart_for_hull
from hullrecon.geometry.frames import Camera
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.records.serialisation import from_arrays, to_arrays
from hullrecon.records.tracks import Tracks
from hullrecon.records.trajectory import Attitude, Odometry, Returns, Trajectory, VehiclePath
from hullrecon.rig import Rig, RigPriors, mount_prior

STEP_S = 0.8
START_M, START_RAD = 0.003, 0.0005  # sigmas of the path that `links` found
MOUNT_SIGMA = (0.005, 0.005, 0.005, 0.5, 0.5, 0.5)  # m and degrees
GUESS_SIGMA = np.r_[0.5, 0.2, 0.2, np.radians([0.5, 0.5, 1.0])]
DEVIATION_SIGMA_M, DEVIATION_LENGTH_M = 0.02, (3.0, 1.5)
# DVL scale, heading drift rad/s, roll, pitch, depth m, backlash rad
NAVIGATION_SIGMA = np.array([0.005, 1e-5, 2e-3, 2e-3, 0.03, 0.01])
PARTS = {"trajectory": Trajectory, "odometry": Odometry, "returns": Returns, "attitude": Attitude}


def size_of(pairs: int, landmarks_a_pair: int) -> Size:
    """Choose the legs of a dive: its patch is some eight times as long as it is high."""
    legs = max(4, 2 * round(math.sqrt(pairs / 40)))
    return Size(pairs, pairs, pairs * landmarks_a_pair, stereo=True, legs=legs)


def make(pairs: int, landmarks_a_pair: int, views: float, seed: int = 0) -> dict[str, Any]:
    """Make the records of a dive by name, as arrays."""
    size = size_of(pairs, landmarks_a_pair)
    problem, truth = simulate(size, seed)
    rng = np.random.default_rng(seed + 1)
    first = problem.unknowns.pose
    trajectory = Trajectory(
        t_ns=10**18 + (STEP_S * 1e9 * np.arange(pairs)).astype(np.int64),
        quaternion=first[:, 3:7],
        translation=first[:, :3],
        covariance=np.tile(1e-4 * np.eye(6), (pairs, 1, 1)),
        tray=problem.tray.measured,
        image=np.tile(np.arange(pairs)[:, None], (1, 2)),
    )
    small = np.r_[np.full(3, START_M), np.full(3, START_RAD)] * rng.standard_normal((pairs, 6))
    near = truth.nodes @ poses.exp(small)
    records = {
        "trajectory": trajectory,
        "odometry": _odometry(problem.odometry),
        "returns": _returns(problem.ranges, trajectory.t_ns),
        "attitude": _attitude(problem.attitude),
        "tracks": _tracks(size, truth, views, rng),
        "start": Trajectory(
            **(vars(trajectory) | {"quaternion": near.quaternion, "translation": near.translation})
        ),
    }
    arrays = {f"{n}.{k}": v for n, record in records.items() for k, v in to_arrays(record).items()}
    return arrays | {
        "guess": poses.pose_vector(truth.global_from_hull),
        "truth": truth.nodes.translation,
    }


def _odometry(table: native.OdometryTable) -> Odometry:
    m = len(table.first)
    by_navigation = np.zeros((m, 6, 2))
    by_navigation[:, :3, 0], by_navigation[:, 5, 1] = table.measured[:, :3], STEP_S
    information = table.sqrt_information
    return Odometry(
        first=table.first.astype(np.int64),
        second=table.second.astype(np.int64),
        quaternion=table.measured[:, 3:7],
        translation=table.measured[:, :3],
        covariance=np.linalg.inv(information.transpose(0, 2, 1) @ information),
        by_navigation=by_navigation,
        by_mount=np.zeros((m, 6, 3)),
        by_tray=np.zeros((m, 6)),
        from_images=np.zeros(m, bool),
    )


def _returns(table: native.RangeTable, t_ns: np.ndarray[Any, Any]) -> Returns:
    return Returns(
        t_ns=t_ns[table.node],
        node=table.node.astype(np.int64),
        quaternion=table.offset[:, 3:7],
        translation=table.offset[:, :3],
        tray_offset=table.tray_offset,
        beam=table.beam,
        range_m=table.measured,
        flagged=np.zeros(len(table.node), bool),
    )


def _attitude(table: native.AttitudeTable) -> Attitude:
    depth, roll, pitch = table.measured.T
    n = len(depth)
    return Attitude(
        node=np.arange(n),
        depth=depth,
        roll=roll,
        pitch=pitch,
        sigma=table.sigma,
        nodes_per_reading=np.ones(n),
        tray_direction=np.zeros(n),
        tray_sigma=np.zeros(n),
    )


def _tracks(size: Size, truth: Truth, views: float, rng: np.random.Generator) -> Tracks:
    node, landmark = views_of(size, truth, views, rng)
    order = np.lexsort((node, landmark))
    node, landmark = node[order], landmark[order]
    pixel = pixels_of(truth, node, landmark)
    pixel += 0.3 * NOISE_PX * rng.standard_normal(pixel.shape)
    return Tracks(
        landmark=landmark,
        node=node,
        top=np.ascontiguousarray(pixel[:, :2]),
        bottom=np.ascontiguousarray(pixel[:, 2:]),
        response=rng.uniform(0.01, 0.05, len(node)),
        color=np.full((size.landmarks, 3), 100, np.uint8),
    )


def rig() -> Rig:
    """Build the rig that `benchmarks.survey` flies, with its priors."""
    return Rig(
        tray_origin=TRAY_ORIGIN,
        pressure_origin=np.zeros(3),
        tray_from_dvl=TRAY_FROM_DVL,
        tray_from_top=TRAY_FROM_TOP,
        top_from_bottom=TOP_FROM_BOTTOM,
        camera_models=dict.fromkeys(Camera, CAMERA),
        priors=RigPriors(
            tray_from_dvl=mount_prior(TRAY_FROM_DVL, (1e-6, 1e-6, 1e-6, 0.5, 0.5, 0.5)),
            tray_from_top=mount_prior(TRAY_FROM_TOP, MOUNT_SIGMA),
            dvl_position_sigma_m=np.full(3, 0.01),
            tray_sigma_rad=0.01,
            navigation_sigma=NAVIGATION_SIGMA,
            density_sigma=0.002,
            pixel_sigma_px=1.0,
            calibration_sigma_px=(0.1, 0.1),
            range_sigma_m=0.02,
        ),
    )


def measurements(path: Path) -> Measurements:
    """Read what `make` made, with the CAD model."""
    with np.load(path) as archive:
        arrays = {name: archive[name] for name in archive.files if not name.startswith("tracks.")}
    arrays |= {name: of for name, of in map_arrays(path).items() if name.startswith("tracks.")}

    def record(name: str, kind: type[Any]) -> Any:
        mine = {k[len(name) + 1 :]: v for k, v in arrays.items() if k.startswith(f"{name}.")}
        return from_arrays(kind, mine)

    start = record("start", Trajectory)
    vertices, faces = hull_mesh(depth_m=size_of(len(start.t_ns), 0).depth_m)
    far = len(vertices)
    mesh = Mesh(
        np.vstack([vertices, vertices * [1, -1, 1]]), np.vstack([faces, faces[:, ::-1] + far])
    )
    cad_model = CadModel(
        mesh=mesh,
        chart=chart_for_hull(mesh),
        guess=poses.pose_from_vector(arrays["guess"]),
        guess_sigma=GUESS_SIGMA,
        deviation_sigma=DEVIATION_SIGMA_M,
        deviation_length=DEVIATION_LENGTH_M,
    )
    return Measurements(
        **{name: record(name, kind) for name, kind in PARTS.items()},
        tracks=record("tracks", Tracks),
        rig=rig(),
        cad_model=cad_model,
        start=VehiclePath(poses=Poses(start.quaternion, start.translation), tray=start.tray),
    )


def measure(path: Path, parts: str) -> dict[str, Any]:
    """Adjust the dive as the step does, and write what it writes."""
    measured = measurements(path)
    row: dict[str, Any] = {"given_mb": status_mb("VmRSS"), "lines": []}
    begun, cpu = time.perf_counter(), time.process_time()

    def tell(line: str) -> None:
        at = f"{time.process_time() - cpu:.1f} s, peak {status_mb('VmHWM'):.0f} MB: {line}"
        row["lines"].append(at)
        print(at, file=sys.stderr, flush=True)

    options = AdjustOptions(threads=2, parts=parts if parts == "auto" else int(parts))
    adjusted = adjust(measured, options, tell)
    tell("adjusted")
    outcome = summarise_adjustment(measured, adjusted, options)
    tell("summarised")
    with tempfile.TemporaryDirectory() as folder:
        np.savez(Path(folder) / "solution.npz", **to_arrays(outcome.solution))
        state, tracks = adjusted.state, measured.tracks
        assert tracks is not None
        assert state.hull is not None
        to_hull = state.hull.global_from_hull.inverse()
        model = SparseModel(
            tracks=tracks,
            top=adjusted.chosen.top,
            bottom=adjusted.chosen.bottom,
            hull_from_top=to_hull @ camera_poses(adjusted.rig, state)[0],
            top_from_bottom=state.mounts.top_from_bottom,
            cameras=(CAMERA, CAMERA),
            stamps=np.tile(measured.trajectory.t_ns[:, None], (1, 2)),
            position=to_hull.apply(state.landmark),
        )
        write_model(model, Path(folder))
    tell("written")
    error = adjusted.state.nodes.translation - np.load(path)["truth"]
    return row | {
        "pairs": len(measured.trajectory.t_ns),
        "landmarks": len(adjusted.chosen.landmarks),
        "observations": len(tracks.node),
        "wall_s": time.perf_counter() - begun,
        "cpu_s": time.process_time() - cpu,
        "peak_mb": status_mb("VmHWM"),
        "rms_mm": 1e3 * float(np.sqrt(np.mean((error - error.mean(axis=0)) ** 2))),
        "parts": adjusted.plan.facts()["count"],
        "summary": outcome.summary,
    }


def main() -> int:
    """Measure each dive, or do the work of a child."""
    if sys.argv[1:2] == ["--make"]:
        np.savez(Path(sys.argv[2]), **make(int(sys.argv[3]), int(sys.argv[4]), float(sys.argv[5])))
        return 0
    if sys.argv[1:2] == ["--measure"]:
        found = measure(Path(sys.argv[2]), sys.argv[3])
        Path(sys.argv[4]).write_text(json.dumps(found, default=float), encoding="utf-8")
        return 0
    parser = parser_for(__doc__)
    parser.add_argument("--pairs", type=int, nargs="+", default=[250, 1000, 4000])
    parser.add_argument("--landmarks-a-pair", type=int, default=100)
    parser.add_argument("--views", type=float, default=7.0)
    parser.add_argument("--parts", default="auto")
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    rows = []
    for pairs in args.pairs:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "dive.npz"
            module = "benchmarks.adjust_tracks"
            call(module, "--make", path, pairs, args.landmarks_a_pair, args.views)
            rows.append(run(module, "--measure", path, args.parts))
        row = rows[-1]
        print(
            f"{pairs} pairs, {row['landmarks']} landmarks: {row['cpu_s']:.0f} s CPU, "
            f"{row['wall_s']:.0f} s, peak {row['peak_mb']:.0f} MB ({row['given_mb']:.0f} given), "
            f"{row['parts']} parts",
            flush=True,
        )
    if len(rows) > 1:
        times = math.log(rows[-1]["pairs"] / rows[0]["pairs"])
        for name in ("cpu_s", "peak_mb"):
            print(f"growth of {name}: {math.log(rows[-1][name] / rows[0][name]) / times:.2f}")
    keep(rows, args.json)
    return 0


if __name__ == "__main__":
    sys.exit(main())
