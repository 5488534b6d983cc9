# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np
import pytest

from hullrecon.change.difference import (
    changed_regions,
    corrected_p_value,
    difference,
    measure_change,
    significant_sigmas,
    smallest_change,
    top_of,
    well_seen,
)
from hullrecon.change.options import ChangeOptions
from hullrecon.change.relief import Relief

OPTIONS = ChangeOptions()
SHAPE = (120, 100)


def relief(*boxes, noise=0.001, seed=0, sigma=0.002, views=5) -> Relief:
    """Bare hull with boxes (first row, first column, size in cells, height) on it."""
    height = noise * np.random.default_rng(seed).standard_normal(SHAPE)
    for row, column, size, tall in boxes:
        height[row : row + size, column : column + size] += tall
    return Relief(height=height, sigma=np.full(SHAPE, sigma), views=np.full(SHAPE, views))


def regions(first: Relief, second: Relief):
    return changed_regions(difference(first, second, OPTIONS), 1000, OPTIONS)


def test_a_box_that_came_is_one_region_of_its_height() -> None:
    (found,) = regions(relief(), relief((50, 40, 10, 0.08), seed=1))
    assert found.change == pytest.approx(0.08, abs=0.005)
    assert found.before == pytest.approx(0.0, abs=0.003)
    assert found.after == pytest.approx(0.08, abs=0.005)
    assert found.cells.sum() == pytest.approx(100, abs=10)


def test_a_box_that_went_is_one_region_of_minus_its_height() -> None:
    (found,) = regions(relief((50, 40, 12, 0.08)), relief(seed=1))
    assert found.change == pytest.approx(-0.08, abs=0.005)
    assert found.before == pytest.approx(0.08, abs=0.005)


def test_a_box_that_grew_is_a_region_on_its_top() -> None:
    (found,) = regions(relief((50, 40, 12, 0.08)), relief((50, 40, 12, 0.11), seed=1))
    assert found.change == pytest.approx(0.03, abs=0.005)


def test_edge_drawn_2_cm_elsewhere_is_no_change() -> None:
    assert regions(relief((50, 40, 12, 0.08)), relief((51, 41, 12, 0.08), seed=1)) == []


def test_noise_is_no_change() -> None:
    assert regions(relief(noise=0.003), relief(noise=0.003, seed=1)) == []


def test_a_tilt_of_the_whole_survey_is_form_and_no_structure() -> None:
    tilted = relief(seed=1)
    tilted = Relief(
        height=tilted.height + np.linspace(0, 0.04, SHAPE[0])[:, None],
        sigma=tilted.sigma,
        views=tilted.views,
    )
    found = difference(relief(), tilted, OPTIONS)
    assert changed_regions(found, 1000, OPTIONS) == []
    assert np.nanmedian(np.abs(found.local)) < 0.003
    assert np.nanmax(found.total) > 0.035


def test_what_only_one_survey_looked_at_is_not_compared() -> None:
    blind = relief(seed=1)
    views = blind.views.copy()
    views[40:70, 30:60] = 1
    assert (
        regions(
            Relief(height=blind.height, sigma=blind.sigma, views=views), relief((50, 40, 10, 0.08))
        )
        == []
    )


def test_a_surface_that_is_poorly_known_was_not_looked_at() -> None:
    assert not well_seen(relief(sigma=0.05), OPTIONS).any()
    assert well_seen(relief(sigma=0.005), OPTIONS).all()


def test_an_unseen_cell_was_not_looked_at() -> None:
    lost = Relief(
        height=np.full(SHAPE, np.nan), sigma=np.full(SHAPE, np.nan), views=np.zeros(SHAPE, int)
    )
    assert not well_seen(lost, OPTIONS).any()
    assert changed_regions(difference(lost, relief(), OPTIONS), 10, OPTIONS) == []


def test_a_change_below_its_own_sigma_is_not_significant() -> None:
    assert regions(relief(sigma=0.014), relief((50, 40, 10, 0.03), seed=1, sigma=0.014)) == []


def test_a_speck_is_no_region() -> None:
    assert regions(relief(), relief((50, 40, 2, 0.08), seed=1)) == []


def test_the_top_of_a_structure_leaves_its_edges_out() -> None:
    height = np.zeros(SHAPE)
    height[40:60, 40:60], height[43:57, 43:57] = 0.04, 0.1
    cells = np.zeros(SHAPE, bool)
    cells[38:62, 38:62] = True
    assert top_of(height, cells, 1.0).sum() == 14 * 14
    assert top_of(-height, cells, -1.0).sum() == 14 * 14


def test_a_change_is_counted_from_the_hull_around_it() -> None:
    found = difference(relief(noise=0), relief((50, 40, 12, 0.05), noise=0), OPTIONS)
    cells = np.zeros(SHAPE, bool)
    cells[50:62, 40:52] = True
    region = measure_change(found, cells, cells, 1, OPTIONS)
    assert region.change == pytest.approx(0.05, abs=1e-3)
    assert region.sigma == pytest.approx(np.hypot(0.002, 0.002), rel=0.2)


def test_probability_grows_with_the_places_looked_at() -> None:
    one, many = corrected_p_value(0.03, 0.01, 1), corrected_p_value(0.03, 0.01, 100)
    assert one == pytest.approx(0.0027, rel=0.01)
    assert many == pytest.approx(1 - (1 - one) ** 100, rel=1e-6)


def test_p_value_of_certain_change_is_not_negative() -> None:
    assert 0 <= corrected_p_value(1.0, 0.001, 10_000) < 1e-100
    assert corrected_p_value(0.0, 0.01, 10) == pytest.approx(1.0)


@pytest.mark.parametrize("places", [1, 100, 10_000])
def test_significant_sigmas_invert_the_p_value(
    places: int,
) -> None:
    least = significant_sigmas(places, OPTIONS)
    p_value = corrected_p_value(least, 1.0, places)
    assert p_value == pytest.approx(OPTIONS.max_p_value, rel=1e-6) or (
        least == 3.0 and p_value < OPTIONS.max_p_value
    )


@pytest.mark.parametrize(("share", "reported"), [(0.8, 0), (1.2, 1)])
def test_smallest_change_parts_reported_from_unreported(share: float, reported: int) -> None:
    least = smallest_change(
        difference(relief(sigma=0.005), relief(seed=1, sigma=0.005), OPTIONS), 1000, OPTIONS
    )
    assert least > OPTIONS.min_change_m
    box = relief((50, 40, 10, share * least), seed=1, sigma=0.005)
    assert len(regions(relief(sigma=0.005), box)) == reported


def test_smallest_change_is_option_where_hull_is_well_known() -> None:
    found = difference(
        relief(noise=1e-4, sigma=5e-4), relief(noise=1e-4, seed=1, sigma=5e-4), OPTIONS
    )
    assert smallest_change(found, 1000, OPTIONS) == OPTIONS.min_change_m


def test_smallest_change_without_common_cells_is_nan() -> None:
    assert np.isnan(smallest_change(difference(relief(), relief(views=0), OPTIONS), 1, OPTIONS))
