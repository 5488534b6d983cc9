# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""A path that an outage cuts in two: each segment is registered to the CAD model, unless
images tie the two.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from adjustment.simulated_dive import aligning, moved, records_poses, simulate

from hullrecon.adjustment.bundle_adjustment import adjust, solve_path
from hullrecon.adjustment.cad_placement import register, segments_of_path
from hullrecon.adjustment.hull_pose import segments
from hullrecon.adjustment.options import PRODUCT, AdjustOptions
from hullrecon.adjustment.results.summary import summarise_adjustment
from hullrecon.adjustment.rounds import RoundSolver

OPTIONS = AdjustOptions()
PER_LEG = 18
SIGMA_M = 1.0
OUTAGE_NS = 60 * 10**9


@lru_cache
def interrupted(shift_m, per_leg=PER_LEG, last=PER_LEG - 1, **scene):
    """The dive with an outage after node `last`: what follows is shifted (x, y in g), as its
    odometry says with SIGMA_M.
    """
    dive = simulate(per_leg=per_leg, **scene)
    m = dive.measured
    pose = m.trajectory.poses().matrix()
    pose[last + 1 :, :2, 3] += shift_m
    row = int(np.flatnonzero(m.odometry.first == last)[0])
    step = records_poses(np.linalg.inv(pose[last]) @ pose[last + 1])
    translation, covariance = m.odometry.translation.copy(), m.odometry.covariance.copy()
    translation[row], covariance[row, :3, :3] = step.translation[0], SIGMA_M**2 * np.eye(3)
    t_ns = m.trajectory.t_ns + OUTAGE_NS * (np.arange(len(pose)) > last)
    trajectory = replace(m.trajectory, t_ns=t_ns, translation=records_poses(pose).translation)
    odometry = replace(m.odometry, translation=translation, covariance=covariance)
    returns = replace(m.returns, t_ns=m.returns.t_ns + OUTAGE_NS * (m.returns.node > last))
    return replace(
        dive, measured=replace(m, trajectory=trajectory, odometry=odometry, returns=returns)
    )


def errors_m(dive, adjusted):
    """Of the vehicle (n, 3) in g after the best rigid alignment."""
    truth, found = dive.global_from_vehicle[:, :3, 3], adjusted.state.nodes.translation
    return moved(aligning(found, truth), found) - truth


def found_segments(dive):
    path = solve_path(dive.measured, solver(dive))
    return path, segments_of_path(path.last, solver(dive))


def solver(dive):
    return RoundSolver(
        calibrated=dive.measured.rig, options=OPTIONS, strategy=PRODUCT, report=lambda _: None
    )


@pytest.mark.parametrize("shift_m", [(1.1, -0.7), (-0.8, 1.2), (-1.5, -0.6)])
def test_both_segments_are_registered_after_any_outage(shift_m):
    dive = interrupted(shift_m, camera=False)
    adjusted = adjust(dive.measured, OPTIONS, lambda _: None)
    outcome = summarise_adjustment(dive.measured, adjusted, OPTIONS)
    assert adjusted.verdict.accepted
    assert len(adjusted.placement.segments) == 2
    assert adjusted.placement.registration.fitness > 0.9
    off = errors_m(dive, adjusted)
    assert np.sqrt(np.mean(np.sum(off**2, axis=1))) < 0.05
    sigma = np.sqrt(np.einsum("nii->ni", outcome.solution.pose_covariance)[:, :3])
    assert np.abs(off).max() < 3 * sigma.max()
    (sentence,) = [w for w in outcome.warnings if "segments" in w]
    assert "Outages cut the path into 2 segments, known to 1.00 m from one to the next" in sentence
    assert np.abs(shift_m).max() < 3 * adjusted.placement.segments.loosest_m


def test_the_first_segment_stays_where_the_dive_began():
    """The guess of the hull pose is one in g, which is where the first node is, whichever segment
    is the longest.
    """
    dive = interrupted((1.1, -0.7), last=PER_LEG - 6, camera=False)
    path, found = found_segments(dive)
    laid = register(path.estimate, dive.measured.cad_model, solver(dive), found)
    assert found.reference == 1
    np.testing.assert_allclose(
        laid.estimate.state.nodes.translation[0],
        path.estimate.state.nodes.translation[0],
        atol=1e-9,
    )
    assert laid.placement.registration.sigmas_off == 1.0
    assert laid.verdict.accepted
    assert laid.estimate.state.hull.segments is found


def test_a_path_that_images_tie_is_one_segment():
    assert found_segments(interrupted((0.05, 0.02)))[1] is None


def test_an_even_path_is_one_segment():
    assert found_segments(simulate(camera=False))[1] is None


def test_a_model_of_another_form_is_refused_for_its_segments_too():
    dive = interrupted((1.1, -0.7), camera=False)
    mesh = dive.measured.cad_model.mesh
    other = replace(
        dive.measured.cad_model, mesh=replace(mesh, vertices=mesh.vertices * [0.25, 0.3, 0.35])
    )
    path, found = found_segments(dive)
    refused = register(path.estimate, other, solver(dive), found)
    assert (
        "wherever it and the 2 segments that outages leave of the path are placed"
        in refused.verdict.reason
    )


def test_what_lies_between_two_segments_moves_with_both():
    nodes = records_poses(np.tile(np.eye(4), (7, 1, 1)))
    of_node = np.array([-1, 0, 0, -1, -1, 1, -1])
    motion = np.tile(np.eye(4), (2, 1, 1))
    motion[1, 0, 3] = 3.0
    out = segments._move(nodes, of_node, [records_poses(motion[0]), records_poses(motion[1])])
    np.testing.assert_allclose(out.translation[:, 0], [0, 0, 0, 1, 2, 3, 3])


def test_a_segment_is_not_laid_onto_a_face_from_within():
    """Half a beam away lies the other side of the hull, which has the same form."""
    dive = interrupted((0.3, 0.2), camera=False)
    path, found = found_segments(dive)
    far = replace(found, step_covariance=found.step_covariance * 25)
    laid = register(path.estimate, dive.measured.cad_model, solver(dive), far)
    truth, at = dive.global_from_vehicle[:, :3, 3], laid.estimate.state.nodes.translation
    assert np.abs(moved(aligning(at, truth), at) - truth).max() < 0.3
