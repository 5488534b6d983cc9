# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The undistorted COLMAP model of a scene whose observations are exact."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from hullrecon.adjustment.results.colmap_export import SparseModel, write_model
from hullrecon.adjustment.results.undistorted_model import camera_of, undistort_model


def read(folder: Path):  # type: ignore[no-untyped-def]
    import pycolmap

    return pycolmap.Reconstruction(str(folder))


def test_observations_still_meet_their_points_and_poses_stay(
    sparse_model: SparseModel, tmp_path: Path
) -> None:
    write_model(sparse_model, tmp_path)
    delivered, found = read(tmp_path), undistort_model(tmp_path)
    (tmp_path / "out").mkdir()
    found.reconstruction.write_binary(str(tmp_path / "out"))
    back = read(tmp_path / "out")
    assert back.compute_mean_reprojection_error() < 1e-5
    assert {c.model.name for c in back.cameras.values()} == {"PINHOLE"}
    assert back.num_images() == delivered.num_images()
    for number, image in back.images.items():
        before = delivered.images[number]
        np.testing.assert_allclose(
            image.cam_from_world().matrix(), before.cam_from_world().matrix(), atol=1e-12
        )
        assert image.name == before.name.replace("/", "_")
    some = next(iter(back.points3D))
    np.testing.assert_array_equal(back.points3D[some].xyz, delivered.points3D[some].xyz)
    np.testing.assert_array_equal(back.points3D[some].color, delivered.points3D[some].color)


def test_observations_outside_smaller_images_are_counted(
    sparse_model: SparseModel, tmp_path: Path
) -> None:
    bent = replace(sparse_model.cameras[0], k1=0.3)
    known = sparse_model.cameras[0].undistort(np.nan_to_num(sparse_model.tracks.top))
    sparse_model.tracks.top[sparse_model.top] = bent.distort(known)[sparse_model.top]
    write_model(replace(sparse_model, cameras=(bent, sparse_model.cameras[1])), tmp_path)
    delivered, found = read(tmp_path), undistort_model(tmp_path)
    back = found.reconstruction
    assert (
        found.lost_observations
        == delivered.compute_num_observations() - back.compute_num_observations()
        > 0
    )
    assert min(point.track.length() for point in back.points3D.values()) >= 2
    for image in back.images.values():
        size = [back.cameras[image.camera_id].width, back.cameras[image.camera_id].height]
        pixels = np.array([p.xy for p in image.points2D]).reshape(-1, 2)
        assert np.all((pixels >= 0) & (pixels <= size))
        assert all(p.has_point3D() for p in image.points2D)


def test_cameras_read_back_as_they_were_written(sparse_model: SparseModel, tmp_path: Path) -> None:
    top = replace(sparse_model.cameras[0], k3=0.02)
    write_model(replace(sparse_model, cameras=(top, sparse_model.cameras[1])), tmp_path)
    cameras = read(tmp_path).cameras
    assert {cameras[1].model.name, cameras[2].model.name} == {"FULL_OPENCV", "OPENCV"}
    for number, expected in ((1, top), (2, sparse_model.cameras[1])):
        np.testing.assert_allclose(
            camera_of(cameras[number]).parameters(), expected.parameters(), atol=1e-12
        )


def test_a_mono_model_has_one_camera(sparse_model: SparseModel, tmp_path: Path) -> None:
    stamps = sparse_model.stamps.copy()
    stamps[:, 1] = -1
    mono = replace(
        sparse_model,
        cameras=(sparse_model.cameras[0], None),
        top_from_bottom=None,
        stamps=stamps,
        bottom=np.zeros_like(sparse_model.bottom),
    )
    write_model(mono, tmp_path)
    found = undistort_model(tmp_path)
    assert set(found.undistortions) == {1}
    assert {image.camera_id for image in found.images} == {1}
    assert found.reconstruction.num_points3D() > 0
