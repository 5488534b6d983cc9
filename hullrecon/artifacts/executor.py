# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run `context.map` here, in worker processes, or on a Dask cluster: same results, same order."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import socket
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from multiprocessing.context import BaseContext
from typing import Any, Self, TypeVar
from urllib.parse import urlsplit

from hullrecon.artifacts.processes import (
    clean_context,
    end_with_parent,
    one_thread_each,
    stop_server,
)
from hullrecon.errors import StageError, UsageError
from hullrecon.memory import keep_free_memory

Item = TypeVar("Item")
Result = TypeVar("Result")
log = logging.getLogger(__name__)
_CHUNKS_PER_WORKER = 8  # at least, so that workers end at about the same time
# Items of a chunk at most: those that a worker has not returned yet are lost with the run, and a
# last large chunk would keep one worker busy while the others wait.
_LARGEST_CHUNK = 4
_CERTIFICATES = ("distributed.comm.tls.ca-file", "distributed.comm.tls.client.cert")
_AHEAD = 256  # items submitted to a cluster at a time: their results take memory there
_CONNECT_S = 10  # how long a connection to the scheduler is tried
_RETRY_S = 0.1  # between two tries


class Executor:
    """Runs in this process, one item after another."""

    def map(self, function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
        """Yield results in the order of the items.

        Raises StageError when a worker dies, and a worker that repeats its work dies too. An error
        of the function passes as it is.
        """
        return map(function, items)

    def fork_workers(self) -> None:
        """Start the workers, if this executor has any, as copies of this process.

        It is to be called before the process has threads or data.
        """

    def close(self) -> None: ...

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


class Processes(Executor):
    """Worker processes, started at the first map and kept until the executor is closed.

    The executor can be pickled as long as it has not started any.
    """

    def __init__(self, jobs: int) -> None:
        self._jobs = jobs
        self._pool: ProcessPoolExecutor | None = None

    def map(self, function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
        """See `Executor`. After a worker was killed, go on once more with half as many."""
        if len(items) < 2:
            yield from map(function, items)
            return
        done = 0
        for is_last_try in (False, True):
            try:
                for result in self._map_once(function, items[done:]):
                    yield result
                    done += 1
                return
            except BrokenProcessPool as error:
                self._lose_pool()
                if is_last_try:
                    raise StageError(
                        f"a worker process was killed, and again at item {done + 1} of"
                        f" {len(items)} or soon after it",
                        remedy="most likely the memory ran out: run again with a smaller --jobs,"
                        " what is finished is kept",
                    ) from error
            log.warning(
                "a worker process was killed: from item %d of %d on, the work is done again by %d"
                " worker%s",
                done + 1,
                len(items),
                self._jobs,
                "s" * (self._jobs > 1),
            )

    def _map_once(
        self, function: Callable[[Item], Result], items: Sequence[Item]
    ) -> Iterator[Result]:
        """Map over all items, in chunks that leave each worker several."""
        pool = self._start_pool()
        chunk = len(items) // (self._jobs * _CHUNKS_PER_WORKER)
        chunk = min(max(1, chunk), _LARGEST_CHUNK)
        return pool.map(function, items, chunksize=chunk)

    def _lose_pool(self) -> None:
        """Forget a pool that has lost a worker, and go on with half as many workers.

        Most often workers are killed because together they need more memory than there is.
        """
        self._pool, self._jobs = None, max(1, self._jobs // 2)

    def fork_workers(self) -> None:
        """Start the workers as copies of this process, which has no threads and no data yet."""
        self._pool = self._make_pool(multiprocessing.get_context("fork"))
        self._pool.submit(os.getpid)  # the first call starts all

    def _start_pool(self) -> ProcessPoolExecutor:
        if self._pool is None:
            self._pool = self._make_pool(clean_context())
        return self._pool

    def _make_pool(self, context: BaseContext) -> ProcessPoolExecutor:
        """Make the pool. Its workers compute with one thread each."""
        with one_thread_each():
            environment = dict(os.environ)
        return ProcessPoolExecutor(
            self._jobs, mp_context=context, initializer=_prepare_worker, initargs=(environment,)
        )

    def close(self) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)
            stop_server()


def _prepare_worker(environment: Mapping[str, str]) -> None:
    """Set a worker's environment, let it ignore Ctrl-C, end with its parent and reuse memory."""
    os.environ.update(environment)
    keep_free_memory()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    end_with_parent()


class Cluster(Executor):
    """A Dask cluster. Its workers need hullrecon and the same paths to the package and to RUNS.

    What goes over the wire is pickled: whoever reaches a port of a plain (tcp://) cluster can run
    any program on all its machines.
    """

    def __init__(self, address: str) -> None:
        _refuse_address(address)
        self._address = address
        self._client: Any = _connect(address)

    def __getstate__(self) -> dict[str, Any]:
        """Pickle the address. The copy connects when it is used."""
        return {"_address": self._address, "_client": None}

    def map(self, function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
        """See `Executor`.

        Always _AHEAD items are submitted, so that no worker waits for work.
        """
        from distributed import CancelledError, KilledWorker
        from distributed.comm import CommClosedError

        if self._client is None:
            _refuse_unreachable(self._address)
            self._client = _connect(self._address)
        begun = deque(self._client.map(function, items[:_AHEAD], pure=False))
        try:
            for item in items[_AHEAD:]:
                yield begun.popleft().result()
                begun.append(self._client.submit(function, item, pure=False))
            while begun:
                yield begun.popleft().result()
        except KilledWorker as error:
            raise StageError(
                "a Dask worker was killed",
                remedy="look at the worker's log: most likely its memory ran out",
            ) from error
        except (CancelledError, CommClosedError) as error:
            raise StageError(
                "the Dask scheduler has gone",
                where=self._address,
                remedy="start one with pipelines/dask-launch and run again: what is finished is"
                " kept",
            ) from error
        finally:
            with suppress(CommClosedError):
                self._client.cancel(list(begun))

    def close(self) -> None:
        if self._client is not None:
            self._client.close()


def _refuse_address(address: str) -> None:
    """Raise UsageError if Dask is not installed, does not answer or has no certificates for tls.

    Warns of an address without tls.
    """
    try:
        import dask
    except ImportError as error:
        raise UsageError("--scheduler needs Dask", remedy="install hullrecon[cluster]") from error
    _refuse_unreachable(address)
    if urlsplit(address).scheme == "tls":
        missing = [key for key in _CERTIFICATES if not dask.config.get(key, None)]
        if missing:
            raise UsageError(
                f"Dask's configuration lacks {' and '.join(missing)}",
                where=address,
                remedy="set them in ~/.config/dask, or as DASK_DISTRIBUTED__COMM__TLS__CA_FILE"
                " and so on",
            )
    else:
        log.warning(
            "%s is plain TCP: whoever reaches its port runs programs here; give tls:// where others"
            " can",
            address,
        )


def _connect(address: str) -> Any:
    """Connect to a Dask scheduler. Raises UsageError where none answers."""
    from distributed import Client

    try:
        return Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise _no_scheduler(address) from error


def _refuse_unreachable(address: str) -> None:
    """Raise UsageError unless something listens at `tcp://HOST:PORT` or `tls://HOST:PORT`.

    A Client that finds nobody keeps trying in a thread of its own, which ends with a traceback long
    after the error.
    """
    try:
        parts = urlsplit(address)
        host, port = parts.hostname, parts.port
        if parts.scheme not in ("tcp", "tls") or host is None or port is None:
            raise ValueError(address)
    except ValueError:
        raise UsageError(
            "not an address of a Dask scheduler",
            where=address,
            remedy="give tcp://HOST:PORT or tls://HOST:PORT",
        ) from None
    until = time.monotonic() + _CONNECT_S
    while True:
        try:
            socket.create_connection((host, port), timeout=_CONNECT_S).close()
            return
        except OSError as error:  # it may be starting, unless its name is unknown
            if isinstance(error, socket.gaierror) or time.monotonic() >= until:
                raise _no_scheduler(address) from None
            time.sleep(_RETRY_S)


def _no_scheduler(address: str) -> UsageError:
    return UsageError(
        "no Dask scheduler answers", where=address, remedy="start one with pipelines/dask-launch"
    )


def choose_executor(jobs: int = 1, scheduler: str | None = None) -> Executor:
    """Make the executor that `--jobs` and `--scheduler` ask for."""
    if scheduler is not None:
        return Cluster(scheduler)
    return Processes(jobs) if jobs > 1 else Executor()
