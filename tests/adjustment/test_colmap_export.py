# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import hashlib

import numpy as np
import pytest

from hullrecon.adjustment.results.colmap_export import write_model


def read(folder):
    import pycolmap

    return pycolmap.Reconstruction(str(folder))


def test_colmap_model_has_no_reprojection_error(sparse_model, tmp_path):
    write_model(sparse_model, tmp_path)
    back = read(tmp_path)
    assert back.num_images() == 2 * len(sparse_model.stamps)
    assert back.compute_mean_reprojection_error() < 1e-6


def test_reprojection_error_is_the_one_put_in(sparse_model, tmp_path):
    sparse_model.tracks.top[sparse_model.top] += [0.3, 0.4]
    write_model(sparse_model, tmp_path)
    error = read(tmp_path).compute_mean_reprojection_error()
    seen = [
        np.bincount(sparse_model.tracks.landmark[use], minlength=len(sparse_model.position))
        for use in (sparse_model.top, sparse_model.bottom)
    ]
    share = seen[0] / np.maximum(seen[0] + seen[1], 1)
    assert error == pytest.approx(0.5 * share[seen[0] + seen[1] > 0].mean(), rel=1e-6)


def test_camera_centres_and_names_are_the_nodes(sparse_model, tmp_path):
    write_model(sparse_model, tmp_path)
    images = {image.name: image for image in read(tmp_path).images.values()}
    assert "camera_bottom/3000000005.jpg" in images
    centre = images["camera_top/3000000000.jpg"].projection_center()
    np.testing.assert_allclose(centre, sparse_model.hull_from_top.translation[3], atol=1e-9)


def test_a_model_is_written_with_the_same_bytes_twice(sparse_model, tmp_path):
    digests = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        write_model(sparse_model, tmp_path / name)
        files = sorted((tmp_path / name).iterdir())
        digests.append([hashlib.sha256(f.read_bytes()).hexdigest() for f in files])
    assert digests[0] == digests[1]
    assert len(digests[0]) == 5
