# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Report errors in one line with an exit code; the one place where errors end."""

from __future__ import annotations

import errno
import os

import click

from hullrecon.artifacts.progress import is_requested
from hullrecon.errors import HullreconError, InputError, StageError, StorageError, UsageError

from .fault_file import write_fault_file
from .printing import printable
from .state import CallState, log_to_file

UNEXPECTED, USAGE, INTERRUPTED = 1, 2, 130
_STORAGE = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EPERM}
_LONG = 100  # characters of a name that is shown


def exit_code_of(error: BaseException, state: CallState) -> int:
    """Print in one line what happened, and return the exit code (docs/deliverables.md)."""
    if isinstance(error, KeyboardInterrupt | click.Abort) or is_requested():
        return _report(
            state,
            "interrupted: what is finished is kept, run again to go on",
            "Interrupted",
            INTERRUPTED,
        )
    known = _as_known(error)
    if known is not None:
        return _report(
            state,
            known.line(),
            type(known).__name__,
            known.exit_code,
            where=known.where,
            remedy=known.remedy,
        )
    if isinstance(error, click.ClickException):
        context = getattr(error, "ctx", None)
        remedy = f"see {context.command_path} --help" if context is not None else ""
        return _report(
            state,
            f"{error.format_message()} ({remedy})" if remedy else error.format_message(),
            "UsageError",
            USAGE,
        )
    if isinstance(
        error, SystemExit
    ):  # click: completion has been printed, or the reader of our output has closed it, like `head`
        return error.code if isinstance(error.code, int) else UNEXPECTED
    path = write_fault_file(error, state.workspace)
    place = (
        f"traceback in {path}"
        if path is not None
        else f"{type(error).__name__}: {error} (no place for its traceback)"
    )
    return _report(state, f"internal error; {place}", "InternalError", UNEXPECTED)


def _as_known(error: BaseException) -> HullreconError | None:
    """Convert to an error that a user can act on. None for an internal error.

    A full disk, a missing permission or a lack of memory can be acted on wherever it occurred.
    """
    from hullrecon.artifacts.machine import is_lack_of_memory

    if isinstance(error, HullreconError):
        return error
    if is_lack_of_memory(error):
        return StageError(
            "the memory ran out", remedy="give the program more, or look at `ulimit -v`"
        )
    if not isinstance(error, OSError) or error.errno is None:
        return None
    what, name = os.strerror(error.errno), str(error.filename or "")
    where = name if len(name) <= _LONG else f"{name[:_LONG]}..., {len(name)} characters"
    if error.errno in _STORAGE:
        return StorageError(what, where=where)
    if error.errno == errno.ENAMETOOLONG:
        return UsageError(what, where=where)
    return InputError(what, where=where) if error.errno == errno.ELOOP else None


def _report(state: CallState, line: str, kind: str, code: int, **more: str) -> int:
    """Print an error in one line, with --json as a document too. Returns its exit code."""
    one_line = printable(" ".join(line.split()))
    try:
        click.echo(f"error: {one_line}", err=True)
        log_to_file(f"error: {one_line}")
        if state.json and not state.is_emitted:
            state.emit(
                {"error": {"kind": kind, "message": one_line, "exit_code": code, **more}}, ()
            )
    # Standard error or output is full or closed: only the exit code can tell of the error.
    except OSError:
        pass
    return code
