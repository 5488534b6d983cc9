# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hullrecon.evaluation.truth import Truth, read_truth
from hullrecon.geometry.frames import Frame
from hullrecon.geometry.poses import Poses, from_rpy
from hullrecon.records.links import NodePairs
from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import VehicleTrack
from hullrecon.studies.paths.link_plots import (
    LinkedBy,
    error_ellipses,
    horizontal_sigma,
    in_hull,
    links_on_hull,
    path_length,
    sigma_along_path,
    two_view_models,
)


@pytest.fixture(scope="module")
def truth(package: Path) -> Truth:
    return read_truth(package)


@pytest.fixture
def track(solution: Solution) -> VehicleTrack:
    """The true path in g, with a sigma along x that grows to 0.4 m."""
    n = len(solution.t_ns)
    covariance = np.zeros((n, 6, 6))
    covariance[:, 0, 0] = np.linspace(0, 0.4, n) ** 2
    covariance[:, 2, 2] = 9.0
    return VehicleTrack(
        t_ns=solution.t_ns,
        poses=solution.global_from_vehicle,
        tray=solution.tray,
        covariance=covariance,
        image=solution.image,
        frame=Frame.GLOBAL,
    )


def drifted(track: VehicleTrack, to_m: float) -> VehicleTrack:
    """The path off by that much along x at its end."""
    shift = np.outer(np.linspace(0, to_m, len(track.t_ns)), [1.0, 0.0, 0.0])
    return replace(track, poses=Poses(track.poses.quaternion, track.poses.translation + shift))


def pairs() -> NodePairs:
    """Four: a neighbour, two across legs of which one was contradicted, one that gave nothing."""
    return NodePairs(
        first=np.array([0, 1, 2, 3]),
        second=np.array([1, 30, 33, 35]),
        across=np.array([False, True, True, True]),
        overlap=np.full(4, 0.5),
        round=np.array([0, 1, 1, 1]),
        putative=np.full(4, 50),
        reason=np.array([0, 0, 0, 2]),
        rejected=np.array([False, False, True, False]),
    )


def table(csv: str) -> list[list[str]]:
    return [line.split(",") for line in csv.splitlines()]


def test_the_sigma_is_that_over_the_ground_and_its_end_is_said(track: VehicleTrack) -> None:
    np.testing.assert_allclose(horizontal_sigma(track), np.linspace(0, 0.4, len(track.t_ns)))
    figure = sigma_along_path(
        {"dead reckoned": track, "with links": replace(track, covariance=0.01 * track.covariance)}
    )
    rows = table(figure.csv)
    assert rows[0] == ["path_m", "dead_reckoned_m", "with_links_m"]
    assert [float(x) for x in rows[-1][1:]] == pytest.approx([0.4, 0.04])
    assert "dead reckoned 400 mm, with links 40 mm" in figure.caption
    assert float(rows[-1][0]) == pytest.approx(path_length(track.poses.translation)[-1], abs=1e-3)


def test_a_path_is_laid_where_it_begins_truly(track: VehicleTrack, truth: Truth) -> None:
    true = truth.vehicle_at(track.t_ns / 1e9)
    turned = from_rpy([7.0, -3.0, 0.0], [0.0, 0.0, 0.6])
    for known in (track, replace(track, poses=turned @ track.poses)):
        np.testing.assert_allclose(in_hull(known, truth).translation, true.translation, atol=1e-6)


def test_links_are_counted_by_kind_and_both_errors_said(track: VehicleTrack, truth: Truth) -> None:
    figure = links_on_hull(drifted(track, 0.3), track, pairs(), truth)
    assert "1 between neighbours, 1 across legs, 1 contradicted, left out" in figure.caption
    rms_mm = 300 * np.sqrt(np.mean(np.linspace(0, 1, len(track.t_ns)) ** 2))
    assert f"{rms_mm:.3g} mm dead reckoned" in figure.caption
    assert table(figure.csv)[3] == ["2", "33", "1", "0", "1"]


def test_an_ellipse_holds_three_sigmas_in_the_axes_of_the_hull(
    track: VehicleTrack, truth: Truth
) -> None:
    turned = replace(track, poses=from_rpy([0.0, 0.0, 0.0], [0.0, 0.0, np.pi / 2]) @ track.poses)
    last = np.array([len(track.t_ns) - 1])
    # turned, the sigma along g's x lies along another axis of the hull
    for known, across in ((track, 1), (turned, 0)):
        placed = in_hull(known, truth)
        outline = error_ellipses(known, placed, last)[0] - placed.translation[last, :2]
        reach = np.abs(outline).max(axis=0)
        assert reach[1 - across] == pytest.approx(1.2, rel=1e-6)
        assert reach[across] == pytest.approx(0.0, abs=1e-6)


def test_each_model_has_its_pairs_and_errors(track: VehicleTrack, truth: Truth) -> None:
    paths = {
        "essential": LinkedBy(track=drifted(track, 0.5), joined=7),
        "automatic": LinkedBy(track=track, joined=12),
    }
    figure = two_view_models(paths, truth)
    rows = {row[0]: [float(x) for x in row[1:]] for row in table(figure.csv)[1:]}
    assert rows["automatic"] == pytest.approx([12, 0, 0], abs=1e-5)
    assert rows["essential"][0] == 7
    assert rows["essential"][1] > rows["essential"][2] > 0.05
    assert "automatic" in figure.caption


def test_a_path_that_nothing_ties_is_drawn_without_a_link(
    track: VehicleTrack, truth: Truth
) -> None:
    none = np.zeros(0, np.int64)
    empty = NodePairs(
        first=none,
        second=none,
        across=none.astype(bool),
        overlap=np.zeros(0),
        round=none,
        putative=none,
        reason=none,
        rejected=none.astype(bool),
    )
    figure = links_on_hull(drifted(track, 0.3), track, empty, truth)
    assert "0 between neighbours, 0 across legs" in figure.caption
    assert figure.csv.splitlines() == ["first,second,across,joined,rejected"]


@pytest.mark.usefixtures("pictures")
def test_figures_are_pictures_and_deterministic(track: VehicleTrack, truth: Truth) -> None:
    def draw() -> list[bytes]:
        off = drifted(track, 0.3)
        paths = {"automatic": LinkedBy(track=track, joined=12)}
        figures = (
            sigma_along_path({"dead reckoned": off}),
            links_on_hull(off, track, pairs(), truth),
            two_view_models(paths, truth),
        )
        return [figure.png for figure in figures]

    first = draw()
    assert all(png[:4] == b"\x89PNG" for png in first)
    assert draw() == first
