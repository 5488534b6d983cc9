# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What a user is told when something fails, and the exit code; the one place where errors end."""

from __future__ import annotations

import os
import tempfile
import time
import traceback
from pathlib import Path

import click

from hullrecon.errors import HullreconError, StorageError

from .state import CallState, log_to_file

UNEXPECTED, USAGE, INTERRUPTED = 1, 2, 130


def exit_code_of(error: BaseException, state: CallState) -> int:
    """Says in one line on standard error what happened and returns the exit code (docs/deliverables.md)."""
    if isinstance(error, HullreconError):
        return _say(state, error.line(), type(error).__name__, error.exit_code, where=error.where, remedy=error.remedy)
    if isinstance(error, click.ClickException):
        context = getattr(error, "ctx", None)
        remedy = f"see {context.command_path} --help" if context is not None else ""
        return _say(state, f"{error.format_message()} ({remedy})" if remedy else error.format_message(), "UsageError", USAGE)
    if isinstance(error, KeyboardInterrupt | click.Abort):
        return _say(state, "interrupted: what is finished is kept, run again to go on", "Interrupted", INTERRUPTED)
    if isinstance(
        error, SystemExit
    ):  # click: completion has been printed, or the reader of our output has left, as `head` does
        return error.code if isinstance(error.code, int) else UNEXPECTED
    line = f"internal error; traceback in {_write_traceback(error, state)}"
    return _say(state, line, "InternalError", UNEXPECTED)


def _say(state: CallState, line: str, kind: str, code: int, **more: str) -> int:
    one_line = " ".join(line.split())
    click.echo(f"error: {one_line}", err=True)
    log_to_file(f"error: {one_line}")
    if state.json:
        state.emit({"error": {"kind": kind, "message": one_line, "exit_code": code, **more}}, ())
    return code


def _write_traceback(error: BaseException, state: CallState) -> Path:
    """Below the dive's folder, or where temporary files go when there is none or no room."""
    from hullrecon.artifacts.storage.disk import write_file

    name = f"fault-{time.strftime('%Y%m%dT%H%M%S')}-{os.getpid()}.txt"
    text = "".join(traceback.format_exception(error)).encode()
    temporary = Path(tempfile.gettempdir()) / f"{name}"
    try:
        path = temporary if state.workspace is None else state.workspace / "logs" / name
        write_file(path, text)
    except (OSError, StorageError):
        path = temporary
        write_file(path, text)
    return path
