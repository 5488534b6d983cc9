# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import os
import pickle

import numpy as np
import pytest

from hullrecon.geometry.frames import Camera
from hullrecon.vision.features.store import FeatureStore, GrowingArray


def write(folder, sizes, value):
    start = np.concatenate([[0], np.cumsum(sizes)])
    for kind, width, dtype in (
        ("keypoints", 4, np.float32),
        ("descriptors", 128, np.uint8),
        ("color", 3, np.uint8),
    ):
        with GrowingArray(folder / f"{kind}_camera_top.npy", width, dtype) as file:
            for k, size in enumerate(sizes):
                file.append(np.full((size, width), value + k, dtype))
    np.savez(
        folder / "index.npz",
        camera_top_start=start,
        camera_top_saliency=np.full(len(sizes), value / 10),
    )


def test_blocks_make_one_array_that_numpy_maps(tmp_path):
    with GrowingArray(tmp_path / "a.npy", 4, np.float32) as file:
        file.append(np.arange(8.0).reshape(2, 4))
        file.append(np.arange(12.0).reshape(3, 4))
    found = np.load(tmp_path / "a.npy", mmap_mode="r")
    assert found.dtype == np.float32
    np.testing.assert_array_equal(
        found, np.vstack([np.arange(8).reshape(2, 4), np.arange(12).reshape(3, 4)])
    )


def test_array_of_no_rows_is_still_array(tmp_path):
    with GrowingArray(tmp_path / "a.npy", 128, np.uint8):
        pass
    assert np.load(tmp_path / "a.npy").shape == (0, 128)


def test_rows_of_another_width_are_refused(tmp_path):
    with (
        GrowingArray(tmp_path / "a.npy", 4, np.float32) as file,
        pytest.raises(ValueError, match="width 4"),
    ):
        file.append(np.zeros((2, 3)))


def test_closed_array_takes_no_rows(tmp_path):
    with pytest.raises(ValueError, match="open array"):
        GrowingArray(tmp_path / "a.npy", 4, np.float32).append(np.zeros((1, 4)))


def test_features_are_read_by_image(tmp_path):
    write(tmp_path, [3, 0, 2], 5)
    store = FeatureStore(tmp_path, Camera.TOP)
    assert len(store) == 3
    assert [len(store.read(k)) for k in (0, 1, 2, -1)] == [3, 0, 2, 0]
    assert (store.read(2).descriptors == 7).all()


def test_saliency_is_read_by_image(tmp_path):
    write(tmp_path, [3, 2], 5)
    store = FeatureStore(tmp_path, Camera.TOP)
    assert (store.saliency(1), store.saliency(-1)) == (0.5, 0.0)


def test_store_pickles_to_its_path(tmp_path):
    write(tmp_path, [2], 5)
    store = FeatureStore(tmp_path, Camera.TOP)
    store.read(0)
    assert len(pickle.dumps(store)) < 1000
    assert (pickle.loads(pickle.dumps(store)).read(0).color == 5).all()


def test_rewritten_artifact_is_read_anew(tmp_path):
    write(tmp_path, [2], 5)
    assert (FeatureStore(tmp_path, Camera.TOP).read(0).color == 5).all()
    write(tmp_path, [4], 9)
    os.utime(tmp_path / "index.npz", ns=(1, 1))
    assert (FeatureStore(tmp_path, Camera.TOP).read(0).color == 9).all()
    assert len(FeatureStore(tmp_path, Camera.TOP).read(0)) == 4


def test_camera_whose_images_have_no_features_can_be_read(tmp_path):
    write(tmp_path, [0, 0], 5)
    assert len(FeatureStore(tmp_path, Camera.TOP).read(1)) == 0
