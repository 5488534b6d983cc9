# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import struct
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.fuzz.corpus import Entry, describe, read_corpus, write_corpus
from benchmarks.fuzz.field_mutators import FIELDS, edit_records, set_float
from benchmarks.fuzz.formats import seeds, with_right_sums, with_right_word_sums
from benchmarks.fuzz.mutators import BINARY, TEXT, mutate
from benchmarks.fuzz.records import record_starts
from benchmarks.fuzz.seed_ad2cp import dvl_file
from benchmarks.fuzz.seed_files import pd0
from benchmarks.fuzz.text_mutators import encode_otherwise

QUICK = settings(max_examples=30, deadline=None, derandomize=True)


@pytest.mark.parametrize(
    "mutator", [*dict.fromkeys([*BINARY, *FIELDS, *TEXT])], ids=lambda m: m.__name__
)
@QUICK
@given(data=st.binary(max_size=60), other=st.binary(max_size=60), seed=st.integers(0, 99))
def test_a_mutator_takes_any_bytes(mutator, data, other, seed):
    assert isinstance(mutator(bytearray(data), other, Random(seed)), bytearray)


@pytest.mark.parametrize(
    "mutator", [*dict.fromkeys([*BINARY, *FIELDS, *TEXT])], ids=lambda m: m.__name__
)
def test_a_mutator_changes_something_sooner_or_later(mutator):
    data = b"a = 1, 2\nbb = [3.5, 4]\n" * 20
    assert any(bytes(mutator(bytearray(data), data[::-1], Random(k))) != data for k in range(20))


def test_damage_at_the_start_of_a_record_is_frequent():
    data = bytes(5000)
    damaged = [mutate(data, data, Random(k), text=False, marks=(4321,)) for k in range(300)]
    assert sum(d[:4321] == data[:4321] and d[4321:4330] != data[4321:4330] for d in damaged) > 10


@pytest.mark.parametrize(
    ("form", "least"),
    [
        ("mcap", 10),
        ("bag", 10),
        ("pd0", 4),
        ("ad2cp", 6),
        ("aris", 4),
        ("view_point", 5),
        ("npz", 6),
    ],
)
def test_the_records_of_a_sound_file_are_found(form, least):
    seed = seeds()[form][0]
    assert len(record_starts(seed.files[seed.target])) >= least


def test_record_mutators_move_whole_records():
    data, marks = b"head" + b"aaaa" + b"bbbbbb" + b"cc", (4, 8, 14)
    found = {bytes(edit_records(bytearray(data), marks, Random(k))) for k in range(200)}
    assert {
        b"head",
        b"headaaaa",
        b"headbbbbbbcc",
        b"headaaaaaaaabbbbbbcc",
        b"headccbbbbbbaaaa",
        b"headbbbbbbaaaabbbbbbcc",
    } <= found


def test_a_field_becomes_a_number_that_no_sensor_gives():
    data = struct.pack("<4d", 1.5, 2.5, 3.5, 4.5)
    damaged = [
        np.frombuffer(bytes(d), "<f8")
        for d in (set_float(bytearray(data), b"", Random(k)) for k in range(300))
        if len(d) == 32
    ]
    assert any(np.isnan(d).any() for d in damaged)
    assert any(np.isinf(d).any() for d in damaged)


@pytest.mark.parametrize("how", ["utf-8-sig", "utf-16", "utf-32"])
def test_text_is_written_in_other_encodings(how):
    text = "[dive]\nname = 1\n"
    found = {bytes(encode_otherwise(bytearray(text.encode()), b"", Random(k))) for k in range(300)}
    assert text.encode(how) in found
    assert text.replace("\n", "\r\n").encode() in found


def test_text_has_no_records():
    assert record_starts(b"solid\n") == ()


def test_damaged_pd0_gets_the_checksums_that_its_bytes_ask_for():
    data = bytearray(pd0())
    assert with_right_sums(bytes(data)) == bytes(data)
    data[100] ^= 1
    repaired = with_right_sums(bytes(data))
    assert repaired != bytes(data)
    assert repaired[100] == data[100]


def test_damaged_ad2cp_gets_valid_checksums():
    data = bytearray(dvl_file())
    assert with_right_word_sums(bytes(data)) == bytes(data)
    data[-1] ^= 1
    repaired = with_right_word_sums(bytes(data))
    assert repaired[:-1] != bytes(data[:-1])
    assert repaired[-1] == data[-1]
    assert with_right_word_sums(repaired) == repaired


@settings(max_examples=50, deadline=None, derandomize=True)
@given(form=st.sampled_from(["toml", "yaml", "pd0", "hull"]), seed=st.integers(0, 10_000))
def test_an_entry_of_the_corpus_gives_the_bytes_back(form, seed):
    whole = seeds()[form][0]
    data = mutate(whole.files[whole.target], b"other", Random(seed), text=whole.text)
    assert describe(form, 0, data, "").data() == data


def test_a_corpus_is_written_and_read_back(tmp_path):
    entry = Entry(form="toml", number=0, found="traceback", edits=((3, 1, "c$|Lx0RjR0"),))
    write_corpus(tmp_path / "c.json", [entry])
    assert read_corpus(tmp_path / "c.json") == [entry]
    assert read_corpus(tmp_path / "none.json") == []
