# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""`study run`: what a folder of studies holds, and what a failure costs."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from hullrecon_cli.commands import study as commands
from hullrecon_cli.main import main

from hullrecon import studies
from hullrecon.errors import InputError
from hullrecon.studies import registry
from hullrecon.studies.figure_style import PublishedFigure
from hullrecon.studies.page import page
from hullrecon.studies.study import ComparedValue, DiveStudy, SceneStudy, StudyResult

PNG = b"\x89PNG\r\n"


def drawn() -> StudyResult:
    return StudyResult(
        figures=(PublishedFigure(name="curve", png=PNG, csv="a,b\n1,2\n", caption="A <curve>."),),
        heads=("method", "seconds"),
        rows=(("EKF", "20"), ("selective", "1")),
        compared=(
            ComparedValue(what="ratio of times", unit="", printed=25.7, ours=20.0),
            ComparedValue(what="drift", unit="%", printed=None, ours=np.nan, note="in words"),
        ),
        values={"EKF": {"seconds": np.float64(20.0), "error": np.nan}},
    )


def refused() -> StudyResult:
    raise InputError("the park is not here", where="park.csv")


def broken() -> StudyResult:
    raise ZeroDivisionError("of a study")


def scene(name: str, run: Callable[[], StudyResult]) -> SceneStudy:
    return SceneStudy(id=name, source="[A Fig. 1]", shows=f"what {name} shows", run=run)


@pytest.fixture
def listed(monkeypatch: pytest.MonkeyPatch) -> Callable[[Sequence[DiveStudy | SceneStudy]], None]:
    """Put other studies into the registry."""

    def put(entries: Sequence[DiveStudy | SceneStudy]) -> None:
        for module in (registry, studies, page):
            monkeypatch.setattr(module, "STUDIES", tuple(entries))

    return put


def test_a_study_leaves_pictures_tables_and_its_result(listed, tmp_path: Path) -> None:
    listed([scene("curves", drawn)])
    assert main(["study", "run", "curves", "--out", str(tmp_path / "out")]) == 0
    folder = tmp_path / "out" / "curves"
    assert (folder / "curve.png").read_bytes() == PNG
    assert (folder / "curve.csv").read_text() == "a,b\n1,2\n"
    assert (folder / "table.csv").read_text() == "method,seconds\nEKF,20\nselective,1\n"
    kept = json.loads((folder / "result.json").read_text())
    assert [value["ours"] for value in kept["compared"]] == [20.0, None]
    assert kept["values"] == {"EKF": {"seconds": 20.0, "error": None}}


def test_the_page_holds_pictures_and_printed_beside_ours(listed, tmp_path: Path) -> None:
    listed([scene("curves", drawn)])
    main(["study", "run", "curves", "--out", str(tmp_path)])
    text = (tmp_path / "index.html").read_text()
    assert "data:image/png;base64,iVBORw0K" in text
    assert '<td class="number">25.7</td><td class="number ours">20</td>' in text
    assert "A &lt;curve&gt;." in text


def test_a_failure_costs_itself_and_gives_the_exit_code(
    listed, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    listed([scene("park", refused), scene("curves", drawn)])
    assert main(["study", "run", "all", "--out", str(tmp_path)]) == 3
    assert (tmp_path / "curves" / "result.json").is_file()
    text = (tmp_path / "index.html").read_text()
    assert "has no result: the park is not here (park.csv)" in text
    assert "iVBORw0K" in text
    lines = capsys.readouterr().err.splitlines()
    assert re.fullmatch(r"park: failed in \d+ s, 1 left", lines[0])
    assert re.fullmatch(r"curves: done in \d+ s, 0 left", lines[1])
    assert "study park failed: the park is not here" in lines[2]


def test_a_fault_of_ours_leaves_its_traceback(
    listed, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    listed([scene("sums", broken)])
    assert main(["study", "run", "sums", "--out", str(tmp_path)]) == 1
    assert "ZeroDivisionError" in (tmp_path / "sums" / "traceback.txt").read_text()
    assert str(tmp_path / "sums" / "traceback.txt") in capsys.readouterr().err


def test_the_page_keeps_studies_of_an_earlier_run(listed, tmp_path: Path) -> None:
    listed([scene("curves", drawn), scene("other", drawn)])
    main(["study", "run", "curves", "--out", str(tmp_path)])
    main(["study", "run", "other", "--out", str(tmp_path)])
    text = (tmp_path / "index.html").read_text()
    assert 'id="curves"' in text
    assert 'id="other"' in text


def test_without_a_dive_a_study_of_one_says_what_to_give(
    listed,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    listed([DiveStudy(id="paths", source="[A]", shows="paths", run=lambda _: drawn())])
    monkeypatch.setattr("hullrecon.synthetic.sample.FOLDER", tmp_path / "demo")
    assert main(["study", "run", "paths", "--out", str(tmp_path / "out")]) == 2
    assert "give one with --dive" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_the_sample_dive_is_taken_where_no_dive_is_given(
    listed, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    listed([DiveStudy(id="paths", source="[A]", shows="paths", run=lambda _: drawn())])
    opened: list[Path] = []

    def open_dive(package: Path, *_: object, **__: object) -> None:
        opened.append(package)
        raise InputError("enough")

    monkeypatch.setattr(commands, "open_dive", open_dive)
    main(["study", "run", "paths", "--out", str(tmp_path)])
    assert [path.parts[-2:] for path in opened] == [("sample_data", "demo")]


def test_scenes_run_in_worker_processes_with_the_same_result(tmp_path: Path) -> None:
    names = ["toy-graph", "label-boundary"]
    for jobs in ("1", "2"):
        out = str(tmp_path / jobs)
        assert main(["study", "run", *names, "--out", out, "--jobs", jobs]) == 0
    for name in names:
        folders = [tmp_path / jobs / name for jobs in ("1", "2")]
        pictures = [sorted(f.glob("*.csv")) for f in folders]
        assert [p.read_bytes() for p in pictures[0]] == [p.read_bytes() for p in pictures[1]]
        assert pictures[0]
