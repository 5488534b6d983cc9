# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A simulated dive package in a folder: dive.toml, logs, calibration, CAD model, truth."""

from __future__ import annotations

from pathlib import Path

from hullrecon.new_folder import new_folder
from hullrecon.synthetic.dive import Dive, simulate_dive
from hullrecon.synthetic.dive_toml import camera_info, cameras_of, dive_toml
from hullrecon.synthetic.hull_shapes import write_stl
from hullrecon.synthetic.logs import write_mcap, write_plain
from hullrecon.synthetic.options import DiveSpec
from hullrecon.synthetic.recorder import Streams, Track, record, without_progress
from hullrecon.synthetic.truth import write_truth


def write_package(folder: Path, spec: DiveSpec, track: Track = without_progress) -> Dive:
    """Simulate a dive and write its package, with the truth.

    It is written under a temporary name, so that a simulation that fails or is interrupted leaves
    nothing. Raises StorageError when the folder is not empty or cannot be written.
    """
    with new_folder(folder) as partial:
        dive = simulate_dive(spec)
        write_parts(partial, dive, record(dive, track))
    return dive


def write_parts(folder: Path, dive: Dive, streams: Streams) -> None:
    """Write the parts of a package into an empty folder, with the dive's sensor streams as logs."""
    write_stl(folder / "hull.stl", dive.cad_model)
    (folder / "logs").mkdir()
    if dive.spec.form == "mcap":
        write_mcap(folder / "logs" / "dive.mcap", streams)
    else:
        write_plain(folder / "logs", streams)
    for name, camera in cameras_of(dive).items():
        (folder / "calibration").mkdir(exist_ok=True)
        (folder / "calibration" / f"{name}.yaml").write_text(camera_info(name, camera))
    (folder / "truth").mkdir()
    write_truth(folder / "truth", dive)
    (folder / "dive.toml").write_text(dive_toml(dive))
