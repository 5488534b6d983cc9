# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import errno
import gzip
import os
import re
import shutil
import sqlite3
from pathlib import Path

import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hullrecon.dive.check.contents import describe_losses
from hullrecon.dive.logs.messages.decode import decode
from hullrecon.dive.logs.readers.open import find_logs, open_log
from hullrecon.dive.logs.readers.rosbag2 import Rosbag2Log
from hullrecon.dive.logs.readers.sqlite import SqliteLog
from hullrecon.errors import HullreconError, InputError, StorageError
from hullrecon.findings.finding import sentences

QUICK = settings(
    max_examples=20,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
)


@pytest.fixture(scope="module")
def folders(kit, tmp_path_factory) -> dict[str, Path]:
    base = tmp_path_factory.mktemp("ros2")
    return {
        storage: kit.ros2(base / storage.lower(), kit.dive(), storage)
        for storage in ("SQLITE3", "MCAP")
    }


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
    assert sorted((m.channel.topic, m.t_ns) for m in messages) == sorted(
        (e.topic, e.t_ns) for e in kit.dive()
    )
    assert log.losses() == []
    ping = next(m for m in messages if m.channel.topic == "/dvl")
    assert decode(ping.channel, ping.data).range[3] == 4.0


def test_without_metadata_files_are_read_by_name_with_a_note(kit, folder):
    (folder / "metadata.yaml").unlink()
    messages, log = read(Rosbag2Log(folder))
    assert len(messages) == len(kit.dive())
    assert any("metadata.yaml" in note for note in sentences(log.notes))


def test_a_file_that_the_metadata_names_but_is_gone_is_a_loss(folder):
    database(folder).unlink()
    messages, log = read(Rosbag2Log(folder))
    assert messages == []
    assert any("is missing" in loss.why for loss in log.losses())


def test_a_file_that_was_packed_by_hand_is_named_and_read_once_it_is_unpacked(folder, kit):
    path = database(folder)
    path.with_name(path.name + ".gz").write_bytes(gzip.compress(whole := path.read_bytes()))
    path.unlink()
    _, log = read(Rosbag2Log(folder))
    assert any(f"{path.name}.gz lies there: unpack it" in loss.why for loss in log.losses())
    path.write_bytes(whole)
    assert len(read(Rosbag2Log(folder))[0]) == len(kit.dive())


def test_an_empty_file_is_a_loss(folder):
    database(folder).write_bytes(b"")
    _, log = read(Rosbag2Log(folder))
    assert any("is empty" in loss.why for loss in log.losses())


def test_a_file_that_is_no_database_is_a_loss_of_the_folder(folder):
    database(folder).write_bytes(b"nothing of the kind" * 100)
    messages, log = read(Rosbag2Log(folder))
    assert messages == []
    assert any("cannot be read" in loss.why for loss in log.losses())


def edit_metadata(folder: Path, *changes: tuple[str, str]) -> None:
    text = (folder / "metadata.yaml").read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / "metadata.yaml").write_text(text)


def pack_as_recorded(folder: Path) -> Path:
    """Pack the storage file as rosbag2 does in its compression mode FILE."""
    (path,) = [p for p in folder.iterdir() if p.suffix in (".db3", ".mcap")]
    packed = path.with_name(f"{path.name}.zstd")
    packed.write_bytes(zstandard.ZstdCompressor().compress(path.read_bytes()))
    path.unlink()
    edit_metadata(
        folder, (path.name, packed.name), ("compression_mode: ''", "compression_mode: FILE")
    )
    return packed


def unpack(packed: Path) -> None:
    content = zstandard.ZstdDecompressor().decompress(packed.read_bytes())
    packed.with_suffix("").write_bytes(content)


class FullDisk:
    """Stands for a disk with room for some bytes."""

    def __init__(self, path: Path, room: int) -> None:
        self._file, self._room = open(path, "wb"), room  # noqa: SIM115

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self._file.close()

    def write(self, data: bytes) -> int:
        if self.tell() + len(data) > self._room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return self._file.write(data)

    def tell(self) -> int:
        return self._file.tell()


