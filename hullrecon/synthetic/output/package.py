# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A simulated dive package in a folder: dive.toml, logs, calibration, CAD model, truth."""

from __future__ import annotations

from pathlib import Path

from hullrecon.new_folder import new_folder
from hullrecon.synthetic.dive import Dive, simulate_dive
from hullrecon.synthetic.output.calibration import camera_info, cameras_of
from hullrecon.synthetic.output.dive_toml import dive_toml
from hullrecon.synthetic.output.mcap_log import write_mcap
from hullrecon.synthetic.output.plain_log import write_plain
from hullrecon.synthetic.output.truth import write_truth
from hullrecon.synthetic.sensors.recorder import Track, record, without_progress
from hullrecon.synthetic.spec import DiveSpec
from hullrecon.synthetic.world.hull_shapes import write_stl


def write_package(folder: Path, spec: DiveSpec, track: Track = without_progress) -> Dive:
    """Simulate a dive, write its package and return it, truth and all. The folder may exist but must be empty; it is written
    beside under a temporary name, so that a simulation that fails or is interrupted leaves nothing. track: shows the
    images as they are written.

    Raises StorageError when the folder is not empty or cannot be written."""
    with new_folder(folder) as partial:
        dive = simulate_dive(spec)
        write_stl(partial / "hull.stl", dive.cad_model)
        (partial / "logs").mkdir()
        streams = record(dive, track)
        if spec.form == "mcap":
            write_mcap(partial / "logs" / "dive.mcap", streams)
        else:
            write_plain(partial / "logs", streams)
        for name, camera in cameras_of(dive).items():
            (partial / "calibration").mkdir(exist_ok=True)
            (partial / "calibration" / f"{name}.yaml").write_text(camera_info(name, camera))
        (partial / "truth").mkdir()
        write_truth(partial / "truth", dive)
        (partial / "dive.toml").write_text(dive_toml(dive))
    return dive
