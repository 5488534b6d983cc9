# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Accuracy and honesty on simulated dives: python -m benchmarks.dives FOLDER --hulls HULLS
[--cameras mono] [--json FILE]

Ten dives of other hulls, curvatures, deviations, backlash, guesses and seeds are simulated into
FOLDER (kept for next time), run, and scored against their truth. HULLS holds the meshes named in
DIVES; without it only the analytic hulls are dived. `mono` is the same dive with its lower camera
removed. Prints each figure by dive with median and worst, and the vehicle's NEES. With
--drawn the ten are others: their first guesses and the hull's deviation are drawn from the sigmas
that their packages state, as a test of those sigmas needs.
"""

from __future__ import annotations

import gzip
import re
import shutil
import statistics
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.arguments import keep, parser_for
from hullrecon.evaluation.score import score_run
from hullrecon.evaluation.truth import read_truth
from hullrecon.geometry.poses import Poses

BASE = "--no-sonar --legs 4 --leg-length-m 5 --views 6"
DIVES = {
    "d1": "",
    "d2": "--length-m 90 --beam-m 15 --depth-m 9 --draught-m 6 --bilge-radius-m 2 --backlash-deg "
    "0.8 --guess-along-m 0.8"
    " --guess-across-m 0.3 --guess-turn-deg 3 --top-m 2",
    "d3": "--length-m 25 --beam-m 6 --depth-m 3.5 --draught-m 2.6 --bilge-radius-m 0.9 "
    "--deviation-sigma-m 0.02"
    " --deviation-length-m 1.5 --top-m 0.9 --leg-spacing-m 0.5",
    "d4": "--hull DTC-scaled_decimated30k.stl --length-m 120 --draught-m 5 --top-m 1.5 --along-m "
    "90",
    "d5": "--hull JBC_rigidBodyHull_HULL.obj --length-m 90 --draught-m 5 --top-m 1.5 --along-m "
    "70 --servo-sigma-deg 0.15",
    "d6": "--hull kvlcc2_lq_3dpea.stl --length-m 333.6 --draught-m 18 --top-m 4 --along-m 160",
    "d7": "--hull wigley.stl --length-m 60 --draught-m 3.75 --top-m 0.9 --along-m 40 "
    "--deviation-mean-m 0.01",
    "d8": "--hull DTC-scaled_decimated30k.stl --length-m 60 --draught-m 3.5 --top-m 1.0 "
    "--along-m 12 --guess-along-m 1.0"
    " --guess-across-m 0.4 --guess-turn-deg 5",
    "d9": "--length-m 70 --beam-m 11 --depth-m 7 --draught-m 5 --entrance 0.45 --visibility-m "
    "3.5 --backlash-deg 0.2",
    "d10": "--deviation-sigma-m 0.005 --deviation-mean-m 0 --standoff-m 1.4 --speed-m-per-s 0.4 "
    "--structures 8",
}
# length, beam, depth, draught, bilge radius, m
SHIPS = ("80 13 8 5.5 1.8", "30 6.5 4 3 1.0", "50 9 5.5 3.8 1.3")


def drawn_dives(count: int = 10) -> dict[str, str]:
    """Return options of dives whose truth is drawn from what their packages state.

    Guesses lie within the metre and five degrees that registration is made for.
    """
    random, dives = np.random.default_rng(2026), {}
    for k in range(1, count + 1):
        along, across = np.clip(random.normal(0, [1.0, 0.5]), -1, 1)
        turn, mean = np.clip(random.normal(0, 5), -5, 5), random.normal(0, 0.014)
        ship = zip(
            ("length", "beam", "depth", "draught", "bilge-radius"),
            SHIPS[(k - 1) % 3].split(),
            strict=True,
        )
        dives[f"n{k}"] = (
            "--leg-length-m 4 --views 5 --structures 2 --marks 1 --barnacles 1 "
            "--deviation-sigma-m 0.02 --deviation-length-m 3"
            f" --deviation-mean-m {mean:.4f} --guess-along-m {along:.3f} --guess-across-m "
            f"{across:.3f}"
            f" --guess-turn-deg {turn:.2f} "
        ) + " ".join(f"--{name}-m {value}" for name, value in ship)
    return dives


# (figure, the limit that the project holds itself to; negative: at least)
FIGURES: tuple[tuple[str, float | None], ...] = (
    ("trajectory.girth_rmse_m", 0.06),
    ("trajectory.normal_rmse_m", 0.03),
    ("trajectory.rigid_rmse_m", 0.003),
    ("trajectory.along_rmse_m", None),
    ("trajectory.median_sigma_x_m", None),
    ("trajectory.error_over_sigma_x", 4.0),
    ("trajectory.error_over_sigma_y", 2.0),
    ("trajectory.error_over_sigma_z", 2.0),
    ("cameras.similarity_rmse_m", 0.0015),
    ("cameras.scale_error_percent", 0.1),
    ("landmarks.aligned_median_m", 0.004),
    ("landmarks.off_recall", -0.9),
    ("landmarks.off_precision", -0.8),
    ("surface.aligned_rmse_m", 0.02),
    ("as_found.aligned_rmse_m", 0.006),
    ("objects.recall", -1.0),
    ("objects.height_error_worst_m", 0.02),
    ("objects.false_reports", 0.0),
    ("objects.reported_twice", 0.0),
)


def simulate(name: str, options: str, seed: int, folder: Path, hulls: Path | None) -> Path | None:
    """Return the package, made once; None when it needs a mesh that is not at hand."""
    package = folder / name
    if (package / "truth").exists():
        return package
    words = f"{BASE} {options}".split()
    if "--hull" in words:
        at = words.index("--hull") + 1
        mesh = _mesh(words[at], folder, hulls)
        if mesh is None:
            return None
        words[at] = str(mesh)
    _hullrecon("simulate", "-q", str(package), "--name", name, "--seed", str(seed), *words)
    return package


def _mesh(name: str, folder: Path, hulls: Path | None) -> Path | None:
    if hulls is None:
        return None
    if (hulls / name).exists():
        return hulls / name
    packed, plain = hulls / f"{name}.gz", folder / name
    if not packed.exists():
        return None
    plain.write_bytes(gzip.decompress(packed.read_bytes()))
    return plain


def without_lower_camera(package: Path) -> Path:
    """Return the same dive as a package whose dive.toml does not name the lower camera."""
    mono = package.with_name("mono-" + package.name)
    if mono.exists():
        return mono
    shutil.copytree(package, mono)
    text = (package / "dive.toml").read_text()
    text = re.sub(r"^name = .*$", f'name = "{mono.name}"', text, count=1, flags=re.M)
    text = re.sub(r"^camera_bottom = .*\n", "", text, flags=re.M)
    (mono / "dive.toml").write_text(
        re.sub(r"\[camera\.bottom\]\n(?:[^\[\n][^\n]*\n|\n)*", "", text)
    )
    return mono


def _hullrecon(*words: str) -> None:
    program = "import sys; from hullrecon_cli.main import main; sys.exit(main())"
    subprocess.run([sys.executable, "-c", program, *words], check=True)


def nees(adjust: Path, package: Path) -> float:
    """Return (x - x_true)' C^-1 (x - x_true) of the vehicle's pose in the hull (six freedoms) at
    the dive's middle pose.

    One value a dive: errors of neighbouring poses are one and the same, that of the hull's pose.
    """
    solution = np.load(adjust / "solution.npz")
    middle = len(solution["t_ns"]) // 2
    pose, hull = (
        Poses(
            np.atleast_2d(solution[f"{name}.quaternion"])[row],
            np.atleast_2d(solution[f"{name}.translation"])[row],
        )
        for name, row in (("global_from_vehicle", [middle]), ("hull_pose.global_from_hull", [0]))
    )
    ours, true = (
        hull.inverse() @ pose,
        read_truth(package).vehicle_at(solution["t_ns"][middle : middle + 1] / 1e9),
    )
    turn = (true.rotation.inv() * ours.rotation).as_rotvec()[0]
    error = np.r_[ours.translation[0] - true.translation[0], turn]
    return float(error @ np.linalg.solve(solution["pose_covariance"][middle], error))


def dive(package: Path, folder: Path, mono: bool, jobs: int) -> dict[str, Any]:
    """Run one simulated dive and score it."""
    package = without_lower_camera(package) if mono else package
    _hullrecon("run", "-q", str(package), "--runs", str(folder / "runs"), "--jobs", str(jobs))
    run = folder / "runs" / package.name
    return score_run(run, package) | {"nees": nees(run / "adjust", package)}


def figure(row: dict[str, Any], name: str) -> float:
    part, key = name.split(".")
    return float(row.get(part, {}).get(key, float("nan")))


def table(rows: dict[str, dict[str, Any]]) -> list[str]:
    """Tabulate figures by dive; a star marks a broken limit."""
    lines = [f"{'':30s}" + "".join(f"{name:>9s} " for name in rows) + "   median     worst"]
    for name, limit in FIGURES:
        values = [figure(row, name) for row in rows.values()]
        worst = (min if limit is not None and limit < 0 else max)(values)
        cells = "".join(f"{v:9.4f}{'*' if breaks(v, limit) else ' '}" for v in values)
        lines.append(f"{name:30s}{cells}{statistics.median(values):9.4f} {worst:9.4f}")
    return lines


def breaks(value: float, limit: float | None) -> bool:
    """Tell whether a figure breaks its limit; one that is missing (NaN) does."""
    return limit is not None and not (value <= limit if limit >= 0 else value >= -limit)


def consistency(values: list[float]) -> dict[str, float]:
    """Return the sum of the dives' NEES and its 95 % band."""
    from scipy.stats import chi2

    low, high = (float(chi2.ppf(p, 6 * len(values))) for p in (0.025, 0.975))
    return {"dives": len(values), "sum": float(sum(values)), "low": low, "high": high}


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--hulls", type=Path)
    parser.add_argument("--cameras", choices=("stereo", "mono"), default="stereo")
    parser.add_argument("--drawn", action="store_true")
    parser.add_argument("--only", nargs="+", metavar="NAME")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    rows: dict[str, dict[str, Any]] = {}
    dives, seed = (drawn_dives(), 101) if args.drawn else (DIVES, 11)
    for k, (name, options) in enumerate(dives.items()):
        if args.only and name not in args.only:
            continue
        package = simulate(name, options, seed + k, args.folder, args.hulls)
        if package is None:
            print(f"{name}: left out, its hull's mesh is not in --hulls", flush=True)
            continue
        row = rows[name] = dive(package, args.folder, args.cameras == "mono", args.jobs)
        print(
            f"{name}: rigid {1e3 * figure(row, 'trajectory.rigid_rmse_m'):.2f} mm, NEES "
            f"{row['nees']:.1f}",
            flush=True,
        )
    together = consistency([row["nees"] for row in rows.values()])
    print("\n".join(table(rows)))
    print("NEES {dives:.0f} dives: {sum:.1f}, 95 % band {low:.1f} to {high:.1f}".format(**together))
    keep({"cameras": args.cameras, "dives": rows, "nees": together}, args.json)
    return 0


if __name__ == "__main__":
    sys.exit(main())
