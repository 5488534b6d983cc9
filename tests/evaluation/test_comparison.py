# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import json
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hullrecon.errors import InputError
from hullrecon.evaluation.comparison.comparison import Reckoned, Solved, compare, read_reckoned, read_solved, table_rows
from hullrecon.evaluation.figures.figures import draw
from hullrecon.evaluation.figures.sections import cut, whole
from hullrecon.evaluation.scoring.truth import Truth, read_truth
from hullrecon.geometry.poses import pose_from_vector
from hullrecon.records.serialisation import to_arrays
from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import Returns, Trajectory

NOWHERE = Path("no such artifact")


@pytest.fixture(scope="module")
def truth(package: Path) -> Truth:
    return read_truth(package)


@pytest.fixture
def start(solution: Solution, returns: Returns) -> Reckoned:
    n = len(solution.t_ns)
    path = solution.translation + np.outer(np.linspace(0, 0.1, n), [1, 1, 0])
    reckoned = Trajectory(
        t_ns=solution.t_ns,
        quaternion=solution.quaternion,
        translation=path,
        covariance=np.zeros((n, 6, 6)),
        tray=solution.tray,
        image=solution.image,
    )
    return Reckoned(reckoned, returns, np.array([0.45, 0.0, 0.1]), pose_from_vector(solution.T_s_d))


@pytest.fixture
def solved(solution: Solution) -> list[Solved]:
    """geva squashes the block, naive leaves the landmarks 3 cm off the DVL's surface, maxmix does neither."""
    flat = solution.landmark.copy()
    flat[:, 1] = np.minimum(flat[:, 1], 2.02)
    off = np.add(solution.landmark, [0, 0.03, 0])
    count = np.full(4, len(solution.landmark))
    record = {"cost": np.array([9.0, 3.0, 8.0, 2.0]), "on_surface": np.array([300, 390, 395, 400]), "landmarks": count}
    record |= {"round": np.array([1, 1, 2, 2]), "accepted": np.array([True, True, True, True])}
    record |= {"label_changes": np.array([0, 90, 0, 5])}
    made = {"naive": off, "geva": flat, "maxmix": solution.landmark}
    return [
        Solved(m, w, replace(solution, landmark=made[m]), record, 6.0, np.array([1.0, 2.0, 4.0, 6.0]))
        for w in ("as printed", "as weighted by us")
        for m in made
    ]


def test_the_table_shows_what_each_method_does(solved: list[Solved], start: Reckoned, truth: Truth) -> None:
    figures = compare(solved, start, truth)
    assert list(figures)[:3] == ["naive as printed", "geva as printed", "maxmix as printed"]
    assert figures["geva as printed"]["heights"]["ratio_median"] < 0.2
    assert figures["naive as printed"]["gap"]["median_m"] == pytest.approx(0.03, abs=1e-3)
    assert figures["maxmix as printed"]["heights"]["ratio_median"] == pytest.approx(1, abs=0.01)
    assert figures["maxmix as printed"]["gap"]["median_m"] == pytest.approx(0, abs=1e-3)


def test_lengths_are_in_millimetres_and_missing_figures_a_dash(solved: list[Solved], start: Reckoned, truth: Truth) -> None:
    figures = compare(solved, start, truth)
    del figures["maxmix as printed"]["cameras"]
    heads, rows = table_rows(figures)
    gap, cameras = heads.index("to DVL, mm"), heads.index("cameras, mm")
    assert float(rows[0][gap]) == pytest.approx(30, abs=1)
    assert rows[2][cameras] == "-"
    assert all(len(row) == len(heads) for row in rows)
    assert rows[0][-1] == "2"  # the starts of two rounds are no iterations


def test_all_of_the_sources_figures_are_drawn(solved: list[Solved], start: Reckoned, truth: Truth) -> None:
    names = [figure.name for figure in draw(solved, start, truth, NOWHERE)]
    assert names == ["cost_history", "label_frequency", "cross_sections", "structure_height", "range_residuals"]


def test_without_returns_or_landmarks_their_figures_are_left_out(solved: list[Solved], start: Reckoned, truth: Truth) -> None:
    bare = [replace(s, solution=replace(s.solution, landmark=np.zeros((0, 3)), label=np.zeros(0, np.int64))) for s in solved]
    assert [f.name for f in draw(bare, replace(start, returns=None), truth, NOWHERE)] == ["cost_history"]


