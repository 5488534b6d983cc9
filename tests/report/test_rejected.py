# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Section 9 of the page and its parameters."""

from __future__ import annotations

from dataclasses import replace

from hullrecon.records.deliverables import RejectedRegion
from hullrecon.report.content.rejected import rejected_groups, settings_rows
from hullrecon.report.survey import (
    AdjustSummary,
    LogFindings,
    NavigationFacts,
    PairFacts,
    StepRun,
    Survey,
)


def step(name: str, settings: dict[str, object]) -> StepRun:
    return StepRun(name=name, version=1, settings=settings, inputs={}, warnings=(), run={})


def groups_of(survey: Survey) -> dict[str, list[str]]:
    return dict(rejected_groups(survey))


def test_headings_without_an_item_are_left_out(bare: Survey) -> None:
    assert list(groups_of(bare)) == ["Deliverables that this dive cannot give"]
    assert rejected_groups(replace(bare, provenance=replace(bare.provenance, missing={}))) == []


def test_missing_deliverables_stand_with_their_reason(bare: Survey) -> None:
    items = groups_of(bare)["Deliverables that this dive cannot give"]
    assert "objects.json: no camera was carried" in items


def test_outages_stand_at_the_logs_own_times(bare: Survey) -> None:
    navigation = NavigationFacts(
        start_ns=60 * 10**9,
        outages_s=((1.0, 2.5),),
        attitude_gaps_s=((3.0, 4.0),),
        remarks=("one remark",),
    )
    items = groups_of(replace(bare, facts=replace(bare.facts, navigation=navigation)))["Navigation"]
    assert items == [
        "no DVL from 1970-01-01T00:01:01.000Z to 1970-01-01T00:01:02.500Z",
        "no attitude from 1970-01-01T00:01:03.000Z to 1970-01-01T00:01:04.000Z",
        "one remark",
    ]


def test_pairs_are_counted_by_reason_singular_and_plural(bare: Survey) -> None:
    pairs = PairFacts(failed={"too few inliers": 1, "inconsistent with navigation": 12})
    items = groups_of(replace(bare, facts=replace(bare.facts, pairs=pairs)))[
        "Image pairs without a relative pose"
    ]
    assert items == ["inconsistent with navigation: 12 pairs", "too few inliers: 1 pair"]


def test_lost_data_and_findings_of_the_cad_model_are_apart(
    bare: Survey,
) -> None:
    log = LogFindings(lost=("2 s of /dvl",), hull=("22 boundary edges",), notes=("no sonar",))
    groups = groups_of(replace(bare, facts=replace(bare.facts, log=log)))
    assert groups["Lost data"] == ["2 s of /dvl"]
    assert groups["CAD model, as checked"] == ["22 boundary edges"]
    assert groups["Remarks on the log"] == ["no sonar"]


def test_no_observation_is_counted_where_none_was_rejected(survey: Survey) -> None:
    assert survey.adjusted is not None
    clean = replace(survey.adjusted, summary=AdjustSummary(observations=100))
    assert "Observations" not in groups_of(replace(survey, adjusted=clean))
    assert groups_of(survey)["Observations"] == ["2 of 100 image observations rejected as outliers"]


def test_a_region_has_its_height_and_its_address(bare: Survey) -> None:
    region = RejectedRegion(
        center=(1.0, -2.0, 0.5),
        height=-0.043,
        height_sigma=0.006,
        reason="only 4 landmarks",
        address="frame 3, port",
    )
    groups = groups_of(replace(bare, findings=replace(bare.findings, not_reported=(region,))))
    assert groups["Regions examined and not reported as objects"] == [
        "only 4 landmarks (height −0.043 ± 0.006 m, frame 3, port)"
    ]


def test_warnings_carry_the_name_of_their_step(survey: Survey) -> None:
    assert groups_of(survey)["Warnings of the steps"] == ["adjust: two rays missed"]


def test_options_are_listed_once_by_section_and_key() -> None:
    steps = [
        step(
            "adjust", {"adjust": {"rounds": 3, "method": "maxmix"}, "dvl": {"mount": [0, 0, 1.5]}}
        ),
        step("surface", {"dvl": {"mount": [0, 0, 1.5]}, "surface": {"cell_m": None}}),
    ]
    assert settings_rows(steps) == [
        ("adjust.method", "maxmix"),
        ("adjust.rounds", "3"),
        ("dvl.mount", "0, 0, 1.5"),
        ("surface.cell_m", "not set"),
    ]


def test_nested_options_have_dotted_names() -> None:
    assert settings_rows([step("x", {"hull": None, "camera": {"top": {"mount": 1}}})]) == [
        ("camera.top.mount", "1")
    ]


def test_a_table_among_the_settings_is_a_line_of_words() -> None:
    regions = [{"name": "bow", "along": [1.0, 2.0], "girth": None}]
    assert settings_rows([step("x", {"hull": {"region": regions}})]) == [
        ("hull.region", "name bow along 1.0, 2.0 girth not set")
    ]
