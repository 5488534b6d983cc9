# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether long, drifting legs close: python -m benchmarks.legs FOLDER [--dives NAME ...] [--seeds N
...] [--drifts D ...]

Simulates dives out and back along a hull into FOLDER (kept for next time; the drifts of one seed
share their images), adjusts each with its CAD model and, with --free, without, and compares the
path with the truth: dead reckoned, tied by links, adjusted. Prints a line a dive, and with --json
all figures: rms of the vehicle after rigid alignment, errors in sigmas by axis of the hull, share
of the pairs of images overlapping by 30 % across legs that links tie, directly or by way of a third
image, and what was said of the CAD model.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from mcap.reader import make_reader
from scipy.sparse import csr_array

from benchmarks.arguments import keep, parser_for
from hullrecon.evaluation.deliverables import TimedPoses
from hullrecon.evaluation.trajectory import hull_from_start
from hullrecon.evaluation.truth import Truth, read_truth
from hullrecon.geometry.frames import Frame
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.rigid_fit import fit_rigid, fit_scale
from hullrecon.new_folder import new_folder
from hullrecon.records.serialisation import from_arrays
from hullrecon.records.solution import Solution
from hullrecon.steps.artifacts import IngestArtifact, LinksArtifact, NavigateArtifact
from hullrecon.synthetic.dive import simulate_dive
from hullrecon.synthetic.logs import TOPICS, store
from hullrecon.synthetic.options import spec_from
from hullrecon.synthetic.package import write_package, write_parts
from hullrecon.synthetic.recorder import InTurn, record
from hullrecon.typing import Array, Ints, Mask
from hullrecon.vision.pairs.camera_track import CameraTrack
from hullrecon.vision.pairs.footprints import footprint_overlap

OVERLAPPING = 0.3  # a pair of images that share that much of their footprints
OTHER_LEG_M = 4.0  # path between two images of different legs, at least
DIVES: dict[str, dict[str, Any]] = {
    "stereo18": {"legs": 4, "leg_length_m": 18.0, "length_m": 120.0},
    "stereo45": {"legs": 2, "leg_length_m": 45.0, "length_m": 160.0},
    "stereo60": {"legs": 2, "leg_length_m": 60.0, "length_m": 200.0},
    "stereo100": {
        "legs": 2,
        "leg_length_m": 100.0,
        "length_m": 300.0,
        "beam_m": 40.0,
        "depth_m": 20.0,
        "draught_m": 14.0,
    },
    "mono18": {"cameras": "mono", "legs": 4, "leg_length_m": 18.0, "length_m": 120.0},
    "mono45": {"cameras": "mono", "legs": 2, "leg_length_m": 45.0, "length_m": 160.0},
}
Figures = dict[str, object]


@dataclass(frozen=True)
class NoErrors:
    """Poses that are true."""

    def relative_covariance(self, first: Ints, second: Ints) -> Array:
        """Return zeros (m, 6, 6)."""
        return np.zeros((len(first), 6, 6))


def hullrecon(*words: str) -> int:
    program = "import sys; from hullrecon_cli.main import main; sys.exit(main())"
    return subprocess.run([sys.executable, "-c", program, *words], check=False).returncode


def simulate(name: str, seed: int, drift: float, folder: Path, like: Path | None = None) -> Path:
    """Simulate the package unless it exists.

    like: a package of the same dive and seed with another drift, which has the same images.
    """
    package = folder / f"{name}-{seed}-{drift:g}"
    if (package / "truth").exists():
        return package
    spec = spec_from(
        name=package.name, sonar=False, seed=seed, heading_drift_deg_per_hour=drift, **DIVES[name]
    )
    if like is None:
        write_package(package, spec)
        return package
    (log,) = (like / "logs").glob("*.mcap")
    with new_folder(package) as partial:
        dive = simulate_dive(spec)
        streams = record(dive)
        frames = zip(
            *[logged_images(log, TOPICS[camera][0]) for camera in streams.cameras], strict=True
        )
        write_parts(partial, dive, replace(streams, frames=InTurn(frames)))
    return package


def logged_images(log: Path, topic: str) -> Iterator[bytes]:
    """Yield the files of one camera in the order of time."""
    with log.open("rb") as file:
        for schema, _, message in make_reader(file).iter_messages(topics=[topic]):
            assert schema is not None
            yield bytes(store().deserialize_cdr(message.data, schema.name).data)


