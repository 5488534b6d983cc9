# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import errno
import os
import shutil
import sqlite3
import stat
from collections import Counter
from contextlib import closing
from pathlib import Path

import pytest

from hullrecon.dive.logs.read_streams import read_streams
from hullrecon.dive.logs.readers.open import open_log
from hullrecon.dive.logs.readers.sqlite import SqliteLog
from hullrecon.errors import InputError, StorageError
from hullrecon.findings.finding import Finding, sentences


@pytest.fixture(scope="module")
def whole(kit, tmp_path_factory) -> Path:
    return next(kit.ros2(tmp_path_factory.mktemp("db3") / "bag", kit.dive()).glob("*.db3"))


@pytest.fixture
def database(whole, tmp_path) -> Path:
    return Path(shutil.copy(whole, tmp_path / "dive.db3"))


@pytest.fixture
def unmerged(whole, tmp_path) -> Path:
    """A database of a recorder that was killed: the newer half of its rows stands in the
    write-ahead log alone.
    """
    work, out = tmp_path / "work.db3", tmp_path / "killed" / "dive.db3"
    shutil.copy(whole, work)
    with closing(sqlite3.connect(work)) as connection:
        connection.execute("PRAGMA journal_mode = wal")
        connection.execute("PRAGMA wal_autocheckpoint = 0")
        rows = connection.execute("SELECT * FROM messages WHERE id > 48").fetchall()
        connection.execute("DELETE FROM messages WHERE id > 48")
        connection.commit()
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        for row in rows:
            connection.execute("INSERT INTO messages VALUES (?, ?, ?, ?)", row)
            connection.commit()
        out.parent.mkdir()
        shutil.copy(work, out)
        shutil.copy(f"{work}-wal", f"{out}-wal")
    return out


def read(path: Path):
    log = SqliteLog(path)
    return list(log.messages()), log


def change(path: Path, *statements: str) -> None:
    with closing(sqlite3.connect(path)) as connection:
        for statement in statements:
            connection.execute(statement)
        connection.commit()


def test_a_database_carries_no_checksums_and_that_is_said(kit, whole):
    messages, log = read(whole)
    assert len(messages) == len(kit.dive())
    assert log.losses() == []
    assert log.notes == [Finding("database-no-checksum")]


def test_messages_of_an_unmerged_write_ahead_log_are_read(kit, unmerged):
    messages, log = read(unmerged)
    assert Counter(m.channel.topic for m in messages) == Counter(e.topic for e in kit.dive())
    assert log.losses() == []
    assert any("write-ahead log" in note for note in sentences(log.notes))


def test_reading_a_write_ahead_log_leaves_package_unchanged(kit, unmerged):
    folder = unmerged.parent
    before = {p.name: (p.read_bytes(), p.stat().st_mtime_ns) for p in folder.iterdir()}
    modes = {p: p.stat().st_mode for p in (folder, *folder.iterdir())}
    for path in modes:
        path.chmod(0o555 if stat.S_ISDIR(modes[path]) else 0o444)
    try:
        assert len(read(unmerged)[0]) == len(kit.dive())
        assert {p.name: (p.read_bytes(), p.stat().st_mtime_ns) for p in folder.iterdir()} == before
    finally:
        for path, mode in modes.items():
            path.chmod(mode)


def test_no_room_for_the_write_ahead_log_leaves_nothing(unmerged, tmp_path, monkeypatch):
    def copy(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    (tmp_path / "full").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "full"))
    monkeypatch.setattr(shutil, "copyfile", copy)
    with pytest.raises(StorageError, match="no space to unpack a log"):
        read(unmerged)
    assert list((tmp_path / "full").iterdir()) == []


@pytest.mark.parametrize("damage", ["flip", "cut", "insert", "header"])
def test_what_a_damaged_write_ahead_log_loses_is_named(kit, unmerged, damage):
    log = unmerged.with_name("dive.db3-wal")
    content = bytearray(log.read_bytes())
    middle = len(content) // 2
    if damage == "flip":
        content[middle] ^= 1
    elif damage == "cut":
        del content[middle:]
    elif damage == "insert":
        content[middle:middle] = b"\x00"
    else:
        content[8] ^= 1
    log.write_bytes(content)
    messages, found = read(unmerged)
    assert 48 <= len(messages) < len(kit.dive())
    assert any(
        "write-ahead log beside the database is not whole" in loss.why for loss in found.losses()
    )


def test_a_write_ahead_log_that_was_merged_long_ago_is_no_loss(unmerged, kit):
    """Frames of an older generation stand behind those of the last one."""
    with closing(sqlite3.connect(unmerged)) as connection:
        connection.execute("PRAGMA wal_checkpoint(RESTART)")
        connection.execute("UPDATE topics SET name = '/other' WHERE name = '/imu'")
        connection.commit()
        kept = {
            name: unmerged.with_name(name).read_bytes() for name in ("dive.db3", "dive.db3-wal")
        }
    for name, content in kept.items():
        unmerged.with_name(name).write_bytes(content)
    messages, log = read(unmerged)
    assert Counter(m.channel.topic for m in messages)["/other"] == 40
    assert log.losses() == []


