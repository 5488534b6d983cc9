# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from hullrecon.dive.logs.formats.db3_tables import FRAME_HEAD, HEADER, describe_damage

FRAME = FRAME_HEAD + 4096


@pytest.fixture(scope="module")
def content(tmp_path_factory) -> bytes:
    """Ten transactions as SQLite itself writes them."""
    path = tmp_path_factory.mktemp("wal") / "x.db3"
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA page_size = 4096")
        connection.execute("PRAGMA journal_mode = wal")
        connection.execute("PRAGMA wal_autocheckpoint = 0")
        connection.execute("CREATE TABLE rows (id INTEGER PRIMARY KEY, data BLOB)")
        for n in range(10):
            connection.execute("INSERT INTO rows VALUES (?, ?)", (n, bytes([n]) * 3000))
            connection.commit()
        return Path(f"{path}-wal").read_bytes()


def damage(tmp_path: Path, content: bytes) -> str:
    (tmp_path / "x.db3-wal").write_bytes(content)
    return describe_damage(tmp_path / "x.db3-wal")


def test_a_whole_log_has_no_damage(tmp_path, content):
    assert damage(tmp_path, content) == ""
    assert damage(tmp_path, content[:HEADER]) == ""


@pytest.mark.parametrize("frame", [1, 3, 8])
@pytest.mark.parametrize("byte", [0, 9, 17, 500])
def test_a_flipped_bit_is_found_in_its_frame(tmp_path, content, frame, byte):
    broken = bytearray(content)
    broken[HEADER + (frame - 1) * FRAME + byte] ^= 4
    assert damage(tmp_path, bytes(broken)) == f"it is damaged from frame {frame} on"


@pytest.mark.parametrize("byte", [0, 5, 9, 17, 25])
def test_a_damaged_header_is_found(tmp_path, content, byte):
    broken = bytearray(content)
    broken[byte] ^= 1
    assert damage(tmp_path, bytes(broken)) == "its header is damaged"


@pytest.mark.parametrize("rest", [5, 30, 2000])
def test_a_cut_is_found(tmp_path, content, rest):
    assert damage(tmp_path, content[: HEADER + 4 * FRAME + rest]) in (
        "it is cut off",
        "it is damaged from frame 5 on",
    )


def test_a_byte_too_many_is_found(tmp_path, content):
    at = HEADER + 2 * FRAME + 100
    assert (
        damage(tmp_path, content[:at] + b"\x00" + content[at:]) == "it is damaged from frame 3 on"
    )


def test_trailing_frames_of_an_older_generation_are_no_damage(tmp_path, content):
    old = bytearray(content[HEADER : HEADER + 3 * FRAME])
    for at in range(0, len(old), FRAME):
        old[at + 8] ^= 0xFF  # another salt
    assert damage(tmp_path, content + bytes(old)) == ""


def test_a_transaction_that_was_not_finished_is_named(tmp_path):
    path = tmp_path / "y.db3"
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA journal_mode = wal")
        connection.execute("PRAGMA cache_size = 1")
        connection.execute("CREATE TABLE rows (id INTEGER PRIMARY KEY, data BLOB)")
        connection.commit()
        for n in range(100):
            connection.execute("INSERT INTO rows VALUES (?, ?)", (n, bytes(3000)))
        assert (
            damage(tmp_path, Path(f"{path}-wal").read_bytes())
            == "its last transaction was not finished"
        )
