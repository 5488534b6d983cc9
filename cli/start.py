# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""End the process with the exit code that was reported, also if Ctrl-C came during imports."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress
from typing import NoReturn

INTERRUPTED = 130


def start() -> NoReturn:
    """Run the program and end the process."""
    try:
        from .main import main

        code = main()
        # The result is printed: ignore a signal that comes now.
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
    except KeyboardInterrupt:  # before there was a command
        print("error: interrupted", file=sys.stderr)
        code = INTERRUPTED
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    if code:
        # sys.exit may end with another code: a library whose import was interrupted, or a full
        # standard output (120), would replace it.
        os._exit(code)
    sys.exit(code)


if __name__ == "__main__":
    start()
