# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from benchmarks.mono_survey import BARE_SHARE, OPTIONS, asked, blank
from hullrecon.geometry.poses import Poses
from hullrecon.synthetic.options import options

MET: dict[str, object] = {
    "adjust_mm": 50.0,
    "linked_sharing_nothing": 0,
    "end_sigma_over_dead_reckoning": 0.3,
    "sigma_on_bare_paint_over_elsewhere": 1.4,
}


@dataclass(frozen=True)
class LegsOfTen:
    """Two legs of 10 m out and back at 0.25 m/s."""

    t_s: np.ndarray

    def vehicle_at(self, t_s: np.ndarray) -> Poses:
        along = 10 - np.abs(0.25 * (t_s - 1000) - 10)
        return Poses(np.tile([0.0, 0, 0, 1], (len(t_s), 1)), np.column_stack([along, np.zeros((len(t_s), 2))]))


def test_no_images_are_left_over_the_middle_half_of_the_second_leg() -> None:
    middle_s, half_s = blank(LegsOfTen(1000 + np.arange(0, 80.1, 0.5)), 10.0)  # type: ignore[arg-type]
    assert (middle_s, half_s) == (1060, pytest.approx(10.0))


def test_what_is_asked_is_met_at_its_bounds() -> None:
    assert list(asked(MET).values()) == [True] * 4


@pytest.mark.parametrize(
    ("figure", "value"),
    [
        ("adjust_mm", 50.1),
        ("linked_sharing_nothing", 1),
        ("end_sigma_over_dead_reckoning", 0.31),
        ("sigma_on_bare_paint_over_elsewhere", 1.0),
    ],
)
def test_each_figure_can_fail_by_itself(figure: str, value: float) -> None:
    assert sorted(asked(MET | {figure: value}).values()) == [False, True, True, True]


def test_the_options_are_those_of_simulate() -> None:
    known = {"--" + option.name.replace("_", "-") for option in options()} | {"--no-sonar"}
    assert {word for word in OPTIONS.split() if word.startswith("--")} <= known
    assert 0 < BARE_SHARE < 0.5
