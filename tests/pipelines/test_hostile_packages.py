# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Packages that try to run code or to write outside RUNS through the pipelines: each was possible
once.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from dive.conftest import Entry, Kit

# A file that appears when code of a package has run; without a slash it can be part of a file's
# name.
MARK = "code-has-run"
ATTACK = f"$(shell touch {MARK})$(touch {MARK})`touch {MARK}`; touch {MARK}; '; touch {MARK}; "
ATTACK += f'\'"; touch {MARK}; "'
QUOTED = ATTACK.replace('"', '\\"')  # in a TOML string
LOGS = '[logs]\nfiles = ["log.mcap"]\n[topics]\ndvl = "/dvl"\n'
PAGE = "index.html"  # the fleet's own, beside the dives in RUNS
Pipeline = Callable[[Path], object]


@pytest.fixture(params=["fleet", "make"])
def pipeline(request, call, pipelines: Path, program: Path, tmp_path: Path) -> Pipeline:
    """Gives a package to pipelines/fleet, or to the first rule of dive.mk, which is written as all
    are; in a folder of its own, where nothing may appear.
    """
    here = tmp_path / "here"
    here.mkdir()

    def run(package: Path):
        runs = tmp_path / "runs"
        environment = {
            k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS"))
        } | {"HULLRECON": str(program)}
        if request.param == "fleet":
            answer = call(pipelines / "fleet", package.parent, runs, env=environment, cwd=here)
        else:
            answer = call(
                "make",
                "-f",
                pipelines / "dive.mk",
                f"PACKAGE={package}",
                f"RUNS={runs}",
                runs / "kestrel" / "ingest" / "manifest.json",
                env=environment,
                cwd=here,
            )
        assert list(here.iterdir()) == [], answer.stderr
        assert not [p for p in tmp_path.rglob(MARK) if p.parent != package]
        return answer

    return run


def test_a_dives_name_runs_no_code(pipeline: Pipeline, make_package, tmp_path: Path) -> None:
    package = make_package(tmp_path / "dives" / "a", "kestrel")
    (package / "dive.toml").write_text(f'[dive]\nname = "x{QUOTED}"\n{LOGS}')
    answer = pipeline(package)
    assert answer.returncode != 0
    assert {p.name for p in (tmp_path / "runs").glob("[!.]*")} <= {PAGE}


def test_the_name_of_a_packages_folder_or_file_runs_no_code(
    pipeline: Pipeline, make_package, trace: Path, tmp_path: Path
) -> None:
    package = make_package(tmp_path / "dives" / ATTACK, "kestrel")
    (package / ATTACK).write_text("x")
    (package / f"{ATTACK}\nend").write_text("x")
    (package / "logs of today").mkdir()
    (package / "log.mcap").rename(package / "logs of today" / f"{ATTACK}.mcap")
    (package / "dive.toml").write_text(
        f'[dive]\nname = "kestrel"\n[logs]\nfiles = ["logs of today/{QUOTED}.mcap"]\n'
    )
    answer = pipeline(package)
    assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")
    assert (tmp_path / "runs/kestrel/ingest/manifest.json").exists()


def test_vessel_of_several_lines_is_only_a_vessel(
    pipeline: Pipeline, make_package, trace: Path, tmp_path: Path
) -> None:
    package = make_package(tmp_path / "dives" / "a", "kestrel")
    vessel = f'"""\nname = "x{QUOTED}"\n[dive]\nname = \'{QUOTED}\'\n"""'
    (package / "dive.toml").write_text(f'[dive]\nvessel = {vessel}\n  name = "kestrel"\n{LOGS}')
    answer = pipeline(package)
    # several lines are refused, in words or by make for want of a run; what they hold is no name
    # and no code
    assert answer.returncode != 0
    assert {p.name for p in (tmp_path / "runs").glob("[!.]*")} <= {PAGE}


def test_topic_name_written_by_init_runs_no_code(
    pipeline: Pipeline, call, program: Path, trace: Path, tmp_path: Path
) -> None:
    kit = Kit()
    topics = [f'/imu"\nname = "x{ATTACK}"\n[dive]\nname = "{ATTACK}', f"/other\nname = {ATTACK} # "]
    package = tmp_path / "dives" / "kestrel"
    entries = [
        Entry(topic, "sensor_msgs/msg/Imu", kit.start_ns + k, kit.imu(kit.start_ns))
        for k, topic in enumerate(topics)
    ]
    kit.mcap(package / "log.mcap", entries)
    answer = call(program, "init", package)
    assert answer.returncode == 0, answer.stderr
    pipeline(package)
    assert {p.name for p in (tmp_path / "runs").glob("[!.]*")} <= {"kestrel", PAGE}


