# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Whether two CAD models are of one hull, however they are meshed."""

from __future__ import annotations

import numpy as np
import pytest

from hullrecon.change.compare_surveys import cad_model_gap
from hullrecon.geometry.meshes.mesh import Mesh

BOX = np.array([[x, y, z] for x in (0.0, 10) for y in (-1.0, 1) for z in (0.0, 2)])
FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7]], np.int32)


def test_the_same_hull_meshed_otherwise_is_the_same_hull() -> None:
    """Quads split along the other diagonal, and one of them into four about its middle."""
    turned = np.array([[0, 1, 2], [1, 3, 2], [4, 6, 5], [6, 7, 5]], np.int32)
    fan = np.array([[0, 1, 8], [1, 3, 8], [3, 2, 8], [2, 0, 8], *FACES[2:]], np.int32)
    for other in (Mesh(BOX, turned), Mesh(np.vstack([BOX, BOX[:4].mean(axis=0)]), fan)):
        assert cad_model_gap(Mesh(BOX, FACES), other) == pytest.approx(0.0, abs=1e-6)


def test_the_gap_of_two_cad_models_is_the_same_from_both_sides() -> None:
    """A part that one of them lacks counts, although all of the other lies on it."""
    whole, half = Mesh(BOX, FACES), Mesh(BOX[:4], FACES[:2])
    assert cad_model_gap(whole, half) == pytest.approx(10.0)
    assert cad_model_gap(half, whole) == pytest.approx(10.0)


@pytest.mark.parametrize("shift_m", [0.001, 0.004])
def test_the_gap_of_a_model_that_was_shifted_is_its_shift(shift_m: float) -> None:
    moved = Mesh(BOX + np.array([shift_m, 0, 0]), FACES)
    assert cad_model_gap(Mesh(BOX, FACES), moved) == pytest.approx(shift_m, rel=1e-3)
