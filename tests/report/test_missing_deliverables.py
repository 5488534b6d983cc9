# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Why a dive cannot give a deliverable, as summary.json and the page say it."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hullrecon.report import deliverables
from hullrecon.report.deliverables import DELIVERABLES, missing_deliverables
from hullrecon.report.survey import (
    Carried,
    Findings,
    Mosaic,
    MosaicFacts,
    Mosaics,
    Provenance,
    Surfaces,
    Survey,
)

OF_DEVIATION = ("deviation.tif", "deviation_sigma.tif", "form.tif", "form_sigma.tif")
RASTERS = (*OF_DEVIATION, "support.tif")
OF_MOSAIC = (
    *("ortho_{}.tif", "ortho_{}.png", "mosaic_{}.glb", "variance_{}.tif", "views_{}.tif"),
    "tiles/{}/",
)
DOCS = Path(__file__).parents[2] / "docs" / "deliverables.md"


@pytest.fixture(autouse=True)
def with_pango(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deliverables, "why_no_pdf", lambda: None)


@pytest.fixture
def whole(survey: Survey) -> Survey:
    """A dive that has everything but an earlier dive to be compared with."""
    mosaic = Mosaic(facts=MosaicFacts(), preview=b"", has_mesh=True)
    names = [name.format(kind) for kind in ("optical", "sonar") for name in OF_MOSAIC]
    names = [f"{name}tileset.json" if name.endswith("/") else name for name in names]
    copies = {name: Path(name) for name in (*names, *RASTERS, "colmap/cameras.bin")}
    documents = {"objects.json": {}, "coverage.json": {}}
    return replace(
        survey,
        findings=replace(survey.findings, documents=documents),
        mosaics=Mosaics(optical=mosaic, sonar=mosaic),
        provenance=replace(survey.provenance, copies=copies),
    )


def without(survey: Survey, *names: str, **provenance: object) -> Survey:
    """The survey without some of the files of its steps, its provenance changed."""
    copies = {
        k: v for k, v in survey.provenance.copies.items() if not k.startswith(names or (" ",))
    }
    changed = replace(survey.provenance, copies=copies, **provenance)
    return replace(survey, provenance=changed)


def unfitted(survey: Survey) -> Survey:
    assert survey.adjusted is not None
    free = replace(survey.adjusted.solution, hull_pose=None)
    return replace(survey, adjusted=replace(survey.adjusted, solution=free))


def test_a_whole_dive_lacks_nothing(whole: Survey) -> None:
    assert missing_deliverables(whole) == {}


def test_without_cameras_images_are_the_reason(whole: Survey) -> None:
    of_images = ("colmap/", *(name.format("optical") for name in OF_MOSAIC))
    blind = without(whole, *of_images, carried=Carried(camera=False))
    blind = replace(blind, mosaics=replace(blind.mosaics, optical=None))
    assert missing_deliverables(blind) == dict.fromkeys(
        ("landmarks.ply", *of_images), "no camera was carried"
    )


def test_without_a_cad_model_nothing_is_aligned_to_it(whole: Survey) -> None:
    free = without(unfitted(whole), *OF_DEVIATION, carried=Carried(cad_model=False))
    reasons = missing_deliverables(free)
    assert set(reasons) == {"alignment.json", *OF_DEVIATION}
    no_model = "no CAD model was given, so there is nothing to"
    assert reasons["alignment.json"] == f"{no_model} align to"
    assert reasons["form_sigma.tif"] == f"{no_model} deviate from"


def test_a_cad_model_that_was_left_out_is_the_reason(whole: Survey) -> None:
    reasons = missing_deliverables(without(unfitted(whole), *OF_DEVIATION))
    assert reasons == dict.fromkeys(
        ("alignment.json", *OF_DEVIATION),
        "the CAD model does not fit the survey and was left out",
    )


def test_without_a_sonar_its_mosaic_is_missing(whole: Survey) -> None:
    names = [name.format("sonar") for name in OF_MOSAIC]
    silent = without(whole, *names, carried=Carried(sonar=False))
    silent = replace(silent, mosaics=replace(silent.mosaics, sonar=None))
    assert missing_deliverables(silent) == dict.fromkeys(names, "no imaging sonar was carried")


