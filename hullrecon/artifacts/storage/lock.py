# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""One writer a workspace; readers never wait. The kernel frees the lock when its holder dies,
however it dies.
"""

from __future__ import annotations

import fcntl
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from hullrecon.artifacts.storage.disk import make_folder, storage_errors
from hullrecon.errors import LockedError

_POLL_S = 0.2


@contextmanager
def hold_lock(path: Path, wait_s: float = 0.0) -> Iterator[None]:
    """Hold the lock of a workspace, the file `path`. Raises LockedError when another holds it after
    `wait_s` seconds.
    """
    make_folder(path.parent)
    with storage_errors(path.parent):
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o666)
    try:
        _acquire(descriptor, path, time.monotonic() + wait_s)
        with storage_errors(path.parent):
            os.truncate(descriptor, 0)
            os.pwrite(descriptor, f"{os.getpid()}\n".encode(), 0)
        try:
            yield
        finally:
            with suppress(OSError):
                # nobody holds it: no file of a finished run is without a checksum
                os.truncate(descriptor, 0)
    finally:
        os.close(descriptor)


def _acquire(descriptor: int, path: Path, until: float) -> None:
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            if time.monotonic() >= until:
                holder = os.pread(descriptor, 32, 0).decode(errors="replace").strip() or "unknown"
                remedy = "wait for it to end, or wait in the command with --wait SECONDS"
                raise LockedError(
                    f"dive is locked by process {holder}",
                    where=str(path.parent.parent),
                    remedy=remedy,
                ) from None
            time.sleep(_POLL_S)
