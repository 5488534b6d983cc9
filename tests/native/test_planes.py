# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Planes, beams to them and constant velocity: values by hand, a twin, what they are blind to,
truth from noisy ones.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from drafts import Draft, evaluate, solve
from native.test_cores import planes, planes_seen
from native.test_factors import residuals, turned
from native.test_links import circle, moved_rigidly, rms_m
from scipy.spatial.transform import Rotation

from hullrecon.errors import StageError
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses, exp, from_rpy, tray_poses
from hullrecon.native import (
    LinkKernel,
    Options,
    Problem,
    Unknowns,
    curvature_difference,
    curvature_information,
)
from hullrecon.studies.sessions.motions import plane_in, plane_out

Empty = Callable[[int], Draft]
Survey = Callable[..., Draft]


def ahead(p: Draft, distance: float = 2.0) -> None:
    """A wall across x of g, seen by the first node: the normal points back to it."""
    p.unknowns.plane, p.planes.anchor = np.array([[-distance, 0, 0.0]]), np.zeros(1, np.int32)


def sight(p: Draft, node: int, measured: list[float]) -> None:
    p.plane_sightings.node, p.plane_sightings.plane = (
        np.array([node], np.int32),
        np.zeros(1, np.int32),
    )
    p.plane_sightings.measured, p.plane_sightings.sqrt_information = (
        np.array([measured]),
        np.eye(3)[None],
    )


def test_a_wall_seen_from_the_side_is_turned_and_nearer(empty: Empty) -> None:
    p = empty(2)
    ahead(p)
    # its x is y of g
    p.unknowns.pose[1, :3], p.unknowns.pose[1, 3:7] = [0.5, 7.0, -3.0], turned(2, np.pi / 2)
    sight(p, 1, [0.0, 1.0, 0.0])
    p.plane_sightings.sqrt_information = np.diag([1.0, 2.0, 1.0])[None]
    # 1.5 m away; the normal, -x of g, is +y of the turned vehicle
    np.testing.assert_allclose(residuals(p, "plane"), [0, 2 * (1.5 - 1.0), 0], atol=1e-12)


def test_a_wall_is_led_into_a_frame_by_the_inverse_of_what_leads_it_out(empty: Empty) -> None:
    """[Ozog2016 App. B] prints for the way into frame j the operator of the way out, [+]."""
    p = empty(2)
    ahead(p)
    p.unknowns.pose[1, :3], p.unknowns.pose[1, 3:7] = [0.5, 7.0, -3.0], turned(2, np.pi / 2)
    second = Poses(p.unknowns.pose[1:, 3:7], p.unknowns.pose[1:, :3])
    seen = plane_in(second, p.unknowns.plane)[0]
    np.testing.assert_allclose(plane_out(second, seen), p.unknowns.plane, atol=1e-12)
    sight(p, 1, seen[0].tolist())
    np.testing.assert_allclose(residuals(p, "plane"), 0, atol=1e-12)
    sight(p, 1, plane_out(second, p.unknowns.plane)[0].tolist())  # as printed
    assert np.abs(residuals(p, "plane")).max() > 1


def test_a_sighting_from_the_anchor_compares_the_three_numbers(empty: Empty) -> None:
    p = empty(2)
    ahead(p)
    p.unknowns.pose[0, :3] = [9.0, 9, 9]
    sight(p, 0, [-1.5, 0.25, 0.0])
    np.testing.assert_allclose(residuals(p, "plane"), [-0.5, -0.25, 0])
    # the plane alone
    assert set(np.flatnonzero(np.bincount(evaluate(p).jacobian_column))) == {14, 15, 16}


