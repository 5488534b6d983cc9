# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The trajectory by evo, the COLMAP model and the export by pycolmap."""

import csv

import numpy as np
import pycolmap
import pytest
from evo.core.trajectory import PoseTrajectory3D
from evo.tools import file_interface


def test_evo_reads_the_trajectory_that_the_table_has(deliver):
    path = file_interface.read_tum_trajectory_file(str(deliver / "trajectory.tum"))
    assert isinstance(path, PoseTrajectory3D)
    is_valid, details = path.check()
    assert is_valid, details
    rows = list(csv.DictReader((deliver / "trajectory.csv").read_text().splitlines()))
    np.testing.assert_allclose(
        path.positions_xyz, [[float(row[f"{axis}_m"]) for axis in "xyz"] for row in rows], atol=1e-8
    )
    np.testing.assert_allclose(
        path.timestamps, [float(row["t_s"]) for row in rows], rtol=0, atol=1e-6
    )


def test_pycolmap_reads_the_model_with_its_reprojection_error(deliver):
    model = pycolmap.Reconstruction(str(deliver / "colmap"))
    assert model.num_reg_images() == model.num_images() > 100
    before = model.compute_mean_reprojection_error()
    model.update_point_3d_errors()
    assert model.compute_mean_reprojection_error() == pytest.approx(before, rel=1e-6)
    assert before < 1


@pytest.mark.parametrize("sparse", ["sparse", "sparse/0"])
def test_pycolmap_finds_an_image_of_the_cameras_size_for_every_exported_pose(exported, sparse):
    model = pycolmap.Reconstruction(str(exported / sparse))
    assert {camera.model.name for camera in model.cameras.values()} == {"PINHOLE"}
    assert model.compute_mean_reprojection_error() < 1
    for image in model.images.values():
        bitmap = pycolmap.Bitmap.read(str(exported / "images" / image.name), as_rgb=True)
        camera = model.cameras[image.camera_id]
        assert (bitmap.width, bitmap.height) == (camera.width, camera.height)


def test_undistorting_what_is_exported_changes_nothing(exported, tmp_path):
    """COLMAP's own undistortion takes the folder, and finds nothing left to undo."""
    pycolmap.undistort_images(tmp_path, exported / "sparse", exported / "images")
    again, model = (
        pycolmap.Reconstruction(str(tmp_path / "sparse")),
        pycolmap.Reconstruction(str(exported / "sparse")),
    )
    for number, camera in model.cameras.items():
        assert (again.cameras[number].width, again.cameras[number].height) == (
            camera.width,
            camera.height,
        )
        np.testing.assert_allclose(again.cameras[number].params, camera.params)
    names = sorted(image.name for image in model.images.values())
    assert sorted((tmp_path / "stereo" / "fusion.cfg").read_text().split()) == names
    assert sorted((exported / "stereo" / "fusion.cfg").read_text().split()) == names
