# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""artifacts.manifest: nothing is read twice without need, and nothing changed is overlooked."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import pytest

from hullrecon.artifacts import manifest
from hullrecon.artifacts.manifest import FileRecord, HashCache, files_below, hash_file


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "log.bin"
    path.write_bytes(b"abc")
    return path


@pytest.fixture
def reads(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Every file that is read to be hashed."""
    read: list[Path] = []
    monkeypatch.setattr(manifest, "hash_file", lambda path: (read.append(path), hash_file(path))[1])
    return read


def test_a_file_is_hashed_with_its_size(file: Path) -> None:
    assert hash_file(file) == FileRecord(hashlib.sha256(b"abc").hexdigest(), 3)


def test_an_unchanged_file_is_read_once(file: Path, reads: list[Path]) -> None:
    cache = HashCache()
    assert cache.record(file) == cache.record(file) == hash_file(file)
    assert reads == [file]


def test_a_file_of_other_size_time_or_inode_is_read_again(file: Path, reads: list[Path]) -> None:
    cache = HashCache()
    cache.record(file)
    file.write_bytes(b"abcd")
    assert cache.record(file).size == 4
    os.utime(file, ns=(1, 1))
    cache.record(file)
    copy = file.with_name("copy")
    copy.write_bytes(b"efgh")
    os.utime(copy, ns=(1, 1))
    os.replace(copy, file)
    assert cache.record(file).sha256 == hashlib.sha256(b"efgh").hexdigest()
    assert len(reads) == 4


def test_cache_without_trust_reads_each_file_once(
    file: Path, tmp_path: Path, reads: list[Path]
) -> None:
    first = HashCache(tmp_path / "hashes.json")
    first.record(file)
    first.save()
    second = HashCache(tmp_path / "hashes.json", trusting=False)
    second.record(file)
    second.record(file)
    assert reads == [file, file]


def test_the_cache_outlives_the_run(file: Path, tmp_path: Path, reads: list[Path]) -> None:
    first = HashCache(tmp_path / "hashes.json")
    first.record(file)
    first.save()
    assert HashCache(tmp_path / "hashes.json").record(file) == hash_file(file)
    assert reads == [file]


def test_a_damaged_cache_is_forgotten_and_written_anew(
    file: Path, tmp_path: Path, reads: list[Path]
) -> None:
    store = tmp_path / "hashes.json"
    first = HashCache(store)
    first.record(file)
    first.save()
    store.write_bytes(store.read_bytes().replace(b"3,", b"4,"))
    second = HashCache(store)
    second.record(file)
    second.save()
    assert reads == [file, file]
    assert HashCache(store).record(file) == hash_file(file)
    assert len(reads) == 2


def test_a_cache_without_news_is_not_written(file: Path, tmp_path: Path) -> None:
    store = tmp_path / "hashes.json"
    first = HashCache(store)
    first.record(file)
    first.save()
    written = store.stat().st_mtime_ns
    second = HashCache(store)
    second.record(file)
    second.save()
    assert store.stat().st_mtime_ns == written


def test_files_below_are_sorted_and_relative(tmp_path: Path) -> None:
    for name in ("b", "a/z", "a/y/x"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    assert files_below(tmp_path) == ["a/y/x", "a/z", "b"]
