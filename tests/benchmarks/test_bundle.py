# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from benchmarks import bundle as bundles
from benchmarks.peer_hullrecon import problem_of
from benchmarks.peers import bundle_of
from hullrecon.native import Options, evaluate, solve


def test_a_rotation_matrix_is_that_of_the_quaternion():
    turns = Rotation.random(5, random_state=np.random.default_rng(0))
    np.testing.assert_allclose(bundles.rotation(turns.as_quat()), turns.as_matrix(), atol=1e-14)


def test_bundle_has_the_pixels_of_its_problem(small):
    bundle = bundle_of(small[0])
    mine = bundles.residuals(bundle, bundle.pose, bundle.point)
    theirs = evaluate(small[0], Options(method="naive", huber_stereo=np.inf, huber_mono=np.inf))
    rows = theirs.residual[np.isin(theirs.factor, [4, 5])].reshape(mine.shape)
    np.testing.assert_allclose(mine, rows, atol=1e-6)


def test_a_bundle_has_no_pose_without_an_image(small):
    bundle = bundle_of(small[0])
    assert set(bundle.seen_from) == set(range(len(bundle.pose)))
    assert len(bundle.pose) == (372 if bundle.stereo else 400)


def test_a_bundle_comes_back_from_its_file(small, tmp_path):
    bundle = bundle_of(small[0])
    bundle.save(tmp_path / "b.npz")
    again = bundles.load(tmp_path / "b.npz")
    assert np.array_equal(again.pixel, bundle.pixel)
    assert again.stereo == bundle.stereo


def test_solved_bundle_holds_its_gauge_and_reaches_pixel_noise(small):
    bundle = bundle_of(small[0])
    found = solve(
        problem_of(bundle), Options(method="naive", huber_stereo=np.inf, huber_mono=np.inf)
    ).unknowns
    pose = found.pose[:, :7]
    np.testing.assert_allclose(pose[0, :3], bundle.pose[0, :3], atol=1e-6)
    views, unknowns = bundle.pixel.size, 6 * len(pose) + 3 * len(bundle.point)
    assert bundles.rms_px(bundle, pose, found.landmark) == pytest.approx(
        np.sqrt(1 - unknowns / views), rel=0.06
    )
    if not bundle.stereo:
        far, axis, metres = bundle.baseline()
        offset = bundles.rotation(bundle.pose[0, 3:]).T @ (pose[far, :3] - pose[0, :3])
        assert offset[axis] == pytest.approx(metres, abs=1e-5)


def test_the_distortion_is_that_of_the_native_camera(small):
    bundle = bundle_of(small[0])
    bent = bundles.Bundle(
        **(
            vars(bundle)
            | {"camera": bundle.camera + np.r_[np.zeros(4), 0.1, -0.05, 0.002, -0.001, 0.01]}
        )
    )
    rows = evaluate(
        problem_of(bent), Options(method="naive", huber_stereo=np.inf, huber_mono=np.inf)
    )
    theirs = rows.residual[np.isin(rows.factor, [4, 5])]
    np.testing.assert_allclose(
        bundles.residuals(bent, bent.pose, bent.point).ravel(), theirs, atol=1e-6
    )
