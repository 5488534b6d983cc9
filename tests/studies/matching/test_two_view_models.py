# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from vision.pairs.test_two_view import FOCAL, scene

from hullrecon.studies.matching.comparison import TWO_VIEW_MODELS


def test_model_asked_for_is_taken_whatever_fits_better():
    for model, relief_m in (("essential", 0.0), ("homography", 0.2)):
        fit = TWO_VIEW_MODELS[model].fit_two_views
        assert fit(*scene(relief_m), 2 / FOCAL).model == model


def test_automatic_model_is_likelier():
    fit = TWO_VIEW_MODELS["automatic"].fit_two_views
    assert fit(*scene(0.0), 2 / FOCAL).model == "homography"
    assert fit(*scene(0.2), 2 / FOCAL).model == "essential"
