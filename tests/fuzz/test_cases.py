# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What the bench calls a failure, and that it sees each kind of it."""

import gc
import mmap
from pathlib import Path

import pytest

from benchmarks.fuzz import cases
from benchmarks.fuzz.cases import Bench, Verdict, damaged_input, judge
from benchmarks.fuzz.formats import Seed, seeds
from benchmarks.fuzz.readings import READERS, Reading
from hullrecon.errors import InputError

SOUND = Reading("data", frozenset(["a remark"]))


def verdict_on(monkeypatch: pytest.MonkeyPatch, read, *, checksummed: bool = True) -> Verdict:
    monkeypatch.setattr(cases, "READERS", {"test": read})
    seed = Seed(read="test", files={"x": b""}, target="x", checksummed=checksummed)
    return judge(seed, SOUND, Path())


def raising(error: BaseException):
    def read(folder: Path, name: str) -> Reading:
        raise error

    return read


def giving(digest: str, *said: str):
    return lambda folder, name: Reading(digest, frozenset(said))


@pytest.mark.parametrize(
    ("read", "kind"),
    [
        (raising(InputError("it is damaged", where="x")), "refused"),
        (raising(InputError("two\nlines")), "lines"),
        (raising(InputError("two\u2028lines")), "lines"),
        (raising(InputError("x" * 2000)), "lines"),
        (raising(KeyError("x")), "traceback"),
        (raising(MemoryError()), "memory"),
        (giving("data"), "same"),
        (giving("other", "a remark", "the rest is lost"), "named"),
        (giving("other", "a remark"), "silence"),
        (giving("other", "two\nlines"), "lines"),
    ],
)
def test_every_end_of_a_case_has_its_verdict(monkeypatch, read, kind):
    assert verdict_on(monkeypatch, read).kind == kind


def test_silent_damage_is_no_failure_where_undetectable(monkeypatch):
    assert verdict_on(monkeypatch, giving("other"), checksummed=False).kind == "unnoticed"


def test_endless_reader_that_catches_all_errors_is_stopped(monkeypatch):
    def read(folder: Path, name: str) -> Reading:
        while True:
            try:
                sum(range(1000))
            except Exception:
                continue

    monkeypatch.setattr(cases, "SECONDS", 0.1)
    assert verdict_on(monkeypatch, read).kind == "hang"


def test_memory_that_was_used_and_given_back_is_seen(monkeypatch):
    def read(folder: Path, name: str) -> Reading:
        # A mapping of its own: the heap of a process that has run other tests may hold so many free
        # pages that it still owns.
        with mmap.mmap(-1, 128 << 20) as block:
            block[:: mmap.PAGESIZE] = b"x" * len(range(0, len(block), mmap.PAGESIZE))
        raise InputError("it is damaged")

    gc.collect()  # garbage of other tests that went meanwhile would hide as much
    monkeypatch.setattr(cases, "LARGEST_BYTES", 32 << 20)
    verdict = verdict_on(monkeypatch, read)
    assert verdict.kind == "memory"
    assert "it is damaged" in verdict.text
    assert verdict_on(monkeypatch, giving("data")).kind == "same"


@pytest.mark.parametrize("form", seeds())
def test_the_sound_inputs_are_sound_and_made_alike_each_time(bench: Bench, form: str) -> None:
    for number, seed in enumerate(seeds()[form]):
        assert bench.judge(form, number, seed.files[seed.target]).kind == "same"
        assert seed.read in READERS
        assert len(seed.files[seed.target]) < 100_000
    again = seeds.__wrapped__()[form]
    unstable = "metadata.yaml"  # it says when it was written
    assert [s.files[s.target] for s in again if unstable not in s.target] == [
        s.files[s.target] for s in seeds()[form] if unstable not in s.target
    ]


def test_damage_that_a_sum_of_bytes_cannot_see_is_no_silence(bench):
    data = seeds()["pd0"][0].files["dive.pd0"]
    at = data.find(b"\xe8\x03\x4c\x04")  # two ranges that change places
    swapped = data[:at] + data[at + 2 : at + 4] + data[at : at + 2] + data[at + 4 :]
    assert bench.judge("pd0", 0, swapped).kind == "unnoticed"
    raised = data[:at] + b"\xe9" + data[at + 1 :]
    assert bench.judge("pd0", 0, raised).kind == "named"


@pytest.mark.parametrize("form", seeds())
def test_a_case_is_the_same_wherever_it_runs(form: str) -> None:
    assert [damaged_input(form, 3, k) for k in range(20)] == [
        damaged_input(form, 3, k) for k in range(20)
    ]
    assert len({damaged_input(form, 3, k)[1] for k in range(20)}) > 10
