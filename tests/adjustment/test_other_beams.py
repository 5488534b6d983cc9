# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""DVL ranges of beams in another order are named where the CAD model fits them in theirs."""

from dataclasses import replace

import numpy as np
import pytest
from adjustment.test_cad_acceptance import true_path

from hullrecon.adjustment.hull_pose.other_beams import find_fitting_beams
from hullrecon.geometry.poses import from_mount

SOLVED = true_path(camera=False)
RIG = SOLVED.state.mounted(SOLVED.measured.rig)


def ends(returns):
    return RIG.dvl_points(returns, SOLVED.state.path).points


def of_three_beams(order):
    """Returns of three beams, logged in another order than the beams have."""
    returns = SOLVED.measured.returns
    directions = returns.beam[returns.t_ns == returns.t_ns[0]][:3]
    kept = returns.take(
        np.flatnonzero((returns.beam[:, None] == directions).all(axis=2).any(axis=1))
    )
    number = (kept.beam[:, None] == directions).all(axis=2).argmax(axis=1)
    return replace(kept, beam=directions[np.array(order)[number]])


def found(order):
    return find_fitting_beams(of_three_beams(order), ends, SOLVED.measured.cad_model, 0.01)


@pytest.mark.parametrize("order", [(2, 0, 1)])
def test_order_in_which_ranges_fit_the_cad_model_is_named(order):
    named, before_m, after_m = found(order)
    assert after_m < 0.5 * before_m
    # the ranges are those of the beams that are named
    assert [order[k - 1] for k in named] == [0, 1, 2]


def test_no_order_explains_a_hull_pose_that_is_wrong():
    """One order fits better than the others, and none fits."""
    cad_model = SOLVED.measured.cad_model
    turned = from_mount([0, 0, 0, 0, 0, 180])
    elsewhere = replace(cad_model, guess=cad_model.guess @ turned)
    assert find_fitting_beams(of_three_beams((0, 1, 2)), ends, elsewhere, 0.01) is None


def test_beams_in_their_order_are_not_doubted():
    assert found((0, 1, 2)) is None
