# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a run is predicted to cost, beside what it took, and dives that cost too much."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

import hullrecon
from benchmarks.step_costs import fit_line, measured
from hullrecon.api import dive_run
from hullrecon.api.costs import (
    QUANTITIES,
    DiveSize,
    findings_of,
    fit_together,
    predict,
    size_of_run,
)
from hullrecon.errors import InputError, StorageError
from hullrecon.steps.chain import NAMES

SAMPLE = Path(__file__).parents[2] / "sample_data" / "demo"
FACTOR = 2.0  # between prediction and measurement that is still "about"


def test_a_line_is_fitted_by_relative_errors_and_never_negative() -> None:
    assert fit_line([10, 30], [25.0, 65.0]) == pytest.approx([5, 2])
    assert fit_line([10, 30], [10.0, 40.0]) == pytest.approx([0, 1.12], rel=0.02)
    assert fit_line([20], [10.0]) == pytest.approx([0, 0.5])


def test_the_demo_takes_about_the_predicted_memory_and_disk(demo_run: Path) -> None:
    costs = {c.step: c for c in predict(size_of_run(demo_run), NAMES)}
    took = {name: measured(demo_run / name) for name in costs}
    spent = {name: row for name, row in took.items() if row is not None}
    assert set(spent) == {*NAMES} - {"change"}
    # what is said is the peak of the run: other steps' figures follow the code more loosely
    peak_mb = max(cost.memory_mb for cost in costs.values())
    assert 1 / FACTOR < peak_mb / max(row["memory_mb"] for row in spent.values()) < FACTOR
    disk_mb = sum(costs[name].disk_mb for name in spent)
    assert 1 / FACTOR < disk_mb / sum(row["disk_mb"] for row in spent.values()) < FACTOR


def test_each_step_of_a_longer_dive_takes_more() -> None:
    short, long = (predict(DiveSize(megapixels=100.0 * k, pings=200 * k), NAMES) for k in (1, 10))
    for one, ten in zip(short, long, strict=True):
        for name in QUANTITIES:
            ratio = getattr(ten, name) / getattr(one, name)
            # a step without a fixed part takes ten times as much, but for the last bits
            assert 1 < ratio <= 10.001, (one.step, name)


def test_the_sentence_names_the_step_and_says_about() -> None:
    costs = predict(DiveSize(megapixels=4000.0, pings=4000), NAMES)
    (said,) = findings_of(costs, memory_gb=1000)
    assert said.severity == "note"
    assert said.sentence.startswith("a run takes about ")
    assert max(costs, key=lambda cost: cost.memory_mb).step in said.sentence


def test_steps_that_fit_run_beside_each_other_and_their_sum_is_said() -> None:
    costs = predict(DiveSize(megapixels=300.0, pings=460), NAMES)
    mosaics = ("mosaic-optical", "mosaic-sonar")
    both_gb = sum(cost.memory_mb for cost in costs if cost.step in mosaics) / 1000
    assert fit_together(mosaics, costs, 1.01 * both_gb)
    assert not fit_together(mosaics, costs, 0.99 * both_gb)
    (said,) = findings_of(costs, 1.01 * both_gb, [mosaics])
    assert f"{both_gb:.1f} GB of memory (mosaic-optical beside mosaic-sonar)" in said.sentence


def test_a_part_of_the_dive_is_advised_only_where_that_can_heal() -> None:
    costs, part = (predict(DiveSize(megapixels=1000.0 * k, pings=1000 * k), NAMES) for k in (4, 1))
    most_gb = max(cost.memory_mb for cost in costs) / 1000
    _, tight = findings_of(costs, 0.9 * most_gb)
    assert tight.severity == "warning"
    assert "dive.from" in tight.sentence
    assert len(findings_of(part, 0.9 * most_gb)) == 1
    _, hopeless = findings_of(costs, 0.01)
    assert hopeless.severity == "error"
    assert "dive.from" not in hopeless.sentence


def test_a_dive_over_its_memory_is_refused_until_it_fits(tmp_path: Path) -> None:
    from hullrecon.api.package import check_loaded
    from hullrecon.dive.config.load import load_config
    from hullrecon.steps.chain import stages

    loaded = load_config(SAMPLE, {stage.name: stage.parameters for stage in stages()})
    checked = check_loaded(loaded, memory_gb=0.2)
    assert not checked.run_is_possible
    (reason,) = checked.reasons
    with pytest.raises(InputError) as refused:
        hullrecon.run(SAMPLE, tmp_path, last_step="navigate", jobs=1, memory_gb=0.01)
    assert "--memory" in str(refused.value)
    assert "--memory" in reason
    done = hullrecon.run(SAMPLE, tmp_path, last_step="navigate", jobs=1, memory_gb=2.0)
    assert [outcome.made for outcome in done.outcomes] == [False, True]


def test_a_disk_too_small_for_the_dive_is_refused_before_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dive_run.shutil, "disk_usage", lambda _: SimpleNamespace(free=50_000))
    with pytest.raises(StorageError, match="0 MB are free"):
        hullrecon.run(SAMPLE, tmp_path, last_step="navigate", jobs=1)