def test_two_parallel_walls_differ_by_the_step_between_them(empty: Empty) -> None:
    p = empty(2)
    p.unknowns.pose[1, 0] = 0.5
    p.unknowns.plane, p.planes.anchor = (
        np.array([[-2, 0, 0.0], [-1.2, 0, 0]]),
        np.arange(2, dtype=np.int32),
    )
    p.plane_pairs.first, p.plane_pairs.second = np.zeros(1, np.int32), np.ones(1, np.int32)
    p.plane_pairs.measured, p.plane_pairs.sqrt_information = (
        np.array([[0.1, 0, 0]]),
        2 * np.eye(3)[None],
    )
    p.plane_pairs.point, p.plane_pairs.place = np.array([[1.2, 0.3, 0]]), np.array([[1.7, 0.1, 0]])
    p.plane_pairs.by_place = np.zeros((1, 3, 3))
    # the second stands 1.7 m from the first node
    np.testing.assert_allclose(residuals(p, "plane_pair"), [2 * (-1.7 + 2 - 0.1), 0, 0], atol=1e-12)
    p.plane_pairs.by_place[0, 2, 1] = 0.5  # its point lies 0.2 m farther along than it was
    np.testing.assert_allclose(
        residuals(p, "plane_pair"), [2 * (-1.7 + 2 - 0.1), 0, -2 * 0.5 * 0.2], atol=1e-12
    )


