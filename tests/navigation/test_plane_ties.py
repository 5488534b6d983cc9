# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Patches along a path, which of them are proposed and pass the gate, and what a pair is expected
to show.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from navigation.planar_dive import simulate
from scipy.spatial.transform import Rotation

from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses
from hullrecon.navigation.planes.comparison import (
    compare_patches,
    difference_of_planes,
    gap_by_poses,
)
from hullrecon.navigation.planes.curvature import (
    BROAD,
    LEAST,
    curvature_of_mesh,
    curvature_of_patches,
)
from hullrecon.navigation.planes.patches import WINDOW_M, Patches, find_patches
from hullrecon.navigation.planes.ties import (
    MOST_TIES,
    REACH_M,
    SAME_PASS_M,
    is_alike,
    is_informative,
    propose_ties,
    roughness,
    tie_planes,
)
from hullrecon.records.trajectory import VehiclePath
from hullrecon.studies.scenes.ellipsoid_dive import STANDOFF_M, EllipsoidDive


@pytest.fixture(scope="module")
def dive() -> EllipsoidDive:
    return simulate(4, drift_deg_per_hour=10.0, legs=3, leg_m=6.0)


@pytest.fixture(scope="module")
def path(dive: EllipsoidDive) -> VehiclePath:
    """The truth."""
    return VehiclePath(poses=dive.truth, tray=np.zeros(len(dive.truth)))


@pytest.fixture(scope="module")
def patches(dive: EllipsoidDive, path: VehiclePath) -> Patches:
    return find_patches(dive.returns, path, dive.trajectory.t_ns, dive.rig, BROAD)


def test_there_is_a_patch_for_every_window_of_the_path(
    patches: Patches, dive: EllipsoidDive
) -> None:
    # a window ends at the node that exceeds it
    assert 0.85 < len(patches) * WINDOW_M / patches.travelled[-1] <= 1.05
    assert (np.diff(patches.anchor) > 0).all()
    rows = np.concatenate(patches.rows)
    assert len(np.unique(rows)) == len(rows)  # a return measures one patch
    np.testing.assert_allclose(np.linalg.norm(patches.plane, axis=1), STANDOFF_M, atol=0.1)


def test_flagged_returns_and_rough_windows_make_no_patch(
    dive: EllipsoidDive, path: VehiclePath
) -> None:
    flagged = replace(dive.returns, flagged=np.ones(len(dive.returns.node), bool))
    assert len(find_patches(flagged, path, dive.trajectory.t_ns, dive.rig, BROAD)) == 0
    noise = 0.2 * np.random.default_rng(0).standard_normal(len(dive.returns.node))
    rough = replace(dive.returns, range_m=dive.returns.range_m + noise)
    assert len(find_patches(rough, path, dive.trajectory.t_ns, dive.rig, BROAD)) == 0


def test_only_patches_of_other_passes_within_reach_are_proposed(
    patches: Patches, path: VehiclePath
) -> None:
    first, second = propose_ties(patches, path)
    assert len(first) > 10
    assert (patches.travelled[second] - patches.travelled[first] > SAME_PASS_M).all()
    at = path.poses[patches.anchor].apply(patches.center)
    assert np.linalg.norm(at[first] - at[second], axis=1).max() < REACH_M + 0.1
    assert np.bincount(second).max() <= MOST_TIES
    assert len(set(zip(first, second, strict=True))) == len(first)


def test_patches_of_two_sides_of_a_plate_are_not_proposed(
    patches: Patches, path: VehiclePath
) -> None:
    turned = replace(
        patches, axes=patches.axes * np.where(np.arange(len(patches)) % 2, 1, -1)[:, None, None]
    )
    first, second = propose_ties(turned, path)
    assert ((first - second) % 2 == 0).all()


def test_gaps_on_the_true_path_match_their_covariance(patches: Patches, path: VehiclePath) -> None:
    pairs = compare_patches(patches, *propose_ties(patches, path), path)
    whole = pairs.noise + pairs.fit
    chi2 = np.sum(pairs.gap * np.linalg.solve(whole, pairs.gap[:, :, None])[:, :, 0], axis=1)
    assert 0.3 < np.mean(chi2) / 3 < 1.5


def test_the_gap_is_what_a_wrong_pose_makes_of_it(
    patches: Patches, path: VehiclePath, dive: EllipsoidDive
) -> None:
    """All poses after the first leg moved away from the hull by 10 cm: seen by the first leg, the
    hull has come nearer.
    """
    later = np.arange(len(dive.truth)) >= 50
    moved = VehiclePath(
        poses=Poses(dive.truth.quaternion, dive.truth.translation - np.outer(later, [0.1, 0, 0])),
        tray=path.tray,
    )
    first, second = propose_ties(patches, path)
    across = later[patches.anchor[second]] & ~later[patches.anchor[first]]
    before, after = (
        compare_patches(patches, first[across], second[across], p) for p in (path, moved)
    )
    np.testing.assert_allclose(after.gap[:, 0] - before.gap[:, 0], 0.1, atol=0.01)


