# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""Read untrusted files: regular files only, up to a largest size."""

from __future__ import annotations

import codecs
import errno
import gzip
import io
import os
import stat
import zlib
from pathlib import Path
from typing import BinaryIO

GROWTH = 1 << 16  # bytes read at a time of a file that is longer than its stated size
BLOCK = 1 << 20  # bytes unpacked at a time
MIB = 1 << 20
KINDS = (
    (stat.S_ISFIFO, "a FIFO"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)

# marks with which Windows begins a text, by its coding
MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
LFS_POINTER = b"version https://git-lfs"
LFS_WORDS = "a pointer of Git LFS: the file itself was not fetched", "fetch it with git lfs pull"


def open_regular(path: Path) -> BinaryIO:
    """Open a file to be read.

    Raises OSError, without waiting, for what cannot be opened and for a FIFO, a socket or a device.
    """
    _refuse_special(path, path.stat())
    # A file may be replaced between check and opening. So what was opened is checked again.
    # With O_NONBLOCK opening does not wait, not even for a FIFO.
    stream = os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb")
    try:
        _refuse_special(path, os.fstat(stream.fileno()))
    except OSError:
        stream.close()
        raise
    return stream


def special_kind(mode: int) -> str:
    """Name the kind of a file by its mode: "a FIFO", "a socket", "a device". "" for all others."""
    return next((kind for is_kind, kind in KINDS if is_kind(mode)), "")


def special_file(path: Path) -> str:
    """Name a path's kind where it is neither file nor folder. "" where nothing is there."""
    try:
        return special_kind(path.stat().st_mode)
    except (OSError, ValueError):
        return ""


def read_regular(path: Path, largest_bytes: int) -> bytes:
    """Read a file. Raises OSError like open_regular, and for more than `largest_bytes`."""
    with open_regular(path) as stream:
        size = os.fstat(stream.fileno()).st_size
        if size > largest_bytes:
            raise too_large(path, largest_bytes)
        data = stream.read(size)  # read allocates all that is asked for, so not largest_bytes
        # more bytes where the file has grown, or where its size was not known
        while len(data) <= largest_bytes and (more := stream.read(GROWTH)):
            data += more
    if len(data) > largest_bytes:
        raise too_large(path, largest_bytes)
    return data


def read_text(path: Path, largest_bytes: int) -> str:
    """Read a text of UTF-8 or of the coding that its mark states, its line ends as newlines.

    Raises OSError like read_regular, and UnicodeDecodeError.
    """
    data = read_regular(path, largest_bytes)
    text = data.decode(marked_coding(data) or "utf-8")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def marked_coding(data: bytes) -> str:
    """Name the coding whose mark a text begins with. "" where it begins with none."""
    return next((coding for mark, coding in MARKS.items() if data.startswith(mark)), "")


def too_large(path: Path, largest_bytes: int) -> OSError:
    """Make the error for a file that holds more than it may."""
    return OSError(errno.EFBIG, f"it holds more than {largest_bytes / MIB:g} MiB", str(path))


def gunzip(data: bytes, largest_bytes: int) -> bytes:
    """Unpack a gzip file, comparing its checksums.

    It is unpacked twice: the first pass only counts bytes, so that a small file does not fill the
    memory.

    Raises ValueError when the file is damaged or holds more than `largest_bytes`.
    """
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(data)) as stream:
            size = 0
            while block := stream.read(BLOCK):
                size += len(block)
                if size > largest_bytes:
                    raise ValueError(f"it unpacks to more than {largest_bytes / MIB:g} MiB")
        with gzip.GzipFile(fileobj=io.BytesIO(data)) as stream:
            return stream.read()
    except (OSError, EOFError, zlib.error) as error:
        raise ValueError(str(error)) from None


def _refuse_special(path: Path, found: os.stat_result) -> None:
    """Raise OSError where a file is a FIFO, a socket or a device."""
    kind = special_kind(found.st_mode)
    if kind:
        raise OSError(errno.EINVAL, f"it is {kind}, not a file", str(path))
