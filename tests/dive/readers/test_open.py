# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import os
import socket
from pathlib import Path

import pytest

from hullrecon.dive.logs.readers.open import find_logs, open_log
from hullrecon.errors import InputError


def test_each_format_is_known_by_what_lies_in_it(kit, tmp_path):
    entries = kit.dive()[:10]
    kit.mcap(tmp_path / "a", entries)
    kit.bag1(tmp_path / "b", kit.dive(ros=1)[:10])
    kit.ros2(tmp_path / "c", entries)
    (tmp_path / "d").mkdir()
    (tmp_path / "d" / "imu.csv").write_text("t\n")
    (tmp_path / "e").write_bytes(b"\x7f\x7f123")
    kinds = [open_log(tmp_path / name).kind for name in "abcde"]
    assert kinds == ["MCAP", "ROS 1 bag", "ROS 2 folder", "plain files", "Teledyne PD0"]
    assert open_log(next((tmp_path / "c").glob("*.db3"))).kind == "ROS 2 database"


def test_a_damaged_first_byte_is_made_up_for_by_the_name(kit, tmp_path):
    path = kit.mcap(tmp_path / "a.mcap", kit.dive())
    data = bytearray(path.read_bytes())
    data[0] ^= 1
    path.write_bytes(data)
    assert len(list(open_log(path).messages())) == len(kit.dive())


def test_a_ros2_folder_is_known_without_its_metadata(kit, tmp_path):
    folder = kit.ros2(tmp_path / "c", kit.dive()[:10])
    (folder / "metadata.yaml").unlink()
    assert open_log(folder).kind == "ROS 2 folder"


def test_missing_log_is_refused_with_a_list_of_those_present(tmp_path):
    (tmp_path / "dive.bag").write_bytes(b"x")
    with pytest.raises(InputError, match=r"the log dive\.mcap is missing \(there are dive\.bag\)"):
        open_log(tmp_path / "dive.mcap")


def test_an_empty_log_is_an_input_error(tmp_path):
    (tmp_path / "x.mcap").touch()
    with pytest.raises(InputError, match="is empty"):
        open_log(tmp_path / "x.mcap")


@pytest.mark.parametrize("name", ["x.txt", "."])
def test_what_is_no_log_is_an_input_error_that_lists_the_formats(tmp_path: Path, name):
    (tmp_path / "x.txt").write_text("hello")
    with pytest.raises(InputError, match="MCAP"):
        open_log(tmp_path / name)
    (tmp_path / "x.mcap").write_bytes(b"\x89MCAP0\r\n")
    assert open_log(tmp_path / "x.mcap").kind == "MCAP"


def test_logs_are_found_in_a_folder_or_its_logs_folder(tmp_path):
    (tmp_path / "logs").mkdir()
    for name in ("b.mcap", "a.pd0", "notes.txt"):
        (tmp_path / "logs" / name).write_bytes(b"x")
    assert [p.name for p in find_logs(tmp_path)] == ["a.pd0", "b.mcap"]
    (tmp_path / "top.bag").write_bytes(b"x")
    assert find_logs(tmp_path) == [tmp_path / "top.bag"]
    assert find_logs(tmp_path / "top.bag") == [tmp_path / "top.bag"]


def test_a_folder_that_is_a_log_is_found_as_such(tmp_path):
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "metadata.yaml").write_text("{}")
    assert find_logs(tmp_path) == [tmp_path / "bag"]
    assert find_logs(tmp_path / "bag") == [tmp_path / "bag"]


def test_a_folder_without_logs_is_an_input_error(tmp_path):
    with pytest.raises(InputError, match="holds no log"):
        find_logs(tmp_path)


