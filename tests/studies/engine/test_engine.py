# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The studies of [KimEustice2009]'s registration, on arrays."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses, exp
from hullrecon.studies.engine.one_camera import TrueCamera
from hullrecon.studies.engine.pair_overlap import ComparedPair
from hullrecon.studies.engine.pair_stages import five_numbers
from hullrecon.studies.engine.relief_views import relief_views

MODEL = CameraModel(width=400, height=300, fx=500.0, fy=500.0, cx=199.5, cy=149.5)


@pytest.fixture
def two_cameras() -> TrueCamera:
    """Two cameras 0.2 m apart, 2 m before a wall."""
    wall = Mesh(
        np.array([[-5.0, -5.0, 2.0], [5.0, -5.0, 2.0], [5.0, 5.0, 2.0], [-5.0, 5.0, 2.0]]),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )
    poses: Poses = exp(np.array([[0.0] * 6, [0.2, 0, 0, 0, 0, 0]]))
    return TrueCamera(model=MODEL, hull_from_camera=poses, built=Scene(wall))


def test_a_point_of_the_wall_moves_by_the_baseline_over_depth(two_cameras: TrueCamera) -> None:
    seen = two_cameras.seen_again(0, 1, np.array([[0.0, 0.0], [0.1, 0.02]]))
    np.testing.assert_allclose(seen, [[149.5, 149.5], [199.5, 159.5]], atol=1e-6)


def test_what_the_other_image_does_not_show_is_nan(two_cameras: TrueCamera) -> None:
    assert np.isnan(two_cameras.seen_again(0, 1, np.array([[-0.39, 0.0]]))).all()


def test_the_overlap_is_outlined_where_the_other_image_ends(two_cameras: TrueCamera) -> None:
    outline = two_cameras.outline_of(1, 0)
    assert outline[:, 0].min() == pytest.approx(50.0)
    assert outline[:, 0].max() == pytest.approx(449.0)


def test_a_match_is_right_within_pixels_of_the_truth(two_cameras: TrueCamera) -> None:
    xy = np.zeros((2, 2))
    pixel = np.array([[150.5, 149.5], [159.5, 149.5]])
    assert two_cameras.are_right((0, 1), xy, pixel, 3.0).tolist() == [True, False]


@pytest.mark.parametrize(
    ("baseline", "azimuth", "elevation"),
    [((1, 0, 0), 0, 0), ((0, 2, 0), 90, 0), ((1, 0, 1), 0, -45), ((1, -1, 0), -45, 0)],
)
def test_azimuth_and_elevation_are_those_of_the_baseline(baseline, azimuth, elevation) -> None:
    second_from_first = exp(np.array([[*baseline, 0, 0, 0]], float)).inverse().matrix()[0]
    found = five_numbers(second_from_first)
    np.testing.assert_allclose(found, [azimuth, elevation, 0, 0, 0], atol=1e-9)


def test_yaw_is_the_turn_of_the_second_camera() -> None:
    second_from_first = exp(np.array([[1, 0, 0, 0, 0, 0.3]])).inverse().matrix()[0]
    assert five_numbers(second_from_first)[4] == pytest.approx(np.degrees(0.3))


def test_matches_outside_the_overlap_count_as_wrong() -> None:
    pair = ComparedPair(
        nodes=(0, 1),
        here=np.zeros((4, 2)),
        there=np.zeros((4, 2)),
        inlier={"essential": np.array([True, True, True, False])},
        shared=np.array([True, True, False, False]),
        right=np.array([True, False, False, False]),
    )
    accepted = pair.accepted("essential")
    assert (accepted.count, accepted.outside, accepted.wrong) == (3, 1, 2)


def test_the_surface_is_drawn_in_both_views() -> None:
    table = [line.split(",")[:2] for line in relief_views().csv.splitlines()[1:]]
    assert {tuple(row) for row in table} == {
        (view, kind) for view in "12" for kind in ("surface", "match")
    }