def without_cad_model(package: Path, run: Path) -> tuple[Path, Path]:
    """Return the same dive as a package that names no CAD model, and a folder of runs that holds
    what is known of it.
    """
    free, runs = package.with_name(f"free-{package.name}"), run.parent.with_name("runs-without")
    if not free.exists():
        shutil.copytree(package, free, copy_function=os.link)
        text = (package / "dive.toml").read_text()
        (free / "dive.toml").unlink()
        (free / "dive.toml").write_text(re.sub(r"\[hull\]\n(?:[^\[\n][^\n]*\n|\n)*", "", text))
    if not (runs / package.name).exists():
        # it names the other package
        shutil.copytree(run, runs / package.name, ignore=shutil.ignore_patterns("workspace.json"))
    return free, runs


def run_to_adjust(package: Path, runs: Path) -> bool:
    return hullrecon("run", "-q", str(package), "--runs", str(runs), "--to", "adjust") == 0


def rigid_rms_mm(t_ns: Ints, positions: Array, truth: Truth) -> tuple[float, float]:
    """Return the rms after rigid alignment, mm, and the scale by which the path is too short."""
    true = truth.vehicle_at(t_ns / 1e9).translation
    motion = fit_rigid(positions, true)
    error = motion.apply(positions) - true
    return 1e3 * float(np.sqrt((error**2).sum(axis=1).mean())), fit_scale(positions, true, motion)


def in_sigmas(solution: Solution, truth: Truth, has_depth: bool = True) -> list[float]:
    """Return the rms of the vehicle's errors in their own sigmas, by axis of the hull; without a
    CAD model by axis of g, from where the path begins.
    """
    track = solution.track()
    t_s = track.t_ns / 1e9
    inside = (t_s >= truth.t_s[0]) & (t_s <= truth.t_s[-1])
    true = truth.vehicle_at(t_s)
    if track.frame is Frame.GLOBAL:
        told = TimedPoses(t_s=t_s, poses=track.poses, has_depth=has_depth)
        true = hull_from_start(told, truth).inverse() @ true
    error = (track.poses.translation - true.translation) / track.sigma[:, :3]
    return [float(x) for x in np.sqrt((error[inside] ** 2).mean(axis=0))]


def true_revisits(run: Path, truth: Truth) -> tuple[Ints, Ints, int]:
    """Return the pairs of nodes (first, second) of different legs that have top images that truly
    overlap, and the number of nodes.
    """
    from scipy.spatial import cKDTree

    solution = np.load(run / "adjust" / "solution.npz")
    t_s = solution["t_ns"] / 1e9
    vehicle = truth.vehicle_at(t_s)
    cameras = truth.cameras_at(nearest_frames(truth.t_s, t_s))
    camera = next(iter(IngestArtifact(run / "ingest").camera_models.values()))
    axis = cameras.rotation.as_matrix()[:, :, 2]
    depth = np.asarray(cast(truth.built, cameras.translation, axis))
    along_path = np.r_[0, np.cumsum(np.linalg.norm(np.diff(vehicle.translation, axis=0), axis=1))]
    seen = cameras.translation + np.where(np.isfinite(depth), depth, 0)[:, None] * axis
    reach = float(np.nanmedian(depth)) * np.hypot(
        camera.width / camera.fx, camera.height / camera.fy
    )
    first, second = cKDTree(seen).query_pairs(reach, output_type="ndarray").T
    has_image = NavigateArtifact(run / "navigate").trajectory.image[:, 0] >= 0
    apart = (
        (along_path[second] - along_path[first] > OTHER_LEG_M)
        & has_image[first]
        & has_image[second]
    )
    first, second = first[apart], second[apart]
    track = CameraTrack(global_from_camera=cameras, errors=NoErrors())
    overlap = footprint_overlap(
        track, first, second, np.where(np.isfinite(depth), depth, np.nan), camera
    )
    return first[overlap >= OVERLAPPING], second[overlap >= OVERLAPPING], len(t_s)


def nearest_frames(frame_s: Array, t_s: Array) -> Ints:
    """Return the frames (n,) nearest in time; the frame after a time is the wrong one where the two
    differ by rounding. frame_s: ascending.
    """
    after = np.clip(np.searchsorted(frame_s, t_s), 1, len(frame_s) - 1)
    return np.asarray(after - (t_s - frame_s[after - 1] < frame_s[after] - t_s))


