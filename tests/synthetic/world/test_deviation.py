# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import numpy as np

from hullrecon.synthetic.built_hull import deviation_m
from hullrecon.synthetic.options import DiveSpec, spec_from

WIDE = np.meshgrid(np.arange(0, 300, 1.0), np.arange(0, 150, 1.0), indexing="ij")


def test_mean_and_sigma_are_as_asked() -> None:
    field = deviation_m(spec_from(deviation_mean_m=-0.013, deviation_sigma_m=0.012), *WIDE)
    assert abs(field.mean() + 0.013) < 0.002
    assert abs(field.std() - 0.012) < 0.001


def test_no_sigma_gives_mean_everywhere() -> None:
    field = deviation_m(spec_from(deviation_mean_m=0.03, deviation_sigma_m=0.0), *WIDE)
    np.testing.assert_allclose(field, 0.03)


def test_neighbours_agree_and_far_points_do_not() -> None:
    spec = spec_from(deviation_length_m=4.0, deviation_mean_m=0.0)
    field = deviation_m(spec, *WIDE)
    correlation = lambda lag: float(np.corrcoef(field[:-lag].ravel(), field[lag:].ravel())[0, 1])  # noqa: E731
    assert correlation(1) > 0.9
    assert correlation(4) < 0.75
    assert abs(correlation(30)) < 0.15


def test_it_changes_twice_as_fast_over_girth() -> None:
    field = deviation_m(spec_from(deviation_length_m=8.0), *WIDE)
    along, girth = np.diff(field, axis=0).std(), np.diff(field, axis=1).std()
    assert 1.6 < girth / along < 2.4


def test_seed_decides() -> None:
    here = (np.array([1.0]), np.array([2.0]))
    assert deviation_m(spec_from(seed=1), *here) == deviation_m(spec_from(seed=1), *here)
    assert deviation_m(spec_from(seed=1), *here) != deviation_m(spec_from(seed=2), *here)


def test_another_option_leaves_field_as_it_is() -> None:
    here = (np.array([1.0]), np.array([2.0]))
    assert deviation_m(DiveSpec(), *here) == deviation_m(spec_from(legs=9, structures=0), *here)
