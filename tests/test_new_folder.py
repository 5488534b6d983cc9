# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import os
from pathlib import Path

import pytest

from hullrecon.errors import StorageError
from hullrecon.new_folder import new_folder


def test_the_folder_appears_when_all_is_written(tmp_path: Path) -> None:
    with new_folder(tmp_path / "far" / "dive") as place:
        (place / "a.txt").write_text("a")
        assert not (tmp_path / "far" / "dive").exists()
    assert (tmp_path / "far" / "dive" / "a.txt").read_text() == "a"
    assert [p.name for p in (tmp_path / "far").iterdir()] == ["dive"]


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError])
def test_an_exception_passes_and_leaves_nothing(tmp_path: Path, error: type[BaseException]) -> None:
    def fail() -> None:
        with new_folder(tmp_path / "dive") as place:
            (place / "a.txt").write_text("a")
            raise error

    with pytest.raises(error):
        fail()
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_is_one_line_about_the_folder(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match=r"dive.*No space left"), new_folder(tmp_path / "dive"):
        raise OSError(28, "No space left on device")
    assert list(tmp_path.iterdir()) == []


def test_what_came_into_the_folder_meanwhile_is_kept(tmp_path: Path) -> None:
    def meddle() -> None:
        with new_folder(tmp_path / "dive"):
            (tmp_path / "dive").mkdir()
            (tmp_path / "dive" / "mine.txt").write_text("mine")

    with pytest.raises(StorageError, match="dive"):
        meddle()
    assert (tmp_path / "dive" / "mine.txt").read_text() == "mine"
    assert [p.name for p in tmp_path.iterdir()] == ["dive"]


def test_a_folder_with_something_in_it_is_refused_before_any_work(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(StorageError, match="not empty"), new_folder(tmp_path):
        raise AssertionError("no work may be done")
    with new_folder(tmp_path / "new") as folder:
        (folder / "a").touch()
    assert (tmp_path / "new" / "a").exists()


@pytest.mark.parametrize("name", [".", "empty", "empty/.", "../here", "link"])
def test_an_empty_folder_is_filled_and_stays_the_same(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever stands in it sees what was written."""
    here = tmp_path / "here"
    target = here if name in (".", "../here") else here / "empty"
    target.mkdir(parents=True)
    if name == "link":
        (here / "link").symlink_to("empty")
    monkeypatch.chdir(here)
    before = target.stat().st_ino
    with new_folder(Path(name)) as place:
        (place / "logs").mkdir()
        (place / "logs" / "a.txt").write_text("a")
        (place / "b.txt").write_text("b")
        assert not (target / "b.txt").exists()
    assert sorted(os.listdir(target)) == ["b.txt", "logs"]
    assert (Path(name) / "logs" / "a.txt").read_text() == "a"
    assert target.stat().st_ino == before
    assert os.listdir(tmp_path) == ["here"]


def test_a_link_to_nothing_leads_to_the_new_folder(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("dive")
    with new_folder(tmp_path / "link") as place:
        (place / "a.txt").write_text("a")
    assert (tmp_path / "dive" / "a.txt").read_text() == "a"
    assert sorted(os.listdir(tmp_path)) == ["dive", "link"]


def test_an_empty_folder_stays_empty_where_the_work_fails(tmp_path: Path) -> None:
    def fail() -> None:
        with new_folder(tmp_path) as place:
            (place / "a.txt").write_text("a")
            raise KeyError("a")

    with pytest.raises(KeyError):
        fail()
    assert os.listdir(tmp_path) == []


def test_what_came_into_an_empty_folder_meanwhile_is_kept(tmp_path: Path) -> None:
    def meddle() -> None:
        with new_folder(tmp_path) as place:
            (place / "mine.txt").write_text("ours")
            (tmp_path / "mine.txt").write_text("mine")

    with pytest.raises(StorageError, match="not empty"):
        meddle()
    assert os.listdir(tmp_path) == ["mine.txt"]
    assert (tmp_path / "mine.txt").read_text() == "mine"


@pytest.mark.parametrize("name", ["file", "loop", "file/dive", "x" * 300])
def test_a_place_that_can_be_no_folder_is_refused_before_any_work(
    tmp_path: Path, name: str
) -> None:
    (tmp_path / "file").write_text("mine")
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(StorageError), new_folder(tmp_path / name):
        raise AssertionError("no work may be done")
    assert (tmp_path / "file").read_text() == "mine"
