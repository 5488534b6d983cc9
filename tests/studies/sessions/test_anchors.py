# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sessions in one graph by anchors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hullrecon.studies.sessions.alignment_study import Draw, align, conversion, one_frame, rank
from hullrecon.studies.sessions.anchors import in_common_frame, merged, path_errors
from hullrecon.studies.sessions.graph import information, solve
from hullrecon.studies.sessions.motions import plane_in
from hullrecon.studies.sessions.survey import legs, planes_before, survey


@pytest.fixture(scope="module")
def draw() -> Draw:
    rng = np.random.default_rng(0)
    sessions = [survey(legs(x, x + 6, (1.5, 2.5)), rng) for x in (-6.0, -2.0)]
    return align(sessions, 0)


def test_anchors_find_sessions_that_lie_metres_apart(draw: Draw) -> None:
    apart = draw.sessions[0].frame.inverse() @ draw.sessions[1].frame
    assert np.linalg.norm(apart.translation) > 1.0
    off = path_errors(draw.ways["anchors"].state.poses, draw.truth)
    assert np.linalg.norm(off[:, :3], axis=1).max() < 0.2


def test_anchors_leave_no_session_free(draw: Draw) -> None:
    apart = replace(draw.joint, across=())
    anchored = information(apart.graph(), apart.state).toarray()
    assert rank(anchored) == len(anchored)
    plain = information(*one_frame(apart)).toarray()
    assert (
        rank(plain) == len(plain) - 3
    )  # along the surface and about the vertical; depth is measured


def test_leaving_anchors_out_keeps_the_sigmas(draw: Draw) -> None:
    assert conversion(draw)[0] < 1e-3


def test_leaving_anchors_out_keeps_the_state_of_least_cost(draw: Draw) -> None:
    """But for the depth of first poses, whose priors are dropped."""
    graph, state = merged(draw.joint)
    again = solve(graph, state).state.poses.translation
    np.testing.assert_allclose(again[:, :2], state.poses.translation[:, :2], atol=2e-3)


def test_planes_go_to_the_common_frame_with_their_poses(draw: Draw) -> None:
    state, second = in_common_frame(draw.joint), draw.sessions[1]
    seer = len(draw.sessions[0].truth) + int(second.seen_from[-1])
    seen = plane_in(state.poses[[seer]], state.planes[-1:])[0]
    expected = planes_before(second.truth[[int(second.seen_from[-1])]])
    np.testing.assert_allclose(seen, expected, atol=0.08)
