# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import shutil
import sqlite3
from pathlib import Path

import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hullrecon.dive.logs.messages.decode import decode
from hullrecon.dive.logs.readers.rosbag2 import Rosbag2Log
from hullrecon.dive.logs.readers.sqlite import SqliteLog
from hullrecon.errors import HullreconError, InputError

QUICK = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture], derandomize=True)


@pytest.fixture(scope="module")
def folders(kit, tmp_path_factory) -> dict[str, Path]:
    base = tmp_path_factory.mktemp("ros2")
    return {storage: kit.ros2(base / storage.lower(), kit.dive(), storage) for storage in ("SQLITE3", "MCAP")}


@pytest.fixture
def folder(folders, tmp_path) -> Path:
    return Path(shutil.copytree(folders["SQLITE3"], tmp_path / "bag"))


def database(folder: Path) -> Path:
    return next(folder.glob("*.db3"))


def read(log):
    return list(log.messages()), log


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_a_whole_folder_gives_every_message(kit, folders, storage):
    messages, log = read(Rosbag2Log(folders[storage]))
    assert sorted((m.channel.topic, m.t_ns) for m in messages) == sorted((e.topic, e.t_ns) for e in kit.dive())
    assert log.losses() == []
    ping = next(m for m in messages if m.channel.topic == "/dvl")
    assert decode(ping.channel, ping.data).range[3] == 4.0


def test_without_metadata_the_files_are_read_by_name_and_that_is_said(kit, folder):
    (folder / "metadata.yaml").unlink()
    messages, log = read(Rosbag2Log(folder))
    assert len(messages) == len(kit.dive())
    assert any("metadata.yaml" in remark for remark in log.remarks)


def test_a_file_that_the_metadata_names_but_is_gone_is_a_loss(folder):
    database(folder).unlink()
    messages, log = read(Rosbag2Log(folder))
    assert messages == []
    assert any("is missing" in loss.why for loss in log.losses())


def test_an_empty_file_is_a_loss(folder):
    database(folder).write_bytes(b"")
    _, log = read(Rosbag2Log(folder))
    assert any("is empty" in loss.why for loss in log.losses())


def test_a_file_that_is_no_database_is_a_loss_of_the_folder(folder):
    database(folder).write_bytes(b"nothing of the kind" * 100)
    messages, log = read(Rosbag2Log(folder))
    assert messages == []
    assert any("cannot be read" in loss.why for loss in log.losses())


def test_files_that_were_compressed_whole_are_refused_with_the_remedy(folder):
    text = (folder / "metadata.yaml").read_text().replace("compression_mode: ''", "compression_mode: FILE")
    (folder / "metadata.yaml").write_text(text)
    with pytest.raises(InputError, match="zstd -d"):
        read(Rosbag2Log(folder))


def test_messages_that_were_compressed_one_by_one_are_unpacked(kit, folder):
    text = (folder / "metadata.yaml").read_text().replace("compression_mode: ''", "compression_mode: MESSAGE")
    (folder / "metadata.yaml").write_text(text)
    with sqlite3.connect(database(folder)) as connection:
        rows = connection.execute("SELECT id, data FROM messages").fetchall()
        pack = zstandard.ZstdCompressor().compress
        connection.executemany("UPDATE messages SET data = ? WHERE id = ?", [(pack(data), n) for n, data in rows])
    messages, _ = read(Rosbag2Log(folder))
    pressures = [decode(m.channel, m.data).fluid_pressure for m in messages if m.channel.topic == "/pressure"]
    assert pressures == [e.message.fluid_pressure for e in kit.dive() if e.topic == "/pressure"]


def test_a_database_of_something_else_is_an_input_error(tmp_path):
    path = tmp_path / "other.db3"
    with sqlite3.connect(path) as connection:
        connection.execute("CREATE TABLE cats (name TEXT)")
    with pytest.raises(InputError, match="no rosbag2 database"):
        read(SqliteLog(path))


@pytest.mark.parametrize("share", [0.5, 0.95])
def test_a_cut_database_gives_what_sqlite_reaches_or_a_typed_error(folder, share):
    path = database(folder)
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    messages, log = read(Rosbag2Log(folder))
    assert log.losses()
    assert all(loss.why for loss in log.losses())
    assert len(messages) < 200


def test_a_page_of_rubbish_loses_its_rows_and_not_those_behind(kit, folder):
    path = database(folder)
    content = bytearray(path.read_bytes())
    middle = len(content) // 2 // 4096 * 4096
    content[middle : middle + 4096] = b"\xff" * 4096
    path.write_bytes(content)
    messages, log = read(Rosbag2Log(folder))
    assert len(messages) > 0.3 * len(kit.dive())
    assert len(messages) == len(kit.dive()) or log.losses()


@QUICK
@given(st.data())
def test_any_flipped_bit_is_survived_or_a_typed_error(kit, folders, tmp_path, data):
    content = bytearray(database(folders["SQLITE3"]).read_bytes())
    content[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    path = tmp_path / "x.db3"
    path.write_bytes(content)
    try:
        messages, log = read(SqliteLog(path))
    except HullreconError:
        return
    assert len(messages) <= len(kit.dive())
    assert len(messages) == len(kit.dive()) or log.losses()
