# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The pose graph on two legs of 15 m with truth: what links do to the path, and which of them are
believed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from navigation.linked_dive import (
    STEP_S,
    LinkedDive,
    aligned_error_m,
    disturbed,
    joined,
    link,
    neighbours,
    opposite,
    simulate,
)
from scipy.spatial.transform import Rotation

from hullrecon import native
from hullrecon.geometry.poses import Poses, exp, pose_from_vector
from hullrecon.navigation.pose_graph.graph import (
    OPTIONS,
    GraphErrors,
    GraphSolution,
    PoseGraph,
    linked_parts,
)
from hullrecon.navigation.pose_graph.link_table import link_table
from hullrecon.navigation.pose_graph.start import path_along_links
from hullrecon.records.links import CameraLinks
from hullrecon.studies.scenes.ellipsoid_dive import reckoned

DRIFT = 1.5e-3  # rad/s: 10 degrees over the two minutes of the dive


def graph_of(dive: LinkedDive, kernel: str = "scaling") -> PoseGraph:
    return PoseGraph(
        trajectory=dive.trajectory,
        odometry=dive.odometry,
        attitude=dive.attitude,
        rig=dive.rig,
        kernel=kernel,
    )


def error_m(found: GraphSolution, dive: LinkedDive) -> float:
    return aligned_error_m(found.path.poses, dive.global_from_vehicle)


def no_links(dive: LinkedDive) -> CameraLinks:
    return link(dive, np.zeros((0, 2), np.int64), np.random.default_rng(0))


@pytest.fixture(scope="module")
def dive() -> LinkedDive:
    return simulate(1, drift=DRIFT)


@pytest.fixture(scope="module")
def links(dive: LinkedDive) -> CameraLinks:
    """Neighbours, and every third pair of opposite nodes."""
    return link(dive, np.vstack([neighbours(), opposite(every=3)]), np.random.default_rng(2))


# the path


def test_without_links_the_path_is_dead_reckoning(dive: LinkedDive) -> None:
    found = graph_of(dive).solve(no_links(dive))
    assert found.converged
    np.testing.assert_allclose(
        found.path.poses.translation[:, :2], dive.trajectory.translation[:, :2], atol=0.1
    )
    assert error_m(found, dive) > 0.2


def test_links_between_the_legs_take_the_drift_out_of_the_path(
    dive: LinkedDive, links: CameraLinks
) -> None:
    """Dead reckoning, neighbours alone, neighbours and opposite nodes: 22 cm, 6 mm, 4.5 mm."""
    reckoned = aligned_error_m(dive.trajectory.poses(), dive.global_from_vehicle)
    chained = error_m(
        graph_of(dive).solve(link(dive, neighbours(), np.random.default_rng(2))), dive
    )
    tied = graph_of(dive).solve(links)
    assert tied.converged
    assert not tied.rejected.any()
    assert reckoned > 0.2
    assert chained < 0.01
    assert error_m(tied, dive) < min(0.006, chained)


def test_the_heading_drift_is_found(dive: LinkedDive, links: CameraLinks) -> None:
    found = graph_of(dive).solve(links).problem.unknowns.navigation[1]
    assert found == pytest.approx(DRIFT, rel=0.1)


@pytest.mark.parametrize("kernel", ["switch", "none"])
def test_second_solve_from_first_equals_a_single_solve(
    dive: LinkedDive, links: CameraLinks, kernel: str
) -> None:
    graph = graph_of(dive, kernel)
    before = graph.solve(link(dive, neighbours(), np.random.default_rng(2)))
    again, at_once = graph.solve(links, before), graph.solve(links)
    np.testing.assert_allclose(
        again.path.poses.translation, at_once.path.poses.translation, atol=5e-4
    )


def test_with_scaling_both_ways_end_in_paths_of_one_shape(
    dive: LinkedDive, links: CameraLinks
) -> None:
    """Scaling is not convex: which right links are weighed down depends on the start, which turns
    the path a little.
    """
    graph = graph_of(dive)
    again = graph.solve(links, graph.solve(link(dive, neighbours(), np.random.default_rng(2))))
    shape = np.tile(np.eye(4), (60, 1, 1))
    shape[:, :3, 3] = graph.solve(links).path.poses.translation
    assert aligned_error_m(again.path.poses, shape) < 1e-3