def test_the_derivative_by_poses_and_trays_is_that_of_the_gaps(
    patches: Patches, path: VehiclePath, dive: EllipsoidDive
) -> None:
    rng = np.random.default_rng(5)
    first, second = propose_ties(patches, path)
    pairs = compare_patches(patches, first[:6], second[:6], path)
    by = gap_by_poses(patches, pairs, path, dive.rig.tray_origin)
    step = 1e-4 * rng.standard_normal((len(dive.truth), 6))
    turned = Poses(
        (path.poses.rotation * Rotation.from_rotvec(step[:, 3:])).as_quat(),
        path.poses.translation + step[:, :3],
    )
    after = compare_patches(
        patches, pairs.first, pairs.second, VehiclePath(poses=turned, tray=path.tray)
    )
    anchors = [patches.anchor[pairs.first], patches.anchor[pairs.second]]
    none = np.zeros((len(pairs), 1))
    change = np.hstack([step[anchors[0]], none, step[anchors[1]], none])
    np.testing.assert_allclose(
        after.gap - pairs.gap, np.einsum("mij,mj->mi", by, change), atol=2e-6
    )
    lever = np.abs(by[:, :, [6, 13]]).max(axis=0)
    assert (lever[2] > 0.5).all()  # the tray turns what it carries: the slope in elevation


def test_a_tie_has_to_pass_both_ways(
    patches: Patches, path: VehiclePath, dive: EllipsoidDive
) -> None:
    pairs = compare_patches(patches, *propose_ties(patches, path), path)
    known = np.zeros((len(pairs), 14, 14))
    assert is_alike(patches, pairs, path, dive.rig, known).mean() > 0.9
    off = replace(
        patches,
        center=patches.center + (np.arange(len(patches)) == pairs.second[0])[:, None] * [0.3, 0, 0],
    )
    wrong = compare_patches(off, pairs.first, pairs.second, path)
    touched = (pairs.first == pairs.second[0]) | (pairs.second == pairs.second[0])
    assert not is_alike(off, wrong, path, dive.rig, known)[touched].any()
    wide = np.tile(np.diag(np.r_[np.full(3, 1.0), np.full(4, 1e-4)]), (2, 1, 1))
    joint = np.zeros((len(pairs), 14, 14))
    joint[:, :7, :7], joint[:, 7:, 7:] = wide
    # nothing speaks against it where nothing is known
    assert is_alike(off, wrong, path, dive.rig, joint)[touched].all()


def test_a_tie_gains_where_less_is_known_than_it_measures(
    patches: Patches, path: VehiclePath, dive: EllipsoidDive
) -> None:
    pairs = compare_patches(patches, *propose_ties(patches, path), path)
    for sigma, gains in ((1e-4, False), (0.1, True)):
        joint = np.tile(np.eye(14) * sigma**2, (len(pairs), 1, 1))
        assert (is_informative(patches, pairs, path, dive.rig, joint) == gains).all()


def test_a_rough_hull_is_weighed_by_what_it_shows(
    patches: Patches, path: VehiclePath, dive: EllipsoidDive
) -> None:
    rng = np.random.default_rng(6)
    center = patches.center + 0.08 * rng.standard_normal((len(patches), 1)) * patches.axes[:, :, 2]
    rough = replace(patches, center=center)
    pairs = compare_patches(rough, *propose_ties(rough, path), path)
    known = np.zeros((len(pairs), 14, 14))
    smooth = compare_patches(patches, pairs.first, pairs.second, path)
    assert roughness(patches, smooth, path, dive.rig, known)[0] == 1.0
    factor = roughness(rough, pairs, path, dive.rig, known)
    assert factor[0] > 4
    np.testing.assert_allclose(
        pairs.roughened(factor).noise[:, 0, 0], factor[0] ** 2 * pairs.noise[:, 0, 0]
    )


def test_the_difference_of_two_planes_is_that_of_the_true_ones(
    patches: Patches, path: VehiclePath
) -> None:
    """Within the sigmas that its information claims, and those of the fits."""
    pairs = compare_patches(patches, *propose_ties(patches, path), path)
    found = difference_of_planes(patches, pairs, pairs.noise + pairs.fit)
    anchors = path.poses[patches.anchor]
    motion = anchors[pairs.first].inverse() @ anchors[pairs.second]
    normal = motion.rotation.apply(patches.axes[pairs.second][:, :, 2])
    distance = -np.sum(normal * motion.apply(patches.center[pairs.second]), axis=1)
    seen = distance[:, None] * normal - patches.plane[pairs.first]
    square = np.sum(
        np.einsum("mij,mj->mi", found.information, seen - found.difference) ** 2, axis=1
    )
    assert 0.3 < square.mean() / 3 < 1.5


