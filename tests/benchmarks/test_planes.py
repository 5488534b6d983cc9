# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The benchmark of planes: what it calls an error, and that it takes the CAD model away from a
copy.
"""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks import planes
from hullrecon.geometry.poses import Poses, identity
from hullrecon.records.links import LinkedPath

N = 60


def found(offset_m: np.ndarray, sigma_m: float) -> LinkedPath:
    pose = np.zeros((N, 7))
    pose[:, 6], pose[:, 1] = 1.0, np.linspace(0, 10, N)
    pose[:, :3] += offset_m
    covariance = np.tile(sigma_m**2 * np.eye(6), (N, 1, 1))
    return LinkedPath(
        pose=pose,
        tray=np.zeros(N),
        covariance=covariance,
        part=np.full(N, -1),
        part_sigma=np.zeros(0),
    )


def truth() -> SimpleNamespace:
    at = np.column_stack([np.zeros(N), np.linspace(0, 10, N), np.zeros(N)])
    poses = Poses(np.tile([0, 0, 0, 1.0], (N, 1)), at)
    return SimpleNamespace(
        t_s=np.arange(N, dtype=float),
        global_from_hull=identity(),
        vehicle_at=lambda t_s: poses[np.asarray(t_s, int)],
    )


def test_path_counts_from_its_start_and_depth_from_the_water() -> None:
    row = planes.score(
        found(np.array([0.03, 0, 0.02]), 0.01), (1e9 * np.arange(N)).astype(np.int64), truth()
    )
    assert row["rigid_m"] == pytest.approx(0, abs=1e-9)
    assert row["error_over_sigma"] == pytest.approx(2.0)


def test_a_bend_across_the_hull_is_an_error_across_it() -> None:
    bend = np.zeros((N, 3))
    bend[:, 0] = 0.1 * np.cos(np.linspace(0, 2 * np.pi, N))
    row = planes.score(found(bend, 0.01), (1e9 * np.arange(N)).astype(np.int64), truth())
    assert row["across_m"] == pytest.approx(0.1 / np.sqrt(2), rel=0.05)
    assert row["along_m"] < 0.01
    assert row["down_m"] == pytest.approx(0, abs=1e-9)


def test_the_cad_model_is_taken_from_a_copy(tmp_path: Path) -> None:
    package = tmp_path / "dive1"
    package.mkdir()
    (package / "dive.toml").write_text('[dive]\nname = "dive1"\n\n[hull]\nmesh = "hull.stl"\n')
    bare = planes.without_cad_model(package)
    assert "[hull]" not in (bare / "dive.toml").read_text()
    assert "[hull]" in (package / "dive.toml").read_text()
    assert planes.without_cad_model(package) == bare  # made once