def compared(p: Draft, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """The residual of two planes of one frame that are to be the same, sigmas of one."""
    p.unknowns.plane, p.planes.anchor = np.array([first, second]), np.zeros(2, np.int32)
    p.plane_pairs.first, p.plane_pairs.second = np.zeros(1, np.int32), np.ones(1, np.int32)
    p.plane_pairs.measured = np.zeros((1, 3))
    p.plane_pairs.sqrt_information = np.eye(3)[None]
    p.plane_pairs.point, p.plane_pairs.place = np.zeros((2, 1, 3))
    p.plane_pairs.by_place = np.zeros((1, 3, 3))
    return residuals(p, "plane_pair")


def test_planes_are_not_compared_by_an_orthogonal_distance_as_printed(empty: Empty) -> None:
    """[Ozog2016 3.3.2.1] prints of patches of a hull what 3.3.3 measures of meshes."""
    wall, lean = np.array([-2.0, 0, 0]), np.array([np.cos(0.2), np.sin(0.2), 0])
    corners = np.array([[2.0, -0.5, -0.5], [2, 0.5, -0.5], [2, 0, 0.5]])
    patch = Scene(Mesh(corners, np.array([[0, 1, 2]], np.int32)))
    # a wall that leans, through the patch: no distance, and yet another plane
    through, leaning = np.array([[2.0, 0, 0]]), -(lean @ -wall) * lean
    assert abs(patch.closest(through).distance[0]) < 1e-9
    assert np.linalg.norm(compared(empty(2), wall, leaning)) > 0.3
    # ten metres along the wall: far from the patch, and yet the same plane
    assert abs(patch.closest(np.array([[2.0, 10, 0]])).distance[0]) > 9
    np.testing.assert_array_equal(compared(empty(2), wall, wall), 0)


def test_a_beam_meets_a_wall_where_the_corrected_formula_says(empty: Empty) -> None:
    p = empty(2)
    ahead(p)
    p.unknowns.pose[1, 0], p.unknowns.T_s_d = 0.5, np.array([0.1, 0, 0, 0, 0, 0, 1.0])
    p.plane_ranges.node, p.plane_ranges.plane = np.ones(1, np.int32), np.zeros(1, np.int32)
    p.plane_ranges.offset, p.plane_ranges.tray_offset = (
        np.array([[0.2, 0, 0, 0, 0, 0, 1.0]]),
        np.zeros(1),
    )
    p.plane_ranges.beam, p.plane_ranges.measured = np.array([[0.8, 0.6, 0.0]]), np.array([1.4])
    p.plane_ranges.sigma = np.array([0.1])
    # the DVL is at x = 0.8, the wall at 2: 1.2 m ahead, 1.5 m along the beam
    np.testing.assert_allclose(residuals(p, "plane_range"), [1.0], atol=1e-12)
    p.plane_ranges.measured = np.array([1.0])
    e = evaluate(p)
    assert e.cost_by_factor["plane_range"] == pytest.approx(1.345 * 5 - 0.5 * 1.345**2)  # Huber's


def test_length_of_a_beam_as_printed_is_negative_and_the_same_from_any_distance(
    empty: Empty,
) -> None:
    """[Ozog2016 eq. 2.4] prints |x - pi| / (r' (x - pi)): no square, no sign."""
    ray, sigma = np.array([0.8, 0.6, 0.0]), 0.1
    for distance, hit in ((1.0, 1.25), (2.0, 2.5)):
        p = empty(2)
        ahead(p, distance)
        p.unknowns.T_s_d = np.array([0, 0, 0, 0, 0, 0, 1.0])
        p.plane_ranges.node, p.plane_ranges.plane = np.ones(1, np.int32), np.zeros(1, np.int32)
        p.plane_ranges.offset = np.array([[0, 0, 0, 0, 0, 0, 1.0]])
        p.plane_ranges.tray_offset, p.plane_ranges.measured = np.zeros(1), np.array([hit])
        p.plane_ranges.beam, p.plane_ranges.sigma = ray[None], np.array([sigma])
        np.testing.assert_allclose(residuals(p, "plane_range"), 0, atol=1e-12)
        seen = p.unknowns.plane[0]
        printed = np.linalg.norm(seen) / (ray @ seen)
        assert printed == pytest.approx(-1.25)  # however far the wall is


def test_a_pair_costs_the_square_in_the_inverse_of_its_covariance(empty: Empty) -> None:
    """[Ozog2016 eq. 2.3] prints the norm without its square, and calls W a weight."""
    costs = []
    for sigma in (0.1, 0.2):
        p = empty(2)
        p.unknowns.plane, p.planes.anchor = (
            np.array([[-2, 0, 0.0], [-1.9, 0, 0]]),
            np.zeros(2, np.int32),
        )
        p.plane_pairs.first, p.plane_pairs.second = np.zeros(1, np.int32), np.ones(1, np.int32)
        p.plane_pairs.measured = np.zeros((1, 3))
        p.plane_pairs.sqrt_information = np.eye(3)[None] / sigma
        p.plane_pairs.point, p.plane_pairs.place = np.zeros((2, 1, 3))
        p.plane_pairs.by_place = np.zeros((1, 3, 3))
        costs.append(evaluate(p).cost_by_factor["plane_pair"])
    squared = [0.5 * (0.1 / sigma) ** 2 for sigma in (0.1, 0.2)]
    np.testing.assert_allclose(costs, squared, rtol=1e-9)
    as_printed = [0.5 * 0.1 / sigma for sigma in (0.1, 0.2)]
    as_a_weight = [0.5 * (0.1 * sigma) ** 2 for sigma in (0.1, 0.2)]
    assert costs[1] / costs[0] != pytest.approx(as_printed[1] / as_printed[0])
    assert costs[1] / costs[0] != pytest.approx(as_a_weight[1] / as_a_weight[0])


def test_a_ray_from_elsewhere_is_as_long_as_the_corrected_formula_says(empty: Empty) -> None:
    """[Ozog2016 D.1] prints the length of a ray from the origin, (2.5) the range's variance."""
    plane, place, ray = np.array([-2, 0, 0.0]), np.array([0.8, 0.3, 0]), np.array([0.8, 0.6, 0.0])
    p = empty(2)
    ahead(p)
    p.unknowns.pose[1, :3], p.unknowns.T_s_d = place, np.array([0, 0, 0, 0, 0, 0, 1.0])
    p.plane_ranges.node, p.plane_ranges.plane = np.ones(1, np.int32), np.zeros(1, np.int32)
    p.plane_ranges.offset = np.array([[0, 0, 0, 0, 0, 0, 1.0]])
    p.plane_ranges.tray_offset, p.plane_ranges.measured = np.zeros(1), np.array([1.4])
    p.plane_ranges.beam, p.plane_ranges.sigma = ray[None], np.array([0.1])
    right = -(plane @ plane + plane @ place) / (ray @ plane)
    printed = -(plane @ plane) / (ray @ plane)
    (found,) = residuals(p, "plane_range")
    assert found == pytest.approx((right - 1.4) / 0.1)
    assert found != pytest.approx((right - 1.4) / np.sqrt(0.1))
    assert abs(printed - right) > 0.9


def test_a_vehicle_that_speeds_up_shows_its_change_of_velocity(empty: Empty) -> None:
    p = empty(3)
    p.unknowns.pose[:, 3:7] = turned(2, np.pi / 2)
    p.unknowns.pose[1, 1], p.unknowns.pose[2, 1] = 1.0, 4.0  # ahead in the vehicle's axes
    p.unknowns.pose[2, 3:7] = turned(2, np.pi / 2 + 0.3)
    p.velocities.first, p.velocities.second, p.velocities.third = (
        np.array([k], np.int32) for k in range(3)
    )
    p.velocities.before, p.velocities.after = np.array([2.0]), np.array([3.0])
    p.velocities.sigma = np.array([[0.1, 1, 1, 1, 1, 0.05]])
    np.testing.assert_allclose(residuals(p, "velocity"), [5.0, 0, 0, 0, 0, 2.0], atol=1e-12)


def test_every_row_equals_its_twin(make_survey: Survey, shaken: Survey) -> None:
    p = shaken(make_survey())
    planes(p)
    at, t = Poses(p.unknowns.pose[:, 3:7], p.unknowns.pose[:, :3]), p.plane_sightings
    seen = planes_seen(at, p.unknowns.plane[t.plane], p.planes.anchor[t.plane], t.node)
    expected = np.einsum("kij,kj->ki", t.sqrt_information, seen - t.measured).ravel()
    np.testing.assert_allclose(residuals(p, "plane"), expected, atol=1e-10)
    t = p.plane_pairs
    seen = planes_seen(
        at, p.unknowns.plane[t.second], p.planes.anchor[t.second], p.planes.anchor[t.first]
    )
    anchors = at[p.planes.anchor[t.first]].inverse() @ at[p.planes.anchor[t.second]]
    by_curvature = t.measured + np.einsum(
        "kij,kj->ki", t.by_place, anchors.apply(t.point) - t.place
    )
    expected = np.einsum(
        "kij,kj->ki", t.sqrt_information, seen - p.unknowns.plane[t.first] - by_curvature
    ).ravel()
    np.testing.assert_allclose(residuals(p, "plane_pair"), expected, atol=1e-10)
    t = p.plane_ranges
    mount = Poses(p.unknowns.T_s_d[None, 3:], p.unknowns.T_s_d[None, :3])
    dvl = (
        Poses(t.offset[:, 3:], t.offset[:, :3])
        @ tray_poses(p.lever_arms.tray, p.unknowns.pose[t.node, 7] + t.tray_offset)
        @ mount
    )
    in_anchor = at[p.planes.anchor[t.plane]].inverse() @ at[t.node] @ dvl
    pi, along = p.unknowns.plane[t.plane], in_anchor.rotation.apply(t.beam)
    predicted = -(np.sum(pi * pi, 1) + np.sum(pi * in_anchor.translation, 1)) / np.sum(
        pi * along, 1
    )
    np.testing.assert_allclose(
        residuals(p, "plane_range"), (predicted - t.measured) / t.sigma, atol=1e-9
    )
    end = in_anchor.translation + predicted[:, None] * along
    # the ends lie on the planes
    np.testing.assert_allclose(np.sum(pi * end, 1), -np.sum(pi * pi, 1))
    t = p.velocities
    i, j, k = at[t.first], at[t.second], at[t.third]
    came, goes = i.inverse() @ j, j.inverse() @ k
    linear = (
        goes.translation / t.after[:, None]
        - came.rotation.inv().apply(came.translation) / t.before[:, None]
    )
    angular = (
        goes.rotation.as_rotvec() / t.after[:, None] - came.rotation.as_rotvec() / t.before[:, None]
    )
    np.testing.assert_allclose(
        residuals(p, "velocity"), (np.hstack([linear, angular]) / t.sigma).ravel(), atol=1e-9
    )


def test_none_of_them_sees_where_the_whole_path_stands(make_survey: Survey, shaken: Survey) -> None:
    p = shaken(make_survey())
    planes(p)
    before = {
        kind: residuals(p, kind) for kind in ("plane", "plane_pair", "plane_range", "velocity")
    }
    moved_rigidly(p, exp(np.array([[30.0, -20, 10, 0.5, 1.5, -1]])))
    for kind, rows in before.items():
        np.testing.assert_allclose(residuals(p, kind), rows, atol=1e-8, err_msg=kind)


def test_plane_through_the_origin_of_g_is_solved_as_others(empty: Empty) -> None:
    """Held in its anchor; in g its three numbers would all be nothing."""
    p = empty(2)
    p.unknowns.pose[:, 0] = [-2.0, -1.5]
    ahead(p)
    sight(p, 1, [-1.5, 0, 0])
    np.testing.assert_allclose(residuals(p, "plane"), np.zeros(3), atol=1e-12)


def test_a_beam_along_its_plane_is_refused_by_name(empty: Empty) -> None:
    p = empty(1)
    ahead(p)
    p.plane_ranges.node = p.plane_ranges.plane = np.zeros(1, np.int32)
    p.plane_ranges.offset, p.plane_ranges.tray_offset = (
        np.array([[0, 0, 0, 0, 0, 0, 1.0]]),
        np.zeros(1),
    )
    p.plane_ranges.beam, p.plane_ranges.measured, p.plane_ranges.sigma = (
        np.array([[0, 1.0, 0]]),
        np.ones(1),
        np.ones(1),
    )
    with pytest.raises(StageError, match="cannot be evaluated") as caught:
        evaluate(p)
    assert caught.value.where == "plane_range 0"


@pytest.mark.parametrize("core", ["schur", "ceres"])
def test_planes_seen_again_remove_drift_along_their_normals(core: str) -> None:
    """Twice around a room of six walls: the odometry of `circle`, no link across; the walls bound
    the drift to centimetres.
    """
    rng = np.random.default_rng(4)
    p, truth = circle(80, rng, wrong=0)
    for name, value in vars(p.links).items():
        if isinstance(value, np.ndarray):
            setattr(p.links, name, value[:79])
    drift = exp(np.r_[0, 0, 0, 0, 0, 0.004])
    measured = Poses(p.links.measured[:, 3:], p.links.measured[:, :3]) @ drift
    p.links.measured = np.c_[measured.translation, measured.quaternion]
    p.links.sqrt_information = np.tile(np.diag([200.0] * 3 + [200.0] * 3), (79, 1, 1))
    alone = rms_m(solve(p).unknowns.pose, truth)
    corners = np.linspace(0, 2 * np.pi, 6, endpoint=False)
    walls = np.c_[np.cos(corners), np.sin(corners), 0.3 * np.sin(3 * corners + 1)]
    # and a floor
    walls = np.vstack([walls / np.linalg.norm(walls, axis=1, keepdims=True), [[0, 0, 1.0]]])
    node = np.tile(np.arange(80), 3)
    near = np.argsort(-truth.translation @ walls[:6].T, axis=1)[:, :2]
    wall = np.r_[near[:, 0], near[:, 1], np.full(80, 6)]
    offset = 8.0  # n . x = -8 with the normal towards the origin, -wall
    height = offset - np.sum(walls[wall] * truth.translation[node], axis=1)
    pi = truth[node].rotation.inv().apply(-height[:, None] * walls[wall])
    p.plane_sightings.node, p.plane_sightings.plane = node.astype(np.int32), wall.astype(np.int32)
    p.plane_sightings.measured = pi + 0.01 * rng.normal(size=pi.shape)
    p.plane_sightings.sqrt_information = np.tile(np.eye(3) * 100, (len(node), 1, 1))
    first = np.array([np.flatnonzero(wall == k)[0] for k in range(7)])
    p.planes.anchor, p.unknowns.plane = (
        node[first].astype(np.int32),
        p.plane_sightings.measured[first].copy(),
    )
    got = solve(p, Options(core=core, function_tolerance=1e-10))
    assert alone > 0.3
    assert rms_m(got.unknowns.pose, truth) < 0.02


def sphere(n: int, radius: float, standoff: float) -> tuple[Poses, np.ndarray]:
    """Poses that look along their x at the middle of a sphere from outside, by spirals; what plane
    each sees.
    """
    turn, tilt = np.linspace(0, 20 * np.pi, n), np.linspace(-0.9, 0.9, n)
    out = np.c_[np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt)]
    at = from_rpy((radius + standoff) * out, np.c_[np.zeros(n), tilt, turn + np.pi])
    return at, np.tile([-standoff, 0, 0.0], (n, 1))


