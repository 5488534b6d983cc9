# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""`study methods` and `study figures`; the chain is a short one whose adjust knows the truth."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from hullrecon_cli.commands import study
from msgspec import Struct

from hullrecon.api.dive_run import DiveRun
from hullrecon.artifacts.chain import Chain
from hullrecon.artifacts.stage import Context, Stage
from hullrecon.artifacts.workspace import Workspace
from hullrecon.dive.config.schema import Dvl, Tray
from hullrecon.errors import InputError
from hullrecon.records.serialisation import to_arrays
from hullrecon.records.solution import Solution
from hullrecon.records.trajectory import Returns, Trajectory
from hullrecon.studies import compare_methods
from hullrecon.studies.methods import adjust_variant
from hullrecon.studies.methods.variants import read_dead_reckoning, read_objects, read_solutions
from hullrecon.studies.scenes import scene_figures as scenes


class Nothing(Struct, frozen=True, kw_only=True):
    """No parameters."""


class Options(Struct, frozen=True, kw_only=True):
    rounds: int = 3
    max_iterations: int = 60


class Method(Options, frozen=True, kw_only=True):
    method: str = "maxmix"
    as_published: bool = False


@pytest.fixture
def opened(
    package: Path,
    solution: Solution,
    returns: Returns,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> Callable[..., DiveRun]:
    """A dive whose chain is navigate and adjust; the calls of adjust are counted in `calls`."""

    def navigate(context: Context) -> None:
        n = len(solution.t_ns)
        path = Trajectory(
            t_ns=solution.t_ns,
            quaternion=solution.global_from_vehicle.quaternion,
            translation=solution.global_from_vehicle.translation,
            covariance=np.zeros((n, 6, 6)),
            tray=solution.tray,
            image=solution.image,
        )
        context.out.arrays("trajectory.npz", to_arrays(path))
        context.out.arrays("returns.npz", to_arrays(returns))

    def adjust(context: Context) -> None:
        p = context.parameters
        as_published = getattr(p, "as_published", False)
        calls.append((getattr(p, "method", "maxmix"), as_published))
        rounds.append((as_published, p.rounds, p.max_iterations))
        context.out.arrays("solution.npz", to_arrays(solution))
        context.out.arrays("iterations.npz", record)
        context.out.json("adjust.json", {"registration": {"T_g_M": [1, 2, 3, 0, 0, 0, 1]}})
        context.record_times("iterations_s", [0.5, 1.0, 1.5])

    stages = (
        Stage("navigate", "walk", (), Nothing, 1, navigate),
        Stage("adjust", "solve", ("navigate",), Options, 1, adjust),
    )
    variant = Stage("adjust", "solve", ("navigate",), Method, 1, adjust)
    monkeypatch.setattr(adjust_variant, "STAGE", variant)
    monkeypatch.setattr(adjust_variant, "VariantOptions", Method)
    tray = Tray(origin=(0.45, 0.0, 0.1))
    sections = {
        "navigate": Nothing(),
        "adjust": Options(),
        "tray": tray,
        "dvl": Dvl(mount=(0, 0, 0.08, 0, 90, 0)),
    }
    calls: list[tuple[str, bool]] = []
    rounds: list[tuple[bool, int, int]] = []
    count = np.full(3, len(solution.landmarks))
    record = {
        "cost": np.array([4.0, 2.0, 1.0]),
        "on_surface": count - [20, 0, 0],
        "landmarks": count,
        "round": np.ones(3, int),
    }
    record |= {"accepted": np.ones(3, bool), "label_changes": np.array([0, 20, 0])}
    dive = DiveRun("wall", Chain(stages, sections, package), Workspace(tmp_path / "runs" / "wall"))

    def open_dive(*_: Any, **__: Any) -> DiveRun:
        return dive

    open_dive.calls = calls  # type: ignore[attr-defined]
    open_dive.rounds = rounds  # type: ignore[attr-defined]
    return open_dive


def call(command: Any, *arguments: object) -> Any:
    return CliRunner().invoke(command, [str(a) for a in arguments], catch_exceptions=False)


def test_compare_solves_six_times_and_prints_one_table(
    opened: Any, package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study, "open_dive", opened)
    lines = call(study.methods, package).stdout.splitlines()
    assert len(opened.calls) == 6
    assert set(opened.calls) == {(m, p) for m in ("naive", "geva", "maxmix") for p in (True, False)}
    table = lines[-7:]
    assert table[0].startswith("method")
    assert [line.split("  ")[0] for line in table[1:4]] == [
        "naive as published",
        "geva as published",
        "maxmix as published",
    ]


def test_compare_again_solves_nothing(
    opened: Any, package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study, "open_dive", opened)
    call(study.methods, package)
    opened.calls.clear()
    call(study.methods, package)
    assert opened.calls == []


def test_as_printed_is_one_whole_solve(
    opened: Any, package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study, "open_dive", opened)
    call(study.methods, package)
    assert set(opened.rounds) == {(True, 1, 200), (False, 3, 60)}


def test_what_the_chain_solves_itself_stands_in_its_own_place(
    opened: Any, package: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study, "open_dive", opened)
    call(study.methods, package)
    root = opened().workspace.root
    assert (root / "adjust" / "solution.npz").exists()
    assert (root / "compare" / "maxmix-as-published" / "adjust" / "solution.npz").exists()
    assert not (root / "compare" / "maxmix-as-weighted-by-us").exists()


@pytest.mark.usefixtures("pictures")
def test_figures_solves_and_leaves_pictures_and_tables(
    opened: Any, package: Path, scene_figures: list, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study, "open_dive", opened)
    monkeypatch.setattr(scenes, "draw_scene_figures", lambda: scene_figures)
    # a log that another test set up goes to standard error
    printed = call(study.figures, package).stdout.splitlines()
    assert len(opened.calls) == 6
    names = [Path(line.split(": ", 1)[0]).stem for line in printed]
    assert names[-3:] == ["gic_by_relief", "search_ellipses", "sphere"]
    assert len(printed) == 5 + 3
    for line in printed:
        name, words = line.split(": ", 1)
        assert Path(name).read_bytes()[:4] == b"\x89PNG"
        assert len(Path(name).with_suffix(".csv").read_text().splitlines()) > 1
        assert words.endswith(".")


def test_figures_after_compare_solves_nothing(
    opened: Any, package: Path, scene_figures: list, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study, "open_dive", opened)
    monkeypatch.setattr(scenes, "draw_scene_figures", lambda: scene_figures)
    call(study.methods, package)
    opened.calls.clear()
    call(study.figures, package)
    assert opened.calls == []


def test_a_variant_that_is_not_there_says_what_to_run(opened: Any) -> None:
    with pytest.raises(InputError, match="hullrecon study methods"):
        read_solutions(opened())


def test_solutions_are_read_back_with_times(opened: Any, solution: Solution) -> None:
    dive = opened()
    with pytest.raises(InputError):
        read_solutions(dive)
    compare_methods(dive)
    found = {v.name: v for v in read_solutions(dive)}
    ours, published = found["geva as weighted by us"], found["geva as published"]
    assert (ours.as_published, published.as_published) == (False, True)
    assert ours.iterations_s.tolist() == [0.5, 1.0, 1.5]
    assert ours.registered is not None
    assert ours.registered.translation.tolist() == [[1, 2, 3]]
    assert ours.chart is None
    read_back, written = to_arrays(ours.solution), to_arrays(solution)
    assert read_back.keys() == written.keys()
    for name, values in written.items():
        np.testing.assert_array_equal(read_back[name], values)


def test_dead_reckoning_has_the_rig_of_the_package(opened: Any, returns: Returns) -> None:
    dive = opened()
    compare_methods(dive)
    start = read_dead_reckoning(dive)
    np.testing.assert_array_equal(start.rig.tray_origin, [0.45, 0.0, 0.1])
    np.testing.assert_allclose(start.rig.tray_from_dvl.translation, [[0, 0, 0.08]])
    assert start.returns is not None
    np.testing.assert_array_equal(start.returns.range_m, returns.range_m)


def test_a_dive_without_detect_delivers_no_objects(opened: Any) -> None:
    assert read_objects(opened()) == ()
