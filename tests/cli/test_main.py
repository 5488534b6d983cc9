# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""cli.main: the list of commands, the common options, the exit codes."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from hullrecon_cli.command_table import COMMANDS, STEPS
from hullrecon_cli.main import cli, main

from hullrecon.steps.chain import NAMES, stages

ROOT = Path(__file__).resolve().parents[2]
HEAVY = (
    "numpy",
    "scipy",
    "msgspec",
    "rich",
    "cv2",
    "open3d",
    "pycolmap",
    "trimesh",
    "matplotlib",
    "hullrecon.steps.chain",
)


def test_help_lists_every_command_with_its_line(program) -> None:
    answer = program("--help")
    assert answer.code == 0
    for name, entry in COMMANDS.items():
        assert f"  {name} " in answer.out
        assert entry.summary.split()[0] in answer.out


def test_the_bare_program_prints_its_help(program) -> None:
    answer = program()
    assert (answer.code, answer.err) == (0, "")
    assert answer.out == program("--help").out
    assert max(map(len, answer.out.splitlines())) <= 100


def test_help_imports_nothing_heavy() -> None:
    loaded = f"' '.join(set({HEAVY!r}) & set(sys.modules))"
    code = "import sys; from hullrecon_cli.main import main; main(['--help']);"
    code += f" sys.exit({loaded} or 0)"
    answer = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False
    )
    assert (answer.returncode, answer.stderr) == (0, "")


def test_the_list_of_steps_says_what_the_steps_say_of_themselves() -> None:
    assert {stage.name: stage.summary for stage in stages()} == {
        name: entry.summary for name, entry in STEPS.items()
    }
    assert tuple(STEPS) == NAMES


@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_every_command_can_be_asked_for_help(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert main([name, "--help"]) == 0
    out = capfd.readouterr().out
    assert out.startswith(f"Usage: hullrecon {name} ")
    assert "--json" in out


def test_version_names_pyproject_and_commit(program) -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    head = subprocess.run(
        ["git", "rev-parse", "--short=12", "HEAD"], cwd=ROOT, capture_output=True, text=True
    ).stdout.strip()
    said = program("--version").out
    assert said.startswith(f"hullrecon {project['version']} (commit {head}")


def test_version_of_a_wheel_comes_from_its_build(tmp_path: Path) -> None:
    package = tmp_path / "hullrecon"
    package.mkdir()
    shutil.copy(ROOT / "hullrecon" / "version.py", package)
    shutil.copy(ROOT / "hullrecon" / "__init__.py", package)
    folder = tmp_path / "hullrecon-9.8.7.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: hullrecon\nVersion: 9.8.7\n")
    code = "from hullrecon.version import describe; print(describe())"

    def said() -> str:
        return subprocess.run(
            [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
        ).stdout.strip()

    assert said() == "9.8.7 (commit not known: built without git)"
    (package / "commit.txt").write_text("0123456789ab")
    assert said() == "9.8.7 (commit 0123456789ab)"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["rnu"], "no command is called 'rnu'; did you mean 'run'?"),
        (["xyzzy"], "no command is called 'xyzzy'"),
        (["compare-methods", "dive"], "did you mean 'study methods'?"),
        (["figures", "dive"], "did you mean 'study figures'?"),
        (["run"], "Missing argument 'PACKAGE'"),
        (["run", "somewhere", "--job", "2"], "No such option '--job'"),
        (["run", "somewhere", "--jobs", "0"], "Invalid value for '--jobs'"),
        (["completion", "tcsh"], "'tcsh' is not one of"),
    ],
)
def test_wrong_usage_is_one_line_and_code_2(arguments: list[str], words: str, program) -> None:
    answer = program(*arguments)
    assert answer.code == 2
    assert answer.out == ""
    assert answer.err.startswith("error: ")
    assert answer.err.count("\n") == 1
    assert words in answer.err.replace("option: --job", "option '--job'")


def test_an_error_with_json_is_a_json_document(program, tmp_path: Path) -> None:
    answer = program("status", tmp_path, "--json")
    document = json.loads(answer.out)["error"]
    assert (answer.code, document["exit_code"], document["kind"]) == (3, 3, "InputError")
    assert document["where"] == str(tmp_path)
    assert answer.err == f"error: {document['message']}\n"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_is_a_script_for_the_shell(shell: str, program) -> None:
    answer = program("completion", shell)
    assert answer.code == 0
    assert f"_HULLRECON_COMPLETE={shell}_complete" in answer.out.replace(
        '_HULLRECON_COMPLETE="bash', "_HULLRECON_COMPLETE=bash"
    )


def test_bash_completes_commands_through_the_script() -> None:
    environment = os.environ | {
        "_HULLRECON_COMPLETE": "bash_complete",
        "COMP_WORDS": "hullrecon mos",
        "COMP_CWORD": "1",
    }
    code = "import sys; from hullrecon_cli.main import main; sys.exit(main([]))"
    answer = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
    )
    assert answer.stdout.split() == ["plain,mosaic-optical", "plain,mosaic-sonar"]


def test_blas_has_one_thread_unless_the_user_says_otherwise(
    program, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    program("--version")
    assert os.environ["OPENBLAS_NUM_THREADS"] == "1"
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    program("--version")
    assert os.environ["OPENBLAS_NUM_THREADS"] == "2"


def test_a_reader_that_leaves_early_is_told_nothing() -> None:
    script = (
        "import sys; from hullrecon_cli.main import main; sys.exit(main(['completion', 'bash']))"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert process.stdout is not None
    process.stdout.close()
    _, err = process.communicate(timeout=60)
    assert err == b""


def test_sigterm_is_an_interruption() -> None:
    script = (
        "import os, signal, sys\n"
        "from hullrecon_cli import main as m\n"
        "m.cli.callback = lambda: os.kill(os.getpid(), signal.SIGTERM)\n"
        "sys.exit(m.main(['completion', 'bash']))\n"
    )
    answer = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert answer.returncode == 130
    assert (
        answer.stderr.strip() == "error: interrupted: what is finished is kept, run again to go on"
    )
    assert signal.SIGTERM == 15


def test_the_group_knows_all_its_commands() -> None:
    import click

    context = click.Context(cli)
    assert cli.list_commands(context) == list(COMMANDS)
    assert cli.get_command(context, "absent") is None


def test_status_loads_no_library_that_only_steps_need(tmp_path):
    sample = Path(__file__).resolve().parents[2] / "sample_data" / "demo"
    program = (
        "import sys; from hullrecon_cli.main import main;"
        f"code = main(['--quiet', 'status', {str(sample)!r}, '--runs', {str(tmp_path)!r}]);"
        "print(sorted({'scipy.signal', 'scipy.stats', 'open3d', 'cv2', 'matplotlib'}"
        " & set(sys.modules)), code)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.splitlines()[-1:] == ["[] 0"], done.stdout + done.stderr
