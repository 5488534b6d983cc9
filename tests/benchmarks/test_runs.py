# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import json

import numpy as np
import pytest
from datasets import dataset

from benchmarks import adjustment, libmv, subprocess_runner
from benchmarks.bundle import rms_px
from benchmarks.peer_hullrecon import problem_of
from benchmarks.solve_one import rigid_rmse_m
from hullrecon.errors import InputError
from hullrecon.native import Options, solve
from hullrecon.records.serialisation import to_arrays


def test_a_problem_comes_back_from_its_file(small, tmp_path):
    problem, truth = small
    subprocess_runner.save(tmp_path / "p.npz", problem, position=truth.nodes.translation)
    again = subprocess_runner.load(tmp_path / "p.npz")
    expected = to_arrays(problem)
    assert list(to_arrays(again)) == list(expected)
    for name, array in to_arrays(again).items():
        assert np.array_equal(array, expected[name]), name
    assert list(subprocess_runner.load_truth(tmp_path / "p.npz")) == ["position"]


def test_the_command_writes_a_row_for_each_method(tmp_path, capsys, monkeypatch):
    out = tmp_path / "a.json"
    monkeypatch.setattr(
        "sys.argv", ["adjustment", "--size", "small", "--threads", "1", "--json", str(out)]
    )
    assert adjustment.main() == 0
    rows = {row["method"]: row for row in json.loads(out.read_text())["methods"]}
    assert list(rows) == ["naive", "geva", "maxmix"]
    asked = {
        "method",
        "total_s",
        "iterations",
        "final_cost",
        "peak_rss_mb",
        "seconds_by_part",
        "rigid_rmse_m",
    }
    assert all(asked <= set(row) for row in rows.values())
    assert rows["maxmix"]["labels_wrong"] < 0.01
    assert rows["maxmix"]["rigid_rmse_m"] < 0.3 * rows["maxmix"]["start_rmse_m"]
    assert capsys.readouterr().out.count("iterations") == 3


def test_equal_iterations_are_equal(tmp_path, monkeypatch):
    out = tmp_path / "a.json"
    arguments = [
        "--size",
        "small",
        "--threads",
        "1",
        "--same-iterations",
        "3",
        "--repeat",
        "2",
        "--json",
        str(out),
    ]
    monkeypatch.setattr("sys.argv", ["adjustment", *arguments])
    adjustment.main()
    found = json.loads(out.read_text())
    assert [(row["method"], row["iterations"]) for row in found["runs"]] == 2 * [
        ("naive", 3),
        ("maxmix", 3),
    ]
    assert found["maxmix_over_naive"]["iteration_s"] > 0


def test_the_run_of_median_time_stands_for_a_method():
    rows = [
        {"method": m, "total_s": s}
        for m, s in [("a", 3.0), ("b", 1.0), ("a", 1.0), ("b", 2.0), ("a", 2.0), ("b", 9.0)]
    ]
    assert adjustment.medians(rows) == [
        {"method": "a", "total_s": 2.0},
        {"method": "b", "total_s": 2.0},
    ]


def test_a_failing_process_says_why():
    with pytest.raises(RuntimeError, match="No module named"):
        subprocess_runner.call("benchmarks.nothing")


def test_a_rigid_motion_and_nothing_else_is_taken_off():
    points = np.random.default_rng(0).normal(size=(50, 3))
    moved = points @ np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]]) + [1, 2, 3]
    assert rigid_rmse_m(moved, points) < 1e-12
    assert rigid_rmse_m(1.1 * points, points) > 0.05


@pytest.mark.parametrize(
    ("number", "sizes", "rms"), [(1, (333, 26), 0.92192863), (3, (500, 37), 0.21950205)]
)
def test_a_libmv_problem_ends_where_plain_ceres_and_gtsam_end(number, sizes, rms):
    bundle = libmv.read(dataset("ba-small") / f"libmv_problem_0{number}.bin")
    assert (len(bundle.pose), len(bundle.point)) == sizes
    options = Options(
        method="naive",
        huber_stereo=np.inf,
        huber_mono=np.inf,
        function_tolerance=1e-14,
        max_iterations=30,
    )
    found = solve(problem_of(bundle), options).unknowns
    assert rms_px(bundle, found.pose[:, :7], found.landmark) == pytest.approx(rms, rel=5e-7)


def test_another_kind_of_file_is_refused(tmp_path):
    path = tmp_path / "x.bin"
    path.write_bytes(b"VP" + bytes(100))
    with pytest.raises(InputError, match="little-endian"):
        libmv.read(path)
