# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.disk: files and folders come whole or not at all."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from hullrecon.artifacts import disk
from hullrecon.errors import StorageError


def test_a_file_is_written_whole_and_leaves_no_temporary(tmp_path: Path) -> None:
    disk.write_file(tmp_path / "new" / "a.bin", b"content")
    assert (tmp_path / "new" / "a.bin").read_bytes() == b"content"
    assert os.listdir(tmp_path / "new") == ["a.bin"]


def test_an_error_while_writing_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("old")

    def fail() -> None:
        with disk.durable_file(path) as file:
            file.write(b"half of the n")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_a_file_is_synced_before_its_rename_and_the_folder_after(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = []
    fsync, replace = os.fsync, os.replace
    monkeypatch.setattr(
        os, "fsync", lambda fd: (calls.append(os.readlink(f"/proc/self/fd/{fd}")), fsync(fd))
    )
    monkeypatch.setattr(os, "replace", lambda a, b: (calls.append("rename"), replace(a, b)))
    disk.write_file(tmp_path / "a", b"x")
    assert calls == [str(tmp_path / ".tmp-a"), "rename", str(tmp_path)]


def test_a_library_is_given_a_path_of_the_same_suffix(tmp_path: Path) -> None:
    with disk.durable_path(tmp_path / "mesh.glb") as path:
        assert (path.parent, path.suffix) == (tmp_path, ".glb")
        path.write_bytes(b"glb")
        assert not (tmp_path / "mesh.glb").exists()
    assert (tmp_path / "mesh.glb").read_bytes() == b"glb"


def test_a_library_may_write_a_folder(tmp_path: Path) -> None:
    with disk.durable_path(tmp_path / "model") as path:
        (path / "sub").mkdir(parents=True)
        (path / "sub" / "images.bin").write_bytes(b"i")
    assert (tmp_path / "model" / "sub" / "images.bin").read_bytes() == b"i"


def test_a_library_that_writes_nothing_is_noticed(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), disk.durable_path(tmp_path / "model"):
        pass


def test_a_failing_library_leaves_nothing_behind(tmp_path: Path) -> None:
    def fail() -> None:
        with disk.durable_path(tmp_path / "model") as path:
            path.mkdir()
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (errno.ENOSPC, "No space left"),
        (errno.EDQUOT, "quota"),
        (errno.EROFS, "Read-only"),
        (errno.EACCES, "denied"),
    ],
)
def test_a_disk_that_refuses_is_named_with_its_folder(
    number: int, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(descriptor: int) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "fsync", refuse)
    with pytest.raises(StorageError, match=words) as caught:
        disk.write_file(tmp_path / "a", b"x")
    assert caught.value.exit_code == 6
    assert caught.value.where == str(tmp_path)
    assert caught.value.remedy


def test_an_error_that_is_not_the_disks_passes_as_it_is(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), disk.storage_errors(tmp_path):
        raise FileNotFoundError(errno.ENOENT, "no such file", "elsewhere")


def test_an_unreadable_file_elsewhere_is_no_fault_of_the_storage(tmp_path: Path) -> None:
    with pytest.raises(PermissionError), disk.storage_errors(tmp_path, only_below=tmp_path):
        raise PermissionError(errno.EACCES, "denied", "/package/log.bag")


def test_a_read_only_place_is_refused(read_only_folder: Path) -> None:
    with pytest.raises(StorageError, match="cannot write"):
        disk.make_folder(read_only_folder / "dive")


def test_a_file_in_the_place_of_a_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "runs").write_text("a file")
    with pytest.raises(StorageError, match="runs"):
        disk.make_folder(tmp_path / "runs" / "dive")


def _folder(path: Path, content: str) -> Path:
    path.mkdir()
    (path / "a").write_text(content)
    return path


def test_a_folder_is_committed_where_none_was(tmp_path: Path) -> None:
    disk.commit_folder(_folder(tmp_path / "built", "new"), tmp_path / "final")
    assert (tmp_path / "final" / "a").read_text() == "new"
    assert os.listdir(tmp_path) == ["final"]


def test_a_folder_is_synced_whole_before_it_is_committed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "built" / "sub").mkdir(parents=True)
    (tmp_path / "built" / "sub" / "a").write_text("new")
    synced = set()
    monkeypatch.setattr(os, "fsync", lambda fd: synced.add(os.readlink(f"/proc/self/fd/{fd}")))
    disk.commit_folder(tmp_path / "built", tmp_path / "final")
    built = {str(tmp_path / name) for name in ("built", "built/sub", "built/sub/a")}
    assert built <= synced  # under these names: before the rename


@pytest.mark.parametrize("can_swap", [True, False])
def test_a_folder_replaces_another(
    can_swap: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not can_swap:
        monkeypatch.setattr(disk, "exchange", lambda first, second: False)
    _folder(tmp_path / "final", "old")
    disk.commit_folder(_folder(tmp_path / "built", "new"), tmp_path / "final")
    assert (tmp_path / "final" / "a").read_text() == "new"
    assert os.listdir(tmp_path) == ["final"]


def test_two_folders_are_swapped_in_one_call(tmp_path: Path) -> None:
    first, second = _folder(tmp_path / "first", "1"), _folder(tmp_path / "second", "2")
    if not disk.exchange(first, second):
        pytest.skip("this file system cannot swap")
    assert ((first / "a").read_text(), (second / "a").read_text()) == ("2", "1")


def test_swapping_with_nothing_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        disk.exchange(_folder(tmp_path / "first", "1"), tmp_path / "absent")


def test_commit_without_swap_cut_short_keeps_old_folder(
    tmp_path: Path,
) -> None:
    final = tmp_path / "final"
    _folder(disk.set_aside(final), "old")
    assert (disk.existing_folder(final) / "a").read_text() == "old"
    disk.recover(final)
    assert (final / "a").read_text() == "old"
    assert not disk.set_aside(final).exists()


def test_commit_without_swap_forgets_old_folder(tmp_path: Path) -> None:
    final = _folder(tmp_path / "final", "new")
    _folder(disk.set_aside(final), "old")
    assert disk.existing_folder(final) == final
    disk.recover(final)
    assert os.listdir(tmp_path) == ["final"]
