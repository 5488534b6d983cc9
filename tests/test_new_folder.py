# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

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
