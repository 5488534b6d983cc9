# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import numpy as np
import pytest

from hullrecon import native
from hullrecon.adjustment.problem.iteration_history import (
    Round,
    columns,
    lines,
    seconds,
    summarise_rounds,
)

SIGMAS = {
    "pixel_sigma_px": 1.0,
    "tray_sigma_rad": 0.01,
    "range_sigma_m": 0.02,
    "depth_sigma_m": 0.02,
}


def record(cost, on_surface):
    n = len(cost)
    parts = {name: np.zeros(n) for name in native.FACTORS} | {"stereo": np.array(cost)}
    return native.IterationRecord(
        cost=np.array(cost),
        cost_change=np.zeros(n),
        step_norm=np.full(n, 0.5),
        gradient_norm=np.full(n, 2.0),
        radius=np.full(n, 1e4),
        accepted=np.arange(n) != 1,
        seconds=0.5 * np.arange(n),
        cost_by_factor=parts,
        on_surface=np.array(on_surface),
        label_changes=np.abs(np.diff(on_surface, prepend=on_surface[0])),
        rays_missed=np.zeros(n, np.int64),
    )


@pytest.fixture
def rounds():
    """Three iterations on a hundred landmarks, then one on 400 with a finer pixel sigma."""
    first = Round(
        record=record([90.0, 95.0, 10.0], [50, 50, 80]),
        **SIGMAS,
        landmarks=100,
        converged=False,
        message="stopped",
        began_s=1.0,
    )
    finer = SIGMAS | {"pixel_sigma_px": 0.2, "depth_sigma_m": 0.005}
    return [
        first,
        Round(
            record=record([300.0, 200.0], [300, 310]),
            **finer,
            landmarks=400,
            converged=True,
            message="converged",
            began_s=5.0,
        ),
    ]


def test_rounds_stand_one_after_the_other_with_their_own_sigmas(rounds) -> None:
    table = columns(rounds)
    assert table["round"].tolist() == [1, 1, 1, 2, 2]
    assert table["iteration"].tolist() == [0, 1, 2, 0, 1]
    assert table["cost"].tolist() == [90, 95, 10, 300, 200]
    assert table["cost_stereo"].tolist() == table["cost"].tolist()
    assert table["landmarks"].tolist() == [100, 100, 100, 400, 400]
    assert table["pixel_sigma_px"].tolist() == [1, 1, 1, 0.2, 0.2]
    assert table["depth_sigma_m"].tolist() == [0.02, 0.02, 0.02, 0.005, 0.005]
    assert table["label_changes"].tolist() == [0, 0, 30, 0, 10]
    assert {len(values) for values in table.values()} == {5}


def test_no_column_holds_the_wall_clock(rounds) -> None:
    later = [
        replace(r, began_s=r.began_s + 100, record=replace(r.record, seconds=r.record.seconds + 7))
        for r in rounds
    ]
    for name, values in columns(rounds).items():
        np.testing.assert_array_equal(values, columns(later)[name])


def test_seconds_run_on_from_round_to_round(rounds) -> None:
    assert seconds(rounds).tolist() == [1.0, 1.5, 2.0, 5.0, 5.5]


def test_a_round_in_figures_says_what_it_was_given_and_reached(rounds) -> None:
    first, second = summarise_rounds(rounds)
    assert (
        first["iterations"],
        first["first_cost"],
        first["last_cost"],
        first["labels_changed"],
    ) == (2, 90.0, 10.0, 30)
    assert (first["converged"], first["message"]) == (False, "stopped")
    assert (second["landmarks"], second["pixel_sigma_px"], second["on_surface"]) == (400, 0.2, 310)


def test_dive_without_depths_has_no_depth_sigma(rounds) -> None:
    without = [replace(r, depth_sigma_m=float("nan")) for r in rounds]
    assert summarise_rounds(without)[0]["depth_sigma_m"] is None
    assert np.isnan(columns(without)["depth_sigma_m"]).all()


def test_log_table_has_line_an_iteration_and_no_empty_column(rounds) -> None:
    said = list(lines(2, rounds[0]))
    assert "costs do not compare" in said[0]
    assert "depths 0.02 m" in said[0]
    heads = said[1].split()
    assert "stereo" in heads
    assert "mono" not in heads
    assert len(said) == 2 + 3 + 1
    assert [line.split()[0] for line in said[2:5]] == ["0", "(1)", "2"]
    assert said[4].split()[1] == "10"
    assert said[-1].startswith("stopped")
