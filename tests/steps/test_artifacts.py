# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What is read of a step's artifact beyond its files."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hullrecon.steps.artifacts import AdjustArtifact


@pytest.mark.parametrize(
    ("summary", "sigma_m"),
    [
        ({"navigation_sigma": {"depth_bias_m": 0.04}, "sigmas": {"depth_m": 0.03}}, 0.05),
        # zero: not known
        ({"navigation_sigma": {"depth_bias_m": 0.0}, "sigmas": {"depth_m": 0.03}}, None),
        # no depth was measured
        ({"navigation_sigma": {"depth_bias_m": 0.04}, "sigmas": {"depth_m": None}}, None),
        ({}, None),
    ],
)
def test_water_surface_sigma_combines_pressure_bias_and_noise(
    tmp_path: Path, summary: dict[str, object], sigma_m: float | None
) -> None:
    (tmp_path / "adjust.json").write_text(json.dumps(summary))
    found = AdjustArtifact(tmp_path).depth_sigma_m
    assert found == (None if sigma_m is None else pytest.approx(sigma_m))
