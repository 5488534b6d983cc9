# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import gzip
import os
import socket
import tracemalloc
import zlib
from pathlib import Path

import pytest

from hullrecon.dive.files import MIB, gunzip, open_regular, read_regular, read_text, special_file


@pytest.fixture
def fifo(tmp_path) -> Path:
    os.mkfifo(tmp_path / "fifo")
    return tmp_path / "fifo"


@pytest.fixture
def listening(tmp_path):
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(tmp_path / "socket"))
        yield tmp_path / "socket"


def test_a_file_is_read_whole(tmp_path):
    (tmp_path / "x").write_bytes(b"abc")
    assert read_regular(tmp_path / "x", 3) == b"abc"
    with open_regular(tmp_path / "x") as stream:
        assert stream.read() == b"abc"
    assert special_file(tmp_path / "x") == ""


def test_a_fifo_is_refused_without_waiting_for_a_writer(fifo):
    with pytest.raises(OSError, match="it is a FIFO, not a file"):
        open_regular(fifo)
    assert special_file(fifo) == "a FIFO"


def test_a_link_to_a_fifo_is_one(fifo, tmp_path):
    (tmp_path / "link").symlink_to(fifo)
    with pytest.raises(OSError, match="a FIFO"):
        read_regular(tmp_path / "link", 10)


def test_a_socket_is_refused(listening):
    with pytest.raises(OSError, match="a socket"):
        open_regular(listening)
    assert special_file(listening) == "a socket"


@pytest.mark.parametrize("name", ["zero", "null"])
def test_a_device_is_refused(name):
    with pytest.raises(OSError, match="a device"):
        read_regular(Path("/dev") / name, 10)


def test_a_folder_and_a_missing_file_are_what_the_system_says(tmp_path):
    with pytest.raises(IsADirectoryError):
        read_regular(tmp_path, 10)
    with pytest.raises(FileNotFoundError):
        open_regular(tmp_path / "x")
    assert special_file(tmp_path) == special_file(tmp_path / "x") == ""


def test_file_beyond_its_limit_is_refused_by_size(tmp_path):
    with (tmp_path / "x").open("wb") as stream:
        stream.truncate(1 << 40)
    with pytest.raises(OSError, match="more than 2 MiB"):
        read_regular(tmp_path / "x", 2 * MIB)


def test_a_small_file_is_read_without_room_for_the_largest(tmp_path):
    (tmp_path / "x").write_bytes(b"abc")
    tracemalloc.start()
    try:
        assert read_regular(tmp_path / "x", 64 * MIB) == b"abc"
        assert tracemalloc.get_traced_memory()[1] < MIB
    finally:
        tracemalloc.stop()


def test_a_text_has_newlines_whatever_wrote_it(tmp_path):
    (tmp_path / "x").write_bytes(b"a\r\nb\rc\n")
    assert read_text(tmp_path / "x", 10) == "a\nb\nc\n"


def test_a_gzip_file_of_several_members_unpacks_to_all_of_them():
    assert gunzip(gzip.compress(b"one ") + gzip.compress(b"two") + bytes(7), 7) == b"one two"


def test_a_gzip_bomb_is_counted_and_not_kept():
    packer = zlib.compressobj(9, zlib.DEFLATED, 31)
    bomb = b"".join(packer.compress(bytes(MIB)) for _ in range(200)) + packer.flush()
    with pytest.raises(ValueError, match="more than 3 MiB"):
        gunzip(bomb, 3 * MIB)


@pytest.mark.parametrize("at", [0, 3, 12, 20, -6])
def test_a_damaged_gzip_file_is_a_value_error(at):
    packed = bytearray(gzip.compress(os.urandom(200)))
    packed[at] ^= 0xFF
    with pytest.raises(ValueError, match=r"."):
        gunzip(bytes(packed), MIB)


def test_a_cut_gzip_file_is_a_value_error():
    with pytest.raises(ValueError, match="end"):
        gunzip(gzip.compress(os.urandom(200))[:-9], MIB)
