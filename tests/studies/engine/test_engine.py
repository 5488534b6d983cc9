# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The studies of [KimEustice2009]'s registration, on arrays."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses, exp
from hullrecon.navigation.dead_reckoning.error_propagation import trajectory_covariance
from hullrecon.records.links import CameraLinks
from hullrecon.records.trajectory import Trajectory, TrajectoryErrorModel
from hullrecon.studies.engine.fly_through import (
    FOCAL_PX,
    HEIGHT,
    WIDTH,
    Ortho,
    Station,
    TexturedHull,
    film,
)
from hullrecon.studies.engine.link_errors import LinkErrors, link_errors
from hullrecon.studies.engine.one_camera import TrueCamera
from hullrecon.studies.engine.pair_overlap import ComparedPair
from hullrecon.studies.engine.pair_stages import five_numbers
from hullrecon.studies.engine.planar_adjustment import (
    adjust_plane,
    homography_of,
    whitened_transfer,
)
from hullrecon.studies.engine.relief_views import relief_views
from hullrecon.studies.engine.survey import (
    largest_fall,
    leave_blank,
    share_of_falls,
    without_lasting_errors,
)
from hullrecon.studies.paths.link_plots import horizontal_sigma

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


def test_a_blank_takes_the_images_between_two_times(tmp_path: Path) -> None:
    table = tmp_path / "camera_top.csv"
    table.write_text("t,file\n1.0,a\n2.0,b\n3.5,c\n4.0,d\n")
    leave_blank(table, 1.5, 3.6)
    assert table.read_text() == "t,file\n1.0,a\n4.0,d\n"


def test_links_errors_are_of_rotation_and_direction_alone() -> None:
    hull_from_camera = Poses(
        np.tile([0.0, 0, 0, 1], (2, 1)), np.array([[0.0, 0, 0], [-1.0, 0, 0]])
    )  # first to second: 1 m along x
    links = CameraLinks(
        first=np.array([0]),
        second=np.array([1]),
        translation=np.array([[0.5, 0.005, 0.0]]),  # half as long, 10 mrad off
        quaternion=Rotation.from_rotvec([[0.0, 0.0, 2e-3]]).as_quat(),
        covariance=np.diag([1.0, 0.005, 0.005, 1e-3, 1e-3, 1e-3])[None] ** 2,
        scaled=np.array([False]),
        bottom=np.zeros((1, 2), bool),
    )
    found = link_errors(links, hull_from_camera)
    assert found.direction_rad == pytest.approx(0.010, rel=1e-3)
    assert found.rotation_rad == pytest.approx(0.002, rel=1e-6)
    assert found.chi2 == pytest.approx(1.0 + 4.0, rel=1e-3)


def test_links_of_two_models_are_compared_pair_by_pair() -> None:
    none = np.zeros(0)
    one, other = (
        LinkErrors(pairs=np.array(pairs), rotation_rad=none, direction_rad=none, chi2=none)
        for pairs in ([[0, 1], [0, 12], [3, 4]], [[0, 12], [1, 2], [2, 3], [3, 4]])
    )
    here, there = one.rows_of_same_pairs(other)
    assert (here.tolist(), there.tolist()) == ([1, 2], [0, 3])


def test_white_noise_alone_lets_no_sigma_fall() -> None:
    """A wrong scale errs by the way from the start, which gets shorter on the way back."""
    out = np.array([0.0, 1.0, 2.0, 3.0, 2.0, 1.0])
    count = len(out)
    poses = Poses(np.tile([0.0, 0, 0, 1], (count, 1)), np.column_stack([out, 0 * out, 0 * out]))
    by_error = np.zeros((count, 6, 1))
    by_error[:, 0, 0] = out
    walk = np.arange(count)[:, None, None] * np.diag([1.0, 1, 1, 0, 0, 0]) * 1e-6
    errors = TrajectoryErrorModel(
        by_error=by_error,
        error_covariance=np.array([[1e-4]]),
        walk=walk,
        white=np.zeros((count, 6, 6)),
    )
    trajectory = Trajectory(
        t_ns=np.arange(count),
        quaternion=poses.rotation.as_quat(),
        translation=poses.translation,
        covariance=trajectory_covariance(errors, poses),
        tray=np.zeros(count),
        image=np.full((count, 2), -1),
    )
    assert share_of_falls(horizontal_sigma(trajectory.track())) == pytest.approx(2 / 5)
    assert share_of_falls(horizontal_sigma(without_lasting_errors(trajectory, errors))) == 0.0


def test_the_largest_fall_of_a_sigma_is_told_by_the_way() -> None:
    way = np.array([0.0, 1.0, 2.0, 2.25, 3.0])
    sigma = np.array([0.1, 0.2, 0.4, 0.1, 0.1])
    assert largest_fall(way, sigma) == pytest.approx(0.75)


