# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""End the process with the exit code that was reported, also where Ctrl-C met its imports."""

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
        # all is said: one that comes now changes nothing
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
    except KeyboardInterrupt:  # before there was a command
        print("error: interrupted", file=sys.stderr)
        code = INTERRUPTED
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    if code:
        # Libraries whose import was cut short end the process with codes of their own, and a full
        # standard output with 120.
        os._exit(code)
    sys.exit(code)


if __name__ == "__main__":
    start()
