# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""benchmarks.faults: a small dive survives what the bench does to it, and the bench can tell."""

from __future__ import annotations

import json
import random
from pathlib import Path

import pytest

from benchmarks import faults
from benchmarks.lasting_bytes import different_files, flip_bit

BLIND = "--cameras none --legs 1 --leg-length-m 2 --marks 0 --structures 0 --barnacles 0"


def test_a_bit_flips_and_flips_back_unseen_by_size_and_time(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(bytes(8))
    before = path.stat()
    bit = flip_bit(path, random.Random(1))
    assert sum(byte.bit_count() for byte in path.read_bytes()) == 1
    assert (path.stat().st_size, path.stat().st_mtime_ns) == (before.st_size, before.st_mtime_ns)
    flip_bit(path, random.Random(2), bit)
    assert path.read_bytes() == bytes(8)


def test_runs_are_compared_without_volatile_fields(tmp_path: Path) -> None:
    for name, seconds in (("one", 1.0), ("two", 2.0)):
        (tmp_path / name / "step").mkdir(parents=True)
        (tmp_path / name / ".hullrecon").mkdir()
        (tmp_path / name / ".hullrecon" / "lock").write_text(name)
        document = {
            "run": {"seconds": seconds},
            "seal": name,
            "outputs": {"deliver/summary.json": name, "x": "same"},
        }
        (tmp_path / name / "step" / "manifest.json").write_text(json.dumps(document))
        (tmp_path / name / "step" / "index.html").write_text(f"<p>same\n<p data-volatile>{name}")
    assert different_files(tmp_path / "one", tmp_path / "two") == []
    (tmp_path / "two" / "step" / "index.html").write_text("<p>other")
    (tmp_path / "one" / "step" / "more.txt").touch()
    assert different_files(tmp_path / "one", tmp_path / "two") == [
        "step/index.html",
        "step/more.txt",
    ]


@pytest.mark.parametrize(
    ("code", "err", "wrong"),
    [
        (6, "error: no space\n", ""),
        (1, "error: internal\n", "exit code 1, not 6"),
        (6, "Traceback\n  File\nOSError\n", "3 lines"),
        (6, "", "0 lines"),
    ],
)
def test_a_case_is_right_with_its_code_and_one_line(code: int, err: str, wrong: str) -> None:
    assert faults.judge("full", code, err, 6).wrong == wrong


@pytest.mark.slow
def test_a_small_dive_survives_every_fault(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "faults.json"
    monkeypatch.setattr(faults, "DIVE", BLIND)
    monkeypatch.setattr(faults, "LIMITS_GB", (0.5,))
    counts = ["--kills", "1", "--full", "2", "--interruptions", "1"]
    monkeypatch.setattr(
        "sys.argv",
        ["faults", str(tmp_path / "bench"), "--to", "ingest", *counts, "--json", str(out)],
    )
    assert faults.main() == 0, capsys.readouterr().out
    found = [case["fault"] for case in json.loads(out.read_text())]
    full = ("disk of", "files of at most")  # the latter where no small disk may be mounted
    kinds = ("address space of", "a bit in", "the log grows", "kill -9", full, "Ctrl-C")
    assert all(any(fault.startswith(kind) for fault in found) for kind in kinds), found
    assert sum("kill -9 in ingest" in fault for fault in found) == 1
