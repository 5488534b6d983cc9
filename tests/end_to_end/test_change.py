# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Two simulated dives of one hull, run and compared: three objects added, one removed, one grown by
3 cm. The second dive names the first, and every sentence of its report's chapter on change is held
against the truth.
"""

from __future__ import annotations

import csv
import io
import json
import re
from dataclasses import dataclass
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from end_to_end.json_schema import violations
from end_to_end.shell import COARSE, Shell
from scipy.spatial.transform import Rotation

from benchmarks.change import (
    SMALLEST,
    Truth,
    reported_from_true,
    run_both,
    score,
    simulate,
    structures,
    true_changes,
)
from hullrecon.api.change import RunComparison
from hullrecon.evaluation.truth import read_truth
from hullrecon.geometry.frames import Camera
from hullrecon.steps.artifacts import SurfaceArtifact

pytestmark = pytest.mark.slow
SEED = 1
SIZE = {**SMALLEST, "leg_length_m": 3.0}


@dataclass(frozen=True, kw_only=True)
class Compared:
    """Both packages, what `diff` says of their runs, and the second dive's deliverables, in which
    it was compared too.
    """

    first: Path
    second: Path
    by_diff: RunComparison
    deliver: Path

    @property
    def document(self) -> dict:
        return json.loads((self.deliver / "change" / "change.json").read_text())

    @property
    def truth(self) -> Truth:
        return true_changes(self.first, self.second)

    @property
    def page(self) -> str:
        """The report's HTML."""
        return (self.deliver / "report" / "index.html").read_text()

    def chapter(self) -> str:
        """The chapter's HTML."""
        (found,) = re.findall(r'<section id="change".*?</section>', self.page, re.S)
        return found


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> Compared:
    folder = tmp_path_factory.mktemp("change")
    by_diff = run_both(folder, SEED, SIZE)
    first, second = simulate(folder, SEED, SIZE)
    earlier = f"change.earlier={folder / 'runs' / first.name}"
    Shell(folder)("run", second, "--runs", "runs", "--set", earlier, *COARSE)
    deliver = folder / "runs" / second.name / "deliver"
    return Compared(first=first, second=second, by_diff=by_diff, deliver=deliver)


def words(html: str) -> str:
    return " ".join(unescape(re.sub(r"<[^>]+>", " ", html)).split())


@dataclass(frozen=True, kw_only=True)
class TrueChange:
    """What truly became of a structure: status, its place in M, heights before and after, m."""

    status: str
    place: np.ndarray
    before: float
    after: float


def true_changes_of_all(compared: Compared) -> list[TrueChange]:
    """Every structure of either dive."""
    before, after = structures(compared.first), structures(compared.second)
    found = []
    for place, height in before:
        later = [h for p, h in after if np.linalg.norm(p - place) < 0.1]
        status = "gone" if not later else "unchanged" if abs(later[0] - height) < 1e-6 else "grown"
        found.append(
            TrueChange(status=status, place=place, before=height, after=later[0] if later else 0.0)
        )
    for place, height in after:
        if all(np.linalg.norm(p - place) >= 0.1 for p, _ in before):
            found.append(TrueChange(status="new", place=place, before=0.0, after=height))
    return found


def rows_with_truth(compared: Compared) -> list[tuple[dict, TrueChange]]:
    """Each row of change.json with the structure that it is about, matched where the first dive
    reports that.
    """
    placed = reported_from_true(compared.by_diff.first.survey, compared.first)
    truth = true_changes_of_all(compared)
    there = placed.apply(np.array([entry.place for entry in truth]))
    rows = compared.document["objects"]
    nearest = [int(np.argmin(np.linalg.norm(there - row["center"], axis=1))) for row in rows]
    assert sorted(nearest) == list(range(len(truth)))
    return [(row, truth[k]) for row, k in zip(rows, nearest, strict=True)]


