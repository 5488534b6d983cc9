# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace

import numpy as np

from hullrecon.records.solution import Solution
from hullrecon.report.content.missing_deliverables import (
    OF_DEVIATION,
    Carried,
    missing_deliverables,
)

ALL = Carried(camera=True, sonar=True, cad_model=True)
CHAIN = ("ingest", "navigate", "adjust", "surface", "detect", "mosaic-optical", "mosaic-sonar")


def test_a_whole_dive_lacks_nothing(solution: Solution) -> None:
    assert missing_deliverables(ALL, CHAIN, solution) == {}


def test_without_cameras_all_that_needs_images_says_so(solution: Solution) -> None:
    blind = replace(solution, landmarks=replace(solution.landmarks, position=np.zeros((0, 3))))
    reasons = missing_deliverables(
        replace(ALL, camera=False),
        ("ingest", "navigate", "adjust", "surface", "mosaic-sonar"),
        blind,
    )
    assert {reasons[k] for k in ("ortho_optical.tif", "landmarks.ply", "colmap/")} == {
        "no camera was carried"
    }
    assert "ortho_sonar.tif" not in reasons


def test_without_a_cad_model_there_is_no_alignment(solution: Solution) -> None:
    reasons = missing_deliverables(
        replace(ALL, cad_model=False), CHAIN, replace(solution, hull_pose=None)
    )
    assert next(iter(reasons)) == "alignment.json"
    assert set(reasons) == {"alignment.json", *OF_DEVIATION}
    assert "no CAD model was given" in reasons["alignment.json"]


def test_without_a_sonar_its_mosaic_is_absent(solution: Solution) -> None:
    reasons = missing_deliverables(replace(ALL, sonar=False), CHAIN[:-1], solution)
    assert set(reasons.values()) == {"no imaging sonar was carried"}


def test_rasters_that_lie_on_a_mosaics_grid_are_named_where_there_is_none(
    solution: Solution,
) -> None:
    carried = Carried(camera=False, sonar=False, cad_model=True)
    reasons = missing_deliverables(carried, CHAIN[:-2], solution)
    assert {reasons[name] for name in (*OF_DEVIATION, "support.tif")} == {
        "they lie on a mosaic's grid, and there is none"
    }
    assert "support.tif" not in missing_deliverables(ALL, CHAIN[:-1], solution)


def test_a_step_that_left_nothing_is_named() -> None:
    reasons = missing_deliverables(ALL, ("ingest", "navigate"), None)
    assert reasons["surface.ply"] == "the step surface left no result"
    assert reasons["alignment.json"] == "the adjustment did not run"


def test_a_step_that_failed_gives_its_reason(solution: Solution) -> None:
    failures = {"mosaic-sonar": "no sonar mosaic: no ping meets the surface"}
    reasons = missing_deliverables(ALL, CHAIN[:-1], solution, failures)
    assert {"ortho_sonar.tif", "ortho_sonar.png", "mosaic_sonar.glb"} <= set(reasons)
    assert set(reasons.values()) == {failures["mosaic-sonar"]}


def test_a_cad_model_that_was_left_out_is_named_as_such(solution: Solution) -> None:
    reasons = missing_deliverables(ALL, CHAIN, replace(solution, hull_pose=None))
    assert set(reasons) == {"alignment.json", *OF_DEVIATION}
    assert set(reasons.values()) == {"the CAD model does not fit the survey and was left out"}


def test_without_a_cad_model_the_rasters_of_the_deviation_are_named() -> None:
    reasons = missing_deliverables(
        Carried(camera=True, sonar=True, cad_model=False), ("adjust",), None
    )
    assert (
        reasons["deviation.tif"]
        == reasons["form_sigma.tif"]
        == "no CAD model was given, so there is nothing to deviate from"
    )
    assert reasons["objects.gpkg"] == "the step detect left no result"
    with_cad = missing_deliverables(
        Carried(camera=True, sonar=True, cad_model=True), ("adjust", "mosaic-sonar"), None
    )
    assert "form.tif" not in with_cad


def test_a_comparison_is_missed_only_where_an_earlier_dive_is_named(solution: Solution) -> None:
    failures = {"change": "no comparison with an earlier dive: this is no run"}
    named = replace(ALL, earlier_dive=True)
    assert missing_deliverables(ALL, CHAIN, solution) == {}
    assert missing_deliverables(named, CHAIN, solution, failures) == {"change/": failures["change"]}
    assert missing_deliverables(named, (*CHAIN, "change"), solution) == {}
    without_cad = missing_deliverables(
        replace(named, cad_model=False), CHAIN, replace(solution, hull_pose=None)
    )
    assert (
        without_cad["change/"]
        == "no CAD model was given, and two dives are compared on their hull's CAD model"
    )
