# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from pathlib import Path

import numpy as np
import pycolmap
import pytest

from hullrecon.evaluation.trajectory import centre_figures, score_cameras
from hullrecon.evaluation.truth import Truth, read_truth


@pytest.fixture(scope="module")
def truth(package: Path) -> Truth:
    return read_truth(package)


@pytest.fixture(scope="module")
def centres(truth: Truth) -> np.ndarray:
    return truth.cameras_at(np.arange(len(truth.t_s))).translation


def test_true_centres_have_no_error(truth: Truth, centres: np.ndarray) -> None:
    figures = centre_figures(truth.t_s, centres, truth)
    assert figures["images"] == 41
    assert figures["rmse_m"] == pytest.approx(0, abs=1e-9)
    assert figures["scale_error_percent"] == pytest.approx(0, abs=1e-6)


def test_a_scale_is_told_apart_from_the_rest(truth: Truth, centres: np.ndarray) -> None:
    figures = centre_figures(truth.t_s, 1.01 * np.add(centres, [0, 0, 4]), truth)
    assert figures["scale_error_percent"] == pytest.approx(100 * (1 - 1 / 1.01), abs=1e-6)
    assert figures["similarity_rmse_m"] == pytest.approx(0, abs=1e-9)
    assert float(figures["rigid_rmse_m"]) > 0.01
    assert float(figures["rmse_m"]) > 3.9


def test_images_at_other_times_are_left_out(truth: Truth, centres: np.ndarray) -> None:
    t = truth.t_s.copy()
    t[:5] += 0.01
    assert centre_figures(t, centres, truth)["images"] == 36


def test_two_images_are_too_few_for_a_figure(truth: Truth, centres: np.ndarray) -> None:
    assert centre_figures(truth.t_s[:2], centres[:2], truth) == {"images": 2}


def test_a_colmap_model_is_read_by_the_names_of_its_images(
    truth: Truth, centres: np.ndarray, tmp_path: Path
) -> None:
    model = pycolmap.Reconstruction()
    model.add_camera_with_trivial_rig(
        pycolmap.Camera(
            model="PINHOLE", width=640, height=480, params=[600, 600, 320, 240], camera_id=1
        )
    )
    for k, (t, centre) in enumerate(zip(truth.t_s, np.add(centres, [0.0, 0.02, 0.0]), strict=True)):
        name = f"camera_{'bottom' if k == 0 else 'top'}/{round(t * 1e9)}.jpg"
        pose = pycolmap.Rigid3d(pycolmap.Rotation3d(np.eye(3)), -centre)
        model.add_image_with_trivial_frame(
            pycolmap.Image(name=name, camera_id=1, image_id=k + 1), pose
        )
    model.write(str(tmp_path))
    figures = score_cameras(tmp_path, truth)
    assert figures["images"] == 40  # the lower camera's is not counted
    assert figures["rmse_m"] == pytest.approx(0.02, abs=1e-9)
    assert figures["rigid_rmse_m"] == pytest.approx(0, abs=1e-9)