def test_links_without_length_correct_drift_but_not_scale(
    dive: LinkedDive,
) -> None:
    pairs = np.vstack([neighbours(), opposite(every=3)])
    mono = link(dive, pairs, np.random.default_rng(2), scaled=False)
    found = graph_of(dive).solve(mono)
    assert error_m(found, dive) < 0.05
    longer = replace(
        mono, translation=7 * mono.translation, covariance=scaled_by(mono.covariance, 7.0)
    )
    again = graph_of(dive).solve(longer)
    np.testing.assert_allclose(
        again.path.poses.translation, found.path.poses.translation, atol=1e-4
    )


def silent_from(dive: LinkedDive, node: int) -> LinkedDive:
    """The dive with a DVL that says nothing more from a node on: odometry goes on as it went, and
    knows it badly.
    """
    odometry = dive.odometry
    silent = odometry.first >= node
    translation, covariance = odometry.translation.copy(), odometry.covariance.copy()
    translation[silent] = odometry.translation[node - 1]
    covariance[silent, :3, :3] += (
        np.arange(1, silent.sum() + 1)[:, None, None] ** 2 * 0.1**2 * np.eye(3)
    )
    odometry = replace(odometry, translation=translation, covariance=covariance)
    return replace(
        dive, odometry=odometry, trajectory=reckoned(dive.global_from_vehicle[0], odometry, STEP_S)
    )


@pytest.mark.parametrize("every", [1, 2])
def test_links_without_length_follow_a_turn_in_dvl_outage(dive: LinkedDive, every: int) -> None:
    """Also where every second image alone is compared. The steps' lengths are as guessed."""
    unheard = silent_from(dive, 24)
    pairs = neighbours()
    pairs = pairs[(pairs % every == 0).all(axis=1)]
    found = graph_of(unheard).solve(link(unheard, pairs, np.random.default_rng(2), scaled=False))
    seen = np.arange(0, 60, every)
    reckoned_m = aligned_error_m(
        unheard.trajectory.poses()[seen], unheard.global_from_vehicle[seen]
    )
    assert reckoned_m > 4
    assert not found.rejected.any()
    assert (
        aligned_error_m(found.path.poses[seen], unheard.global_from_vehicle[seen])
        < 0.15 * reckoned_m
    )


def test_start_is_dead_reckoning_where_odometry_is_good(dive: LinkedDive) -> None:
    mono = link(dive, neighbours(), np.random.default_rng(2), scaled=False)
    start = path_along_links(dive.trajectory, dive.odometry, mono, dive.rig)
    np.testing.assert_array_equal(start.translation, dive.trajectory.translation)


def scaled_by(covariance: np.ndarray, factor: float) -> np.ndarray:
    rows = np.r_[np.full(3, factor), np.ones(3)]
    return covariance * np.outer(rows, rows)


def test_links_with_and_without_length_are_solved_together(dive: LinkedDive) -> None:
    rng = np.random.default_rng(2)
    found = graph_of(dive).solve(
        joined(link(dive, neighbours(), rng, scaled=False), link(dive, opposite(every=3), rng))
    )
    assert error_m(found, dive) < 0.05


def test_a_link_of_the_bottom_camera_says_where_that_one_stood(dive: LinkedDive) -> None:
    """Every fifth node lacks its top image."""
    lower = np.arange(60) % 5 == 0
    found = graph_of(dive).solve(
        link(
            dive,
            np.vstack([neighbours(), opposite(every=3)]),
            np.random.default_rng(2),
            bottom=lower,
        )
    )
    assert error_m(found, dive) < 0.03
    assert not found.rejected.any()


def test_the_cameras_mount_is_found_where_it_has_a_prior(
    dive: LinkedDive, links: CameraLinks
) -> None:
    true_mount = dive.rig.tray_from_top
    wrong = true_mount @ exp([[0, 0, 0, *np.radians([0.8, -0.5, 0.6])]])
    prior = np.diag(1 / np.r_[np.full(3, 0.01), np.full(3, np.radians(1.0))])
    rig = replace(dive.rig, tray_from_top=wrong).with_priors(tray_from_top=prior)
    found = replace(graph_of(dive), rig=rig).solve(links)
    off = (
        true_mount.inverse() @ pose_from_vector(found.problem.unknowns.T_s_ct)
    ).rotation.magnitude()[0]
    assert (
        np.degrees(off) < 0.4 < np.degrees((true_mount.inverse() @ wrong).rotation.magnitude()[0])
    )
    assert error_m(found, dive) < 0.04


def test_the_same_links_give_the_same_bytes(dive: LinkedDive, links: CameraLinks) -> None:
    one, two = (graph_of(dive).solve(links).record() for _ in range(2))
    assert one.pose.tobytes() == two.pose.tobytes()
    assert one.covariance.tobytes() == two.covariance.tobytes()


