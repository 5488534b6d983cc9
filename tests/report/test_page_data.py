# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the page's script is given."""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from report_pages import page_context

from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.links import NodePairs
from hullrecon.report.content.page_data import script_json
from hullrecon.report.export.layers import object_layers
from hullrecon.report.render import render_page
from hullrecon.report.survey import Survey

WEB = Path(__file__).resolve().parents[2] / "hullrecon" / "report" / "web"
TEMPLATES = WEB.parent / "templates"


def data_of(survey: Survey) -> dict[str, Any]:
    """The document as a browser finds it."""
    text = render_page(page_context(survey, [], {}, {}))
    (found,) = re.findall(
        r'(?s)<script type="application/json" id="report-data">(.*?)</script>', text
    )
    return json.loads(found)


def test_no_text_ends_the_script_that_it_stands_in() -> None:
    text = script_json({"vessel": "</script><b>\u2028", "sum": 1})
    assert "<" not in text
    assert "\u2028" not in text
    assert json.loads(text)["vessel"] == "</script><b>\u2028"
    with pytest.raises(ValueError, match="Out of range"):
        script_json({"height": float("nan")})


def test_objects_lie_on_the_map_as_in_the_files_beside_it(survey: Survey) -> None:
    (found,) = data_of(survey)["objects"]
    assert found["at"] == [-1.0, -1.2]  # x is minus along, as outside says
    outline = np.array(found["outline"])
    np.testing.assert_allclose(np.ptp(outline, axis=0), (0.2, 0.16), atol=1e-4)
    ring = np.array(found["ellipse"]) - found["at"]
    np.testing.assert_allclose(np.abs(ring).max(axis=0), (0.3, 0.02), atol=1e-3)
    layers = object_layers(
        survey.findings.objects, (), survey.surfaces.chart, survey.surfaces.outside
    )
    np.testing.assert_allclose(layers[0].shapes[0], outline, atol=1e-4)


def test_the_map_knows_its_place_and_its_layers(survey: Survey) -> None:
    document = data_of(survey)["map"]
    left, bottom, right, top = document["bounds"]
    assert left < -1 < right
    assert bottom < -1.2 < top
    assert (document["x_sign"], document["y_sign"], document["axes"]) == (-1, 1, ["along", "girth"])
    assert document["frame_spacing"] == 0.6
    (path,) = document["path"]
    assert len(path) == 5
    legend = document["layers"][0]["legend"]
    assert len(legend["colours"]) == 256
    assert all(re.fullmatch("#[0-9a-f]{6}", colour) for colour in legend["colours"])
    text = render_page(page_context(survey, [], {}, {}))
    for layer in document["layers"]:
        assert f'<script type="text/plain" id="{layer["image"]}">data:image/webp;base64,' in text


def test_a_dive_without_a_cad_model_has_no_frames_and_no_girth(
    survey: Survey, bare: Survey
) -> None:
    document = data_of(replace(bare, surfaces=replace(survey.surfaces, deviation=None)))["map"]
    assert document["axes"] == ["along", "across"]
    assert document["frame_spacing"] is None
    assert data_of(bare)["map"] is None


def test_matched_pairs_are_links_by_kind(survey: Survey) -> None:
    pairs = NodePairs(
        first=np.array([0, 1, 0]),
        second=np.array([1, 2, 4]),
        across=np.array([False, False, True]),
        overlap=np.ones(3),
        round=np.zeros(3, int),
        putative=np.ones(3, int),
        reason=np.array([0, 2, 0]),
        rejected=np.zeros(3, bool),
    )
    linked = replace(survey, facts=replace(survey.facts, node_pairs=pairs))
    links = {link["kind"]: link["segments"] for link in data_of(linked)["map"]["links"]}
    path = data_of(linked)["map"]["path"][0]
    assert links == {"along the track": [path[0] + path[1]], "between legs": [path[0] + path[4]]}
    assert data_of(survey)["map"]["links"] == []


def test_an_object_off_the_chart_has_no_place(survey: Survey, found: ReportedObject) -> None:
    off = replace(found, id=2, center=(float("nan"),) * 3, outline=(), position_covariance=None)
    both = replace(survey, findings=replace(survey.findings, objects=(found, off)))
    document = data_of(both)["objects"][1]
    assert (document["at"], document["outline"], document["ellipse"]) == (None, [], [])


def test_the_page_holds_its_data_once(survey: Survey, bare: Survey) -> None:
    assert data_of(survey)["frame"] == "M"
    assert data_of(bare)["frame"] == "g"


def test_bundled_scripts_have_their_licence_and_load_nothing() -> None:
    versions = json.loads((WEB / "package.json").read_text())["devDependencies"]
    for name in ("report.js", "report.css"):
        text = (TEMPLATES / name).read_text()
        assert f"Leaflet {versions['leaflet']}" in text, "built from another version: make web"
        assert f"three.js {versions['three']}" in text
        assert "Redistributions in binary form must reproduce the above copyright" in text
        assert "</script" not in text.lower()
        assert not re.search(r"@import|url\((?!data:|#)|sourceMappingURL", text)


def test_what_is_built_is_built_from_the_sources_that_lie_here() -> None:
    hash_of = hashlib.sha256()
    for path in [WEB / "package.json", *sorted((WEB / "src").iterdir(), key=lambda p: p.name)]:
        hash_of.update(f"{path.relative_to(WEB).as_posix()}\n".encode() + path.read_bytes())
    for name in ("report.js", "report.css"):
        assert f"of sources {hash_of.hexdigest()}." in (TEMPLATES / name).read_text(), (
            "out of date: make web"
        )


def test_the_script_finds_its_elements_in_the_page(survey: Survey) -> None:
    text = render_page(page_context(survey, [], {}, {}))
    ids = set(re.findall(r' id="([^"]+)"', re.sub(r"(?s)<script>.*?</script>", "", text)))
    for source in (WEB / "src").glob("*.js"):
        for wanted in re.findall(r'getElementById\("([^"$]+)"\)', source.read_text()):
            assert wanted in ids | {"scene"}, f"{source.name} looks for #{wanted}"


def test_the_lock_names_exact_versions_and_no_registry() -> None:
    package = json.loads((WEB / "package.json").read_text())
    assert all(
        re.fullmatch(r"\d+\.\d+\.\d+", version) for version in package["devDependencies"].values()
    )
    lock = (WEB / "package-lock.json").read_text()
    assert "registry" not in lock
    assert '"resolved"' not in lock