def test_pipe_as_write_ahead_log_is_a_loss_without_waiting(kit, database):
    os.mkfifo(f"{database}-wal")
    messages, log = read(database)
    assert len(messages) == len(kit.dive())
    assert any("is a pipe" in loss.why for loss in log.losses())


def test_a_journal_beside_a_database_is_named(database):
    database.with_name("dive.db3-journal").write_bytes(b"x")
    assert any("journal" in note for note in sentences(read(database)[1].notes))


def test_row_numbers_far_apart_are_no_work(kit, database):
    change(database, "UPDATE messages SET id = 4611686018427387904 WHERE id = 96")
    messages, log = read(database)
    assert len(messages) == len(kit.dive())
    assert log.losses() == []


def test_damage_in_front_of_a_row_far_away_is_stepped_over(kit, database):
    change(database, "UPDATE messages SET id = 4611686018427387904 WHERE id = 96")
    content = bytearray(database.read_bytes())
    pages = range(0, len(content), 4096)
    leaves = [
        at for at in pages if content[at] == 13 and b"\x00\x01\x00\x00" in content[at : at + 4096]
    ]
    content[leaves[-1] : leaves[-1] + 8] = b"\xff" * 8
    database.write_bytes(content)
    messages, log = read(database)
    assert 0 < len(messages) < len(kit.dive())
    assert any("is damaged from row" in loss.why for loss in log.losses())


@pytest.mark.parametrize(
    ("statement", "lost", "why"),
    [
        (
            "UPDATE messages SET data = 'text' WHERE id = 5",
            1,
            "other things than a topic, a time and bytes",
        ),
        (
            "UPDATE messages SET timestamp = 'noon' WHERE id < 4",
            3,
            "other things than a topic, a time and bytes",
        ),
        (
            "UPDATE messages SET topic_id = x'ff' WHERE id = 7",
            1,
            "other things than a topic, a time and bytes",
        ),
        ("UPDATE messages SET topic_id = 99 WHERE id = 7", 1, "no topic of the database"),
        ("UPDATE topics SET name = x'ff' WHERE name = '/imu'", 40, "no topic of the database"),
        ("UPDATE topics SET type = 3.5 WHERE name = '/imu'", 40, "no topic of the database"),
    ],
)
def test_rows_with_values_in_wrong_columns_are_lost_and_counted(
    kit, database, statement, lost, why
):
    # the columns' types convert what they can; a damaged page asks nobody
    affinity = "PRAGMA writable_schema = 1"
    drop = (
        "UPDATE sqlite_master SET sql = replace(replace(sql, ' TEXT', ''), ' INTEGER NOT NULL', '')"
    )
    change(database, affinity, drop)
    change(database, statement)
    messages, log = read(database)
    assert len(messages) == len(kit.dive()) - lost
    assert [(loss.messages, why in loss.why) for loss in log.losses()] == [(lost, True)]


def test_names_that_are_not_utf8_are_read_all_the_same(kit, database):
    change(database, "UPDATE topics SET name = CAST(x'2fff' AS TEXT) WHERE name = '/imu'")
    messages, _ = read(database)
    assert len(messages) == len(kit.dive())
    assert "/\ufffd" in {m.channel.topic for m in messages}


@pytest.mark.parametrize(
    "schema",
    [
        "CREATE VIEW messages AS WITH RECURSIVE n(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM n)"
        " SELECT id, 1 AS topic_id, id AS timestamp, x'00' AS data FROM n",
        "CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data "
        "AS (zeroblob(100000000)))",
    ],
)
def test_tables_that_are_code_are_refused(database, schema):
    change(database, "DROP TABLE messages", schema)
    with pytest.raises(InputError, match="no rosbag2 database"):
        read(database)


def test_a_database_without_its_first_page_is_one_line(database):
    content = bytearray(database.read_bytes())
    content[100:4096] = b"\xff" * 3996
    database.write_bytes(content)
    with pytest.raises(InputError, match=r"dive\.db3 cannot be read") as caught:
        read(database)
    assert caught.value.line().isprintable()


def test_a_damaged_definition_costs_its_topic_alone(database):
    change(
        database,
        "UPDATE message_definitions SET encoded_message_definition = x'ff00' WHERE topic_type LIKE "
        "'%Imu'",
    )
    log = open_log(database)
    found = read_streams([log], {"/imu": ("imu",), "/pressure": ("pressure",)}, lambda *_: None)
    assert len(found.samples["pressure"]) == 20


def test_a_database_that_was_cut_off_gives_the_rows_of_its_whole_pages(kit, database):
    """As a copy that was broken off: SQLite itself opens no file shorter than its header says."""
    whole, _ = read(database)
    size = database.stat().st_size
    os.truncate(database, size * 2 // 3)
    messages, log = read(database)
    assert 30 < len(messages) < len(whole)
    assert messages == [message for message in whole if message in messages]
    assert f"the database is cut off: {size - size * 2 // 3} bytes of its pages are missing" in [
        loss.why for loss in log.losses()
    ]


def test_row_numbers_that_are_missing_are_counted(database):
    """A page that lost its cells without a trace shows in nothing else."""
    change(database, "DELETE FROM messages WHERE id IN (1, 7, 8)")
    _, log = read(database)
    assert "3 row numbers are missing: rows were deleted, or lost by damage" in sentences(log.notes)
