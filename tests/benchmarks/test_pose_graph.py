# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from benchmarks import pose_graph
from benchmarks.solve_one import rigid_rmse_m
from hullrecon import native


def test_the_graph_of_the_field_has_the_fields_numbers():
    first, second = pose_graph.link_ends(pose_graph.path_of(45_000)[1])
    anchor, node, plane = pose_graph.sightings(pose_graph.path_of(45_000)[1])
    assert (len(first), len(node), len(anchor)) == (200_000, 97_000, 9_000)
    assert (first != second).all()
    assert (anchor[plane] != node).all()
    assert (np.bincount(plane, minlength=9_000) >= 4).all()


def test_links_and_planes_are_short():
    """Neighbours on the wall alone: nothing joins the ends of two legs but the turn."""
    path, at = pose_graph.path_of(4_500)
    for a, b in (
        pose_graph.link_ends(at),
        (pose_graph.sightings(at)[0][pose_graph.sightings(at)[2]], pose_graph.sightings(at)[1]),
    ):
        assert np.linalg.norm(path.translation[a] - path.translation[b], axis=1).max() < 1.0


def test_a_small_graph_comes_back_to_its_truth():
    problem, truth = pose_graph.make(3_000)
    got = native.solve(problem, native.Options(method="naive"))
    rows = 6 * len(problem.links.first) + 3 * len(problem.plane_sightings.node)
    freedom = rows - 6 * 3_000 - 3 * len(problem.unknowns.plane)
    assert abs(2 * got.iterations.cost[-1] / freedom - 1) < 0.03
    start_m, end_m = (
        rigid_rmse_m(u.pose[:, :3], truth.translation) for u in (problem.unknowns, got.unknowns)
    )
    assert end_m < 0.7 * start_m  # two legs alone bend together


def test_a_missing_peer_is_said_in_words(tmp_path, monkeypatch):
    monkeypatch.setattr(pose_graph, "THEIRS", tmp_path / "python")
    found = pose_graph.measure(1_500, 1)
    assert found["nodes"] == 1_500
    assert found["hullrecon"]["peak_rss_mb"] > 0
    assert found["gtsam"] == "not run: the peers' environment is missing (make bench-peers)"
