# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from change.simulated_surveys import ALONG, BEFORE, GIRTH, NONE, Errors, chart, survey

from hullrecon.change.relief import blur, local_median, relief_on, seen_points
from hullrecon.geometry.charts.lattice import Lattice
from hullrecon.geometry.poses import exp
from hullrecon.synthetic.built_hull import deviation_m
from hullrecon.synthetic.options import DiveSpec

LATTICE = Lattice(origin=np.array([30.5, 4.5]), step_m=0.02, shape=(60, 50))


@pytest.fixture(scope="module")
def bare():
    return survey((), NONE)


def test_heights_are_the_hulls_own_over_its_cad_model(bare) -> None:
    relief = relief_on(LATTICE, chart(), bare)
    at = LATTICE.points()
    true = deviation_m(DiveSpec(seed=1), at[..., 0], at[..., 1])
    assert np.abs(relief.height - true).max() < 0.001


def test_a_moved_survey_is_moved(bare) -> None:
    raised = relief_on(LATTICE, chart(), bare, exp(np.array([[0.0, 0.01, 0, 0, 0, 0]])))
    before = relief_on(LATTICE, chart(), bare)
    assert np.nanmedian(raised.height - before.height) == pytest.approx(0.01, abs=0.001)


def test_a_structure_stands_at_its_place() -> None:
    relief = relief_on(LATTICE, chart(), survey(BEFORE[:1], NONE))
    top = LATTICE.points()[np.unravel_index(np.nanargmax(relief.height), LATTICE.shape)]
    assert np.linalg.norm(top - [30.6, 4.8]) < 0.1
    assert np.nanmax(relief.height) == pytest.approx(0.11, abs=0.03)


def test_cells_off_the_survey_are_unseen(bare) -> None:
    outside = Lattice(origin=np.array([ALONG[1] + 0.2, GIRTH[0]]), step_m=0.02, shape=(20, 20))
    relief = relief_on(outside, chart(), bare)
    assert np.isnan(relief.height).all()
    assert (relief.views == 0).all()


def test_vertices_without_support_are_unseen(bare) -> None:
    support = np.where(bare.as_found.vertices[:, 0] < 31.0, 0, 5)
    half = replace(bare, as_found=replace(bare.as_found, support=support))
    relief = relief_on(LATTICE, chart(), half)
    along = LATTICE.points()[..., 0]
    assert np.isnan(relief.height[along < 30.9]).all()
    assert np.isfinite(relief.height[along > 31.1]).all()


def test_a_survey_of_nothing_is_a_relief_of_nothing(bare) -> None:
    blind = replace(
        bare, as_found=replace(bare.as_found, support=np.zeros(len(bare.form_sigma), int))
    )
    assert len(seen_points(blind, chart())[0]) == 0
    assert np.isnan(relief_on(LATTICE, chart(), blind).height).all()


def test_a_hull_pose_off_along_the_hull_moves_what_is_seen() -> None:
    there = survey(BEFORE[:1], Errors(pose=np.array([0.3, 0, 0, 0, 0, 0]), seed=0, noise_m=0.0))
    relief = relief_on(LATTICE, chart(), there)
    top = LATTICE.points()[np.unravel_index(np.nanargmax(relief.height), LATTICE.shape)]
    assert top[0] == pytest.approx(30.9, abs=0.1)


def test_a_blur_keeps_a_level_and_the_unseen() -> None:
    height = np.full((30, 30), 0.02)
    height[:10] = np.nan
    out = blur(height, 2.0)
    assert np.isnan(out[:10]).all()
    assert out[12:] == pytest.approx(0.02)


def test_a_running_median_passes_under_structures() -> None:
    height = np.fromfunction(lambda i, j: 0.0005 * i, (100, 100))
    raised = height.copy()
    raised[45:58, 45:58] += 0.1
    assert np.abs(local_median(raised, 50) - local_median(height, 50)).max() < 0.004


def test_a_running_median_follows_the_hull() -> None:
    wave = np.fromfunction(lambda i, j: 0.01 * np.sin(i / 60), (200, 40))
    assert np.abs(local_median(wave, 30) - wave)[10:-10].max() < 0.002


def test_a_running_median_of_nothing_is_nothing() -> None:
    assert np.isnan(local_median(np.full((20, 20), np.nan), 10)).all()