def test_curvature_of_a_sphere_is_equal_in_both_directions() -> None:
    """The difference that the radius predicts, against that of the true planes, to the third order
    of the step.
    """
    n = 1200
    at, plane = sphere(n, 8.0, 1.0)
    step = at[:-1].inverse() @ at[1:]
    true = planes_seen(at, plane[1:], np.arange(1, n), np.arange(n - 1)) - plane[:-1]
    flat = np.linalg.norm(true, axis=1)
    made = curvature_difference(
        plane[:-1], step.translation, np.full(n - 1, 8.0), np.full(n - 1, 8.0)
    )
    assert np.median(flat) > 0.02
    assert np.linalg.norm(true - made, axis=1).max() < 0.03 * flat.max()


def test_curvature_radii_by_azimuth_and_elevation_have_signs() -> None:
    """Ahead along +x stands a hull that curves away on both sides: its normal leans towards where
    the vehicle has gone.
    """
    plane, inf = np.array([[-2.0, 0, 0]]), np.array([np.inf])
    aside = curvature_difference(plane, np.array([[0, 0.1, 0]]), np.array([5.0]), inf)[0]
    above = curvature_difference(plane, np.array([[0, 0, 0.1]]), inf, np.array([4.0]))[0]
    np.testing.assert_allclose(aside[1:], [2 * 0.1 / 7, 0], atol=1e-4)
    np.testing.assert_allclose(above[1:], [0, 2 * 0.1 / 6], atol=1e-4)
    assert (curvature_difference(plane, np.array([[0.3, 0.1, 0.2]]), inf, inf) == 0).all()
    np.testing.assert_allclose(
        curvature_difference(plane, np.array([[0.3, 0, 0]]), np.ones(1), np.ones(1)), 0, atol=1e-15
    )


