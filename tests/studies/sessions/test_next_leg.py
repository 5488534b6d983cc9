# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Legs that could be driven next, and ranges of lone beams."""

from __future__ import annotations

import numpy as np

from hullrecon.geometry.poses import stacked
from hullrecon.studies.sessions import lone_beams
from hullrecon.studies.sessions.factors import State
from hullrecon.studies.sessions.motions import plane_out
from hullrecon.studies.sessions.next_leg import driven, foreseen_sigma, legs_to_choose
from hullrecon.studies.sessions.survey import planes_before


def test_a_leg_that_meets_an_old_one_is_worth_more() -> None:
    so_far, legs = driven(), legs_to_choose()
    after = {
        name: foreseen_sigma(stacked([so_far, legs[name]]), len(so_far), planes=True)
        for name in ("a new leg below", "up to the first leg, and along it")
    }
    before = foreseen_sigma(so_far, len(so_far), planes=True)
    assert after["up to the first leg, and along it"] < 0.7 * before
    assert after["a new leg below"] > 0.9 * before


def test_ranges_of_lone_beams_agree_with_the_truth_but_for_the_bend() -> None:
    rng = np.random.default_rng(0)
    session, count = lone_beams.surfaced(rng)
    single = lone_beams.beams(session, count, rng)
    truth = session.truth_in_session
    seers = session.seen_from
    state = State(poses=truth, planes=plane_out(truth[seers], planes_before(session.truth[seers])))
    residual = single.linearise(state).residual
    assert np.sqrt(np.mean(residual**2)) < 2.0
    assert len(single) == 2 * (len(truth) - count)


def test_lone_beams_keep_a_surfaced_vehicle_by_the_leg_below() -> None:
    lone_beams_of = lone_beams.drift(range(3))
    without, held = (
        np.sqrt(np.mean(off**2)) for off in (lone_beams_of.without, lone_beams_of.held)
    )
    assert held < 0.6 * without