def test_without_a_mosaic_rasters_have_no_grid(whole: Survey) -> None:
    bare = replace(without(whole, *RASTERS), mosaics=Mosaics())
    reasons = missing_deliverables(bare)
    assert {reasons[name] for name in RASTERS} == {"they lie on a mosaic's grid, and there is none"}


def test_a_mosaic_without_faces_gives_no_mesh(whole: Survey) -> None:
    assert missing_deliverables(without(whole, "mosaic_sonar.glb")) == {
        "mosaic_sonar.glb": "too little was seen for a textured mesh"
    }


def test_tiles_that_failed_are_told_from_a_mosaic_without_faces(whole: Survey) -> None:
    failed = without(whole, "tiles/sonar/")
    assert missing_deliverables(failed) == {
        "tiles/sonar/": "they could not be written: see the warnings of mosaic-sonar"
    }
    faceless = Mosaic(facts=MosaicFacts(), preview=b"", has_mesh=False)
    unseen = replace(failed, mosaics=replace(failed.mosaics, sonar=faceless))
    assert missing_deliverables(unseen) == {
        "tiles/sonar/": "too little was seen for a textured mesh"
    }


def test_a_step_that_left_nothing_is_the_reason(survey: Survey) -> None:
    blank = replace(survey, adjusted=None, surfaces=Surfaces(), findings=Findings())
    reasons = missing_deliverables(replace(blank, provenance=Provenance()))
    assert reasons["surface.ply"] == "the step surface left no result"
    assert reasons["objects.gpkg"] == reasons["as_found.las"] == "the step detect left no result"
    assert reasons["alignment.json"] == "the adjustment did not run"


def test_a_step_that_failed_gives_its_reason(whole: Survey) -> None:
    why = {"mosaic-sonar": "no sonar mosaic: no ping meets the surface"}
    names = [name.format("sonar") for name in OF_MOSAIC]
    failed = without(whole, *names, failures=why)
    failed = replace(failed, mosaics=replace(failed.mosaics, sonar=None))
    assert missing_deliverables(failed) == dict.fromkeys(names, why["mosaic-sonar"])


def test_objects_not_looked_for_are_missing_with_the_reason(whole: Survey) -> None:
    blind = Findings(not_looked_for="too few landmarks", documents={"coverage.json": {}})
    reasons = missing_deliverables(replace(whole, findings=blind))
    of_objects = ("objects.json", "objects.csv", "objects/", "objects.geojson", "objects.gpkg")
    assert reasons == dict.fromkeys(of_objects, "too few landmarks")


def test_without_a_landmark_there_is_no_cloud(whole: Survey) -> None:
    assert whole.adjusted is not None
    landmarks = replace(whole.adjusted.solution.landmarks, position=np.zeros((0, 3)))
    solution = replace(whole.adjusted.solution, landmarks=landmarks)
    bare = replace(whole, adjusted=replace(whole.adjusted, solution=solution))
    assert missing_deliverables(bare) == {"landmarks.ply": "no landmark was adjusted"}


def test_a_comparison_is_missing_only_where_one_was_asked_for(whole: Survey) -> None:
    why = {"change": "no comparison with an earlier dive: this is no run"}
    asked = without(whole, carried=Carried(earlier_dive=True), failures=why)
    assert missing_deliverables(asked) == {"change/": why["change"]}
    there = {**whole.provenance.copies, "change/change.json": Path("change.json")}
    compared = replace(asked, provenance=replace(asked.provenance, copies=there))
    assert missing_deliverables(compared) == {}
    free = unfitted(without(whole, carried=Carried(earlier_dive=True, cad_model=False)))
    assert missing_deliverables(free)["change/"].startswith("no CAD model was given, and two dives")


def test_the_documents_table_names_every_deliverable() -> None:
    table = DOCS.read_text().split("## The page")[0]
    rows = re.findall(r"^\| `([^`]+)` \|", table, flags=re.MULTILINE)
    names = {entry.name for entry in DELIVERABLES}
    assert set(rows) - {"summary.json", "report/"} == names - {"report/index.html"}
