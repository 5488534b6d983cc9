# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a stage hands on, and what it lets go of."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

from hullrecon.adjustment.bundle_adjustment import join_path_and_place
from hullrecon.adjustment.rounds import Estimate, Phase, Verdict

PATH, PLACE = (
    Estimate(measured=None, state=None, weights=None, max_px=limit) for limit in (1.0, 2.0)
)
REFUSED = Verdict(accepted=False, reason="it is another ship's")


def rounds(*names: str) -> list[SimpleNamespace]:
    return [SimpleNamespace(history=name, start=f"start of {name}") for name in names]


def test_joined_stages_keep_the_first_round_and_the_last():
    a, b, c, d = rounds("a", "b", "c", "d")
    joined = Phase.of((a, b, c), PATH).then(None).then(Phase.of((d,), PLACE))
    assert (joined.first, joined.last, joined.start) == (a, d, "start of a")
    assert joined.history == ("a", "b", "c", "d")


def test_a_stage_without_rounds_leaves_those_before_it():
    a, b = rounds("a", "b")
    joined = Phase.of((a, b), PATH).then(Phase.of((), PLACE))
    assert (joined.first, joined.last, joined.estimate) == (a, b, PLACE)


def test_settled_stages_let_go_of_measurements_and_keep_the_history():
    settled = join_path_and_place(Phase.of(rounds("a", "b"), PATH), Phase.of(rounds("c"), PLACE))
    assert (settled.first, settled.last, settled.start) == (None, None, "start of a")
    assert (settled.history, settled.estimate) == (("a", "b", "c"), PLACE)


def test_a_refused_cad_model_leaves_the_path_for_the_last_round():
    placed = replace(Phase.of(rounds("c"), PLACE), verdict=REFUSED)
    settled = join_path_and_place(Phase.of(rounds("a"), PATH), placed)
    assert (settled.estimate, settled.verdict) == (PATH, REFUSED)
    assert join_path_and_place(Phase.of(rounds("a"), PATH), None).estimate is PATH
