# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""How well images overlapped and fit, in words."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hullrecon.records.links import NodePairs
from hullrecon.report.content.quality import WordTable, quality_tables
from hullrecon.report.survey import (
    AdjustSigmas,
    AdjustSummary,
    FactorResiduals,
    PositionFacts,
    RefinedParameter,
    SensorErrors,
    Survey,
)


@pytest.fixture
def pairs() -> NodePairs:
    """Three neighbours, of which one did not match, and one pair across legs."""
    return NodePairs(
        first=np.array([0, 1, 2, 0]),
        second=np.array([1, 2, 3, 4]),
        across=np.array([False, False, False, True]),
        overlap=np.array([0.6, 0.8, 0.7, np.nan]),
        round=np.array([0, 0, 0, 1]),
        putative=np.array([90, 80, 5, 40]),
        reason=np.array([0, 0, 2, 0]),
        rejected=np.zeros(4, bool),
    )


def tables(survey: Survey) -> dict[str, WordTable]:
    return {table.name: table for table in quality_tables(survey)}


def adjusted(survey: Survey, summary: AdjustSummary) -> Survey:
    return replace(survey, adjusted=replace(survey.adjusted, summary=summary))


def test_pairs_are_counted_by_kind_with_their_overlap(survey: Survey, pairs: NodePairs) -> None:
    found = tables(replace(survey, facts=replace(survey.facts, node_pairs=pairs)))["overlap"]
    assert found.rows == [
        ("Neighbours along the track", "3", "2", "70 % (61 to 79 %)"),
        ("Images of other legs", "1", "1", "–"),
    ]
    assert "overlap" not in tables(survey)


def test_residuals_of_images_are_in_pixels(survey: Survey) -> None:
    summary = AdjustSummary(
        residuals_after={
            "stereo": FactorResiduals(rms=1.4, count=1200, robust_sigma=0.8, share_beyond_3=0.051),
            "range": FactorResiduals(rms=1.7, count=764),
        },
        sigmas=AdjustSigmas(pixel_px=0.2, range_m=0.01),
    )
    assert tables(adjusted(survey, summary))["residuals-px"].rows == [
        ("Features seen by both cameras", "1,200", "0.16 px", "0.28 px", "5.1 %"),
        ("DVL ranges", "764", "–", "17 mm", "–"),
    ]
    assert "residuals-px" not in tables(survey)  # no sigma of a pixel is known


def test_residuals_of_positions_from_outside_are_in_metres(survey: Survey) -> None:
    summary = AdjustSummary(
        residuals_after={
            "position": FactorResiduals(rms=1.2, count=80, robust_sigma=1.0, share_beyond_3=0.0)
        },
        positions=PositionFacts(count=40, span_s=200.0, sigma_m=0.5, rms_sigmas=1.04, outliers=0),
    )
    assert tables(adjusted(survey, summary))["residuals-px"].rows == [
        ("Positions from outside, north and east", "80", "0.5 m", "0.6 m", "0.0 %")
    ]


def test_errors_are_given_of_sensors_that_were_carried_alone(survey: Survey) -> None:
    errors = SensorErrors(
        dvl_scale=-0.0029, heading_drift_rad_s=-2.8e-4, roll_bias_rad=0.0015, depth_bias_m=0.006
    )
    sigma = SensorErrors(
        dvl_scale=0.0008, heading_drift_rad_s=3e-5, pitch_bias_rad=0.0027, depth_bias_m=0.095
    )
    found = adjusted(survey, AdjustSummary(navigation=errors, navigation_sigma=sigma))
    assert tables(found)["calibration"].rows == [
        ("Scale error of the DVL's velocities", "+0.29 ± 0.08 %"),
        ("Drift of the heading", "+58 ± 6° per hour"),
        ("Bias of roll", "+0.09°"),
        ("Bias of pitch", "+0.00 ± 0.15°"),
        ("Bias of the depth", "+6 ± 95 mm"),
    ]
    sound = adjusted(
        survey, AdjustSummary(navigation=SensorErrors(dvl_scale=-0.05), navigation_sigma=sigma)
    )
    assert tables(sound)["calibration"].rows[0][1] == "+5.00 ± 0.08 %"  # of the true velocity
    blind = replace(
        found, facts=replace(found.facts, dvl=None, has_depth=False, has_attitude=False)
    )
    assert "calibration" not in tables(blind)


def test_refined_cameras_are_given_with_their_sigmas(survey: Survey) -> None:
    refined = AdjustSummary(
        intrinsics={"top": {"fx": RefinedParameter(calibrated=500.0, found=503.21, sigma=0.4)}}
    )
    assert tables(adjusted(survey, refined))["calibration"].rows == [
        ("Camera top, fx", "503.2 ± 0.4 (calibrated 500)")
    ]


def test_times_are_those_of_the_steps(survey: Survey) -> None:
    (step,) = survey.provenance.steps
    beside = {"started": 4.0, "seconds": 200.4, "peak_rss_bytes": 1.5e9}
    steps = (
        step,
        replace(step, name="detect", run=beside),
        replace(step, run={}),
    )
    found = tables(replace(survey, provenance=replace(survey.provenance, steps=steps)))["times"]
    assert found.rows == [("adjust", "8 s", "–"), ("detect", "3 min 20 s", "1,500 MB")]
    assert "3 min 24 s for 2 steps" in found.caption


def test_a_dive_without_any_of_it_has_no_table(bare: Survey) -> None:
    assert quality_tables(bare) == []
