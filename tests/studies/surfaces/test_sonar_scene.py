# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.charts.plane_chart import PlaneChart
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import from_matrix
from hullrecon.records.sensors import SonarPings
from hullrecon.studies.paths.path_figures import VarianceMap
from hullrecon.studies.surfaces.sonar_scene import (
    BLOCK_M,
    DARK,
    LIGHT,
    TRUE,
    compare,
    paint,
    paint_pings,
    table,
)

CORNERS = np.array([[-3.0, 0, -3], [3, 0, -3], [3, 0, 3], [-3, 0, 3]])
WALL = Mesh(CORNERS, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
CHART = PlaneChart(np.zeros(3), np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]))


def test_blocks_are_of_one_tone_and_both_tones_are_frequent() -> None:
    corner = BLOCK_M * np.array([7.0, -3.0])
    inside = corner + BLOCK_M * np.array([[0.1, 0.1], [0.9, 0.2], [0.5, 0.9]])
    assert len(np.unique(paint(inside))) == 1
    rng = np.random.default_rng(0)
    tones = paint(rng.uniform(-3, 3, (4000, 2)))
    assert set(np.unique(tones)) == {DARK, LIGHT}
    assert 0.4 < np.mean(tones == LIGHT) < 0.6


def test_a_ping_shows_the_paint_where_its_rays_meet_the_wall() -> None:
    """The sonar stands 1 m off the wall and looks along its beam's z at 30 degrees to it."""
    lean = np.radians(30.0)
    forward = np.array([np.cos(lean), -np.sin(lean), 0.0])
    up = np.array([np.sin(lean), np.cos(lean), 0.0])
    pose = np.eye(4)
    pose[:3, :3] = np.stack([up, np.cross(forward, up), forward], axis=1)
    pose[:3, 3] = [0.0, 1.0, 0.0]
    azimuth = np.radians([-10.0, 0.0, 10.0])
    pings = SonarPings(
        t_ns=np.zeros(1, np.int64),
        image=np.zeros((1, 3, 200), np.uint8),
        directions=np.stack([np.zeros(3), np.sin(azimuth), np.cos(azimuth)], axis=1),
        range_m=np.linspace(1.0, 3.0, 200),
    )
    image = paint_pings(Scene(WALL), CHART, from_matrix(pose[None]), pings, np.radians(7.0))
    # the middle beam meets the wall at sqrt(r^2 - 1) along it
    for bin_number in (85, 100, 115):
        along = np.sqrt(pings.range_m[bin_number] ** 2 - 1)
        near = [paint(np.array([[along + gap, 0.0]]))[0] for gap in (-0.02, 0.0, 0.02)]
        if len(set(near)) == 1:
            assert image[0, 1, bin_number] == pytest.approx(near[0], rel=0.35)
    # nothing is nearer than the arc's steepest ray
    assert image[0, 1, : int(0.5 / 0.01)].max() == 0
    assert image[0, :, 60:140].max() > 100


def test_tails_are_told_at_what_one_percent_of_true_poses_exceed() -> None:
    rng = np.random.default_rng(0)
    floor = rng.exponential(size=(100, 100))
    maps = {
        name: VarianceMap(variance=scale * floor, extent=(0.0, 1.0, 0.0, 1.0))
        for name, scale in (("dead reckoned", 2.0), (TRUE, 1.0))
    }
    found = {value.what.rsplit(", ", 1)[-1]: value.ours for value in compare(maps)}
    assert found[TRUE] == pytest.approx(1.0, abs=0.05)
    assert found["dead reckoned"] == pytest.approx(10.0, abs=1.5)  # exp(-ln(100) / 2)
    assert table(maps)[1][0][0] == "dead reckoned"
