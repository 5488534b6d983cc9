# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Slices across the wall of conftest.py at its block."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hullrecon.evaluation.truth import Truth, read_truth
from hullrecon.studies.methods.sections import cut_section, cut_whole_hull

NONE = np.zeros((0, 3))


@pytest.fixture(scope="module")
def truth(package: Path) -> Truth:
    return read_truth(package)


def at_block(*offsets: tuple[float, float, float]) -> np.ndarray:
    """Points by their offset from the foot of the block's middle."""
    return np.array([[1.0, 0.012, 0.0]]) + np.array(offsets)


def test_a_point_is_placed_by_girth_and_height(truth: Truth) -> None:
    points = at_block((0.0, 0.05, 0.2))
    section = cut_section(
        ("geva", "as published"), truth.structures()[0], points, np.array([True]), NONE, truth
    )
    assert abs(section.on[0, 0]) == pytest.approx(0.2)
    assert section.on[0, 1] == pytest.approx(0.05)
    assert (section.method, section.weighting) == ("geva", "as published")


def test_points_beside_the_slice_are_left_out(truth: Truth) -> None:
    points = at_block((0.07, 0, 0), (0.09, 0, 0), (0, 0, 0.5), (0, 0, 0.6), (0, 0.5, 0))
    section = cut_section(
        ("geva", "x"), truth.structures()[0], points, np.ones(5, bool), NONE, truth
    )
    assert len(section.on) == 2


def test_the_dvl_is_taken_from_a_thicker_slice(truth: Truth) -> None:
    points = at_block((0.3, 0, 0), (0.5, 0, 0))
    section = cut_section(
        ("geva", "x"), truth.structures()[0], NONE, np.zeros(0, bool), points, truth
    )
    assert len(section.dvl) == 1


def test_labels_part_the_landmarks(truth: Truth) -> None:
    points = at_block((0, 0, 0), (0, 0.1, 0), (0, 0.1, 0.05))
    section = cut_section(
        ("geva", "x"), truth.structures()[0], points, np.array([True, False, False]), NONE, truth
    )
    assert (len(section.on), len(section.off)) == (1, 2)
    assert set(section.parts()) == {"dvl", "on", "off", "steel", "cad_model"}


def test_without_a_cad_model_its_line_is_empty(truth: Truth) -> None:
    bare = replace(truth, cad_model=None)
    section = cut_section(("geva", "x"), truth.structures()[0], NONE, np.zeros(0, bool), NONE, bare)
    assert len(section.cad_model) == 0
    assert len(section.steel) > 150
    points = at_block((0, 0, 0))
    assert (
        len(cut_whole_hull(truth.structures()[0], points, np.array([True]), NONE, bare).cad_model)
        == 0
    )


def test_the_whole_section_is_in_y_and_z_of_the_hull(truth: Truth) -> None:
    points = at_block((0.01, 0.1, 0.3), (0.2, 0.0, 0.0))
    view = cut_whole_hull(truth.structures()[0], points, np.array([False, True]), NONE, truth)
    np.testing.assert_allclose(view.off, [[0.112, 0.3]], atol=1e-12)
    assert len(view.on) == 0
    np.testing.assert_allclose(view.at, [0.112, 0.0], atol=1e-12)