def placed_by_cameras(
    run: Path, package: Path, center: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Where a dive puts what its cameras saw, beside the truth in M: shift (3,) m at a center, turn
    (3,) rad. The vehicle tells less, for the camera's mount is estimated.
    """
    import pycolmap

    truth, shifts, turns = read_truth(package), [], []
    for image in pycolmap.Reconstruction(str(run / "adjust" / "colmap")).images.values():
        if image.name.startswith(Camera.TOP.key):
            row = np.argmin(np.abs(truth.t_s - int(Path(image.name).stem) * 1e-9))
            true = truth.cameras_at(np.array([row]))
            camera_from_hull = image.cam_from_world().matrix()
            turn = camera_from_hull[:, :3].T @ true.rotation.as_matrix()[0].T
            shifts.append(
                turn @ (center - true.translation[0]) + image.projection_center() - center
            )
            turns.append(Rotation.from_matrix(turn).as_rotvec())
    return np.mean(shifts, axis=0), np.mean(turns, axis=0)


def test_all_five_changes_are_found_and_nothing_else(compared: Compared) -> None:
    placed = reported_from_true(compared.by_diff.first.survey, compared.first)
    figures = score(compared.by_diff.change, compared.truth, placed)
    assert figures["found"] == 5
    assert figures["missed"] == figures["false"] == []
    grown, sigma = figures["grown_m"][0]
    assert grown == pytest.approx(0.03, abs=3 * sigma)


def test_the_second_dives_deliverables_say_the_same_as_diff(compared: Compared) -> None:
    document, change = compared.document, compared.by_diff.change
    assert (document["first"], document["second"]) == (compared.first.name, compared.second.name)
    assert [(row["status"], row["first_id"], row["second_id"]) for row in document["objects"]] == [
        (row.status, row.first_id, row.second_id) for row in change.objects
    ]
    schema = json.loads((compared.deliver / "schemas" / "change.schema.json").read_text())
    assert violations(document, schema) == []
    listed = {
        row["id"]: row
        for row in json.loads((compared.deliver / "objects.json").read_text())["objects"]
    }
    for row in document["objects"]:
        if row["second_id"] is not None:
            assert row["height_after"] == pytest.approx(
                listed[row["second_id"]]["height"], abs=1e-5
            )


def test_the_verdict_counts_what_truly_changed(compared: Compared) -> None:
    counts = {status: len(rows) for status, rows in compared.truth.items()}
    assert counts == {"new": 3, "gone": 1, "grown": 1}
    assert f"{compared.first.name} to {compared.second.name}: 3 new, 1 gone and 1 grown; " in words(
        compared.chapter()
    )
    assert f"Change since {compared.first.name}: 3 new, 1 gone and 1 grown; " in words(
        compared.page
    )


def test_each_row_is_true_within_three_of_its_sigmas(compared: Compared) -> None:
    chart = SurfaceArtifact(compared.deliver.parent / "surface").chart
    pairs = rows_with_truth(compared)
    assert len(pairs) == 7
    for row, true in pairs:
        assert row["status"] == true.status
        assert row["change"] == pytest.approx(
            true.after - true.before, abs=3 * row["change_sigma"]
        ), row
        assert row["height_before"] == pytest.approx(
            true.before, abs=3 * row["height_before_sigma"]
        ), row
        assert row["height_after"] == pytest.approx(
            true.after, abs=3 * row["height_after_sigma"]
        ), row
        along, girth = chart.to_chart(true.place[None])[0, :2]
        assert row["along"] == pytest.approx(along, abs=3 * row["sigma_along"]), row
        assert row["girth"] == pytest.approx(girth, abs=3 * row["sigma_girth"]), row
        assert row["change_sigma"] < 0.015


def test_offset_between_dives_is_true_within_its_covariance(compared: Compared) -> None:
    stated = compared.document["offset"]
    center, covariance = np.array(stated["center"]), np.array(stated["covariance"])
    runs = compared.deliver.parents[1]
    first, second = (
        placed_by_cameras(runs / p.name, p, center) for p in (compared.first, compared.second)
    )
    error = np.r_[
        stated["translation_m"] - (first[0] - second[0]),
        stated["rotation_rad"] - (first[1] - second[1]),
    ]
    beyond_chance = 22.5  # 99.9 % with six degrees of freedom
    assert error @ np.linalg.solve(covariance, error) < beyond_chance
    # To say that the dives do not differ would have been wrong, so there was something to be found.
    offset = np.r_[first[0] - second[0], first[1] - second[1]]
    assert offset @ np.linalg.solve(covariance, offset) > beyond_chance


def test_detectable_change_separates_changed_from_unchanged(
    compared: Compared,
) -> None:
    document = compared.document
    least, coverage = document["coverage"]["detectable_m"], document["coverage"]
    for row in document["objects"]:
        assert (abs(row["change"]) >= least) == (row["status"] != "unchanged")
    assert document["surface_moves"] == []
    assert (
        0.8 * coverage["first_m2"]
        < coverage["both_m2"]
        <= min(coverage["first_m2"], coverage["second_m2"])
    )


def test_the_pages_table_has_the_numbers_of_the_files(compared: Compared) -> None:
    chapter = compared.chapter()
    rows = [
        [words(cell) for cell in re.findall(r"<t[hd].*?</t[hd]>", row)]
        for row in re.findall(r"<tr><th scope=\"row\">.*?</tr>", chapter)
    ]
    written = list(
        csv.DictReader(io.StringIO((compared.deliver / "change" / "change.csv").read_text()))
    )
    assert len(rows) == len(written) == 7
    for cells, row in zip(rows, written, strict=True):
        assert cells[0] == row["status"]
        assert [cells[1], cells[2]] == [row["first_id"] or "–", row["second_id"] or "–"]
        assert cells[3] == row["address"]
        for cell, name in zip(cells[4:7], ("height_before", "height_after", "change"), strict=True):
            value, sigma = (float(text.replace("−", "-")) for text in cell.split(" ± "))
            assert value == pytest.approx(1000 * float(row[f"{name}_m"]), abs=0.51)
            assert sigma == pytest.approx(1000 * float(row[f"{name}_sigma_m"]), abs=0.51)
        assert (
            (cells[7] == "< 0.0001") == (float(row["p_value"]) < 1e-4) == (cells[0] != "unchanged")
        )
