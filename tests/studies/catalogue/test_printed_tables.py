# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Sentences of the sources that their own tables contradict."""

from __future__ import annotations

from datetime import date

import numpy as np
import pytest

from hullrecon.studies.catalogue import SOURCES
from hullrecon.studies.methods.histories import PRINTED_EXTRA_TIME, PRINTED_ITERATIONS
from hullrecon.studies.submaps.world_study import PRINTED_MAP, PRINTED_SECONDS, SELECTIVE
from hullrecon.studies.targets import detector_trials

TABLES = {(s.key, survey.number): survey for s in SOURCES for survey in s.surveys}
TRIALS = TABLES["Ozog2016", "2.5.1, Table 2.1"]


def surveyed(ship: str) -> list[date]:
    """Days of the sessions on a ship, in their order."""
    return [date.fromisoformat(row[2]) for row in TRIALS.rows if row[0] == ship]


def test_lengths_of_the_sessions_add_up_to_the_printed_totals() -> None:
    for ship, total in (("USS Saratoga", 2619), ("SS Curtiss", 7540)):
        assert sum(int(row[-1]) for row in TRIALS.rows if row[0] == ship) == total


def test_no_session_comes_three_years_after_the_first_as_printed_four_come_before() -> None:
    """[Ozog2016 Fig. 2.16] prints that sessions 5 to 12 of the SS Curtiss come after 1 to 4."""
    days = surveyed("SS Curtiss")
    years = np.array([(day - days[3]).days for day in days]) / 365.25
    assert years.max() < 0.1
    assert [number for number, at in enumerate(years, start=1) if at < -1] == [9, 10, 11, 12]
    assert years.min() == pytest.approx(-3, abs=0.2)


def test_the_saratoga_was_surveyed_in_2013_not_in_2014_as_printed() -> None:
    """[Ozog2016 Fig. 2.19]."""
    assert {day.year for day in surveyed("USS Saratoga")} == {2013}


def test_no_ship_is_called_uss_curtiss_as_printed() -> None:
    """[Ozog2016 Fig. 2.20]."""
    assert {row[0] for row in TRIALS.rows} == {"USS Saratoga", "SS Curtiss"}


def test_iterations_explain_the_time_of_two_cameras_and_not_as_printed_of_one() -> None:
    """[Ozog2016 4.4.1] prints them as the reason of both; Fig. 4.13 counts them."""
    stereo = 100 * (PRINTED_ITERATIONS["geva"] / PRINTED_ITERATIONS["naive"] - 1)
    assert stereo == pytest.approx(PRINTED_EXTRA_TIME["geva"], abs=5)
    of_naive, of_geva, extra_time = 47, 46, 36.8
    assert 100 * (of_geva / of_naive - 1) < 0 < extra_time


def test_hierarchical_joining_is_printed_as_faster_than_the_fastest() -> None:
    """[Aulinas2011 3.4.1] prints that selective joining is; Table 3.2 holds the seconds."""
    fastest = min(PRINTED_SECONDS, key=lambda name: PRINTED_SECONDS[name])
    assert fastest == "HS"
    assert PRINTED_SECONDS[SELECTIVE] - PRINTED_SECONDS[fastest] == pytest.approx(0.51)


def test_no_printed_figure_refutes_that_a_map_has_one_number_for_mean_and_deviation() -> None:
    """[Aulinas2011 Table 3.3] prints 0.5761 m for both, of one method alone: perhaps a copy.

    Errors between zero and a maximum may have a mean m and a deviation of up to
    sqrt(m (maximum - m)).
    """
    maps = {  # maximum, mean and deviation, m
        "EKF": (7.9213, 0.5891, 0.9875),
        "LMJ": (4.8144, 0.4857, 0.6822),
        "DCS": (6.2612, 0.1260, 0.5391),
        "HS": (5.5558, 0.5761, 0.5761),
        "CIS": (4.3284, 0.1870, 0.4568),
        "SSJS": (4.5268, 0.1960, 0.3468),
    }
    assert {name: mean for name, (_, mean, _) in maps.items()} == PRINTED_MAP
    assert [name for name, (_, mean, spread) in maps.items() if mean == spread] == ["HS"]
    assert all(spread**2 < mean * (most - mean) for most, mean, spread in maps.values())


def test_leonard_2001_is_not_divide_and_conquer_as_printed() -> None:
    """[Aulinas2011 2.4]; Table 2.3 names its estimator, Table 2.2 whose divide and conquer is."""
    works = {row[0]: row[-1] for row in TABLES["Aulinas2011", "Table 2.3"].rows}
    assert works["Leonard 2001"] == "DSM"
    joined = [row[0] for row in TABLES["Aulinas2011", "Table 2.2"].rows if "DCS" in row[0]]
    assert joined == ["DCS (Paz 2008)"]


def test_negatives_are_printed_as_two_and_a_half_times_the_positives_not_twice() -> None:
    """[Aulinas2011 4.3.4]."""
    assert detector_trials.NEGATIVES == 2.5 * detector_trials.POSITIVES


def test_the_fourth_layer_as_printed_lets_more_pass_than_the_third() -> None:
    """[Aulinas2011 4.3.4] prints the cascade as useful until it; a layer can only refuse."""
    false = [layer[1] for layer in detector_trials.REACHED]
    assert (np.diff(false) < 0).all()
    fourth_above = 0.01  # "> 1" per cent
    assert fourth_above >= false[-1]