@pytest.mark.parametrize("told", [True, False], ids=["size told", "size not told"])
def test_no_room_to_unpack_is_one_line_and_leaves_nothing(
    kit, folders, tmp_path, monkeypatch, told
):
    """Before anything is written where the file tells its size, else as the disk gets full."""
    packed = pack_as_recorded(Path(shutil.copytree(folders["MCAP"], tmp_path / "bag")))
    full, roomy, open_path = tmp_path / "full", tmp_path / "roomy", Path.open
    full.mkdir()
    roomy.mkdir()
    really = shutil.disk_usage
    free = really(full)._replace(free=1000)
    if told:
        monkeypatch.setattr(
            shutil, "disk_usage", lambda at: free if full in Path(at).parents else really(at)
        )
    else:
        stream = zstandard.ZstdCompressor().compressobj()
        content = zstandard.ZstdDecompressor().decompress(packed.read_bytes())
        packed.write_bytes(stream.compress(content) + stream.flush())

        def opened(path, *arguments):
            is_full = full in path.parents
            return FullDisk(path, 1000) if is_full else open_path(path, *arguments)

        monkeypatch.setattr(Path, "open", opened)
    monkeypatch.setattr("tempfile.tempdir", str(full))
    with pytest.raises(StorageError, match="no space to unpack a log") as caught:
        list(open_log(packed.parent).messages())
    assert caught.value.exit_code == 6
    assert "TMPDIR" in caught.value.remedy
    assert caught.value.where == str(full)
    assert list(full.iterdir()) == []
    monkeypatch.setattr("tempfile.tempdir", str(roomy))
    assert len(list(open_log(packed.parent).messages())) == len(kit.dive())


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
@pytest.mark.parametrize("form", ["recorded", "unpacked", "both", "without metadata"])
def test_files_compressed_whole_are_read(kit, folders, tmp_path, storage, form):
    folder = Path(shutil.copytree(folders[storage], tmp_path / "bag"))
    packed = pack_as_recorded(folder)
    if form in ("unpacked", "both"):
        unpack(packed)
    if form == "unpacked":
        packed.unlink()
    if form == "without metadata":
        (folder / "metadata.yaml").unlink()
    log = open_log(folder)
    for _ in range(2):
        messages = list(log.messages())
        assert len(messages) == len(kit.dive())
        assert log.losses() == []
    assert len(find_logs(folder)) == 1


def test_of_a_split_bag_one_file_may_still_be_compressed(kit, folder):
    first = database(folder)
    second = first.with_name("second_1.db3.zstd")
    second.write_bytes(zstandard.ZstdCompressor().compress(first.read_bytes()))
    edit_metadata(folder, (f"- {first.name}\n", f"- {first.name}\n  - {second.name}\n"))
    messages, log = read(Rosbag2Log(folder))
    assert len(messages) == 2 * len(kit.dive())
    assert log.losses() == []


def test_a_compressed_file_that_is_gone_is_missing_by_its_name(folder):
    pack_as_recorded(folder).unlink()
    _, log = read(Rosbag2Log(folder))
    assert any(re.fullmatch(r"the file .*\.db3 is missing", loss.why) for loss in log.losses())


def test_a_compressed_file_that_is_cut_off_is_read_to_there(kit, folders, tmp_path):
    folder = Path(shutil.copytree(folders["MCAP"], tmp_path / "bag"))
    packed = pack_as_recorded(folder)
    packed.write_bytes(packed.read_bytes()[:-30])
    _, log = read(Rosbag2Log(folder))
    assert any("could be unpacked in part only" in loss.why for loss in log.losses())


def test_a_lone_compressed_file_is_read(kit, folder):
    packed = pack_as_recorded(folder)
    assert len(list(open_log(packed).messages())) == len(kit.dive())


@pytest.mark.parametrize("mode", ["MESSAGE", "FILE", ""])
def test_messages_that_were_compressed_one_by_one_are_unpacked(kit, folder, mode):
    edit_metadata(folder, ("compression_mode: ''", f"compression_mode: '{mode}'"))
    with sqlite3.connect(database(folder)) as connection:
        rows = connection.execute("SELECT id, data FROM messages").fetchall()
        pack = zstandard.ZstdCompressor().compress
        connection.executemany(
            "UPDATE messages SET data = ? WHERE id = ?", [(pack(data), n) for n, data in rows]
        )
    messages, log = read(Rosbag2Log(folder))
    assert log.losses() == []
    pressures = [
        decode(m.channel, m.data).fluid_pressure for m in messages if m.channel.topic == "/pressure"
    ]
    assert pressures == [e.message.fluid_pressure for e in kit.dive() if e.topic == "/pressure"]


def test_a_database_of_something_else_is_an_input_error(tmp_path):
    path = tmp_path / "other.db3"
    with sqlite3.connect(path) as connection:
        connection.execute("CREATE TABLE cats (name TEXT)")
    with pytest.raises(InputError, match="no rosbag2 database"):
        read(SqliteLog(path))


@pytest.mark.parametrize("share", [0.5, 0.95])
def test_cut_database_gives_reachable_rows_and_losses(folder, share):
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