@pytest.mark.parametrize(
    ("wall", "moved", "leans"),
    [
        ([-2.0, 0, 0], [0, 0.1, 0], "the other way"),  # ahead
        ([0, -2.0, 0], [-0.1, 0, 0], "not at all"),  # to starboard
        ([2.0, 0, 0], [0, 0.1, 0], "right"),  # astern
    ],
)
def test_lean_by_the_step_along_y_as_printed_is_right_for_a_hull_astern_alone(
    wall: list[float], moved: list[float], leans: str
) -> None:
    """[Ozog2016 2.3.4.2] adds t_y / r_a to the normal's azimuth, wherever the hull is."""
    plane, step, radius = np.array(wall), np.array(moved), 50.0
    azimuth = np.arctan2(plane[1], plane[0]) + step[1] / radius
    printed = 2.0 * np.array([np.cos(azimuth), np.sin(azimuth), 0]) - plane
    found = curvature_difference(plane[None], step[None], np.array([radius]), np.array([np.inf]))[0]
    assert found @ step > 0  # a convex hull leans towards where the vehicle has gone
    if leans == "not at all":
        np.testing.assert_allclose(printed, 0, atol=1e-12)
    else:
        assert (printed @ step > 0) == (leans == "right")


def test_the_weight_counts_the_curvature_the_poses_and_the_floor() -> None:
    plane, moved, radius = (
        np.array([[-2.0, 0.1, 0.2]]),
        np.array([[0.1, 0.6, -0.4]]),
        np.array([5.0]),
    )
    turn = Rotation.from_rotvec([0.3, 0.2, -0.1]).as_matrix()[None]
    difference = curvature_difference(plane, moved, radius, radius)[0]

    def covariance(joint: np.ndarray) -> np.ndarray:
        root = curvature_information(plane, moved, radius, radius, turn, joint[None], 0.01)[0]
        return np.asarray(np.linalg.inv(root.T @ root))

    np.testing.assert_allclose(
        covariance(np.zeros((14, 14))), np.diag(difference**2 + 1e-4), rtol=1e-9
    )
    rng = np.random.default_rng(0)
    a = 0.01 * rng.normal(size=(14, 14))
    joint = a @ a.T
    # by draws: poses i and j with this covariance, the step between them in the axes of i
    draws = rng.multivariate_normal(np.zeros(14), 1e-4 * joint, 20000)
    there = turn[0] @ moved[0] + draws[:, 7:10] - draws[:, 0:3]
    back = Rotation.from_matrix(turn[0]) * Rotation.from_rotvec(draws[:, 3:6])
    many = curvature_difference(np.repeat(plane, 20000, 0), back.inv().apply(there), radius, radius)
    spread = covariance(joint) - covariance(np.zeros((14, 14)))
    np.testing.assert_allclose(1e4 * np.cov(many.T), spread, atol=0.05 * np.abs(spread).max())


