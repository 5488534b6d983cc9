# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The deviation in numbers and words: form and offset apart, each with its sigma, or nothing."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from hullrecon.records.surface import DeviationSplit, Surface
from hullrecon.report.content.deviation import (
    DeviationFigures,
    deviation_document,
    deviation_figures,
    deviation_rows,
)
from hullrecon.report.figures.hull_map import hull_map
from hullrecon.report.figures.map_pictures import form_map, form_png
from hullrecon.report.survey import Survey


@pytest.fixture
def figures(survey: Survey) -> DeviationFigures:
    found = deviation_figures(survey)
    assert found is not None
    return found


def with_split(survey: Survey, split: DeviationSplit | None) -> Survey:
    return replace(survey, surfaces=replace(survey.surfaces, deviation=split))


def test_percentiles_of_the_form_go_by_the_area_seen(
    survey: Survey, split: DeviationSplit, plate: Surface
) -> None:
    # columns x = -1, 0, 1 were seen: areas 1/2, 1, and 1 (half of its cells lie beyond)
    form = np.where(plate.support > 0, np.where(plate.vertices[:, 0] < -0.5, -0.01, 0.004), np.nan)
    found = deviation_figures(with_split(survey, replace(split, form=form)))
    assert found is not None
    np.testing.assert_allclose(found.form, [-0.01, 0.004, 0.004], atol=1e-3)
    assert found.form_sigma == pytest.approx(0.002)


def test_the_words_of_an_offset_say_side_and_significance(
    figures: DeviationFigures,
) -> None:
    assert (
        figures.offset_words
        == "6 mm outside it (one sigma 20 mm, not significantly different from zero)"
    )
    assert replace(figures, offset=0.0003).offset_words.startswith("0 mm from it (")
    assert replace(figures, offset=-0.041).offset_words == "41 mm inside it (one sigma 20 mm)"


def test_the_words_of_the_form_have_its_sigma(figures: DeviationFigures) -> None:
    assert figures.form_words == "−3 to +3 mm (5th to 95th percentile; one sigma 2.0 mm)"


def test_the_table_has_form_offset_and_tilt(figures: DeviationFigures) -> None:
    rows = dict(deviation_rows(figures))
    assert rows["Offset of the surveyed patch"] == "+6 ± 20 mm"
    assert (
        rows["Tilt of the surveyed patch, along / in girth"] == "+1.0 ± 4.0 / −2.0 ± 5.0 mm per m"
    )
    assert deviation_rows(None) == []


def test_the_document_holds_the_same_numbers(figures: DeviationFigures) -> None:
    document = deviation_document(figures)
    assert document == {
        "offset_m": 0.006,
        "offset_sigma_m": 0.02,
        "tilt": [0.001, -0.002],
        "tilt_sigma": [0.004, 0.005],
        "form_m": {"p05": -0.003, "p50": pytest.approx(0.0, abs=0.003), "p95": 0.003},
        "form_sigma_m": 0.002,
    }
    assert deviation_document(None) is None


def test_without_a_deviation_there_are_no_figures(
    survey: Survey, bare: Survey, split: DeviationSplit
) -> None:
    assert deviation_figures(replace(survey, track=bare.track)) is None
    assert deviation_figures(with_split(survey, None)) is None
    assert deviation_figures(with_split(survey, replace(split, form=np.full(15, np.nan)))) is None
    assert (
        deviation_figures(replace(survey, surfaces=replace(survey.surfaces, as_found=None))) is None
    )


def test_the_map_spans_the_bare_hull_and_not_its_structures(
    survey: Survey, split: DeviationSplit
) -> None:
    """A structure far beyond the hull's form leaves its colours as they are."""
    view = hull_map(survey)
    assert view is not None
    assert view.found is not None
    low = replace(split, form=np.where(np.isfinite(split.form), split.form, np.nan))
    one = split.form.copy()
    one[np.flatnonzero(np.isfinite(one))[0]] = 0.5

    def colours(form: np.ndarray) -> np.ndarray:
        assert view is not None
        assert view.found is not None
        png = form_png(form_map(view.found, replace(low, form=form), replace(view, objects=[])))
        return np.asarray(Image.open(BytesIO(png)).convert("RGB"), int)

    before, after = colours(split.form), colours(one)
    assert before.shape == after.shape
    changed = np.abs(before - after).max(axis=2) > 8
    assert 0 < changed.mean() < 0.25


def test_the_map_of_a_hull_that_was_not_seen_is_empty(
    survey: Survey, split: DeviationSplit
) -> None:
    view = hull_map(survey)
    assert view is not None
    assert view.found is not None
    nothing = replace(split, form=np.full(15, np.nan), form_sigma=np.full(15, np.nan))
    assert form_png(form_map(view.found, nothing, view)).startswith(b"\x89PNG")
