# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""The benchmark of wrong CAD models: which there are, and that each is wrong in the way that its
name says.
"""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks import wrong_cad
from hullrecon.adjustment.problem.measurements import CadModel
from hullrecon.geometry.charts.chart import chart_for_hull
from hullrecon.geometry.poses import from_rpy
from hullrecon.synthetic.hull_shapes import ship_form, write_stl
from hullrecon.synthetic.options import Ship

MESH = ship_form(Ship())
GUESS = from_rpy([3.0, 4.0, 5.0], [0.0, 0.0, 0.7])
MODEL = CadModel(MESH, chart_for_hull(MESH), GUESS, np.ones(6), 0.02, (3.0, 1.5))
MEASURED = SimpleNamespace(
    trajectory=SimpleNamespace(
        translation=GUESS.apply(np.array([[30.0, 6.0, 2.0], [32.0, 6.0, 2.0]]))
    )
)


def changed(name: str, others: tuple[Path, ...] = ()) -> CadModel:
    return dict(wrong_cad.cases(MEASURED, MODEL, others))[name](MODEL)


def test_there_are_other_ships_stretched_ones_and_ones_too_large() -> None:
    names = list(dict(wrong_cad.cases(MEASURED, MODEL, [])))
    assert names[0] == "as given"
    assert sum(name.startswith("another ship") for name in names) >= 3
    assert sum(name.startswith("stretched in") for name in names) == 6
    assert {
        "too large by 1.05",
        "too large by 1.2",
        "feet as metres",
        "mirrored end for end",
    } <= set(names)


@pytest.mark.parametrize(
    "name", ["too large by 1.2", "stretched in beam by 1.3", "another ship (90 m)"]
)
def test_wrong_model_passes_through_the_guessed_place(name: str) -> None:
    place, model = wrong_cad.survey_center(MEASURED, MODEL), changed(name)
    assert abs(model.mesh.index.closest(place[None]).distance[0]) < 0.05


def test_a_stretched_model_is_stretched_along_one_axis() -> None:
    np.testing.assert_allclose(
        np.ptp(changed("stretched in beam by 1.3").mesh.vertices, axis=0)
        / np.ptp(MESH.vertices, axis=0),
        [1, 1.3, 1],
    )


def test_a_mesh_of_another_ship_is_scaled_to_this_one_s_length(tmp_path: Path) -> None:
    write_stl(
        tmp_path / "small.stl",
        ship_form(Ship(length_m=7.0, beam_m=1.0, depth_m=0.6, bilge_radius_m=0.2)),
    )
    model = changed("another ship (small.stl)", (tmp_path / "small.stl",))
    assert np.ptp(model.mesh.vertices[:, 0]) == pytest.approx(np.ptp(MESH.vertices[:, 0]), rel=1e-5)


def test_guess_is_wrong_by_metres_at_the_survey_only() -> None:
    model, path = (
        changed("guess 5 m and 15 deg off"),
        MEASURED.trajectory.translation.mean(axis=0)[None],
    )
    moved = model.guess.inverse().apply(path) - GUESS.inverse().apply(path)
    assert np.linalg.norm(moved) == pytest.approx(5.0, abs=1e-6)
    assert model.mesh is MODEL.mesh


def test_a_package_and_its_run_are_asked_for(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["wrong_cad", "package"])
    with pytest.raises(SystemExit):
        wrong_cad.main()
    assert "run" in capsys.readouterr().err