def test_a_misfit_in_its_own_covariance_as_printed_costs_the_same_however_large(
    empty: Empty,
) -> None:
    """[Ozog2016 2.3.4.2] prints the misfit to the curved surface as the sigma of that misfit."""
    plane, moved, radius = np.array([[-2.0, 0, 0]]), np.array([[0, 0.1, 0.1]]), np.array([5.0])
    predicted = curvature_difference(plane, moved, radius, radius)
    turn, certain = np.eye(3)[None], np.zeros((1, 14, 14))
    root = curvature_information(plane, moved, radius, radius, turn, certain, 0.01)
    found, printed = [], []
    for size in (1.0, 2.0):
        misfit = size * np.array([0.02, -0.03, 0.01])
        for costs, weight in ((found, root), (printed, np.diag(1 / np.abs(misfit))[None])):
            p = empty(2)
            p.unknowns.plane = np.vstack([plane, plane + predicted + misfit])
            p.planes.anchor = np.zeros(2, np.int32)
            p.plane_pairs.first, p.plane_pairs.second = np.zeros(1, np.int32), np.ones(1, np.int32)
            p.plane_pairs.measured, p.plane_pairs.sqrt_information = predicted, weight
            p.plane_pairs.point, p.plane_pairs.place = np.zeros((2, 1, 3))
            p.plane_pairs.by_place = np.zeros((1, 3, 3))
            costs.append(evaluate(p).cost_by_factor["plane_pair"])
    explained = predicted[0] ** 2 + 0.01**2
    once = 0.5 * np.sum(np.array([0.02, -0.03, 0.01]) ** 2 / explained)
    np.testing.assert_allclose(found, [once, 4 * once])
    np.testing.assert_allclose(printed, 0.5 * 3)


