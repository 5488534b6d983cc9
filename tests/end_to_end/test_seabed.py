# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The real dark seabed: stereo images alone, no logs, no CAD model (stereo-haltbrekken, pairs 26 to 41)."""

import csv
import json
from itertools import pairwise

import pytest
from end_to_end import seabed

pytestmark = pytest.mark.slow


def test_all_sixteen_pairs_join_in_one_trajectory_and_make_a_mosaic(evaluation_data, shell, tmp_path):
    seabed.write(evaluation_data / "stereo-haltbrekken", tmp_path / "seabed")
    shell("run", tmp_path / "seabed", "--runs", "out", "--jobs", 2)
    deliver = shell.folder / "out" / "seabed" / "deliver"
    with (deliver / "trajectory.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 16
    steps = [sum((float(b[f"{k}_m"]) - float(a[f"{k}_m"])) ** 2 for k in "xyz") ** 0.5 for a, b in pairwise(rows)]
    assert all(0.25 < step < 0.75 for step in steps[:-1]), steps  # 0.37 to 0.55 m by the reference solution
    assert steps[-1] < 0.25
    assert (deliver / "ortho_optical.png").stat().st_size > 50_000
    assert json.loads((deliver / "summary.json").read_text())["frame"] == "g"


def test_the_model_holds_all_images_on_a_rigid_baseline(evaluation_data, shell, tmp_path):
    import numpy as np
    import pycolmap

    seabed.write(evaluation_data / "stereo-haltbrekken", tmp_path / "seabed")
    shell("run", tmp_path / "seabed", "--runs", "out", "--to", "adjust", "--jobs", 2)
    model = pycolmap.Reconstruction(str(shell.folder / "out" / "seabed" / "adjust" / "colmap"))
    centres = {image.name: image.projection_center() for image in model.images.values()}
    assert len(centres) == 32
    tops = sorted(name for name in centres if name.startswith("camera_top"))
    bases = [np.linalg.norm(centres[name] - centres[name.replace("top", "bottom")]) for name in tops]
    np.testing.assert_allclose(bases, 0.305, atol=1e-6)