NO_NAMES = (
    "..",
    ".",
    "kestrel\\n",
    "../kestrel",
    "/kestrel",
    "a/../../kestrel",
    "",
    "-rf",
    "x" * 300,
)


def test_a_dives_name_writes_nothing_outside_its_folder_of_runs(
    call, pipelines: Path, program: Path, make_package, tmp_path: Path
) -> None:
    (tmp_path / "kestrel").mkdir()
    (tmp_path / "kestrel" / "letter.txt").write_text("not ours")
    for k, name in enumerate(NO_NAMES):
        make_package(tmp_path / "dives" / str(k), "kestrel")
        (tmp_path / "dives" / str(k) / "dive.toml").write_text(f'[dive]\nname = "{name}"\n{LOGS}')
    before = sorted(p for p in tmp_path.rglob("*") if p.is_file())
    answer = call(
        pipelines / "fleet",
        tmp_path / "dives",
        tmp_path / "runs",
        env=os.environ | {"HULLRECON": str(program)},
    )
    assert answer.returncode == 4
    assert [line.split(": ")[:3] for line in sorted(answer.stderr.splitlines())] == [
        ["failed", str(k), "exit code 2"] for k in range(len(NO_NAMES))
    ]
    assert (
        sorted(
            p
            for p in tmp_path.rglob("*")
            if p.is_file() and ".fleet" not in p.parts and p != tmp_path / "runs" / PAGE
        )
        == before
    )


@pytest.mark.parametrize("name", ["..", "kestrel\\n"])
def test_make_of_a_dive_with_no_valid_name_writes_nothing(
    name: str, call, pipelines: Path, program: Path, make_package, tmp_path: Path
) -> None:
    package = make_package(tmp_path / "a", "kestrel")
    (package / "dive.toml").write_text(f'[dive]\nname = "{name}"\n{LOGS}')
    before = sorted(tmp_path.rglob("*"))
    answer = call(
        "make",
        "-f",
        pipelines / "dive.mk",
        f"PACKAGE={package}",
        f"RUNS={tmp_path}",
        f"HULLRECON={program}",
    )
    assert answer.returncode == 2
    assert "dive.name" in answer.stderr
    assert sorted(tmp_path.rglob("*")) == before


def test_runs_that_are_the_folder_of_dives_are_refused(
    call, pipelines: Path, program: Path, make_package, tmp_path: Path
) -> None:
    package = make_package(tmp_path / "dives" / "kestrel", "kestrel")
    before = sorted(tmp_path.rglob("*"))
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS"))} | {
        "HULLRECON": str(program)
    }
    for runs in (".", tmp_path / "dives", package):
        answer = call(
            pipelines / "fleet", tmp_path / "dives", runs, env=environment, cwd=tmp_path / "dives"
        )
        assert answer.returncode == 2
        assert answer.stderr.startswith("error: results would lie among the packages")
        assert answer.stderr.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before


def test_links_and_special_files_are_not_followed(
    call, pipelines: Path, program: Path, make_package, trace: Path, tmp_path: Path
) -> None:
    make_package(tmp_path / "private", "private")
    make_package(tmp_path / "dives" / "kestrel", "kestrel")
    (tmp_path / "dives" / "out").symlink_to(tmp_path / "private")
    os.mkfifo(tmp_path / "dives" / "pipe")
    os.mkfifo(tmp_path / "dives" / "kestrel" / "pipe")
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS"))} | {
        "HULLRECON": str(program)
    }
    answer = call(
        program, "fleet", tmp_path / "dives", "--runs", tmp_path / "runs", env=environment
    )
    assert answer.returncode == 0, answer.stderr
    assert {line for line in answer.stderr.splitlines() if line.startswith("skipped")} == {
        "skipped: kestrel/pipe: a FIFO, not opened",
        "skipped: out: a link that leaves the folder of dives",
        "skipped: pipe: a FIFO, not opened",
    }
    assert {p.name for p in (tmp_path / "runs").iterdir()} == {"kestrel", ".fleet", PAGE}
