# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from steps.surveyed_cylinder import (
    OFF,
    RADIUS,
    TURN,
    EarlierSteps,
    bumped,
    earlier,
    on_and_off_bump,
    radius,
    read_surface,
)

from hullrecon.artifacts.stage import load_arrays
from hullrecon.dive.config import schema
from hullrecon.errors import StageError
from hullrecon.geometry.charts.chart import chart_for_hull, chart_from_arrays

__all__ = ["earlier"]


def test_surface_lies_at_returns_with_its_deviation(
    earlier: EarlierSteps,
) -> None:
    surface, facts = read_surface(earlier.run())
    assert np.sqrt(np.mean((radius(surface) - RADIUS - OFF) ** 2)) < 0.004
    assert np.median(surface.deviation) == pytest.approx(OFF, abs=0.004)
    assert facts["poses"] == "adjusted"
    assert facts["returns"] == 240
    assert facts["used"] + facts["outliers"] + facts["flagged"] == 240


def test_the_chart_of_the_adjustment_is_passed_on(earlier: EarlierSteps) -> None:
    out = earlier.run()
    at = np.array([[5.0, 3.0, 3.0]])
    assert np.allclose(
        chart_from_arrays(load_arrays(out / "chart.npz")).to_chart(at),
        chart_for_hull(earlier.hull).to_chart(at),
    )


def test_without_an_adjustment_the_first_guess_places_the_dive(earlier: EarlierSteps) -> None:
    surface, facts = read_surface(earlier.run(adjusted=False))
    assert np.sqrt(np.mean((radius(surface) - RADIUS - OFF) ** 2)) < 0.004
    assert surface.sigma.min() > 0.5  # hull.pose_sigma: 1 m
    assert "hull.pose" in str(facts["poses"])


def test_chart_without_adjustment_has_bow_and_stations(
    earlier: EarlierSteps,
) -> None:
    earlier.sections["hull"] = schema.Hull(
        mesh="hull.stl", pose=TURN, bow="-x", aft_perpendicular=11.0
    )
    chart = chart_from_arrays(load_arrays(earlier.run(adjusted=False) / "chart.npz"))
    at, plain = np.array([[5.0, 2.9, 3.0]]), chart_for_hull(earlier.hull)
    along, girth, _ = chart.to_chart(at)[0]
    assert along == pytest.approx(6.0)
    assert girth == pytest.approx(-plain.to_chart(at)[0, 1], abs=0.01)


def test_surface_without_cad_model_is_in_g_without_deviation(
    earlier: EarlierSteps,
) -> None:
    earlier.without_cad_model()
    surface, _ = read_surface(earlier.run())
    y, z = surface.vertices[:, 1], -surface.vertices[:, 2]
    assert np.abs(np.hypot(y, z - 3) - RADIUS - OFF).max() < 0.05
    assert np.isnan(surface.deviation).all()


def test_flagged_returns_are_left_out_and_counted(earlier: EarlierSteps) -> None:
    flagged = np.arange(240) % 10 == 0
    earlier.returns = replace(
        earlier.returns, flagged=flagged, range_m=earlier.returns.range_m + 0.8 * flagged
    )
    surface, facts = read_surface(earlier.run())
    assert facts["flagged"] == 24
    assert np.abs(radius(surface) - RADIUS - OFF).max() < 0.03


def test_landmarks_sharpen_the_surface_when_asked(earlier: EarlierSteps) -> None:
    earlier.returns = replace(
        earlier.returns,
        range_m=earlier.returns.range_m + np.random.default_rng(0).normal(0, 0.02, 240),
    )
    surface, facts = read_surface(earlier.run(landmarks=True))
    assert int(str(facts["observations"])) > 240
    middle = np.abs(surface.vertices[:, 2] - 3) < 0.7
    assert np.sqrt(np.mean((radius(surface)[middle] - RADIUS - OFF) ** 2)) < 0.004


def test_without_a_dvl_the_landmarks_make_the_surface(earlier: EarlierSteps) -> None:
    surface, facts = read_surface(earlier.run(dvl=False))
    assert facts["returns"] == 0
    assert np.sqrt(np.mean((radius(surface) - RADIUS - OFF) ** 2)) < 0.003


def test_with_neither_returns_nor_landmarks_the_error_says_so(earlier: EarlierSteps) -> None:
    with pytest.raises(StageError, match="neither DVL returns nor landmarks"):
        earlier.run(adjusted=False, dvl=False)


def test_three_returns_are_too_few(earlier: EarlierSteps) -> None:
    earlier.returns = replace(earlier.returns, flagged=np.arange(240) > 2)
    with pytest.raises(StageError, match="fewer than four returns"):
        earlier.run()


def test_two_runs_give_the_same_bytes(earlier: EarlierSteps, tmp_path: Path) -> None:
    (tmp_path / "again").mkdir()
    first, second = earlier.run(), EarlierSteps(tmp_path / "again").run()
    assert (first / "surface.npz").read_bytes() == (second / "surface.npz").read_bytes()


def test_comparison_with_cad_model_is_recorded_as_circular(
    earlier: EarlierSteps,
) -> None:
    _, facts = read_surface(earlier.run())
    assert facts["reference"] == "cad"
    assert "partly circular" in str(facts["comparison"])
    assert "poses that place the returns were adjusted" in str(facts["comparison"])


def test_without_a_cad_model_there_is_nothing_to_compare(earlier: EarlierSteps) -> None:
    earlier.without_cad_model()
    _, facts = read_surface(earlier.run())
    assert facts["reference"] == "survey"
    assert facts["comparison"] is None


def test_a_bump_that_the_cad_model_lacks_is_found(earlier: EarlierSteps) -> None:
    surface, _ = read_surface(bumped(earlier).run(outlier_sigmas=3.0))
    top, aside = on_and_off_bump(surface)
    assert np.median(surface.deviation[top]) == pytest.approx(OFF + 0.08, abs=0.012)
    assert np.median(surface.deviation[aside]) == pytest.approx(OFF, abs=0.006)
