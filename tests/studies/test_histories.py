# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from hullrecon.studies.figure_style import PublishedFigure
from hullrecon.studies.methods.histories import SolveHistory, cost_history, label_frequency


def solve(as_published: bool) -> SolveHistory:
    """As printed one round of six; ours two rounds of three, the second on more landmarks."""
    rounds = np.ones(6, np.int64) if as_published else np.array([1, 1, 1, 2, 2, 2])
    return SolveHistory(
        method="maxmix as published" if as_published else "maxmix as weighted by us",
        as_published=as_published,
        round=rounds,
        cost=np.array([100.0, 10.0, 5.0, 50.0, 20.0, 19.999]),
        landmarks=np.full(6, 2000) if as_published else 1000 * rounds,
        on_surface=np.array([500, 600, 800, 1900, 1902, 1902]),
        label_changes=np.array([0, 120, 200, 0, 3, 1]),
        seconds=np.arange(6.0),
    )


def rows(figure: PublishedFigure) -> list[list[str]]:
    return [line.split(",") for line in figure.csv.splitlines()]


def picture(figure: PublishedFigure) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(figure.png, np.uint8), cv2.IMREAD_COLOR)


def test_labels_are_counted_from_the_round_that_has_them() -> None:
    """The path is solved before, without the CAD model: there all labels are 0."""
    table = rows(label_frequency([solve(False)]))
    assert table[0] == ["method", "round", "iteration", "landmarks", "on_surface", "label_changes"]
    assert table[1][1:] == ["2", "0", "2000", "1900", "0"]
    assert len(table) == 4


def test_as_published_is_the_round_with_the_cad_model() -> None:
    whole = solve(False)
    published = replace(whole, method="maxmix as published", as_published=True)
    figure = label_frequency([published])
    assert "95.0 % to 95.1 %" in figure.caption
    assert figure.compared[0].printed == 0.82
    assert figure.compared[0].ours == pytest.approx(0.95)
    costs = cost_history([published])
    assert "maxmix as published 2 iterations, 2.0 s" in costs.caption
    assert [row[2:4] for row in rows(costs)[1:]] == [["0", "0.000"], ["1", "1.000"], ["2", "2.000"]]
    assert [value.ours for value in costs.compared] == [2.0]


def test_labels_have_settled_when_fewer_than_a_thousandth_change() -> None:
    assert (
        "95.0 % to 95.1 %, converged after 1 iteration" in label_frequency([solve(False)]).caption
    )
    assert label_frequency([solve(True)]).caption.endswith("converged after 4 iterations.")


def test_time_is_set_beside_the_naive_methods() -> None:
    found = {
        name: replace(solve(True), method=f"{name} as published", seconds=np.linspace(0, s, 6))
        for name, s in (("naive", 2.0), ("geva", 3.0))
    }
    compared = {value.what: value for value in cost_history(list(found.values())).compared}
    extra = compared["time of the solve over naive's, geva"]
    assert (extra.printed, extra.ours) == (50.0, pytest.approx(50.0))


def test_costs_stand_with_their_round_and_their_time() -> None:
    table = rows(cost_history([solve(True), solve(False)]))[1:]
    assert [float(row[3]) for row in table[:6]] == [0, 1, 2, 3, 4, 5]
    assert [row[1] for row in table[6:]] == ["1", "1", "1", "2", "2", "2"]
    assert float(table[0][4]) == 100


def test_starts_of_rounds_are_no_iterations() -> None:
    words = cost_history([solve(True), solve(False)]).caption
    assert "maxmix as published 5 iterations, 5.0 s" in words
    assert "maxmix as weighted by us 4 iterations" in words


@pytest.mark.usefixtures("pictures")
@pytest.mark.parametrize("draw", [label_frequency, cost_history])
def test_the_picture_is_not_blank_and_the_same_each_time(draw) -> None:  # type: ignore[no-untyped-def]
    first, second = draw([solve(True), solve(False)]), draw([solve(True), solve(False)])
    assert first.png == second.png
    assert picture(first).std() > 5
    assert picture(first).shape[1] > 1200
