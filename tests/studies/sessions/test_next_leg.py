# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Legs that could be driven next, and ranges of lone beams."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.geometry.poses import stacked
from hullrecon.studies.sessions import lone_beams
from hullrecon.studies.sessions.factors import Beams, State
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


def lone_beams_at_the_truth() -> tuple[Beams, State]:
    rng = np.random.default_rng(0)
    session, count = lone_beams.surfaced(rng)
    single = lone_beams.beams(session, count, rng)
    truth = session.truth_in_session
    seers = session.seen_from
    assert len(single) == 2 * (len(truth) - count)
    return single, State(
        poses=truth, planes=plane_out(truth[seers], planes_before(session.truth[seers]))
    )


def test_ranges_of_lone_beams_agree_with_the_truth_but_for_the_bend() -> None:
    single, truth = lone_beams_at_the_truth()
    assert np.sqrt(np.mean(single.linearise(truth).residual ** 2)) < 2.0


def test_a_length_alone_as_printed_is_no_factor_at_the_truth() -> None:
    """[Ozog2016 2.5.6] prints (2.4), the length of a beam, for (2.5), which compares it."""
    single, truth = lone_beams_at_the_truth()
    as_printed = replace(single, measured_m=np.zeros(len(single)))
    assert np.abs(as_printed.linearise(truth).residual).min() > 30  # sigmas


def test_lone_beams_keep_a_surfaced_vehicle_by_the_leg_below() -> None:
    lone_beams_of = lone_beams.drift(range(3))
    without, held = (
        np.sqrt(np.mean(off**2)) for off in (lone_beams_of.without, lone_beams_of.held)
    )
    assert held < 0.6 * without
