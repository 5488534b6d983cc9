# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""api.fleet's parts: what lies in the folder of dives is data and is not followed out of it;
listings; processes; documents.
"""

from __future__ import annotations

import json
import os
import socket
import sys
from contextlib import closing
from pathlib import Path

import pytest
from end_to_end.json_schema import violations

from hullrecon.api.fleet import preview_fleet, processes
from hullrecon.api.fleet.outcome import FleetDive, FleetResult
from hullrecon.api.fleet.packages import (
    MAX_BYTES,
    Skipped,
    as_utf8,
    find_packages,
    list_folder,
    one_line,
    program_signature,
    read_name,
)
from hullrecon.api.fleet.processes import run_each
from hullrecon.artifacts.documents import encode
from hullrecon.errors import HullreconError, InputError, UsageError

SCHEMA = json.loads(
    (Path(__file__).parents[2] / "hullrecon/report/schemas/fleet.schema.json").read_text()
)
TOML = '[dive]\nname = "kestrel"\n'
HOSTILE = [
    "two words",
    "'quoted'",
    '"quoted"',
    "$(touch here)",
    "`touch here`",
    "$(shell touch here)",
    "line\nend",
    "-rf",
    "--help",
    "; touch here",
    "tab\there",
    "\x1b[2J",
    "Brückenprüfung",
    "*",
    "a&b",
    "%s{0}",
]


@pytest.fixture
def dives(tmp_path: Path) -> Path:
    (tmp_path / "dives").mkdir()
    return tmp_path / "dives"


def make(package: Path, text: str | bytes = TOML) -> Path:
    package.mkdir(parents=True)
    (package / "dive.toml").write_bytes(text if isinstance(text, bytes) else text.encode())
    return package


def reasons(dives: Path) -> dict[str, str]:
    return {s.path.name: s.reason for s in find_packages(dives)[1]}


def test_package_is_a_folder_with_a_dive_toml(
    dives: Path,
) -> None:
    (dives / "README.txt").touch()
    (dives / "2025" / "kestrel").mkdir(parents=True)
    packages = [make(dives / "b"), make(dives / "a")]
    assert find_packages(dives)[0] == packages[::-1]
    assert reasons(dives) == {"2025": "it holds no dive.toml"}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_packages_folder_may_have_any_name(name: str, dives: Path) -> None:
    package = make(dives / name)
    assert find_packages(dives)[0] == [package]
    assert read_name(package, dives) == "kestrel"


def test_special_files_are_skipped_by_kind(dives: Path) -> None:
    os.mkfifo(dives / "fifo")
    (dives / "zero").symlink_to("/dev/zero")
    here = os.getcwd()
    os.chdir(dives)  # the path of a socket is at most 107 bytes long
    try:
        with socket.socket(socket.AF_UNIX) as server:
            server.bind("socket")
            found = reasons(dives)
    finally:
        os.chdir(here)
    leaves = "a link that leaves the folder of dives"
    assert found == {"fifo": "a FIFO, not opened", "socket": "a socket, not opened", "zero": leaves}


def test_links_out_of_the_folder_are_not_followed(tmp_path: Path, dives: Path) -> None:
    make(tmp_path / "elsewhere")
    (dives / "out").symlink_to(tmp_path / "elsewhere")
    (dives / "up").symlink_to("..")
    (dives / "self").symlink_to(".")
    (dives / "lost").symlink_to("/nowhere")
    (dives / "latest").symlink_to("a")
    (dives / "old").symlink_to("archive/b")
    (dives / "older").symlink_to("archive/b")
    packages = [make(dives / "a"), make(dives / "archive" / "b")]
    assert find_packages(dives)[0] == packages
    leaves, twice = "a link that leaves the folder of dives", "a link to another dive here"
    assert reasons(dives) == {
        "archive": "it holds no dive.toml",
        "latest": twice,
        "lost": leaves,
        "older": twice,
        "out": leaves,
        "self": leaves,
        "up": leaves,
    }


@pytest.mark.parametrize("kind", ["fifo", "folder", "device", "link out", "lost link"])
def test_dive_toml_outside_the_folder_is_not_opened(kind: str, tmp_path: Path, dives: Path) -> None:
    package = dives / "a"
    package.mkdir()
    path = package / "dive.toml"
    if kind == "fifo":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    else:
        (tmp_path / "secret.toml").write_text(TOML)
        path.symlink_to(
            {"device": "/dev/zero", "link out": tmp_path / "secret.toml", "lost link": "nowhere"}[
                kind
            ]
        )
    assert find_packages(dives)[0] == [package]
    with pytest.raises(InputError, match=r"no regular file|leaves the folder|cannot be read"):
        read_name(package, dives)
    (only,) = preview_fleet(dives, tmp_path / "runs").dives
    assert (only.state, only.exit_code) == ("failed", 3)


@pytest.mark.parametrize(
    "text",
    [
        "x = [", "", "[dive]", "dive = 3", "[dive]\nname = 3", '[dive]\nname = ".."',
        '[dive]\nname = "a\\n"', b"\xff\xfe",
        "a = " + "[" * 3000, "a = " + "9" * 9000, '[dive]\nname = "$(touch here)"',
        "[[dive]]\nname = 'a'",
    ],
)  # fmt: skip
def test_a_dive_toml_without_a_valid_name_has_none(text: str | bytes, dives: Path) -> None:
    assert read_name(make(dives / "a", text), dives) is None


@pytest.mark.parametrize(
    "text", ["#" * (MAX_BYTES + 1), "a." * 10_000 + "a = 1", "[" + "a." * 5000 + "a]\nb = 1"]
)
def test_a_dive_toml_that_takes_minutes_to_parse_is_refused(text: str, dives: Path) -> None:
    with pytest.raises(UsageError, match=r"more than \d+ (bytes|dots)"):
        read_name(make(dives / "a", TOML + text), dives)


def test_a_folder_that_may_not_be_listed_or_is_gone_is_one_error(dives: Path) -> None:
    with pytest.raises(HullreconError, match="cannot be read: No such file"):
        find_packages(dives / "nowhere")


def test_a_listing_changes_with_content_times_names_and_inodes(dives: Path) -> None:
    package = make(dives / "a")
    seen = [list_folder(package, dives).signature]
    (package / "log").write_text("one")
    seen.append(list_folder(package, dives).signature)
    (package / "log").rename(package / "logs")
    seen.append(list_folder(package, dives).signature)
    os.utime(package / "logs", ns=(1, 1))
    seen.append(list_folder(package, dives).signature)
    (package / "copy").write_text("one")
    os.utime(package / "copy", ns=(1, 1))
    (package / "copy").replace(package / "logs")
    seen.append(list_folder(package, dives).signature)
    assert len(set(seen)) == len(seen)
    assert list_folder(package, dives).signature == seen[-1]


def test_a_listing_names_files_and_what_is_none_and_stays_inside(
    tmp_path: Path, dives: Path
) -> None:
    package = make(dives / "a")
    (package / "logs").mkdir()
    (package / "logs" / "b.csv").touch()
    os.mkfifo(package / "logs" / "pipe")
    (dives / "shared").mkdir()
    (dives / "shared" / "hull.stl").touch()
    (tmp_path / "private").mkdir()
    (tmp_path / "private" / "key").touch()
    for name, target in {
        "shared": dives / "shared",
        "private": tmp_path / "private",
        "loop": package,
        "lost": "x",
    }.items():
        (package / name).symlink_to(target)
    found = list_folder(package, dives)
    assert found.files == ("dive.toml", "logs/b.csv", "shared/hull.stl")
    assert found.special == (("logs/pipe", "a FIFO"),)
    assert list_folder(package, dives, ("logs",)).files == ("dive.toml", "shared/hull.stl")


def test_the_signature_of_the_program_is_that_of_its_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert program_signature() == program_signature()
    before = program_signature()
    monkeypatch.setattr("hullrecon.api.fleet.packages.version", lambda: "another")
    assert program_signature() != before


def test_preview_of_hostile_names_fits_the_schema(tmp_path: Path, dives: Path) -> None:
    for k, name in enumerate(HOSTILE):
        package = make(dives / name, f'[dive]\nname = "dive-{k}"\n')
        (package / name).touch()
    bad = os.fsencode(dives) + b"/\xff\xfe"
    os.mkdir(bad)
    os.mkfifo(bad + b"/dive.toml")
    os.mkfifo(dives / "pipe\nline")
    result = preview_fleet(dives, tmp_path / "runs")
    document = json.loads(encode(result.document()))
    assert violations(document, SCHEMA) == []
    assert {d["package"].rpartition("/")[2] for d in document["dives"]} == {*HOSTILE, "\\xff\\xfe"}
    assert [
        d["package_files"][1:] or d["package_files"]
        for d in document["dives"]
        if d["name"] == "dive-6"
    ] == [["line\nend"]]
    assert all("\n" not in dive.line() and "\x1b" not in dive.line() for dive in result.dives)


def test_document_lists_deliverables_up_to_date_alone(tmp_path: Path, dives: Path) -> None:
    (tmp_path / "runs" / "kestrel" / "deliver" / "report").mkdir(parents=True)
    (tmp_path / "runs" / "kestrel" / "deliver" / "report" / "index.html").touch()
    rows = []
    for state, code in (("delivered", 0), ("up to date", 0), ("failed", 4), ("to do", None)):
        dive = FleetDive(
            package=dives / state,
            name="kestrel",
            state=state,
            exit_code=code,
            reason="",
            ran=False,
            known=False,
            files=(),
            log=None,
            delivered=state in ("delivered", "up to date"),
        )
        rows.append(dive)
    skipped = (Skipped(path=dives / "x", reason="a FIFO, not opened"),)
    result = FleetResult(
        dives_folder=dives, runs=tmp_path / "runs", dives=tuple(rows), skipped=skipped
    )
    document = json.loads(encode(result.document()))
    assert violations(document, SCHEMA) == []
    assert [d["deliver_files"] for d in document["dives"]] == [["report/index.html"]] * 2 + [[], []]
    assert [d["deliver"] is None for d in document["dives"]] == [False, False, True, True]
    assert (
        document["exit_code"],
        document["delivered"],
        document["failed"],
        document["to_do"],
    ) == (4, 2, 1, 1)
    assert result.summary() == "4 dives: 2 delivered, 1 failed, 1 to do"


@pytest.mark.parametrize(
    ("code", "exit_code", "reason"),
    [
        ("pass", 0, ""),
        ("import os; os.kill(os.getpid(), 11)", 139, "ended by SIGSEGV"),
        ("import os; os.kill(os.getpid(), 40)", 168, "ended by signal 40"),
        ("""print('{"error": {"message": "no IMU"}}'); raise SystemExit(3)""", 3, "no IMU"),
        ("print('[1, 2'); raise SystemExit(3)", 3, "it said nothing"),
        (
            "print('[1, 2]'); import sys; print('one\\ntwo\\n', file=sys.stderr);"
            " raise SystemExit(1)",
            1,
            "two",
        ),
        ("print('[' * 100000); raise SystemExit(1)", 1, "it said nothing"),
    ],
)
def test_end_of_a_process_is_explained(
    code: str, exit_code: int, reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(processes, "PROGRAM", (sys.executable, "-c", code))
    ((key, ended),) = run_each({"a": []}, 1, tmp_path)
    assert (key, ended.exit_code, ended.reason) == ("a", exit_code, reason)
    assert list(tmp_path.iterdir()) == []


def test_no_more_processes_run_than_jobs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code = f"""
import os, time
open({str(tmp_path)!r} + "/" + str(os.getpid()), "w")
time.sleep(0.1)
print('{{"error": {{"message": "%d"}}}}' % len(os.listdir({str(tmp_path)!r})))
os.remove({str(tmp_path)!r} + "/" + str(os.getpid()))
raise SystemExit(3)
"""
    monkeypatch.setattr(processes, "PROGRAM", (sys.executable, "-c", code))
    ended = dict(run_each({k: [] for k in range(5)}, 2, tmp_path))
    assert sorted(ended) == list(range(5))
    assert max(int(end.reason) for end in ended.values()) <= 2


def test_closing_run_each_ends_running_processes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = f"""
import os, time
open({str(tmp_path)!r} + '/new', 'w').write(str(os.getpid()))
os.rename({str(tmp_path)!r} + '/new', {str(tmp_path)!r} + '/pid')
time.sleep(300)"""
    monkeypatch.setattr(
        processes, "PROGRAM", (sys.executable, "-c", "import sys; exec(sys.argv[4])")
    )
    wait = (
        f"import os, time\nwhile not os.path.exists({str(tmp_path)!r} + '/pid'): time.sleep(0.01)"
    )
    with closing(run_each({"quick": [wait], "slow": [code]}, 2, tmp_path)) as ended:
        assert next(ended)[0] == "quick"
    assert not Path(f"/proc/{(tmp_path / 'pid').read_text()}").exists()


def test_module_in_the_current_folder_is_not_imported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("hullrecon_cli", "numpy", "json", "click"):
        (tmp_path / f"{name}.py").write_text("open('taken', 'w')\n")
    monkeypatch.chdir(tmp_path)
    ((_, ended),) = run_each({"a": ["status", str(tmp_path)]}, 1, tmp_path)
    assert ended.exit_code == 3
    assert "no dive.toml here" in ended.reason
    assert not (tmp_path / "taken").exists()


def test_text_of_others_is_one_line_and_valid_utf_8() -> None:
    assert one_line("a\nb\x1b[0m \u202e é") == "a\\nb\\x1b[0m \\u202e é"
    assert one_line(os.fsdecode(b"\xff")) == "\\udcff"
    assert as_utf8(os.fsdecode(b"a\xff/\xc3\xa9")) == "a\\xff/é"


def test_exit_code_survives_libraries_at_exit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "sitecustomize.py").write_text("import atexit, os\natexit.register(os._exit, 1)\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    ((_, ended),) = run_each({"a": ["status", str(tmp_path)]}, 1, tmp_path)
    assert ended.exit_code == 3
    assert "no dive.toml here" in ended.reason
