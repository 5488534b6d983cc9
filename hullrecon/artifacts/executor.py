# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Run `context.map` here, in worker processes, or on a Dask cluster: same results, same order."""

from __future__ import annotations

import logging
import multiprocessing
import os
import signal
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing.connection import wait
from typing import Any, Self, TypeVar
from urllib.parse import urlsplit

from hullrecon.errors import StageError, UsageError

Item = TypeVar("Item")
Result = TypeVar("Result")
log = logging.getLogger(__name__)
# A worker has one core: libraries that count the machine's cores would start that many threads.
THREAD_VARIABLES = (
    "OPENBLAS_NUM_THREADS",
    "OMP_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "OPENCV_FOR_THREADS_NUM",
)
_CHUNKS_PER_WORKER = 8
_LARGEST_CHUNK = 8  # items: what a worker has not returned yet is lost with the run
_CERTIFICATES = ("distributed.comm.tls.ca-file", "distributed.comm.tls.client.cert")
_AHEAD = 256  # items that a cluster is given at a time: it holds their results
_CONNECT_S = 10
_RETRY_S = 0.1


class Executor:
    """Runs in this process, one item after another."""

    def map(self, function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
        """Yield results in the order of the items.

        Raises StageError when a worker dies and its work, done again, kills one too. An error of
        the function passes as it is.
        """
        return map(function, items)

    def close(self) -> None: ...

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


class Processes(Executor):
    """Worker processes, started at the first map and kept until the end of the run."""

    def __init__(self, jobs: int) -> None:
        self._jobs = jobs
        self._pool: ProcessPoolExecutor | None = None

    def map(self, function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
        """See `Executor`. Where a worker is killed, go on once with half as many."""
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
        pool = self._start_pool()
        chunk = len(items) // (self._jobs * _CHUNKS_PER_WORKER)
        chunk = min(max(1, chunk), _LARGEST_CHUNK)
        with one_thread_each():
            return pool.map(function, items, chunksize=chunk)

    def _lose_pool(self) -> None:
        """Forget a pool that has lost a worker, and go on with half of its workers.

        What kills workers is most often that they need more memory together than there is.
        """
        self._pool, self._jobs = None, max(1, self._jobs // 2)

    def _start_pool(self) -> ProcessPoolExecutor:
        if self._pool is None:
            # fork would copy the locks and threads of libraries
            context = multiprocessing.get_context("spawn")
            self._pool = ProcessPoolExecutor(
                self._jobs, mp_context=context, initializer=_prepare_worker
            )
        return self._pool

    def close(self) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def one_thread_each() -> Iterator[None]:
    """Let processes started inside have one thread each, unless the environment says otherwise."""
    added = [name for name in THREAD_VARIABLES if name not in os.environ]
    os.environ.update(dict.fromkeys(added, "1"))
    try:
        yield
    finally:
        for name in added:
            del os.environ[name]


def _prepare_worker() -> None:
    """Leave Ctrl-C to the parent, and end a worker whose parent was killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)


class Cluster(Executor):
    """A Dask cluster. Its workers need hullrecon and the same paths to the package and to RUNS.

    What goes over the wire is pickled: whoever reaches a port of a plain (tcp://) cluster can run
    any program on all its machines.
    """

    def __init__(self, address: str) -> None:
        self._address = address
        self._client: Any = _connect(address)

    def map(self, function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
        from distributed import CancelledError, KilledWorker
        from distributed.comm import CommClosedError

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
        self._client.close()


def _connect(address: str) -> Any:
    try:
        import dask
        from distributed import Client
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
