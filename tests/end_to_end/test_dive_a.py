# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The whole chain on the simulated dive of the evaluation data, judged against its truth. Figures
in metres.
"""

import pytest

from hullrecon.evaluation.score import score_run

pytestmark = pytest.mark.slow

DELIVERED = (
    "summary.json",
    "trajectory.csv",
    "trajectory.tum",
    "alignment.json",
    "landmarks.ply",
    "colmap/images.bin",
    "surface.ply",
    "as_found.ply",
    "objects.json",
    "objects.csv",
    "coverage.json",
    "ortho_optical.tif",
    "ortho_optical.png",
    "ortho_sonar.tif",
    "ortho_sonar.png",
    "mosaic_optical.glb",
    "mosaic_sonar.glb",
    "tiles/optical/tileset.json",
    "tiles/sonar/tileset.json",
    "report/index.html",
)


@pytest.fixture(scope="module")
def dive(evaluation_data):
    return evaluation_data / "dive-a"


@pytest.fixture(scope="module")
def figures(dive, dive_a_run):
    """The run's figures against truth, and its deliverables."""
    return score_run(dive_a_run, dive), dive_a_run / "deliver"


def test_every_deliverable_is_there(figures):
    missing = [name for name in DELIVERED if not (figures[1] / name).exists()]
    assert missing == []
    assert list((figures[1] / "plots").glob("*.png"))


def test_trajectory_of_dive_a_errs_by_millimetres(figures):
    t = figures[0]["trajectory"]
    assert t["share_of_true_frames_with_a_pose"] >= 0.98
    assert t["girth_rmse_m"] <= 0.06
    assert t["normal_rmse_m"] <= 0.03
    assert t["rigid_rmse_m"] <= 0.003
    assert t["error_over_sigma_x"] <= 4


def test_the_cameras_are_as_good_as_images_alone_and_metric(figures):
    c = figures[0]["cameras"]
    assert c["images"] >= 225
    assert c["similarity_rmse_m"] <= 0.0015
    assert c["scale_error_percent"] <= 0.1


def test_landmarks_and_their_labels(figures):
    m = figures[0]["landmarks"]
    assert m["aligned_median_m"] <= 0.004
    assert m["off_recall"] >= 0.9
    assert m["off_precision"] >= 0.8


def test_surfaces(figures):
    assert figures[0]["surface"]["aligned_rmse_m"] <= 0.020
    assert figures[0]["as_found"]["aligned_rmse_m"] <= 0.006


def test_objects_are_found_once_and_nothing_false(figures):
    o = figures[0]["objects"]
    assert o["recall"] == 1.0
    assert o["false_reports"] == 0
    assert o["reported_twice"] == 0
    assert o["height_error_worst_m"] <= 0.02
