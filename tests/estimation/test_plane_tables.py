# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Planes of the hull as tables of a native problem."""

import numpy as np
import pytest
from navigation.planar_dive import simulate

from hullrecon import native
from hullrecon.estimation.plane_tables import with_planes
from hullrecon.estimation.position_tables import fit_of_positions, with_positions
from hullrecon.navigation.planes.planar_graph import planar_graph
from hullrecon.navigation.pose_graph.graph import OPTIONS, PoseGraph
from hullrecon.records.links import no_links
from hullrecon.records.trajectory import PositionTies


@pytest.fixture(scope="module")
def solved():
    dive = simulate(1, drift_deg_per_hour=60.0, legs=2, leg_m=5.0)
    graph = PoseGraph(
        trajectory=dive.trajectory, odometry=dive.odometry, attitude=dive.attitude, rig=dive.rig
    )
    return planar_graph(graph, dive.returns, None).solve(no_links())


def test_without_planes_the_problem_is_the_same(solved):
    assert with_planes(solved.problem, None) is solved.problem


def test_every_plane_is_an_unknown_in_the_frame_of_its_anchor(solved):
    problem = with_planes(solved.problem, solved.planes)
    np.testing.assert_array_equal(problem.unknowns.plane, solved.planes.plane)
    np.testing.assert_array_equal(problem.planes.anchor, solved.planes.table.anchor)
    distance = np.linalg.norm(problem.unknowns.plane, axis=1)
    assert np.all((distance > 0.5) & (distance < 2.0))  # of the vehicle from the hull
    assert np.all(problem.unknowns.plane[:, 0] < 0)  # the hull is ahead, its normal looks back


def test_ranges_and_pairs_fit_within_sigmas_at_solution(solved):
    found = native.evaluate(solved.problem, OPTIONS)
    rms = {}
    for name in ("plane_range", "plane_pair"):
        rows = found.residual[found.factor == native.FACTORS.index(name)]
        rms[name] = float(np.sqrt(np.mean(rows**2)))
    assert 0.8 < rms["plane_range"] < 1.2
    # what is shared among the ties of a patch is counted once: they fit better than they claim
    assert rms["plane_pair"] < 1.0


def test_a_planes_returns_are_moved_onto_it_along_their_beams(solved):
    rows = solved.planes.ranges
    assert np.bincount(rows.plane).min() >= 12
    np.testing.assert_allclose(np.linalg.norm(rows.beam, axis=1), 1)
    assert np.all(rows.sigma >= 0.01)


def test_positions_are_compared_with_a_path_that_planes_tie(solved):
    at = solved.problem.unknowns.pose[:, :2]
    ties = PositionTies(
        t_ns=np.arange(len(at), dtype=np.int64),
        node=np.arange(len(at)),
        antenna=np.zeros((len(at), 3)),
        north_east=at + np.array([30.0, -4.0]),
        sigma=np.full(len(at), 0.3),
    )
    problem = with_positions(solved.problem, ties)
    fit = fit_of_positions(problem, ties, np.eye(3), OPTIONS)
    assert fit is not None
    assert fit.rms < 1e-3
