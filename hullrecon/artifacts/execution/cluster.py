# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""`context.map` on a Dask cluster. Its workers need hullrecon installed and the same paths to the
package and to RUNS.

What goes over the wire is pickled: whoever reaches a port of a plain cluster runs what he likes on
all its machines.
"""

from __future__ import annotations

import logging
import socket
import time
from collections.abc import Callable, Iterator, Sequence
from types import TracebackType
from typing import Any, Self, TypeVar
from urllib.parse import urlsplit

from hullrecon.errors import StageError, UsageError

Item = TypeVar("Item")
Result = TypeVar("Result")
log = logging.getLogger(__name__)
_CERTIFICATES = ("distributed.comm.tls.ca-file", "distributed.comm.tls.client.cert")
_CONNECT_S = 10
_RETRY_S = 0.1


class Cluster:
    def __init__(self, address: str) -> None:
        self._client: Any = _connect(address)

    def map(self, function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
        from distributed import KilledWorker

        futures = self._client.map(function, items, pure=False)
        try:
            for future in futures:
                yield future.result()
        except KilledWorker as error:
            raise StageError(
                "a Dask worker was killed",
                remedy="look at the worker's log: most likely its memory ran out",
            ) from error
        finally:
            self._client.cancel(futures)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._client.close()


def _connect(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError as error:
        raise UsageError("--scheduler needs Dask", remedy="install hullrecon[cluster]") from error
    _refuse_unreachable(address)
    if urlsplit(address).scheme == "tls":
        _refuse_without_certificates(address)
    else:
        log.warning(
            "%s is plain TCP: whoever reaches its port runs programs here; give tls:// where others can",
            address,
        )
    try:
        return Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise _no_scheduler(address) from error


def _refuse_without_certificates(address: str) -> None:
    """Raise UsageError where Dask's configuration names no certificates."""
    import dask

    missing = [key for key in _CERTIFICATES if not dask.config.get(key, None)]
    if missing:
        remedy = "set them in ~/.config/dask, or as DASK_DISTRIBUTED__COMM__TLS__CA_FILE and so on"
        raise UsageError(
            f"Dask's configuration lacks {' and '.join(missing)}", where=address, remedy=remedy
        )


def _refuse_unreachable(address: str) -> None:
    """Raise UsageError unless something listens at `tcp://HOST:PORT` or `tls://HOST:PORT`.

    A Client that finds nobody keeps trying in a thread of its own, which ends long after the error,
    with a traceback.
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
        except socket.gaierror:
            raise _no_scheduler(address) from None
        except OSError:  # it may be starting
            if time.monotonic() >= until:
                raise _no_scheduler(address) from None
            time.sleep(_RETRY_S)


def _no_scheduler(address: str) -> UsageError:
    return UsageError(
        "no Dask scheduler answers", where=address, remedy="start one with pipelines/dask-launch"
    )
