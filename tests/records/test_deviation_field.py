# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.records.solution import DeviationField

FIELD = DeviationField(
    origin=np.zeros(2), step=np.array([1.0, 2.0]), value=np.array([[0.0, 0.0], [0.1, 0.1]]), sigma=np.zeros((2, 2))
)


def test_the_field_is_interpolated_on_the_chart_and_held_past_its_edge() -> None:
    np.testing.assert_allclose(FIELD.value_at(np.array([[0.5, 1.0], [-3, 0], [7, 9]])), [0.05, 0.0, 0.1])


def test_a_point_off_the_chart_has_the_offset_of_the_origin() -> None:
    np.testing.assert_allclose(FIELD.value_at(np.array([[np.nan, np.nan]])), [0.0])
