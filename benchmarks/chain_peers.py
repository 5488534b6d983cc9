# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The whole chain beside pycolmap's sparse pipeline: python -m benchmarks.chain_peers PACKAGE
[--threads N] [--json FILE]

hullrecon runs all steps of the dive, all cameras and sensors, to its report. pycolmap makes
features, matches and a sparse model of the top camera's images alone, with its calibration, on as
many cores, afterwards in the same call. `make bench-peers` makes its environment. Prints JSON:
seconds of both, and ours as a share of theirs.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from benchmarks.arguments import parser_for
from benchmarks.legs import hullrecon
from benchmarks.peers import THEIRS
from benchmarks.subprocess_runner import run
from hullrecon.api.dive_run import open_dive
from hullrecon.dive.images.store import ImageStore
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.frames import Camera
from hullrecon.steps.artifacts import IngestArtifact

JPEG = b"\xff\xd8"  # how a file begins


def run_ours(package: Path, runs: Path, threads: int) -> dict[str, Any]:
    """Run all steps of a dive anew, and time the command."""
    begun = time.perf_counter()
    if hullrecon("run", "-q", str(package), "--runs", str(runs), "--jobs", str(threads)):
        raise RuntimeError(f"the chain failed on {package}")
    return {"total_s": round(time.perf_counter() - begun, 1)}


def write_images(store: ImageStore, folder: Path) -> int:
    """Write the usable images of a camera as they were logged, in the order of time."""
    rows = store.index.usable.nonzero()[0]
    for number, row in enumerate(rows):
        data = store.bytes(int(row))
        suffix = "jpg" if data.startswith(JPEG) else "png"
        (folder / f"{number:06d}.{suffix}").write_bytes(data)
    return len(rows)


def full_opencv(camera: CameraModel) -> str:
    """Write a calibration as COLMAP's camera FULL_OPENCV has it."""
    pinhole = (camera.fx, camera.fy, camera.cx + 0.5, camera.cy + 0.5)  # of a pixel's corner
    return ",".join(
        map(repr, (*pinhole, camera.k1, camera.k2, camera.p1, camera.p2, camera.k3, 0.0, 0.0, 0.0))
    )


def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("package", type=Path)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    if not THEIRS.exists():
        parser.error("the peers' environment is missing: make bench-peers")
    package = args.package.resolve()
    with tempfile.TemporaryDirectory() as folder:
        runs, images = Path(folder) / "runs", Path(folder) / "images"
        images.mkdir()
        ours = run_ours(package, runs, args.threads)
        ingest = IngestArtifact(open_dive(package, runs).workspace.artifact("ingest"))
        count = write_images(ingest.images(Camera.TOP, package), images)
        calibration = full_opencv(ingest.camera_models[Camera.TOP])
        theirs = run(
            "benchmarks.peer_pycolmap_chain",
            *(images, calibration, args.threads),
            python=str(THEIRS),
            threads=args.threads,
        )
    text = json.dumps(
        {
            "dive": package.name,
            "images_of_top_camera": count,
            "threads": args.threads,
            "hullrecon": ours,
            "pycolmap": theirs,
            "share": round(ours["total_s"] / theirs["total_s"], 3),
        },
        indent=1,
    )
    print(text)
    if args.json:
        args.json.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
