# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hullrecon.errors import InputError
from hullrecon.evaluation.truth import read_mesh, read_truth
from hullrecon.geometry.poses import Poses


def test_poses_are_interpolated_between_frames(package: Path) -> None:
    truth = read_truth(package)
    middle = truth.vehicle_at(0.5 * (truth.t_s[:1] + truth.t_s[1:2]))
    np.testing.assert_allclose(
        middle.translation[0],
        0.5 * (truth.poses.translation[0] + truth.poses.translation[1]),
        atol=1e-6,
    )


def test_the_camera_stands_where_the_mounts_say(package: Path) -> None:
    truth = read_truth(package)
    camera = truth.cameras_at(np.array([0]))
    # tray origin 0.45 ahead (-y) and 0.1 down (-z); the camera 0.05 ahead and 0.05 up in the tray,
    # which tilts by 0.02 rad
    c, s = np.cos(0.02), np.sin(0.02)
    ahead, down = 0.45 + 0.05 * c - 0.05 * s, 0.1 - 0.05 * s - 0.05 * c
    np.testing.assert_allclose(camera.translation[0], [0.0, 1.5 - ahead, -down], atol=1e-9)


def test_structures_are_unpainted_and_due_are_high_and_seen(package: Path) -> None:
    truth = read_truth(package)
    assert [o.id for o in truth.structures()] == [1, 3]
    assert [o.id for o in truth.due()] == [1]


def test_near_is_a_distance_to_the_vertices(package: Path) -> None:
    truth = read_truth(package)
    assert truth.near(np.array([[2.0, 0.2, 0.0], [2.0, 0.4, 0.0]]), 0.25).tolist() == [True, False]


def test_the_cad_model_is_scaled_by_its_unit(package: Path, tmp_path: Path) -> None:
    mesh = read_mesh(package / "hull.stl", 0.001)
    assert np.ptp(mesh.vertices[:, 0]) == pytest.approx(0.006)


def test_a_dive_without_a_cad_model_has_none(package: Path, tmp_path: Path) -> None:
    (tmp_path / "truth").symlink_to(package / "truth")
    (tmp_path / "dive.toml").write_text("")
    truth = read_truth(tmp_path)
    assert truth.cad_model is None
    assert isinstance(truth.global_from_hull, Poses)


def test_a_package_without_truth_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no truth"):
        read_truth(tmp_path)


def test_a_damaged_truth_is_named(package: Path, tmp_path: Path) -> None:
    import shutil

    shutil.copytree(package, tmp_path / "copy")
    (tmp_path / "copy" / "truth" / "objects.json").write_text("{")
    with pytest.raises(InputError, match=r"objects\.json"):
        read_truth(tmp_path / "copy")
