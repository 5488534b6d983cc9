# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The report of a dive that was only navigated, run as a step."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import msgspec
import numpy as np
import pytest
from PIL import Image

from hullrecon.artifacts.runner import run_stage
from hullrecon.artifacts.stage import StageSettings
from hullrecon.dive.config.schema import Dive, DiveConfig, Logs
from hullrecon.records.serialisation import to_arrays
from hullrecon.records.trajectory import Trajectory
from hullrecon.report.options import ReportOptions
from hullrecon.report.survey import SurfaceFacts
from hullrecon.steps.chain import stage
from hullrecon.steps.conditions import files_to_report
from hullrecon.steps.finished_run import TRACEBACKS, failed_delivery

STAGE = stage("report")


def save(folder: Path, name: str, record: object) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / name).open("wb") as file:
        np.savez(file, **to_arrays(record))  # type: ignore[arg-type]


@pytest.fixture
def navigated(tmp_path: Path) -> dict[str, Path]:
    return write_navigated(tmp_path)


@pytest.fixture(scope="module")
def delivered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder deliver/ of a dive that was only navigated."""
    folder = tmp_path_factory.mktemp("delivered")
    return run(write_navigated(folder), folder / "report")


@pytest.fixture
def no_pdf(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave the PDF out, which takes as long as the rest."""
    monkeypatch.setattr(
        "hullrecon.report.deliverables.why_no_pdf", lambda: "Pango is not installed"
    )


def write_navigated(tmp_path: Path) -> dict[str, Path]:
    """Write artifacts of ingest and navigate, and nothing else."""
    n = 6
    trajectory = Trajectory(
        t_ns=np.arange(n) * 500_000_000,
        quaternion=np.tile([0.0, 0.0, 0.0, 1.0], (n, 1)),
        translation=np.column_stack([np.arange(n) * 0.25, np.zeros(n), np.full(n, 3.0)]),
        covariance=np.tile(np.eye(6) * 1e-4, (n, 1, 1)),
        tray=np.zeros(n),
        image=np.full((n, 2), -1),
    )
    save(tmp_path / "navigate", "trajectory.npz", trajectory)
    (tmp_path / "navigate" / "navigation.json").write_text(
        json.dumps({"source": "dvl", "outages": [], "remarks": ["one beam lost"]})
    )
    (tmp_path / "ingest").mkdir()
    (tmp_path / "ingest" / "findings.json").write_text(
        json.dumps({"lost": ["/dvl: 2 s at 09:31"], "hull": [], "remarks": []})
    )
    return {"ingest": tmp_path / "ingest", "navigate": tmp_path / "navigate"}


def run(inputs: dict[str, Path], out: Path, options: ReportOptions | None = None) -> Path:
    config = DiveConfig(dive=Dive(name="bare"), logs=Logs(files=("logs/dive.mcap",)))
    settings = {
        name: getattr(config, name) for name in ("dive", "logs", "tray", "camera", "sonar", "hull")
    }
    section = {} if options is None else {"report": options}
    return run_stage(STAGE, settings | section, inputs, out, source=out.parent) / "deliver"


def test_a_mosaic_without_a_textured_mesh_says_why(
    navigated: dict[str, Path], tmp_path: Path, no_pdf: None
) -> None:
    folder = tmp_path / "mosaic-sonar"
    folder.mkdir()
    (folder / "mosaic.json").write_text(
        json.dumps({"caption": "1 m² at 17.6 mm per pixel.", "resolution_m": 0.0176})
    )
    Image.fromarray(np.full((40, 60, 3), 90, np.uint8)).save(folder / "ortho.png")
    deliver = run(navigated | {"mosaic-sonar": folder}, tmp_path / "report")
    summary = json.loads((deliver / "summary.json").read_text())
    assert summary["absent"]["mosaic_sonar.glb"] == "too little was seen for a textured mesh"
    assert "mosaic_sonar.glb</a>" not in (deliver / "report" / "index.html").read_text()


def test_dive_that_was_only_navigated_is_delivered_with_reasons(delivered: Path) -> None:
    deliver = delivered
    summary = json.loads((deliver / "summary.json").read_text())
    assert summary["frame"] == "g"
    assert len((deliver / "trajectory.csv").read_text().splitlines()) == 7
    assert summary["absent"]["ortho_optical.tif"] == "no camera was carried"
    assert summary["absent"]["ortho_sonar.tif"] == "no imaging sonar was carried"
    assert summary["lost"] == ["/dvl: 2 s at 09:31"]
    assert "one beam lost" in (deliver / "report" / "index.html").read_text()