def test_its_information_is_that_of_height_and_slopes(patches: Patches, path: VehiclePath) -> None:
    pairs = compare_patches(patches, *propose_ties(patches, path), path)
    found = difference_of_planes(patches, pairs, pairs.noise)
    root, by = found.information, np.zeros((len(pairs), 3, 3))
    for k in range(3):
        expected = pairs.expected + 1e-6 * np.eye(3)[k]
        raised = difference_of_planes(patches, replace(pairs, expected=expected), pairs.noise)
        by[:, :, k] = (raised.difference - found.difference) / 1e-6
    whole = np.linalg.inv(root.swapaxes(1, 2) @ root)
    np.testing.assert_allclose(
        whole, by @ pairs.noise @ by.swapaxes(1, 2), atol=1e-4 * np.abs(whole).max()
    )


def test_it_changes_with_the_place_as_its_derivative_says(
    patches: Patches, path: VehiclePath
) -> None:
    """The second patch slid along each axis of the vehicle of the first."""
    first, second = propose_ties(patches, path)
    pairs = compare_patches(patches, first, second, path)
    found = difference_of_planes(patches, pairs, pairs.noise)
    away = path.poses[patches.anchor[first]].inverse() @ path.poses[patches.anchor[second]]
    np.testing.assert_allclose(pairs.place, away.apply(patches.center[second]))
    into_second = away.rotation.inv().as_matrix()
    for k in range(3):
        there = []
        for step in (1e-4, -1e-4):
            center = patches.center.copy()
            slid = []
            # each pair alone: a patch may be the second of several
            for row, patch in enumerate(second):
                center[patch] += step * into_second[row, :, k]
                one = replace(patches, center=center)
                moved = compare_patches(one, first[[row]], second[[row]], path)
                slid.append(difference_of_planes(one, moved, moved.noise).difference[0])
                center[patch] = patches.center[patch]
            there.append(np.array(slid))
        np.testing.assert_allclose(found.by_place[:, :, k], (there[0] - there[1]) / 2e-4, atol=1e-5)


def test_a_patch_in_many_pairs_says_less_in_each(
    patches: Patches, path: VehiclePath, dive: EllipsoidDive
) -> None:
    pairs = compare_patches(patches, *propose_ties(patches, path), path)
    one = pairs.rows(np.arange(len(pairs)) == 0)
    alone, many = tie_planes(patches, one, dive.returns), tie_planes(patches, pairs, dive.returns)
    assert len(alone.plane) == 2
    anchor, (first, second) = many.table.anchor, alone.table.anchor
    ties, tie = many.pairs, alone.pairs
    row = np.flatnonzero((anchor[ties.first] == first) & (anchor[ties.second] == second))[0]
    assert np.linalg.norm(ties.sqrt_information[row]) < 0.8 * np.linalg.norm(
        tie.sqrt_information[0]
    )
    np.testing.assert_array_equal(tie.measured[0], ties.measured[row])


def test_the_dive_tells_how_its_hull_bends(patches: Patches) -> None:
    found = curvature_of_patches(patches)
    # an ellipsoid of 5 x 30 x 6 m seen at its pole: 5 / 30^2 along, 5 / 6^2 down
    assert found[0] == pytest.approx(LEAST, abs=0.02)
    assert found[2] == pytest.approx(5 / 36, rel=0.25)


def test_too_few_patches_tell_nothing(
    patches: Patches, dive: EllipsoidDive, path: VehiclePath
) -> None:
    few = replace(dive.returns, flagged=dive.returns.node > 20)
    assert (
        curvature_of_patches(find_patches(few, path, dive.trajectory.t_ns, dive.rig, BROAD))
        is BROAD
    )


def test_a_cad_model_tells_how_it_bends() -> None:
    turn, along = np.meshgrid(np.linspace(0, 2 * np.pi, 61), np.linspace(0, 20, 11), indexing="ij")
    vertices = np.column_stack([4 * np.cos(turn).ravel(), 4 * np.sin(turn).ravel(), along.ravel()])
    k = np.arange(60 * 11).reshape(60, 11)[:, :10].ravel()
    faces = np.vstack(
        [np.column_stack([k, k + 11, k + 1]), np.column_stack([k + 11, k + 12, k + 1])]
    )
    found = curvature_of_mesh(Mesh(vertices, faces))
    assert found[0] == pytest.approx(1 / 4, rel=0.25)
    assert found[2] < 0.06