def cast(surface: Scene, origin: Array, direction: Array) -> Array:
    """Return the distances (n,) to the surface."""
    return surface.cast(origin, direction)


def tied(run: Path, first: Ints, second: Ints, nodes: int) -> Mask:
    """Mark the pairs that a link joins, or two links by way of a third image."""
    pairs = LinksArtifact(run / "links").pairs
    ends = pairs.first[pairs.joined], pairs.second[pairs.joined]
    linked = csr_array((np.ones(len(ends[0])), ends), shape=(nodes, nodes))
    linked = linked + linked.T
    return np.asarray((linked + linked @ linked)[first, second] > 0)


def figures(run: Path, package: Path) -> Figures:
    """Score one run."""
    truth = read_truth(package)
    said = json.loads((run / "adjust" / "adjust.json").read_text())
    navigate, links = (
        np.load(run / "navigate" / "trajectory.npz"),
        np.load(run / "links" / "path.npz"),
    )
    arrays = dict(np.load(run / "adjust" / "solution.npz"))
    solution = from_arrays(Solution, arrays)
    rms, scale = rigid_rms_mm(solution.t_ns, arrays["global_from_vehicle.translation"], truth)
    row: Figures = {
        "nodes": len(solution.t_ns),
        "dead_reckoning_mm": rigid_rms_mm(navigate["t_ns"], navigate["translation"], truth)[0],
        "links_mm": rigid_rms_mm(navigate["t_ns"], links["pose"][:, :3], truth)[0],
        "adjust_mm": rms,
        "scale_error": scale - 1,
        "parts": len(np.unique(links["part"])),
        "cad_model_refused": said.get("cad_model_refused"),
    }
    has_depth = bool(NavigateArtifact(run / "navigate").attitude.has_depth.any())
    row["errors_in_sigmas"] = in_sigmas(solution, truth, has_depth)
    return row


def dive(package: Path, folder: Path, free: bool) -> Figures:
    """Score one dive with its CAD model and, if asked, without."""
    runs = folder / "runs"
    run = runs / package.name
    if not run_to_adjust(package, runs):
        return {"failed": True}
    row = figures(run, package)
    first, second, nodes = true_revisits(run, read_truth(package))
    row["revisits"] = len(first)
    row["revisits_tied"] = float(tied(run, first, second, nodes).mean()) if len(first) else None
    if free:
        bare, bare_runs = without_cad_model(package, run)
        row["without_cad"] = (
            figures(bare_runs / package.name, package)
            if run_to_adjust(bare, bare_runs)
            else {"failed": True}
        )
    return row


def line(name: str, row: Figures) -> str:
    """Format one dive's figures as a line."""
    if row.get("failed"):
        return f"{name}: FAILED"
    sigmas = " ".join(f"{x:.2f}" for x in row.get("errors_in_sigmas", []))
    free = row.get("without_cad")
    beside = (
        f", without CAD {free['adjust_mm']:.2f}"
        if isinstance(free, dict) and "adjust_mm" in free
        else ""
    )
    share = 100 * (row["revisits_tied"] or 0)
    return (
        f"{name}: {row['nodes']} nodes, rigid rms mm: dead reckoning "
        f"{row['dead_reckoning_mm']:.0f}, links"
        f" {row['links_mm']:.2f}, adjusted {row['adjust_mm']:.2f}{beside}; errors in sigmas "
        f"{sigmas}; scale"
        f" {1e6 * row['scale_error']:.0f} ppm; {row['revisits']} revisits, {share:.0f} % tied;"
        f" parts {row['parts']}; CAD refused: {row['cad_model_refused']}"
    )


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--dives", nargs="+", choices=DIVES, default=["stereo18", "stereo45"])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1])
    parser.add_argument("--drifts", nargs="+", type=float, default=[100.0], help="deg/h")
    parser.add_argument("--free", action="store_true", help="adjust also without the CAD model")
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    rows: dict[str, Figures] = {}
    for name in args.dives:
        for seed in args.seeds:
            first = simulate(name, seed, args.drifts[0], args.folder)
            for drift in args.drifts:
                package = simulate(name, seed, drift, args.folder, first)
                rows[package.name] = dive(package, args.folder, args.free)
                print(line(package.name, rows[package.name]), flush=True)
                keep(rows, args.json)
    return 0


if __name__ == "__main__":
    sys.exit(main())
