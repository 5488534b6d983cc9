# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hullrecon.evaluation.truth import Truth, read_truth
from hullrecon.records.deliverables import ReportedObject
from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import Returns, Trajectory
from hullrecon.rig import Rig
from hullrecon.studies.methods.comparison import (
    DeadReckoning,
    SolvedVariant,
    compare_solutions,
    comparison_table,
)
from hullrecon.studies.methods.figures import draw_method_figures
from hullrecon.studies.methods.sections import cut_section, cut_whole_hull


def move_landmarks(solution: Solution, position: np.ndarray) -> Solution:
    return replace(solution, landmarks=replace(solution.landmarks, position=position))


def without_landmarks(solution: Solution) -> Solution:
    return replace(
        solution,
        landmarks=replace(
            solution.landmarks, position=np.zeros((0, 3)), label=np.zeros(0, np.int64)
        ),
    )


@pytest.fixture(scope="module")
def truth(package: Path) -> Truth:
    return read_truth(package)


@pytest.fixture
def start(solution: Solution, returns: Returns, rig: Rig) -> DeadReckoning:
    n = len(solution.t_ns)
    path = solution.global_from_vehicle.translation + np.outer(np.linspace(0, 0.1, n), [1, 1, 0])
    reckoned = Trajectory(
        t_ns=solution.t_ns,
        quaternion=solution.global_from_vehicle.quaternion,
        translation=path,
        covariance=np.zeros((n, 6, 6)),
        tray=solution.tray,
        image=solution.image,
    )
    return DeadReckoning(trajectory=reckoned, returns=returns, rig=rig)


@pytest.fixture
def solved(solution: Solution) -> list[SolvedVariant]:
    """geva squashes the block, naive leaves the landmarks 3 cm off the DVL's surface, maxmix does
    neither.
    """
    flat = solution.landmarks.position.copy()
    flat[:, 1] = np.minimum(flat[:, 1], 2.02)
    off = np.add(solution.landmarks.position, [0, 0.03, 0])
    count = np.full(4, len(solution.landmarks))
    record = {
        "cost": np.array([9.0, 3.0, 8.0, 2.0]),
        "on_surface": np.array([300, 390, 395, 400]),
        "landmarks": count,
    }
    record |= {"round": np.array([1, 1, 2, 2]), "accepted": np.array([True, True, True, True])}
    record |= {"label_changes": np.array([0, 90, 0, 5])}
    made = {"naive": off, "geva": flat, "maxmix": solution.landmarks.position}
    return [
        SolvedVariant(
            method=m,
            weighting=w,
            solution=move_landmarks(solution, made[m]),
            iterations=record,
            seconds=6.0,
            iterations_s=np.array([1.0, 2.0, 4.0, 6.0]),
        )
        for w in ("as published", "as weighted by us")
        for m in made
    ]


def test_the_table_shows_what_each_method_does(
    solved: list[SolvedVariant], start: DeadReckoning, truth: Truth
) -> None:
    figures = compare_solutions(solved, start, truth)
    assert list(figures)[:3] == ["naive as published", "geva as published", "maxmix as published"]
    assert figures["geva as published"]["heights"]["ratio_median"] < 0.2
    assert figures["naive as published"]["gap"]["median_m"] == pytest.approx(0.03, abs=1e-3)
    assert figures["maxmix as published"]["heights"]["ratio_median"] == pytest.approx(1, abs=0.01)
    assert figures["maxmix as published"]["gap"]["median_m"] == pytest.approx(0, abs=1e-3)


def test_lengths_are_in_millimetres_and_missing_figures_a_dash(
    solved: list[SolvedVariant], start: DeadReckoning, truth: Truth
) -> None:
    figures = compare_solutions(solved, start, truth)
    del figures["maxmix as published"]["cameras"]
    heads, rows = comparison_table(figures)
    gap, cameras = heads.index("to DVL, mm"), heads.index("cameras, mm")
    assert float(rows[0][gap]) == pytest.approx(30, abs=1)
    assert rows[2][cameras] == "-"
    assert all(len(row) == len(heads) for row in rows)
    # of the round with the CAD model, as the source counts; its start is no iteration
    assert rows[0][-1] == "1"


@pytest.mark.usefixtures("pictures")
def test_all_of_the_sources_figures_are_drawn(
    solved: list[SolvedVariant], start: DeadReckoning, truth: Truth
) -> None:
    names = [figure.name for figure in draw_method_figures(solved, start, truth, ())]
    assert names == [
        "cost_history",
        "label_frequency",
        "cross_sections",
        "structure_height",
        "range_residuals",
    ]


def test_without_returns_or_landmarks_their_figures_are_left_out(
    solved: list[SolvedVariant], start: DeadReckoning, truth: Truth
) -> None:
    bare = [replace(s, solution=without_landmarks(s.solution)) for s in solved]
    assert [f.name for f in draw_method_figures(bare, replace(start, returns=None), truth, ())] == [
        "cost_history"
    ]


def test_dead_reckoned_residuals_are_wider_than_adjusted_ones(
    solved: list[SolvedVariant], start: DeadReckoning, truth: Truth
) -> None:
    figure = next(
        f for f in draw_method_figures(solved, start, truth, ()) if f.name == "range_residuals"
    )
    table = [line.split(",") for line in figure.csv.splitlines()]
    spread = [np.count_nonzero([float(row[k]) for row in table[1:]]) for k in (1, 2)]
    assert spread[0] > spread[1]


def test_a_section_keeps_what_lies_in_its_slice(solution: Solution, truth: Truth) -> None:
    landmarks = solution.landmarks.position - [1, 2, 3]
    section = cut_section(
        ("maxmix", "x"),
        truth.structures()[0],
        landmarks,
        solution.landmarks.label == 1,
        landmarks,
        truth,
    )
    assert len(section.off) > 20
    np.testing.assert_allclose(section.off[:, 1], 0.1, atol=1e-9)
    assert np.abs(section.off[:, 0]).max() <= 0.1
    assert len(section.on) == 0  # the wall's landmarks begin half a metre away
    assert section.steel[:, 1].max() == pytest.approx(0.1, abs=1e-5)
    np.testing.assert_allclose(section.cad_model[:, 1], -0.012, atol=1e-5)


def test_the_delivered_height_stands_beside_the_landmarks(
    solved: list[SolvedVariant], start: DeadReckoning, truth: Truth
) -> None:
    block = ReportedObject(
        center=(1.02, 0.11, 0.0), height=0.104, height_sigma=0.006, views=9, area=0.09
    )
    elsewhere = replace(block, center=(4.0, 0.02, 0.0), height=0.3)
    figure = next(
        f
        for f in draw_method_figures(solved, start, truth, [elsewhere, block])
        if f.name == "structure_height"
    )
    assert "delivered,0.10400,0.00600" in figure.csv
    assert "0.104 m with a sigma of 0.006 m from 9 images" in figure.caption


def test_an_overview_is_the_slice_across_the_whole_hull(solution: Solution, truth: Truth) -> None:
    landmarks = solution.landmarks.position - [1, 2, 3]
    seen = cut_whole_hull(
        truth.structures()[0], landmarks, solution.landmarks.label == 1, landmarks, truth
    )
    assert len(seen.off) > 20
    assert len(seen.on) == 0
    np.testing.assert_allclose(seen.off[:, 0], 0.112, atol=1e-9)
    np.testing.assert_allclose(seen.cad_model[:, 0], 0.0, atol=1e-5)
    assert np.ptp(seen.cad_model[:, 1]) > 1.5
