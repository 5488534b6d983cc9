# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""benchmarks.fleet with a program that takes no time: what it measures is what it says."""

from __future__ import annotations

import sys
from pathlib import Path

from benchmarks.fleet import BREAKS, MARK, make_dives, measure

CHILD = """
import json, sys, time
from pathlib import Path
from hullrecon.api.fleet.processes import end_with_parent
end_with_parent(int(sys.argv[1]))
command, package, runs = sys.argv[4], Path(sys.argv[5]), Path(sys.argv[7])
time.sleep(0.05)
files = [package / name for name in ("hull.stl", "logs/imu.csv", "logs/dvl.csv")]
lost = [path.name for path in files if not path.exists() or path.stat().st_size < 60]
if command == "status" or lost:
    print(json.dumps({"error": {"message": f"{lost} cannot be read"}}))
    sys.exit(2 if command == "status" else 3)
(runs / package.name / "deliver").mkdir(parents=True, exist_ok=True)
"""
PROGRAM = """
import sys
from hullrecon.api.fleet import processes
processes.PROGRAM = (sys.executable, {child!r})
from hullrecon_cli.main import main
sys.exit(main())
"""


def make_tiny(folder: Path) -> Path:
    (folder / "logs").mkdir(parents=True)
    for name in ("hull.stl", "logs/imu.csv", "logs/dvl.csv"):
        (folder / name).write_text("0,1,2,3\n" * 10)
    (folder / "dive.toml").write_text(
        f'[dive]\nname = "{folder.name}"\nvessel = "Kestrel"\n[tray]\nsigma_deg = 0.8\n'
    )
    return folder


def test_copies_differ_and_five_are_broken_each_in_its_way(tmp_path: Path) -> None:
    broken = make_dives(make_tiny(tmp_path / "tiny"), tmp_path / "dives", 20)
    assert sorted(broken.values()) == sorted(spoil.__name__ for spoil in BREAKS)
    texts = [path.read_text() for path in (tmp_path / "dives").glob("*/dive.toml")]
    assert len(set(texts)) == 20
    assert sum(MARK in text for text in texts) == 1


def test_fleet_killed_twice_delivers_all_but_broken_dives(tmp_path: Path) -> None:
    (tmp_path / "child.py").write_text(CHILD)
    program = (sys.executable, "-c", PROGRAM.format(child=str(tmp_path / "child.py")))
    found = measure(tmp_path / "work", make_tiny(tmp_path / "tiny"), 12, 2, program)
    calls = found["calls"]
    assert calls["killed"]["exit_code"] in (-9, 4)  # 4 where it came to its end first
    assert calls["ended"]["exit_code"] in (130, 4)
    assert 2 <= calls["killed"]["delivered"] <= calls["ended"]["delivered"] <= 7
    for name in ("whole", "again"):
        assert (calls[name]["exit_code"], calls[name]["delivered"], calls[name]["reported"]) == (
            4,
            7,
            7,
        )
        assert sorted(calls[name]["failed"]) == sorted(found["broken"])
        assert len(calls[name]["failed_lines"]) == len(BREAKS)
    assert calls["again"]["ran"] == 0
    assert found["code_ran"] == []
