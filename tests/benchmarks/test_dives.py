# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The accuracy benchmark: what it marks, what it calls consistent, how it makes a mono dive."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest

from benchmarks import dives


def _solution(folder: Path, offset: tuple[float, float, float], sigma: float) -> Path:
    """Three poses that err by `offset` (m) in a hull frame turned by 90 degrees against g."""
    folder.mkdir()
    half = np.sqrt(0.5)
    at = np.array([1.0, 2.0, 3.0]) + offset
    np.savez(
        folder / "solution.npz",
        **{
            "t_ns": np.array([0, 10**9, 2 * 10**9]),
            "global_from_vehicle.translation": np.tile([10 - at[1], at[0], at[2]], (3, 1)),
            "global_from_vehicle.quaternion": np.tile([0, 0, half, half], (3, 1)),
            # x_g = 10 - y_M, y_g = x_M
            "hull_pose.global_from_hull.translation": np.array([[10.0, 0.0, 0.0]]),
            "hull_pose.global_from_hull.quaternion": np.array([[0, 0, half, half]]),
            "pose_covariance": np.tile(sigma**2 * np.eye(6), (3, 1, 1)),
        },
    )
    return folder


def test_errors_of_three_and_four_sigma_are_a_nees_of_25(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from hullrecon.geometry.poses import Poses

    class Still:
        def vehicle_at(self, t_s: np.ndarray) -> Poses:
            assert t_s.tolist() == [1.0]
            return Poses(np.array([[0, 0, 0, 1.0]]), np.array([[1.0, 2.0, 3.0]]))

    monkeypatch.setattr(dives, "read_truth", lambda package: Still())
    adjust = _solution(tmp_path / "adjust", (0.03, -0.04, 0.0), sigma=0.01)
    assert dives.nees(adjust, tmp_path) == pytest.approx(25.0)


def test_the_band_of_ten_dives_is_that_of_sixty_freedoms() -> None:
    found = dives.consistency([6.0] * 10)
    assert found["sum"] == 60.0
    assert found["low"] == pytest.approx(40.48, abs=0.01)
    assert found["high"] == pytest.approx(83.30, abs=0.01)


@pytest.mark.parametrize(
    ("value", "limit", "broken"),
    [
        (0.1, 0.1, False),
        (0.11, 0.1, True),
        (0.9, -0.9, False),
        (0.89, -0.9, True),
        (float("nan"), 1.0, True),
        (5.0, None, False),
    ],
)
def test_a_limit_is_held_or_broken(value: float, limit: float | None, broken: bool) -> None:
    assert dives.breaks(value, limit) is broken


def test_table_marks_broken_limits_and_names_the_worst() -> None:
    good = {"trajectory": {"rigid_rmse_m": 0.001}, "landmarks": {"off_recall": 1.0}}
    bad = {"trajectory": {"rigid_rmse_m": 0.004}, "landmarks": {"off_recall": 0.5}}
    lines = {line.split()[0]: line for line in dives.table({"a": good, "b": bad})[1:]}
    assert lines["trajectory.rigid_rmse_m"].split()[1:] == ["0.0010", "0.0040*", "0.0025", "0.0040"]
    assert lines["landmarks.off_recall"].split()[1:] == ["1.0000", "0.5000*", "0.7500", "0.5000"]


def test_a_mono_dive_does_not_name_its_lower_camera(tmp_path: Path) -> None:
    package = tmp_path / "d1"
    package.mkdir()
    (package / "dive.toml").write_text(
        '[dive]\nname = "d1"\n\n[topics]\ncamera_top = "/top"\ncamera_bottom = "/bottom"\n\n'
        '[camera.top]\ncalibration = "top.yaml"\n\n[camera.bottom]\ncalibration = '
        '"bottom.yaml"\n\n[hull]\nmesh = "hull.stl"\n'
    )
    config = tomllib.loads((dives.without_lower_camera(package) / "dive.toml").read_text())
    assert config["dive"]["name"] == "mono-d1"
    assert config["topics"] == {"camera_top": "/top"}
    assert list(config["camera"]) == ["top"]
    assert config["hull"] == {"mesh": "hull.stl"}


def test_a_dive_whose_mesh_is_not_at_hand_is_not_simulated(tmp_path: Path) -> None:
    assert dives.simulate("d4", dives.DIVES["d4"], 14, tmp_path, None) is None
    assert dives.simulate("d4", dives.DIVES["d4"], 14, tmp_path, tmp_path) is None
    assert json.dumps(sorted(p.name for p in tmp_path.iterdir())) == "[]"


def test_drawn_dives_scatter_as_their_packages_say() -> None:
    many = [
        dict(zip(o.split()[::2], map(float, o.split()[1::2]), strict=True))
        for o in dives.drawn_dives(400).values()
    ]
    assert np.std([d["--deviation-mean-m"] for d in many]) == pytest.approx(0.014, rel=0.1)
    assert np.abs([d["--guess-along-m"] for d in many]).max() == 1.0
    assert {d["--length-m"] for d in many} == {30.0, 50.0, 80.0}
