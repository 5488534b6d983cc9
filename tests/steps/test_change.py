# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The step that compares a dive with an earlier one: what it leaves, when it is out of date, and
how it fails alone.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest
from steps.two_dives import SimulatedDive, june, may

from hullrecon.artifacts.chain import assess_chain
from hullrecon.artifacts.stage import StageSettings
from hullrecon.change.options import EarlierDive
from hullrecon.report.change.chapter import ChangeChapter
from hullrecon.steps.conditions import files_of_earlier_dive, why_no_change

EARLIER = "../../runs/may"
Compared = tuple[SimulatedDive, SimulatedDive]


@pytest.fixture(scope="module")
def compared_once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the runs of both dives, the second compared with the first."""
    folder = tmp_path_factory.mktemp("dives")
    SimulatedDive(folder, may()).run()
    SimulatedDive(folder, june(), EARLIER).run()
    return folder


@pytest.fixture
def compared(compared_once: Path, tmp_path: Path) -> Compared:
    shutil.copytree(compared_once, tmp_path, dirs_exist_ok=True)
    return SimulatedDive(tmp_path, may()), SimulatedDive(tmp_path, june(), EARLIER)


def states(dive: SimulatedDive) -> dict[str, str]:
    found = assess_chain(dive.chain, dive.workspace, dive.workspace.hashes())
    return {status.stage.name: status.state for status in found}


def out_of_date(dive: SimulatedDive) -> set[str]:
    return {name for name, state in states(dive).items() if state == "out of date"}


def absent(dive: SimulatedDive) -> str:
    """Run a dive whose step `change` alone fails, and return the reason."""
    outcomes = dive.run()
    assert {name for name, outcome in outcomes.items() if outcome.failure is not None} == {"change"}
    summary = dive.summary()
    assert summary["inputs"] == ["detect", "ingest"]
    (reason,) = summary["absent"].values()
    assert len(reason.splitlines()) == 1
    return reason


def test_step_writes_document_table_layers_map_and_chapter(
    compared: Compared,
) -> None:
    folder = compared[1].workspace.root / "change"
    assert sorted(path.name for path in folder.iterdir()) == [
        "change.csv",
        "change.geojson",
        "change.gpkg",
        "change.json",
        "change.png",
        "chapter.json",
        "manifest.json",
    ]
    chapter = msgspec.json.decode((folder / "chapter.json").read_bytes(), type=ChangeChapter)
    document = json.loads((folder / "change.json").read_text())
    assert chapter.verdict == document["verdict"]
    assert chapter.verdict.startswith("may to june: 3 new, 1 gone and 1 grown; ")
    assert [row.status for row in chapter.rows] == [row["status"] for row in document["objects"]]


def test_all_is_up_to_date_behind_it(compared: Compared) -> None:
    for dive in compared:
        assert set(states(dive).values()) <= {"up to date", "skipped"}
    assert not any(outcome.made for outcome in compared[1].run().values())


def test_a_dive_that_names_no_earlier_one_has_no_such_step(compared: Compared) -> None:
    assert states(compared[0])["change"] == "skipped"
    assert compared[0].summary() == {"inputs": ["detect", "ingest"], "absent": {}}


def test_earlier_dive_of_same_name_is_told_apart_by_its_folder(
    compared: Compared, tmp_path: Path
) -> None:
    shutil.copytree(tmp_path / "runs" / "may", tmp_path / "runs-of-2025" / "june")
    again = SimulatedDive(tmp_path, june(), "../../runs-of-2025/june")
    again.run()
    document = json.loads((again.workspace.root / "change" / "change.json").read_text())
    assert (document["first"], document["second"]) == ("runs-of-2025/june", "june")


def test_the_earlier_run_may_be_given_by_its_deliverables(compared: Compared) -> None:
    settings = {"change": EarlierDive(earlier=f"{EARLIER}/deliver")}
    by_deliver = files_of_earlier_dive(StageSettings("change", settings), compared[1].package)
    assert len(by_deliver) == 10
    assert all((compared[1].package / file).is_file() for file in by_deliver)


@pytest.mark.parametrize("step", ["ingest", "adjust", "surface", "detect"])
def test_rerun_of_first_dive_outdates_second_change_and_report(
    compared: Compared, step: str
) -> None:
    first, second = compared
    first.rewrite(step, lambda files: {**files, "more.txt": b"new"}, may())
    first.run()
    assert out_of_date(second) == {"change", "report"}


def test_changed_objects_of_first_dive_reach_second_report(
    compared: Compared,
) -> None:
    first, second = compared
    fewer = may()
    fewer = replace(fewer, objects=fewer.objects[:3])
    first.rewrite("detect", lambda files: files, fewer)
    first.run()
    second.run()
    rows = json.loads((second.workspace.root / "change" / "change.json").read_text())["objects"]
    assert {row["first_id"] for row in rows if row["first_id"]} == {1, 2, 3}
    assert out_of_date(second) == set()


def test_rerun_of_second_dive_outdates_its_change_and_report(
    compared: Compared,
) -> None:
    second = compared[1]
    second.rewrite("detect", lambda files: {**files, "more.txt": b"new"}, june())
    assert out_of_date(second) == {"detect", "change", "report"}


def test_another_earlier_dive_makes_it_out_of_date(compared: Compared) -> None:
    second = compared[1]
    second.earlier = "../../runs/march"
    assert out_of_date(second) == {"change", "report"}


def _is_gone(run: Path) -> None:
    shutil.rmtree(run)


def _is_an_empty_folder(run: Path) -> None:
    shutil.rmtree(run)
    run.mkdir()


def _is_a_file(run: Path) -> None:
    shutil.rmtree(run)
    run.write_text("x")


def _lacks_a_step(run: Path) -> None:
    shutil.rmtree(run / "detect")


def _is_damaged(run: Path) -> None:
    (run / "detect" / "as_found.npz").write_bytes(b"PK")


def _has_a_fifo(run: Path) -> None:
    (run / "adjust" / "solution.npz").unlink()
    os.mkfifo(run / "adjust" / "solution.npz")


@pytest.mark.parametrize(
    ("harm", "reason"),
    [
        (_is_gone, "this is no run"),
        (_is_an_empty_folder, "this is no run"),
        (_is_a_file, "this is no run"),
        (_lacks_a_step, "the run is not finished: it has no step detect"),
        (_is_damaged, "detect/as_found.npz is damaged"),
        (_has_a_fifo, "adjust/solution.npz is damaged"),
    ],
)  # fmt: skip
def test_unsound_earlier_run_fails_comparison_alone(
    compared: Compared, tmp_path: Path, harm: Callable[[Path], None], reason: str
) -> None:
    harm(tmp_path / "runs" / "may")
    line = absent(compared[1])
    assert line.startswith(f"no comparison with an earlier dive: {reason}")
    assert f"change.earlier = {EARLIER}" in line
    assert str(tmp_path) not in line


def test_once_the_earlier_run_is_back_the_chapter_is_too(
    compared: Compared, tmp_path: Path
) -> None:
    shutil.move(tmp_path / "runs" / "may", tmp_path / "apart")
    absent(compared[1])
    shutil.move(tmp_path / "apart", tmp_path / "runs" / "may")
    compared[1].run()
    assert compared[1].summary() == {"inputs": ["change", "detect", "ingest"], "absent": {}}


def test_a_dive_is_not_compared_with_itself(compared: Compared) -> None:
    second = compared[1]
    second.earlier = "../../runs/june"
    assert "that is this dive's own run" in absent(second)
    second.earlier = EARLIER
    second.run()
    assert second.summary()["absent"] == {}


def test_dive_of_another_hull_gives_a_reason_not_a_failure(compared: Compared) -> None:
    first, second = compared
    first.rewrite("ingest", lambda files: {"hull.npz": _scaled(files["hull.npz"])}, may())
    first.run()
    assert "the CAD models are of different hulls" in absent(second)


def _scaled(npz: bytes) -> bytes:
    import io

    import numpy as np

    arrays = dict(np.load(io.BytesIO(npz)))
    out = io.BytesIO()
    np.savez(out, **{**arrays, "vertices": arrays["vertices"] * 1.1})
    return out.getvalue()


def test_where_detect_failed_the_step_says_so(compared: Compared, tmp_path: Path) -> None:
    second = SimulatedDive(tmp_path, june(), EARLIER, no_detect=True)
    shutil.rmtree(second.workspace.root)
    second.run()
    assert second.summary()["absent"]["change"].startswith("it needs detect, which failed")


@pytest.mark.parametrize(
    ("earlier", "mesh", "reason"),
    [
        (None, "hull.stl", "no earlier dive is named (change.earlier)"),
        ("../may", None, "no CAD model was given"),
        ("../may", "hull.stl", None),
    ],
)  # fmt: skip
def test_step_applies_with_cad_model_and_earlier_dive(
    earlier: str | None, mesh: str | None, reason: str | None
) -> None:
    assert (
        why_no_change(
            StageSettings("change", {"change": EarlierDive(earlier=earlier), "hull.mesh": mesh}),
            Path(),
        )
        == reason
    )


def test_files_of_a_run_that_is_not_there_are_none(tmp_path: Path) -> None:
    settings = StageSettings("change", {"change": EarlierDive(earlier="x" * 999)})
    assert files_of_earlier_dive(settings, tmp_path) == []
    assert files_of_earlier_dive(StageSettings("change", {"change": EarlierDive()}), tmp_path) == []


def test_dives_farther_apart_than_hull_pose_sigmas_warn(compared: Compared, tmp_path: Path) -> None:
    from change.simulated_surveys import BEFORE, SIGMAS, Errors, survey

    far = survey(BEFORE, Errors(pose=SIGMAS * [0, 9, 0, 0, 0, 0], seed=4), name="june")
    second = SimulatedDive(tmp_path, far, EARLIER)
    shutil.rmtree(second.workspace.root)
    warnings = second.run()["change"].manifest.warnings
    assert len(warnings) == 1
    assert "farther apart on the CAD model than their hull poses foresaw" in warnings[0]
