# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import cv2
import numpy as np
import pytest

from hullrecon.studies.paths.path_figures import VarianceMap, sonar_variance


def of_variance(mean: float, seed: int = 0) -> VarianceMap:
    """A map of half a metre, half of it blended from one view alone."""
    variance = mean * np.random.default_rng(seed).exponential(size=(50, 100))
    variance[:, 50:] = np.nan
    return VarianceMap(variance=variance, extent=(3.0, 3.5, 1.0, 1.25))


def test_the_table_tells_which_share_varies_by_more() -> None:
    figure = sonar_variance(
        {"dead reckoned": of_variance(300.0), "adjusted": of_variance(100.0, 1)}
    )
    rows = np.array([[float(x) for x in line.split(",")] for line in figure.csv.splitlines()[1:]])
    assert figure.csv.startswith("variance_at_least,share_dead_reckoned,share_adjusted")
    np.testing.assert_allclose(rows[0, 1:], 1.0)
    assert (np.diff(rows[:, 1:], axis=0) <= 0).all()
    near = np.argmin(np.abs(rows[:, 0] - 300))
    np.testing.assert_allclose(
        rows[near, 1:], np.exp([-rows[near, 0] / 300, -rows[near, 0] / 100]), atol=0.03
    )


def test_mean_variance_leaves_out_pixels_of_one_view() -> None:
    found = of_variance(200.0)
    mean = np.nanmean(found.variance)
    assert f"dead reckoned {mean:.0f}" in sonar_variance({"dead reckoned": found}).caption


@pytest.mark.usefixtures("pictures")
def test_there_is_a_map_a_source() -> None:
    two = {name: of_variance(200.0) for name in ("a", "b")}
    height = [
        cv2.imdecode(np.frombuffer(sonar_variance(maps).png, np.uint8), cv2.IMREAD_COLOR).shape[0]
        for maps in (two, two | {"c": of_variance(100.0)})
    ]
    assert height[1] > height[0]
