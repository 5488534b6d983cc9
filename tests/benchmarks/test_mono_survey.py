# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from benchmarks.mono_survey import BARE_SHARE, OPTIONS, asked, blank, shared
from hullrecon.geometry.cameras import CameraModel
from hullrecon.geometry.meshes.casting import Scene
from hullrecon.geometry.meshes.mesh import Mesh
from hullrecon.geometry.poses import Poses, from_rpy
from hullrecon.synthetic.options import options

MET: dict[str, object] = {
    "adjust_mm": 50.0,
    "linked_sharing_nothing": 0,
    "revisits_on_texture_tied": 0.9,
    "end_sigma_over_dead_reckoning": 0.3,
    "sigma_on_bare_paint_over_elsewhere": 1.4,
}


@dataclass(frozen=True)
class LegsOfTen:
    """Two legs of 10 m out and back at 0.25 m/s."""

    t_s: np.ndarray

    def vehicle_at(self, t_s: np.ndarray) -> Poses:
        along = 10 - np.abs(0.25 * (t_s - 1000) - 10)
        return Poses(
            np.tile([0.0, 0, 0, 1], (len(t_s), 1)),
            np.column_stack([along, np.zeros((len(t_s), 2))]),
        )


def test_outage_removes_images_of_half_the_second_leg() -> None:
    middle_s, half_s = blank(LegsOfTen(1000 + np.arange(0, 80.1, 0.5)), 10.0)  # type: ignore[arg-type]
    assert (middle_s, half_s) == (1060, pytest.approx(10.0))


def test_images_share_the_steel_that_both_see() -> None:
    """A wall a metre before cameras whose images are 1.03 m wide there; the third looks 20 m
    farther along it.
    """
    wall = Scene(
        Mesh(
            np.array([[-5.0, 1, -5], [30, 1, -5], [30, 1, 5], [-5, 1, 5]]),
            np.array([[0, 1, 2], [0, 2, 3]]),
        )
    )
    camera = CameraModel(640, 512, 620.0, 620.0, 320.0, 256.0)
    turn = from_rpy(np.zeros(3), [-np.pi / 2, 0.0, 0.0]).quaternion
    cameras = Poses(np.tile(turn, (3, 1)), np.array([[0.0, 0, 0], [0.5, 0, 0], [20.0, 0, 0]]))
    found = shared(wall, camera, cameras, np.array([0, 1, 0]), np.array([1, 0, 2]))
    np.testing.assert_allclose(found, [1 - 0.5 / 1.03, 1 - 0.5 / 1.03, 0], atol=0.03)


def test_what_is_asked_is_met_at_its_bounds() -> None:
    assert list(asked(MET).values()) == [True] * 5


@pytest.mark.parametrize(
    ("figure", "value"),
    [
        ("adjust_mm", 50.1),
        ("linked_sharing_nothing", 1),
        ("revisits_on_texture_tied", 0.89),
        ("end_sigma_over_dead_reckoning", 0.31),
        ("sigma_on_bare_paint_over_elsewhere", 1.0),
    ],
)
def test_each_figure_can_fail_by_itself(figure: str, value: float) -> None:
    assert sorted(asked(MET | {figure: value}).values()) == [False, True, True, True, True]


def test_the_options_are_those_of_simulate() -> None:
    known = {"--" + option.name.replace("_", "-") for option in options()} | {"--no-sonar"}
    assert {word for word in OPTIONS.split() if word.startswith("--")} <= known
    assert 0 < BARE_SHARE < 0.5