def test_pairs_by_curvature_tie_a_spiral_around_a_sphere() -> None:
    """The sphere of [Ozog2016 C]: no plane is seen twice; pairs hold the path on its sphere, with
    the right radius best, with half of it and more than twice of it nearly as well.
    """
    at, plane = sphere(400, 8.0, 1.0)
    rng = np.random.default_rng(3)
    n = len(at)
    step = (
        at[:-1].inverse()
        @ at[1:]
        @ exp(np.r_[0.01, 0.005, 0.0, 0, 0, 0] + 0.002 * rng.normal(size=(n - 1, 6)))
    )
    held = (
        "T_g_M",
        "T_s_ct",
        "T_ct_cb",
        "T_s_d",
        "navigation",
        "intrinsics_top",
        "intrinsics_bottom",
        "tray",
    )
    start = [at[:1]]
    for k in range(n - 1):
        start.append(start[-1] @ step[k : k + 1])
    path = Poses(
        np.vstack([x.quaternion for x in start]), np.vstack([x.translation for x in start])
    )
    p = Draft(
        Problem(
            unknowns=Unknowns(pose=np.c_[path.translation, path.quaternion, np.zeros(n)]),
            constant=held,
        )
    )
    p.priors.pose.node, p.priors.pose.value = np.zeros(1, np.int32), p.unknowns.pose[:1, :7].copy()
    p.priors.pose.sqrt_information = np.eye(6)[None] * 1e3
    p.links.first, p.links.second = (
        np.arange(n - 1, dtype=np.int32),
        np.arange(1, n, dtype=np.int32),
    )
    p.links.camera_first = p.links.camera_second = np.zeros(n - 1, np.int32)
    p.links.measured, p.links.scaled = (
        np.c_[step.translation, step.quaternion],
        np.ones(n - 1, bool),
    )
    p.links.sqrt_information = np.tile(np.diag([100.0] * 3 + [400.0] * 3), (n - 1, 1, 1))
    p.links.kernel = np.full(n - 1, LinkKernel.NONE, np.int32)
    rpy = at.rotation.as_euler("xyz")
    p.attitude.node, p.attitude.sigma = (
        np.arange(n, dtype=np.int32),
        np.tile([0.02, 0.002, 0.002], (n, 1)),
    )
    p.attitude.measured = np.c_[at.translation[:, 2], rpy[:, :2]]
    p.unknowns.plane, p.planes.anchor = plane.copy(), np.arange(n, dtype=np.int32)
    p.plane_sightings.node = p.plane_sightings.plane = np.arange(n, dtype=np.int32)
    p.plane_sightings.measured = plane + 0.005 * rng.normal(size=plane.shape)
    p.plane_sightings.sqrt_information = np.tile(np.eye(3) * 200, (n, 1, 1))
    gap = np.linalg.norm(at.translation[:, None] - at.translation[None], axis=2)
    first, second = np.nonzero(
        np.triu((gap < 2.0) & (np.abs(np.subtract.outer(np.arange(n), np.arange(n))) > 20))
    )
    p.plane_pairs.first, p.plane_pairs.second = first.astype(np.int32), second.astype(np.int32)
    p.plane_pairs.point = p.plane_pairs.place = np.zeros((len(first), 3))
    p.plane_pairs.by_place = np.zeros((len(first), 3, 3))
    errors = {}
    for radius in (4.0, 8.0, 20.0, None):
        if radius is None:
            for name in (
                "first",
                "second",
                "measured",
                "sqrt_information",
                "point",
                "place",
                "by_place",
            ):
                setattr(p.plane_pairs, name, getattr(p.plane_pairs, name)[:0])
        else:
            moved = (at[first].inverse() @ at[second]).translation
            radii = np.full(len(first), radius)
            p.plane_pairs.measured = curvature_difference(plane[first], moved, radii, radii)
            none = np.zeros((len(first), 14, 14))
            p.plane_pairs.sqrt_information = curvature_information(
                plane[first], moved, radii, radii, at[first].rotation.as_matrix(), none, 0.05
            )
        errors[radius] = off_sphere_m(
            solve(p, Options(function_tolerance=1e-9)).unknowns.pose[:, :3]
        )
    assert errors[None] > 0.05
    assert errors[8.0] < 0.2 * errors[None]
    assert max(errors[4.0], errors[20.0]) < 0.4 * errors[None]


def off_sphere_m(points: np.ndarray) -> float:
    """Spread of the distances from the middle of the sphere that fits best."""
    (*middle, _), *_ = np.linalg.lstsq(
        np.c_[2 * points, np.ones(len(points))], np.sum(points**2, axis=1), rcond=None
    )
    return float(np.linalg.norm(points - middle, axis=1).std())
