# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Start processes that begin clean, have one thread a library, and end with their parent."""

from __future__ import annotations

import fcntl
import multiprocessing
import os
import signal
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from multiprocessing import forkserver, resource_tracker, util
from multiprocessing.connection import wait
from multiprocessing.context import ForkServerContext

from hullrecon.errors import StageError

# A worker has one core: libraries that count the machine's cores would start that many threads.
THREAD_VARIABLES = (
    "OPENBLAS_NUM_THREADS",
    "OMP_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "OPENCV_FOR_THREADS_NUM",
)
# Linux has 108 bytes for the path of a socket. The library adds two names of up to 18, and a zero.
_LONGEST_FOLDER_OF_SOCKETS = 70


def clean_context(preload: Sequence[str] = ()) -> ForkServerContext:
    """Start the fork server, and return the context whose processes are copies of it.

    A copy of this process would have the locks and the memory of its libraries, but not their
    threads, and might hang. The server has no threads.

    Parameters
    ----------
    preload
        Modules that the server imports for all its copies. They must start no threads. They are
        ignored if the server runs already.

    Raises
    ------
    StageError
        The server's socket cannot be made in the folder for temporary files.
    """
    context = multiprocessing.get_context("forkserver")
    # without a name of its own it would import the user's script, which may start threads
    context.set_forkserver_preload([*preload] or [__name__])
    resource_tracker.ensure_running()
    # Ctrl-C reaches all processes of a terminal, and would end the server in its imports
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        with one_thread_each():
            _choose_folder_of_sockets()
            forkserver.ensure_running()
    except OSError as error:
        raise StageError(
            f"no process can be started: {error.strerror or error}",
            where=error.filename or tempfile.gettempdir(),
            remedy="TMPDIR must name a folder that may be written, with free space",
        ) from error
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    return context


def _choose_folder_of_sockets() -> None:
    """Put the server's socket below /tmp where the path of TMPDIR is too long for a socket.

    Folders that a batch system makes for a job often are.
    """
    folder = tempfile.gettempdir()
    if len(os.fsencode(folder)) > _LONGEST_FOLDER_OF_SOCKETS:
        tempfile.tempdir = "/tmp"
    try:
        util.get_temp_dir()  # made once, and removed when this process ends
    finally:
        tempfile.tempdir = folder


def stop_server() -> None:
    """End the server, unless copies of it still run.

    The CPU time of an ended server counts as that of this process's children.
    """
    if not multiprocessing.active_children():
        forkserver._forkserver._stop()  # type: ignore[attr-defined]  # nothing public does it


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


def end_with_parent() -> None:
    """Let the kernel kill this process when its parent ends, for whatever reason.

    When the parent ends, a pipe is closed, for which the kernel sends SIGKILL. A thread that waits
    for it instead would need the interpreter, which a step may hold for seconds, while a new run
    already works in the same folder.
    """
    parent = multiprocessing.parent_process()
    assert parent is not None
    sentinel = parent.sentinel
    fcntl.fcntl(sentinel, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(sentinel, fcntl.F_SETSIG, signal.SIGKILL)
    flags = fcntl.fcntl(sentinel, fcntl.F_GETFL)
    fcntl.fcntl(sentinel, fcntl.F_SETFL, flags | os.O_ASYNC)
    if wait([sentinel], 0):  # it had ended before
        os._exit(1)
