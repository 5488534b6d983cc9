# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run cases in a process whose memory is limited, and start another when it dies or hangs."""

from __future__ import annotations

import os
import resource
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import astuple
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TextIO

from benchmarks.fuzz.cases import LARGEST_BYTES, Bench, Verdict
from benchmarks.fuzz.readings import parse_each_yaml_once

# of addresses beyond those at the start; what is used beyond LARGEST_BYTES is a failure already
ROOM_BYTES = 2 * LARGEST_BYTES
# of the clock: a case that waits for something uses no processor; one that only waits for it is let
# wait
PATIENCE_S = 120.0
STUCK_S = 10.0  # of the processor, in native code that no signal of Python's ends
START_S = 1800.0  # of the clock, for the imports on a machine that others use


class Worker:
    """One process that runs cases, replaced when it is lost."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._start()

    def run(self, form: str, seed: int, case: int) -> Verdict:
        """Return the verdict on a case; a process that ended is a verdict as well."""
        return next(verdict for _, verdict in self.run_batch(form, seed, range(case, case + 1)))

    def run_batch(self, form: str, seed: int, cases: range) -> Iterator[tuple[int, Verdict]]:
        """Yield the verdict on each case. The process is not waited for between two of them; one
        that is lost is replaced.
        """
        while cases:
            with suppress(BrokenPipeError, ConnectionResetError):
                self._connection.send((form, seed, cases))
            lost = False
            while cases and not lost:
                verdict, lost = self._receive()
                if lost:
                    self._process.kill()
                    self._process.join()
                    self._start()
                yield cases[0], verdict
                cases = cases[1:]

    def _receive(self) -> tuple[Verdict, bool]:
        """Wait for the next verdict; the second value says that the process is lost."""
        used_s = -1.0
        try:
            while not self._connection.poll(PATIENCE_S):
                before_s, (state, used_s) = used_s, _process_state(self.pid)
                stuck = 0 <= before_s < used_s - STUCK_S
                if state not in "R" or stuck:
                    return Verdict(
                        "hang", f"no answer in {PATIENCE_S:g} s, the process is in state {state}"
                    ), True
            return Verdict(*self._connection.recv()), False
        except (EOFError, ConnectionResetError):
            self._process.join()
            return Verdict("crash", f"the process ended with {self._process.exitcode}"), True

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
        self._process = context.Process(
            target=_serve, args=(theirs, str(self._folder)), daemon=True
        )
        self._process.start()
        theirs.close()
        if not self._connection.poll(START_S):
            raise TimeoutError("a worker process does not start")
        self._connection.recv()


def _serve(connection: Connection, folder: str) -> None:
    """Answer cases until the other side closes. Decoders print on standard error themselves; that
    goes to a file.
    """
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    parse_each_yaml_once()
    with tempfile.TemporaryDirectory(dir=folder) as own:
        bench = Bench(Path(own))
        connection.send("ready")
        limited = False
        while True:
            try:
                form, seed, cases = connection.recv()
            except EOFError:
                return
            for case in cases:
                verdict = bench.run(form, seed, case)
                connection.send(astuple(verdict))
                if not limited:  # what is imported lazily is there after the first case
                    limit_memory(ROOM_BYTES)
                    limited = True


def _process_state(pid: int) -> tuple[str, float]:
    """Return the kernel's letter for what a process does, and the seconds of the processor that it
    has used.
    """
    words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return words[0], (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def limit_memory(room_bytes: int) -> None:
    """Let this process map so many more bytes than it has now."""
    with Path("/proc/self/statm").open() as status:
        pages = int(_first_word(status))
    limit = pages * resource.getpagesize() + room_bytes
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))


def _first_word(status: TextIO) -> str:
    return status.read().split()[0]
