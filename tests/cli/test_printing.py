# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""cli.printing: what foreign names hold is shown, never obeyed by the terminal."""

from __future__ import annotations

import json
import logging
import os
import subprocess
import sys
from pathlib import Path

import pytest
from hullrecon_cli.printing import printable
from hullrecon_cli.state import CallState, configure_logging

HOSTILE = "\x1b]0;owned\x07\x1b[2J\x9b31m\u202egnp.exe\x7f\udc80"


@pytest.mark.parametrize("text", ["plain", "Ölfilter m² \u2013 °", "tab\tand\nline"])
def test_what_is_harmless_stays(text: str) -> None:
    assert printable(text) == text


def test_what_a_terminal_would_obey_is_written_out() -> None:
    assert printable("\x1b[31m") == r"\u001b[31m"
    assert printable(HOSTILE).isprintable()
    assert printable(HOSTILE).isascii()


def test_json_stays_the_same_json() -> None:
    text = json.dumps({"name": HOSTILE}, ensure_ascii=False)
    assert json.loads(printable(text)) == {"name": HOSTILE}


@pytest.mark.parametrize("as_json", [False, True])
def test_results_are_printed_without_control_characters(
    as_json: bool, capfd: pytest.CaptureFixture[str]
) -> None:
    CallState(json=as_json).emit({"topic": HOSTILE}, [f"topic {HOSTILE}"])
    out = capfd.readouterr().out
    assert out.replace("\n", "").isprintable()
    assert r"\u001b[2J" in out


def test_the_log_on_the_screen_is_without_control_characters(
    capfd: pytest.CaptureFixture[str],
) -> None:
    configure_logging(CallState())
    # pytest keeps what is logged, and with several workers sends it as UTF-8, which has no lone
    # surrogates
    logging.getLogger("hullrecon.test").warning("lost: %s", HOSTILE.replace("\udc80", ""))
    assert capfd.readouterr().err.rstrip("\n").isprintable()


def test_an_error_is_printed_without_control_characters(program, tmp_path: Path) -> None:
    answer = program("run", tmp_path / f"a{HOSTILE}b")
    assert answer.code == 3
    assert answer.err.rstrip("\n").isprintable()
    assert answer.err.count("\n") == 1


def test_wrong_usage_is_printed_without_control_characters(program) -> None:
    answer = program("run", "--\x1b[31m")
    assert (answer.code, "\x1b" in answer.err) == (2, False)


def test_an_encoding_that_lacks_a_character_is_no_fault() -> None:
    code = "import sys; from hullrecon_cli.main import main; sys.exit(main(['run', 'm\u2192']))"
    environment = os.environ | {"PYTHONIOENCODING": "latin-1:strict"}
    answer = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
    )
    assert answer.returncode == 3
    assert r"(m\u2192)" in answer.stderr