def test_every_delivered_file_is_in_the_summary_with_its_hash(delivered: Path) -> None:
    deliver = delivered
    listed = json.loads((deliver / "summary.json").read_text())["deliverables"]
    there = {p.relative_to(deliver).as_posix() for p in deliver.rglob("*") if p.is_file()} - {
        "summary.json"
    }
    assert set(listed) == there
    for name, entry in listed.items():
        assert hashlib.sha256((deliver / name).read_bytes()).hexdigest() == entry["sha256"]


def test_two_runs_deliver_the_same_bytes(
    delivered: Path, navigated: dict[str, Path], tmp_path: Path
) -> None:
    first, second = delivered, run(navigated, tmp_path / "report")
    for path in sorted(p for p in first.rglob("*") if p.is_file()):
        assert path.read_bytes() == (second / path.relative_to(first)).read_bytes(), path.name


def test_objects_that_were_not_looked_for_are_absent_not_none(
    navigated: dict[str, Path], tmp_path: Path, no_pdf: None
) -> None:
    detect = tmp_path / "detect"
    detect.mkdir()
    (detect / "objects.json").write_text(json.dumps({"objects": []}))
    (detect / "detect.json").write_text(
        json.dumps({"objects": "the images gave too few landmarks"})
    )
    deliver = run({**navigated, "detect": detect}, tmp_path / "report")
    assert not (deliver / "objects.json").exists()
    assert (
        json.loads((deliver / "summary.json").read_text())["absent"]["objects.json"]
        == "the images gave too few landmarks"
    )
    page = (deliver / "report" / "index.html").read_text()
    assert "Objects were not looked for: the images gave too few landmarks." in page


def test_surface_without_cad_model_has_no_comparison() -> None:
    facts = {"reference": "survey", "comparison": None, "method": "gp"}
    assert msgspec.convert(facts, SurfaceFacts).comparison is None


def test_without_pango_page_is_delivered_and_pdf_explained(
    navigated: dict[str, Path], tmp_path: Path, no_pdf: None
) -> None:
    deliver = run(navigated, tmp_path / "report")
    assert (
        json.loads((deliver / "summary.json").read_text())["absent"]["report/report.pdf"]
        == "Pango is not installed"
    )
    assert sorted(p.name for p in (deliver / "report").iterdir()) == ["index.html"]


def test_failed_deliverable_is_warned_of_and_reported_by_run(
    navigated: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(_: object) -> bytes:
        raise ValueError("a layer is 20,000 px wide")

    monkeypatch.setattr("hullrecon.report.deliverables.render_pdf", broken)
    deliver = run(navigated, tmp_path / "report")
    why = "ValueError: a layer is 20,000 px wide"
    assert (deliver / "trajectory.csv").is_file()
    assert (deliver / "report" / "index.html").is_file()
    assert json.loads((deliver / "summary.json").read_text())["failed"] == {
        "report/report.pdf": why
    }
    warnings = json.loads((tmp_path / "report" / "manifest.json").read_text())["warnings"]
    assert warnings == [f"report/report.pdf could not be written: {why}"]
    assert "in broken" in (tmp_path / "report" / TRACEBACKS).read_text()
    error = failed_delivery(tmp_path)
    assert error is not None
    assert error.exit_code == 1
    assert "report/report.pdf could not be written" in error.line()
    assert str(tmp_path / "report" / TRACEBACKS) in error.line()


def test_a_whole_delivery_ends_without_an_error(delivered: Path) -> None:
    assert failed_delivery(delivered.parents[1]) is None


def test_the_page_says_what_the_package_says_of_the_inspection(
    navigated: dict[str, Path], tmp_path: Path, no_pdf: None
) -> None:
    Image.new("RGB", (60, 20), (10, 80, 140)).save(tmp_path / "logo.png")
    options = ReportOptions(
        client="Harbour & Sons",
        equipment=("A50",),
        conclusion="Fine.\n\nLook again.",
        logo="logo.png",
    )
    page = (run(navigated, tmp_path / "report", options) / "report" / "index.html").read_text()
    for text in (
        "Harbour &amp; Sons",
        "A50",
        "<p>Look again.</p>",
        'class="logo" src="data:image/png;base64,',
    ):
        assert text in page, text


def test_another_logo_makes_the_report_out_of_date(tmp_path: Path) -> None:
    def files(**options: str) -> list[Path]:
        sections = {"logs": Logs(files=("logs/dive.mcap",)), "report": ReportOptions(**options)}
        return files_to_report(StageSettings("report", sections), tmp_path)

    assert files(logo="brand/logo.png") == [Path("brand/logo.png")]
    assert files() == []