@pytest.mark.parametrize(
    "text",
    [
        "rosbag2_bagfile_information:\n  compression_mode: 5\n  relative_file_paths: bag.db3\n",
        "rosbag2_bagfile_information:\n  compression_mode:\n  relative_file_paths:\n  "
        "topics_with_message_count:\n",
        "rosbag2_bagfile_information:\n  relative_file_paths: [[a], {b: c}, 3]\n  "
        "topics_with_message_count: [1, {a: b}]\n",
        "rosbag2_bagfile_information: [1, 2]\n",
        "- a list\n",
        "rosbag2_bagfile_information:\n  compress",
        "rosbag2_bagfile_information:\n  version: " + "9" * 10_000 + "\n",
        "[" * 900,
        "\x00\x01",
        "? !!set {a: b}\n: !!omap [3]\n",
    ],
)
def test_damaged_metadata_is_ignored(kit, folder, text):
    (folder / "metadata.yaml").write_text(text)
    messages, log = read(Rosbag2Log(folder))
    assert len(messages) == len(kit.dive())
    assert log.losses() == []
    assert all(note.isprintable() and len(note) < 500 for note in sentences(log.notes))


def test_aliases_that_would_blow_up_are_not_followed(kit, folder):
    merges = "a0: &a0 {k: 1}\n" + "".join(
        f"a{i}: &a{i}\n  <<: [*a{i - 1}, *a{i - 1}]\n" for i in range(1, 60)
    )
    (folder / "metadata.yaml").write_text(merges)
    messages, log = read(Rosbag2Log(folder))
    assert len(messages) == len(kit.dive())
    assert "metadata.yaml merges aliases; the folder's files were read by name" in sentences(
        log.notes
    )
    lists = "a0: &a0 [x, x]\n" + "".join(
        f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 12)
    )
    (folder / "metadata.yaml").write_text(
        f"{lists}rosbag2_bagfile_information:\n  relative_file_paths: [*a11]\n"
    )
    assert len(read(Rosbag2Log(folder))[0]) == len(kit.dive())


def test_metadata_of_megabytes_is_not_parsed(kit, folder):
    (folder / "metadata.yaml").write_text("a: b\n" * 200_000)
    messages, log = read(Rosbag2Log(folder))
    assert len(messages) == len(kit.dive())
    assert any("has 1000000 bytes" in note for note in sentences(log.notes))


def test_a_file_that_is_named_twice_is_read_once(kit, folder):
    name = database(folder).name
    text = (folder / "metadata.yaml").read_text().replace(f"- {name}\n", f"- {name}\n  - {name}\n")
    (folder / "metadata.yaml").write_text(text)
    assert len(read(Rosbag2Log(folder))[0]) == len(kit.dive())


def test_messages_counted_in_metadata_but_absent_are_a_loss(kit, folder):
    with sqlite3.connect(database(folder)) as connection:
        connection.execute("DELETE FROM messages WHERE id % 2")
    messages, log = read(Rosbag2Log(folder))
    assert {loss.why for loss in log.losses()} == {
        "metadata.yaml counts more of them than could be read"
    }
    assert sum(loss.messages for loss in log.losses()) == len(kit.dive()) - len(messages)


def test_absurd_message_count_is_a_loss_of_unknown_number(folder):
    path = folder / "metadata.yaml"
    path.write_text(
        re.sub(r"message_count: \d+\n", f"message_count: 0x{'F' * 5000}\n", path.read_text())
    )
    log = read(Rosbag2Log(folder))[1]
    losses = [loss for loss in log.losses() if loss.why.startswith("metadata.yaml counts more")]
    assert losses
    assert {loss.messages for loss in losses} == {None}
    assert all(
        "an unknown part is lost: metadata.yaml" in line
        for line in sentences(describe_losses([("log", loss) for loss in losses]))
    )


@pytest.mark.parametrize("name", ["metadata.yaml", "more.mcap", "more.db3"])
def test_a_pipe_in_the_folder_is_named_and_not_waited_for(kit, folder, name):
    (folder / name).unlink(missing_ok=True)
    os.mkfifo(folder / name)
    messages, log = read(Rosbag2Log(folder))
    assert len(messages) == len(kit.dive())
    assert any(
        f"{name} is a pipe" in text
        for text in [*sentences(log.notes), *(loss.why for loss in log.losses())]
    )


def test_a_message_that_claims_gigabytes_is_not_unpacked(folder):
    text = (
        (folder / "metadata.yaml")
        .read_text()
        .replace("compression_mode: ''", "compression_mode: MESSAGE")
    )
    (folder / "metadata.yaml").write_text(text)
    bomb = zstandard.ZstdCompressor().compress(bytes(1 << 28))
    with sqlite3.connect(database(folder)) as connection:
        connection.execute("UPDATE messages SET data = ? WHERE id < 40", (bomb,))
    messages, _ = read(Rosbag2Log(folder))
    assert all(len(m.data) < 1 << 20 for m in messages)