# wrong links


def with_wrong(dive: LinkedDive, count: int) -> tuple[CameraLinks, np.ndarray]:
    """Links between the legs of which some are off by half a metre and six degrees, and which those
    are.
    """
    rng = np.random.default_rng(4)
    right = link(dive, np.vstack([neighbours(), opposite()]), rng)
    rows = len(neighbours()) + rng.choice(len(opposite()), count, replace=False)
    wrong = np.zeros(len(right), bool)
    wrong[rows] = True
    return disturbed(right, rows, 0.5, 0.1, rng), wrong


@pytest.mark.parametrize("kernel", ["scaling", "switch"])
def test_wrong_links_are_named_and_do_not_move_the_path(dive: LinkedDive, kernel: str) -> None:
    links, wrong = with_wrong(dive, 4)
    found = graph_of(dive, kernel).solve(links)
    np.testing.assert_array_equal(np.flatnonzero(found.rejected), np.flatnonzero(wrong))
    without = graph_of(dive, kernel).solve(kept(links, ~wrong))
    np.testing.assert_allclose(
        found.path.poses.translation, without.path.poses.translation, atol=0.01
    )


def test_without_a_guard_wrong_links_move_the_path(dive: LinkedDive) -> None:
    links, wrong = with_wrong(dive, 4)
    guarded, open_to_all = (graph_of(dive, kernel).solve(links) for kernel in ("scaling", "none"))
    assert error_m(open_to_all, dive) > 3 * error_m(guarded, dive)
    right = graph_of(dive, "none").solve(kept(links, ~wrong))
    assert error_m(right, dive) == pytest.approx(error_m(guarded, dive), abs=0.01)


def kept(links: CameraLinks, rows: np.ndarray) -> CameraLinks:
    names = ("first", "second", "translation", "quaternion", "covariance", "scaled", "bottom")
    return CameraLinks(**{name: getattr(links, name)[rows] for name in names})


def test_a_wrong_link_that_comes_in_a_later_round_is_named(
    dive: LinkedDive, links: CameraLinks
) -> None:
    rng = np.random.default_rng(7)
    before = graph_of(dive).solve(links)
    astray = disturbed(link(dive, np.array([[4, 55]]), rng), np.array([0]), 0.4, 0.05, rng)
    found = graph_of(dive).solve(joined(links, astray), before)
    assert np.flatnonzero(found.rejected).tolist() == [len(links)]
    np.testing.assert_allclose(
        found.path.poses.translation, before.path.poses.translation, atol=0.01
    )


def test_second_start_is_tried_where_many_links_look_wrong(
    dive: LinkedDive,
) -> None:
    """Links that say too much of themselves: from the path of the neighbours alone more of them are
    rejected than need be.
    """
    rng = np.random.default_rng(3)
    along, across = (link(dive, pairs, rng, scaled=False) for pairs in (neighbours(), opposite()))
    links = joined(along, replace(across, covariance=0.3**2 * across.covariance))
    graph = graph_of(dive)
    before = graph.solve(along)
    from_before, cost = graph._solve_guarded(links, before.problem.unknowns)
    found = graph.solve(links, before)
    assert found.rejected.sum() < from_before.rejected.sum()
    assert (
        sum(native.evaluate(found.problem, OPTIONS, jacobian=False).cost_by_factor.values()) < cost
    )


# how sure it is


def relative_cameras(
    pose: np.ndarray,
    tray: np.ndarray,
    dive: LinkedDive,
    first: int,
    second: int,
    bottom: int | None = None,
) -> Poses:
    """second_from_first of the top cameras, of vehicles `pose` (n, 7) with their trays; bottom: the
    node whose bottom camera leads.
    """
    chain = []
    for k in (first, second):
        hinge = Poses(Rotation.from_euler("y", [tray[k]]).as_quat(), dive.rig.tray_origin[None])
        mount = (
            dive.rig.tray_from_top
            if k != bottom
            else dive.rig.tray_from_top @ dive.rig.top_from_bottom
        )
        chain.append(Poses(pose[[k], 3:7], pose[[k], :3]) @ hinge @ mount)
    return chain[1].inverse() @ chain[0]


ALL_TOP = np.zeros(60, bool)