def test_dead_reckoned_residuals_are_wider_than_adjusted_ones(solved: list[Solved], start: Reckoned, truth: Truth) -> None:
    figure = next(f for f in draw(solved, start, truth, NOWHERE) if f.name == "range_residuals")
    table = [line.split(",") for line in figure.csv.splitlines()]
    spread = [np.count_nonzero([float(row[k]) for row in table[1:]]) for k in (1, 2)]
    assert spread[0] > spread[1]


def test_a_section_keeps_what_lies_in_its_slice(solution: Solution, truth: Truth) -> None:
    landmarks = solution.landmark - [1, 2, 3]
    section = cut(("maxmix", "x"), truth.structures()[0], landmarks, solution.label == 1, landmarks, truth)
    assert len(section.off) > 20
    np.testing.assert_allclose(section.off[:, 1], 0.1, atol=1e-9)
    assert np.abs(section.off[:, 0]).max() <= 0.1
    assert len(section.on) == 0  # the wall's landmarks begin half a metre away
    assert section.steel[:, 1].max() == pytest.approx(0.1, abs=1e-5)
    np.testing.assert_allclose(section.cad_model[:, 1], -0.012, atol=1e-5)


def save(folder: Path, **members: Any) -> None:
    folder.mkdir(exist_ok=True)
    for name, arrays in members.items():
        np.savez(folder / f"{name}.npz", **arrays)


def test_artifacts_are_read_back(solution: Solution, start: Reckoned, tmp_path: Path) -> None:
    save(tmp_path / "adjust", solution=to_arrays(solution), iterations={"cost": np.ones(3)})
    found = read_solved("geva", "as printed", tmp_path / "adjust", {"seconds": 2.5, "times": {"iterations_s": [0, 1, 2]}})
    assert found.name == "geva as printed"
    assert found.printed
    assert found.seconds == 2.5
    assert found.iterations_s.tolist() == [0, 1, 2]
    assert found.registered is None
    for field in fields(Solution):
        np.testing.assert_array_equal(getattr(found.solution, field.name), getattr(solution, field.name))
    save(tmp_path / "navigate", trajectory=to_arrays(start.trajectory))
    assert read_reckoned(tmp_path / "navigate", [0.45, 0, 0.1], start.T_s_d).returns is None


def test_where_the_registration_put_the_hull_is_read_back(solution: Solution, tmp_path: Path) -> None:
    save(tmp_path / "adjust", solution=to_arrays(solution), iterations={"cost": np.ones(3)})
    (tmp_path / "adjust" / "adjust.json").write_text('{"registration": {"T_g_M": [1, 2, 3, 0, 0, 0, 1]}}')
    found = read_solved("geva", "as weighted by us", tmp_path / "adjust", {"seconds": 1})
    assert found.registered is not None
    assert found.registered.tolist() == [1, 2, 3, 0, 0, 0, 1]
    assert not found.printed


def test_the_delivered_height_stands_beside_the_landmarks(
    solved: list[Solved], start: Reckoned, truth: Truth, tmp_path: Path
) -> None:
    block = {"center": [1.02, 0.11, 0.0], "height": 0.104, "height_sigma": 0.006, "views": 9, "area": 0.09}
    stray = {**block, "center": [4.0, 0.02, 0.0], "height": 0.3}
    (tmp_path / "objects.json").write_text(json.dumps({"objects": [stray, block]}))
    figure = next(f for f in draw(solved, start, truth, tmp_path) if f.name == "structure_height")
    assert "delivered,0.10400,0.00600" in figure.csv
    assert "0.104 m with a sigma of 0.006 m from 9 images" in figure.words


def test_an_overview_is_the_slice_across_the_whole_hull(solution: Solution, truth: Truth) -> None:
    landmarks = solution.landmark - [1, 2, 3]
    seen = whole(truth.structures()[0], landmarks, solution.label == 1, landmarks, truth)
    assert len(seen.off) > 20
    assert len(seen.on) == 0
    np.testing.assert_allclose(seen.off[:, 0], 0.112, atol=1e-9)
    np.testing.assert_allclose(seen.cad_model[:, 0], 0.0, atol=1e-5)
    assert np.ptp(seen.cad_model[:, 1]) > 1.5


def test_a_missing_artifact_says_what_to_run(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="hullrecon compare"):
        read_solved("geva", "as printed", tmp_path, {"seconds": 0.0})