@pytest.fixture
def textured_wall() -> TexturedHull:
    """A wall at x = 0 seen from x > 0: red where y < 0, without a picture where y > 0."""
    vertices = np.array([[0.0, y, z] for y in (-3.0, 3.0) for z in (-2.0, 2.0)])
    mesh = Mesh(vertices, np.array([[0, 2, 1], [1, 2, 3]]))
    chart = PlaneOfTest()
    rgba = np.zeros((40, 60, 4), np.uint8)
    rgba[:, :30] = [200, 0, 0, 255]
    pixel = np.array([[10.0, 0.0, 30.0], [0.0, -10.0, 20.0]])
    return TexturedHull(mesh=mesh, chart=chart, ortho=Ortho(rgba=rgba, pixel_from_chart=pixel))


class PlaneOfTest:
    """A chart of the plane x = 0: along is y, girth is z."""

    ship_axes = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    along_of_origin = 0.0

    def to_chart(self, points):
        return points[:, [1, 2, 0]]

    def from_chart(self, along_girth):
        n = len(along_girth)
        return np.column_stack([np.zeros(n), along_girth]), np.tile([1.0, 0, 0], (n, 1))

    def to_arrays(self):
        return {}


def test_a_frame_shows_the_mosaic_where_it_lies(textured_wall: TexturedHull) -> None:
    frame = textured_wall.frame(Station(along=0.0, girth=0.0, distance_m=1.0), np.zeros((0, 3)))
    h, w = frame.shape[:2]
    left, right = frame[h // 2, w // 4].astype(int), frame[h // 2, 3 * w // 4].astype(int)
    # seen from x > 0 with z up, y grows to the right
    assert left[0] > 3 * left[1]
    assert abs(right[0] - right[1]) < 20


def test_an_object_has_a_ring_around_it(textured_wall: TexturedHull) -> None:
    station = Station(along=0.0, girth=0.0, distance_m=1.0)
    plain = textured_wall.frame(station, np.zeros((0, 3)))
    ringed = textured_wall.frame(station, np.array([[0.0, 0.2, 0.0]]))
    rows, columns = np.nonzero((plain != ringed).any(axis=2))
    assert columns.mean() == pytest.approx(0.5 * WIDTH + 0.2 * FOCAL_PX, abs=2)
    assert rows.mean() == pytest.approx(0.5 * HEIGHT, abs=2)


def test_a_film_is_webm_or_nothing(textured_wall: TexturedHull) -> None:
    frames = [np.full((48, 64, 3), k, np.uint8) for k in (0, 128, 255)]
    made = film(frames)
    assert made == b"" or made.startswith(b"\x1aE\xdf\xa3")


def test_the_homographys_sign_is_that_of_its_plane() -> None:
    """A point with n'X + d = 0 is mapped right; where n'X = d, the printed sign maps it wrong."""
    motion = exp(np.array([[0.3, 0.1, -0.05, 0.02, -0.05, 0.1]])).matrix()[0]
    normal, distance = np.array([0.1, -0.2, -1.0]) / np.linalg.norm([0.1, -0.2, -1.0]), 1.4
    ray = np.array([0.2, -0.1, 1.0])
    point = -distance / (normal @ ray) * ray
    seen = motion[:3, :3] @ point + motion[:3, 3]
    for plane, is_right in ((normal, True), (-normal, False)):
        mapped = homography_of(motion, plane, distance) @ ray
        assert np.allclose(mapped[:2] / mapped[2], seen[:2] / seen[2]) is is_right


def test_a_plane_gives_its_motion_and_normal() -> None:
    rng = np.random.default_rng(3)
    motion = exp(np.array([[0.3, 0.1, -0.05, 0.02, -0.05, 0.1]])).matrix()[0]
    normal = np.array([0.1, -0.2, -1.0]) / np.linalg.norm([0.1, -0.2, -1.0])
    rays = np.column_stack([rng.uniform(-0.4, 0.4, (40, 2)), np.ones(40)])
    points = -rays / (rays @ normal)[:, None]
    there = points @ motion[:3, :3].T + motion[:3, 3]
    start = motion.copy()
    start[:3, 3] += [0.02, -0.02, 0.01]
    found, plane = adjust_plane(
        start, np.array([0.0, 0.0, -1.0]), rays[:, :2], there[:, :2] / there[:, 2:]
    )
    np.testing.assert_allclose(found, motion, atol=1e-6)
    np.testing.assert_allclose(plane, normal, atol=1e-6)


def test_transfer_errors_are_whitened_by_noise_of_both_images() -> None:
    rng = np.random.default_rng(4)
    homography = np.array([[1.1, 0.1, 0.05], [-0.1, 0.9, 0.02], [0.05, -0.1, 1.0]])
    at = rng.uniform(-0.4, 0.4, (4000, 2))
    moved = np.hstack([at, np.ones((4000, 1))]) @ homography.T
    noise = 1e-4 * rng.standard_normal((2, 4000, 2))
    found = whitened_transfer(homography, at + noise[0], moved[:, :2] / moved[:, 2:] + noise[1])
    np.testing.assert_allclose(found.std(axis=0), 1e-4, rtol=0.05)
