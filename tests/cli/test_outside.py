# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Packages that name files outside their folder, by every command that reads packages."""

from pathlib import Path

import pytest
from hullrecon_cli.main import main

TOML = """[dive]
name = "small"
[logs]
files = ["logs"]
[dvl]
beam_angle_deg = 30.0
beam_azimuth_deg = [180, 0, 90, -90]
[hull]
mesh = "../hull.off"
"""
TABLES = {
    "dvl": "t,vx,vy,vz,range_1,range_2,range_3,range_4\n"
    "0,1,0,0,1,1,1,\n1,1,0,0,2,2,2,2\n2,1,0,0,2,2,2,2\n",
    "imu": "t,qx,qy,qz,qw\n0,0,0,0,1\n1,0,0,0,1\n2,0,0,0,1\n",
}
OFF = "OFF\n4 4 0\n0 0 0\n20 0 0\n0 20 0\n0 0 20\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"


@pytest.fixture
def package(tmp_path) -> Path:
    """A small package whose CAD model lies beside it."""
    folder = tmp_path / "package"
    (folder / "logs").mkdir(parents=True)
    (folder / "dive.toml").write_text(TOML)
    (tmp_path / "hull.off").write_text(OFF)
    for name, text in TABLES.items():
        (folder / "logs" / f"{name}.csv").write_text(text)
    return folder


@pytest.mark.parametrize(
    "command",
    [
        "check",
        "run",
        "ingest",
        "status",
        "explain",
        "study methods",
        "study surfaces",
        "study figures",
    ],
)
def test_commands_refuse_files_outside_in_one_line(capsys, package, command):
    runs = [] if command == "check" else ["--runs", str(package.parent / "runs")]
    assert main([*command.split(), str(package), *runs]) == 3
    line = capsys.readouterr().err.strip()
    assert line.startswith("error: hull.mesh names a file outside the package: ../hull.off")
    assert "--allow-outside" in line
    assert len(line.splitlines()) == 1
    assert not (package.parent / "runs").exists()


def test_allow_outside_lets_a_command_read_it(capsys, package, monkeypatch):
    assert main(["check", str(package), "--allow-outside"]) == 0
    assert "hull.off: 4 faces" in capsys.readouterr().out
    runs = str(package.parent / "runs")
    assert main(["ingest", str(package), "--runs", runs, "--allow-outside"]) == 0
    assert main(["status", str(package), "--runs", runs]) == 3
    monkeypatch.setenv("HULLRECON_ALLOW_OUTSIDE", "1")
    assert main(["status", str(package), "--runs", runs]) == 0


def test_set_may_name_any_file(capsys, package):
    assert main(["check", str(package), "--set", f"hull.mesh={package.parent / 'hull.off'}"]) == 0
    assert "hull.off: 4 faces" in capsys.readouterr().out


def test_clean_reads_nothing_of_the_package(capsys, package):
    assert main(["clean", str(package), "--yes", "--runs", str(package.parent / "runs")]) == 0


def test_the_library_refuses_and_allows_alike(package, tmp_path):
    import hullrecon
    from hullrecon.errors import InputError

    with pytest.raises(InputError, match=r"hull\.mesh names a file outside"):
        hullrecon.open_dive(package, tmp_path / "runs")
    assert hullrecon.open_dive(package, tmp_path / "runs", allow_outside=True).name == "small"


def test_init_says_which_log_lies_outside_the_package(capsys, package, tmp_path):
    out = tmp_path / "elsewhere"
    assert main(["init", str(package / "logs"), "--out", str(out)]) == 0
    assert (
        f"outside the package: {package / 'logs'}; put it there, or give --allow-outside"
        in capsys.readouterr().out
    )
    assert (
        main(["init", str(package / "logs"), "--out", str(out), "--force", "--allow-outside"]) == 0
    )
    assert "outside the package" not in capsys.readouterr().out
    assert main(["init", str(package / "logs"), "--out", str(package), "--force"]) == 0
    assert "outside the package" not in capsys.readouterr().out


@pytest.mark.parametrize("command", ["init", "check"])
def test_a_bare_folder_of_tables_is_held_to_itself(capsys, package, command):
    (package / "logs" / "dvl.csv").rename(package.parent / "dvl.csv")
    (package / "logs" / "dvl.csv").symlink_to(package.parent / "dvl.csv")
    assert main([command, str(package / "logs")]) == 3
    line = capsys.readouterr().err.strip()
    assert "the log names a file outside the package: dvl.csv (a link to" in line
    assert len(line.splitlines()) == 1
    code = main([command, str(package / "logs"), "--allow-outside"])
    answer = capsys.readouterr()
    assert "dvl: 3 messages" in answer.out
    # a bare log is described, but no run of it is possible
    assert code == (0 if command == "init" else 3)
    assert "outside" not in answer.err