@pytest.mark.parametrize("bottom", [None, 7, 41])
def test_relative_covariance_equals_numeric_propagation(
    dive: LinkedDive, links: CameraLinks, bottom: int | None
) -> None:
    """Central differences of the cameras' relative pose by all fourteen numbers of the two
    vehicles.
    """
    found = graph_of(dive).solve(links)
    pair = (7, 41)
    pose = found.problem.unknowns.pose
    joint = native.pair_covariance(found.problem, np.array([pair], np.int32)).pose[0]
    middle = relative_cameras(pose[:, :7], pose[:, 7], dive, *pair, bottom)
    jacobian = np.zeros((6, 14))
    for column in range(14):
        ends = []
        for sign in (1e-6, -1e-6):
            moved, k, which = pose.copy(), pair[column // 7], column % 7
            if which < 3:
                moved[k, which] += sign
            elif which < 6:
                turn = Rotation.from_rotvec(sign * np.eye(3)[which - 3])
                moved[k, 3:7] = (Rotation.from_quat(moved[k, 3:7]) * turn).as_quat()
            else:
                moved[k, 7] += sign
            at = relative_cameras(moved[:, :7], moved[:, 7], dive, *pair, bottom)
            ends.append(
                np.r_[at.translation[0], (middle.rotation.inv() * at.rotation).as_rotvec()[0]]
            )
        jacobian[:, column] = (ends[0] - ends[1]) / 2e-6
    errors = found.relative_errors(np.arange(60) == bottom)
    predicted = errors.relative_covariance(np.array([7]), np.array([41]))[0]
    np.testing.assert_allclose(predicted, jacobian @ joint @ jacobian.T, rtol=1e-4, atol=1e-12)


def test_no_pairs_have_no_covariances(dive: LinkedDive, links: CameraLinks) -> None:
    none = np.zeros(0, np.int64)
    assert graph_of(dive).solve(links).relative_errors(ALL_TOP).relative_covariance(
        none, none
    ).shape == (0, 6, 6)


def test_relative_poses_err_as_their_covariance_says() -> None:
    """Normalised squared errors of pairs far apart over ten dives with all errors drawn: chi-square
    of six.
    """
    first, second = np.array([2, 10, 15, 5]), np.array([57, 30, 44, 25])
    squares = []
    for seed in range(10):
        dive = simulate(100 + seed)
        found = graph_of(dive, "none").solve(
            link(dive, np.vstack([neighbours(), opposite(every=3)]), np.random.default_rng(seed))
        )
        covariance = found.relative_errors(ALL_TOP).relative_covariance(first, second)
        pose = found.problem.unknowns.pose
        camera = dive.cameras()
        for k, (a, b) in enumerate(zip(first, second, strict=True)):
            at = relative_cameras(pose[:, :7], pose[:, 7], dive, a, b)
            truth = np.linalg.inv(camera[b]) @ camera[a]
            turn = (Rotation.from_matrix(truth[:3, :3]).inv() * at.rotation).as_rotvec()[0]
            error = np.r_[at.translation[0] - truth[:3, 3], turn]
            squares.append(error @ np.linalg.solve(covariance[k], error))
    assert 4.5 < np.mean(squares) < 7.5  # forty squares of six, correlated within a dive


def test_what_links_tie_is_known_better_than_what_they_do_not(
    dive: LinkedDive, links: CameraLinks
) -> None:
    ends = np.array([0]), np.array([59])
    loose, tied = (
        graph_of(dive).solve(x).relative_errors(ALL_TOP) for x in (no_links(dive), links)
    )
    sigma = [np.sqrt(np.trace(e.relative_covariance(*ends)[0, :3, :3])) for e in (loose, tied)]
    assert sigma[1] < 0.02 < 0.1 * sigma[0]


def test_information_of_a_link_is_what_it_takes_off_the_covariance(
    dive: LinkedDive, links: CameraLinks
) -> None:
    """Of a pair whose nodes have no link yet: half the logarithm of the ratio of determinants."""
    found = graph_of(dive).solve(kept(links, np.flatnonzero(links.second - links.first > 2)))
    ends = np.array([[0], [30]])
    one = link(dive, ends.T, np.random.default_rng(3))
    (gain,) = found.information_gain(ALL_TOP, *ends, np.linalg.inv(one.covariance))
    mounts = found.problem.hold("T_s_d", "T_s_ct", "T_ct_cb")
    both = link_table(joined(found.links, one), 60, native.LinkKernel.NONE)
    before, after = (
        GraphErrors(problem=problem, bottom=ALL_TOP).relative_covariance(*ends)[0]
        for problem in (mounts, replace(mounts, links=both))
    )
    assert gain == pytest.approx(
        0.5 * np.log(np.linalg.det(before) / np.linalg.det(after)), rel=1e-4
    )
    assert gain > 1


def test_a_further_link_of_linked_nodes_informs_less(dive: LinkedDive) -> None:
    ends = np.array([[7], [41]])
    information = np.linalg.inv(link(dive, ends.T, np.random.default_rng(3)).covariance)
    few, many = (
        graph_of(dive)
        .solve(link(dive, pairs, np.random.default_rng(3)))
        .information_gain(ALL_TOP, *ends, information)[0]
        for pairs in (neighbours(), np.vstack([neighbours(), opposite()]))
    )
    assert many < 0.5 * few


def test_the_record_holds_path_covariance_and_parts(dive: LinkedDive, links: CameraLinks) -> None:
    found = graph_of(dive).solve(links)
    record = found.record()
    np.testing.assert_array_equal(record.pose[:, :3], found.path.poses.translation)
    assert record.covariance.shape == (60, 6, 6)
    assert (np.linalg.eigvalsh(record.covariance) > -1e-12).all()
    assert record.part.tolist() == [0] * 60
    np.testing.assert_array_equal(record.path().tray, found.path.tray)


# how links become factors


def test_a_link_says_less_the_more_links_share_its_images(dive: LinkedDive) -> None:
    rng = np.random.default_rng(0)
    alone, crowd = (
        link(dive, np.array([[0, 1]]), rng),
        link(dive, np.array([[0, k] for k in range(1, 8)]), rng),
    )
    one, many = (
        link_table(x, 60, native.LinkKernel.NONE).sqrt_information[0] for x in (alone, crowd)
    )
    np.testing.assert_allclose(one, np.linalg.inv(np.linalg.cholesky(alone.covariance[0])))
    np.testing.assert_allclose(many, one / np.sqrt((7 + 1) / 4))


def test_a_link_without_length_is_whitened_by_its_direction(dive: LinkedDive) -> None:
    """A metre along x, known to 1 cm along it and to 2 and 3 cm across: angles of 0.02 and 0.03
    rad.
    """
    made = link(dive, np.array([[0, 1]]), np.random.default_rng(0), scaled=False)
    covariance = np.diag([0.01, 0.02, 0.03, 0.1, 0.2, 0.3])[None] ** 2
    made = replace(made, translation=np.array([[1.0, 0, 0]]), covariance=covariance)
    table = link_table(made, 60, native.LinkKernel.NONE)
    found = np.linalg.inv(table.sqrt_information[0, :5, :5].T @ table.sqrt_information[0, :5, :5])
    np.testing.assert_allclose(np.sort(np.diag(found)[:2]), [0.02**2, 0.03**2])
    np.testing.assert_allclose(np.diag(found)[2:], [0.1**2, 0.2**2, 0.3**2])


# parts


def test_parts_are_numbered_by_size_without_loose_nodes() -> None:
    part = linked_parts(9, np.array([0, 3, 4, 5, 7]), np.array([1, 4, 5, 3, 8]))
    assert part.tolist() == [1, 1, -1, 0, 0, 0, -1, 2, 2]


def test_of_parts_of_one_size_the_earlier_comes_first() -> None:
    assert linked_parts(4, np.array([2, 0]), np.array([3, 1])).tolist() == [0, 0, 1, 1]


def test_without_links_no_node_is_in_a_part() -> None:
    none = np.zeros(0, np.int64)
    assert linked_parts(3, none, none).tolist() == [-1, -1, -1]


def test_image_odometry_is_dropped_where_a_link_joins_its_nodes(
    dive: LinkedDive,
) -> None:
    odometry = replace(dive.odometry, from_images=np.arange(len(dive.odometry)) % 3 > 0)
    pairs = np.column_stack([odometry.first, odometry.second])[::2]
    found = replace(graph_of(dive), odometry=odometry).solve(
        link(dive, pairs, np.random.default_rng(4))
    )
    assert found.converged
    linked = np.arange(len(odometry)) % 2 == 0
    kept = ~(odometry.from_images & linked)
    np.testing.assert_array_equal(found.problem.odometry.first, odometry.first[kept])


def test_a_dive_in_two_parts_is_solved_and_says_so(dive: LinkedDive) -> None:
    pairs = neighbours(reach=1)
    pairs = pairs[(pairs[:, 0] != 29) & (pairs[:, 1] > 5)]
    record = graph_of(dive).solve(link(dive, pairs, np.random.default_rng(1))).record()
    assert record.part.tolist() == [-1] * 5 + [1] * 25 + [0] * 30
