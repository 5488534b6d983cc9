# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run cases in a process whose memory is limited, and start another when it dies or hangs."""

from __future__ import annotations

import os
import resource
import tempfile
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TextIO

from benchmarks.fuzz.cases import LARGEST_BYTES, Bench, Verdict

ROOM_BYTES = 2 * LARGEST_BYTES  # of addresses beyond those at the start; what is used beyond LARGEST_BYTES is a failure already
PATIENCE_S = 120.0  # of the clock: a case that waits for something uses no processor
START_S = 1800.0  # of the clock, for the imports on a machine that others use


class Worker:
    """One process that runs cases, replaced when it is lost."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._start()

    def run(self, form: str, seed: int, case: int) -> Verdict:
        """Return the verdict on a case; the end of the process is one too."""
        try:
            self._connection.send((form, seed, case))
            if self._connection.poll(PATIENCE_S):
                kind, text = self._connection.recv()
                return Verdict(kind, text)
            return self._replace(Verdict("hang", f"no answer in {PATIENCE_S:g} s"))
        except (EOFError, BrokenPipeError, ConnectionResetError):
            self._process.join()
            return self._replace(Verdict("crash", f"the process ended with {self._process.exitcode}"))

    @property
    def pid(self) -> int:
        """Return the number of the process that runs the cases now."""
        assert self._process.pid is not None
        return self._process.pid

    def stop(self) -> None:
        """End the process."""
        self._connection.close()
        self._process.join(5)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()

    def _start(self) -> None:
        context = get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, str(self._folder)), daemon=True)
        self._process.start()
        theirs.close()
        if not self._connection.poll(START_S):
            raise TimeoutError("a worker process does not start")
        self._connection.recv()

    def _replace(self, verdict: Verdict) -> Verdict:
        self._process.kill()
        self._process.join()
        self._start()
        return verdict


def _serve(connection: Connection, folder: str) -> None:
    """Answer cases until the other side closes. Decoders print on standard error themselves; that goes to a file."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    with tempfile.TemporaryDirectory(dir=folder) as own:
        bench = Bench(Path(own))
        connection.send("ready")
        limited = False
        while True:
            try:
                form, seed, case = connection.recv()
            except EOFError:
                return
            verdict = bench.run(form, seed, case)
            connection.send((verdict.kind, verdict.text))
            if not limited:  # what is imported lazily is there after the first case
                limit_memory(ROOM_BYTES)
                limited = True


def limit_memory(room_bytes: int) -> None:
    """Let this process map so many more bytes than it has now."""
    with Path("/proc/self/statm").open() as status:
        pages = int(_first_word(status))
    limit = pages * resource.getpagesize() + room_bytes
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def _first_word(status: TextIO) -> str:
    return status.read().split()[0]
