# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What holds for one call of the program: how much it says and in which form."""

from __future__ import annotations

import errno
import logging
import sys
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

import click

from hullrecon.errors import StorageError, UsageError

from .printing import printable

_LONG = 100  # characters of a path that is shown


@dataclass(kw_only=True)
class CallState:
    """How much this call of the program says, and in which form."""

    verbose: bool = False
    quiet: bool = False
    json: bool = False
    log_file: Path | None = None
    workspace: Path | None = None  # RUNS/<dive> once it is known, where a fault's traceback goes
    is_emitted: bool = False  # the result has been printed

    def emit(self, document: object, lines: Iterable[str]) -> None:
        """Print the result: the document with --json, else the lines, nothing when quiet."""
        self.is_emitted = True
        if self.json:
            from hullrecon.artifacts.documents import encode

            click.echo(printable(encode(document).decode()), nl=False)
        elif not self.quiet:
            for line in lines:
                click.echo(printable(line))


def state_of(context: click.Context | None = None) -> CallState:
    """Return the state of this call; a plain one outside the program's own group."""
    return (context or click.get_current_context()).find_root().ensure_object(CallState)


class _Stderr(logging.StreamHandler[TextIO]):
    """Writes to the present sys.stderr, which a progress bar replaces while it is shown."""

    @property
    def stream(self) -> TextIO:
        return sys.stderr

    @stream.setter
    def stream(self, value: TextIO) -> None:
        """Ignore the assignment: the stream is always sys.stderr."""


class _MessageFormatter(logging.Formatter):
    """The message alone, a warning marked as one."""

    def format(self, record: logging.LogRecord) -> str:
        text = printable(super().format(record))
        return f"{record.levelname.lower()}: {text}" if record.levelno >= logging.WARNING else text


def configure_logging(state: CallState) -> None:
    """Log to standard error as --quiet and --verbose ask, and everything to the log file."""
    logger = logging.getLogger("hullrecon")
    for handler in logger.handlers[:]:
        logger.removeHandler(handler)
        handler.close()
    screen = _Stderr()
    screen.setFormatter(_MessageFormatter("%(message)s"))
    screen.setLevel(
        logging.ERROR if state.quiet else logging.DEBUG if state.verbose else logging.INFO
    )
    logger.addHandler(screen)
    logger.setLevel(logging.DEBUG)
    if state.log_file is not None:
        logger.addHandler(_file_handler(state.log_file))


def log_to_file(line: str) -> None:
    """Write what was printed already to the log file too, where there is one."""
    for handler in logging.getLogger("hullrecon").handlers:
        if isinstance(handler, logging.FileHandler):
            handler.handle(
                logging.LogRecord("hullrecon.cli", logging.ERROR, __file__, 0, line, None, None)
            )


class _LogFile(logging.FileHandler):
    """A log file that, if it can no longer be written, warns once and lets the run go on."""

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802 (of logging.Handler)
        """Warn of the error, and stop logging to the file."""
        error = sys.exc_info()[1]
        logging.getLogger("hullrecon").removeHandler(self)
        with suppress(OSError):
            self.close()
        logging.getLogger("hullrecon.cli").warning(
            "the log file ends here (%s): %s", self.baseFilename, error
        )


def _file_handler(path: Path) -> logging.Handler:
    """Open the log file.

    Raises UsageError where its folder does not exist, StorageError where it is refused.
    """
    try:
        handler = _LogFile(path, encoding="utf-8", errors="backslashreplace")
    except OSError as error:
        kind = (
            UsageError
            if error.errno in (errno.ENOENT, errno.ENOTDIR, errno.EISDIR, errno.ENAMETOOLONG)
            else StorageError
        )
        where = str(path) if len(str(path)) <= _LONG else f"{str(path)[:_LONG]}..."
        remedy = "give --log-file in a folder that exists and may be written"
        raise kind(
            f"the log file cannot be written: {error.strerror}", where=where, remedy=remedy
        ) from error
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))
    return handler


def add_common_options(command: click.Command) -> None:
    """Add --verbose, --quiet, --json and --log-file, which may stand before the command too."""
    taken = {name for parameter in command.params for name in parameter.opts}
    for option in common_options():
        if not taken.intersection(option.opts):
            command.params.append(option)


def common_options() -> list[click.Option]:
    """Make the options that every command has."""
    file = click.Path(path_type=Path, dir_okay=False)
    return [
        _option("verbose", ["-v", "--verbose"], "say more"),
        _option("quiet", ["-q", "--quiet"], "say nothing unless something fails"),
        _option("json", ["--json"], "standard output is one JSON document"),
        _option("log_file", ["--log-file"], "write the log with times to a file as well", file),
    ]


def _option(name: str, flags: list[str], text: str, file: click.Path | None = None) -> click.Option:
    """Make a flag, or the option of a file, that sets the field `name` of the call's state."""
    callback = _setter(name)
    return click.Option(
        [*flags, name],
        help=text,
        expose_value=False,
        callback=callback,
        is_flag=file is None,
        type=file,
    )


def _setter(name: str) -> Callable[[click.Context, click.Parameter, object], object]:
    """Make the callback of an option that sets the field `name` of the call's state."""

    def store(context: click.Context, parameter: click.Parameter, value: object) -> object:
        """Set the field where the option is given. Logging may depend on it."""
        if value:
            state = state_of(context)
            setattr(state, name, value)
            configure_logging(state)
        return value

    return store
