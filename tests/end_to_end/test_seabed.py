# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The real dark seabed: stereo images alone, no logs, no CAD model (stereo-haltbrekken, pairs 34 to
41).
"""

import csv
import json
from itertools import pairwise

import pytest
import rasterio
from end_to_end import seabed
from end_to_end.shell import COARSE, Shell

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def run(evaluation_data, tmp_path_factory):
    """The folder of a whole run, to be read."""
    shell = Shell(tmp_path_factory.mktemp("seabed"))
    seabed.write(evaluation_data / "stereo-haltbrekken", shell.folder / "seabed")
    shell("run", shell.folder / "seabed", "--runs", "out", *COARSE)
    return shell.folder / "out" / "seabed"


def seen_m2(path):
    """Area that an orthomosaic shows, by the alpha of its texels and their size."""
    with rasterio.open(path) as file:
        return float((file.read(4) > 0).sum() * abs(file.transform.a * file.transform.e))


def test_all_eight_pairs_of_the_seabed_join_in_one_path(run):
    deliver = run / "deliver"
    with (deliver / "trajectory.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 8
    steps = [
        sum((float(b[f"{k}_m"]) - float(a[f"{k}_m"])) ** 2 for k in "xyz") ** 0.5
        for a, b in pairwise(rows)
    ]
    # 0.37 to 0.55 m by the reference solution
    assert all(0.33 < step < 0.58 for step in steps[:-1]), steps
    assert steps[-1] == pytest.approx(0.11, abs=0.03)
    assert (deliver / "ortho_optical.png").exists()
    assert seen_m2(deliver / "ortho_optical.tif") > 4
    assert json.loads((deliver / "summary.json").read_text())["frame"] == "g"


def test_the_model_holds_all_images_on_a_rigid_baseline(run):
    import numpy as np
    import pycolmap

    model = pycolmap.Reconstruction(str(run / "adjust" / "colmap"))
    centres = {image.name: image.projection_center() for image in model.images.values()}
    assert len(centres) == 16
    tops = sorted(name for name in centres if name.startswith("camera_top"))
    bases = [
        np.linalg.norm(centres[name] - centres[name.replace("top", "bottom")]) for name in tops
    ]
    np.testing.assert_allclose(bases, bases[0], atol=1e-6)
    # as calibrated: without a DVL nothing tells its length
    np.testing.assert_allclose(bases, 0.305, atol=1e-3)


def test_a_rough_calibration_is_refined_and_said(run):
    summary = json.loads((run / "adjust" / "adjust.json").read_text())
    assert summary["stereo_contradiction"]["by_images"]
    warnings = json.loads((run / "adjust" / "manifest.json").read_text())["warnings"]
    assert any("stereo calibration does not hold" in sentence for sentence in warnings)