@pytest.mark.parametrize("suffix", [".mcap", ".bag", ".db3", ".pd0", ".txt"])
def test_pipes_sockets_devices_are_refused_without_waiting(tmp_path, suffix):
    os.mkfifo(tmp_path / f"pipe{suffix}")
    with pytest.raises(InputError, match=f"pipe{suffix} is a pipe, not a file"):
        open_log(tmp_path / f"pipe{suffix}")
    with socket.socket(socket.AF_UNIX) as end:
        end.bind(str(tmp_path / f"s{suffix}"))
        with pytest.raises(InputError, match=f"s{suffix} is a socket, not a file"):
            open_log(tmp_path / f"s{suffix}")
    (tmp_path / f"zero{suffix}").symlink_to("/dev/zero")
    with pytest.raises(InputError, match=f"zero{suffix} is a device, not a file"):
        open_log(tmp_path / f"zero{suffix}")
    (tmp_path / f"copy{suffix}").write_bytes(b"\x89MCAP0\r\n")  # what came out of the pipe
    assert open_log(tmp_path / f"copy{suffix}").kind == "MCAP"


@pytest.mark.parametrize(
    "name", ["a" * 5000 + ".mcap", "a\0b.mcap", "x.mcap/y.mcap", "\x1b[31m.mcap"]
)
def test_a_name_that_no_file_has_is_one_line(tmp_path, name):
    (tmp_path / "x.mcap").write_bytes(b"x")
    with pytest.raises(InputError) as caught:
        open_log(tmp_path / name)
    assert caught.value.line().isprintable()


def test_read_error_midway_keeps_messages_and_notes_the_loss(kit, tmp_path, monkeypatch):
    log = open_log(kit.mcap(tmp_path / "a.mcap", kit.dive()))
    whole = type(log)._read

    def fail_halfway(self):
        for n, message in enumerate(whole(self)):
            if n == 50:
                raise OSError(5, "Input/output error")
            yield message

    monkeypatch.setattr(type(log), "_read", fail_halfway)
    assert len(list(log.messages())) == 50
    assert {loss.why for loss in log.losses()} == {
        "the file cannot be read further: Input/output error"
    }


def test_a_file_that_vanishes_before_it_is_read_is_one_line(kit, tmp_path):
    log = open_log(kit.mcap(tmp_path / "a.mcap", kit.dive()))
    (tmp_path / "a.mcap").unlink()
    with pytest.raises(InputError, match=r"a\.mcap cannot be read: No such file"):
        list(log.messages())


@pytest.mark.parametrize("name", ["ADCP_20.000", "track.ENR", "x"])
def test_log_is_found_by_first_bytes_whatever_its_name(kit, tmp_path, name):
    # the head of a PD0 ensemble
    (tmp_path / name).write_bytes(b"\x7f\x7f" + bytes([20, 0, 0, 1, 8, 0]) + bytes(40))
    (tmp_path / "grey.raw").write_bytes(b"\x7f" * 4096)
    (tmp_path / "library.sqlite").write_bytes(b"SQLite format 3\0" + bytes(84))
    assert find_logs(tmp_path) == [tmp_path / name]
    kit.bag1(tmp_path / "recording.1", kit.dive(ros=1)[:10])
    assert {p.name for p in find_logs(tmp_path)} == {name, "recording.1"}


POINTER = b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 12345\n"


@pytest.mark.parametrize("name", ["dive.mcap", "dive.bag", "dive.bin"])
def test_a_pointer_of_git_lfs_is_named(tmp_path, name):
    (tmp_path / name).write_bytes(POINTER)
    with pytest.raises(InputError, match="a pointer of Git LFS") as caught:
        open_log(tmp_path / name)
    assert caught.value.remedy == "fetch it with git lfs pull"


def test_what_a_server_sent_in_a_files_place_and_a_dead_link_are_named(tmp_path):
    (tmp_path / "dive.mcap").write_text("<!DOCTYPE html><html>Sign in</html>")
    with pytest.raises(InputError, match="a page of the web"):
        open_log(tmp_path / "dive.mcap")
    (tmp_path / "link.mcap").symlink_to("gone.mcap")
    with pytest.raises(InputError, match="is missing") as caught:
        open_log(tmp_path / "link.mcap")
    assert "a link to gone.mcap, which is not there" in caught.value.remedy


def test_a_path_of_windows_is_refused_with_how_to_write_it(tmp_path):
    with pytest.raises(InputError, match="is missing") as caught:
        open_log(tmp_path / "logs\\dive.mcap")
    assert "write / between folders" in caught.value.remedy
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs" / "dive.mcap").write_bytes(b"\x89MCAP0\r\n")
    assert open_log(tmp_path / "logs" / "dive.mcap").kind == "MCAP"
