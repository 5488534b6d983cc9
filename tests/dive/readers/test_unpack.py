# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import bz2
import zlib

import lz4.frame
import pytest
import zstandard
from hypothesis import given
from hypothesis import strategies as st

from hullrecon.dive.logs.readers.unpack import (
    LONGEST_NAME,
    DamagedError,
    UnpackBudget,
    decompress,
    fields,
    printable,
    text,
    unpack_frame,
)

PACK = {
    "": lambda data: data,
    "none": lambda data: data,
    "zstd": zstandard.ZstdCompressor().compress,
    "lz4": lz4.frame.compress,
    "bz2": bz2.compress,
    "zlib": zlib.compress,
}


@pytest.mark.parametrize("how", PACK)
@given(data=st.binary(max_size=300))
def test_what_was_packed_comes_back(how, data):
    assert decompress(PACK[how](data), how, len(data)) == data


@pytest.mark.parametrize("how", PACK)
@pytest.mark.parametrize("off", [-1, 1, 10**6])
def test_another_size_than_promised_is_damage(how, off):
    with pytest.raises(DamagedError):
        decompress(PACK[how](b"x" * 50), how, 50 + off)


@pytest.mark.parametrize("how", PACK)
@given(data=st.binary(max_size=100))
def test_rubbish_is_damage_or_itself_and_nothing_else(how, data):
    try:
        assert len(decompress(data, how, 40)) == 40
    except DamagedError:
        return


def test_a_small_file_that_claims_to_be_huge_is_not_believed():
    bomb = zstandard.ZstdCompressor().compress(bytes(10**6))
    with pytest.raises(DamagedError, match="claims"):
        decompress(bomb, "zstd", 2**40)
    with pytest.raises(DamagedError, match="claims 1000000 bytes instead of 10"):
        decompress(bomb, "zstd", 10)
    with pytest.raises(DamagedError):
        decompress(lz4.frame.compress(bytes(10**6)), "lz4", 10)
    with pytest.raises(DamagedError):
        decompress(bz2.compress(bytes(10**6)), "bz2", 10)
    with pytest.raises(DamagedError):
        decompress(zlib.compress(bytes(10**6)), "zlib", 10)


def test_an_unknown_compression_is_damage():
    with pytest.raises(DamagedError, match="'brotli' is not known"):
        decompress(b"", "brotli", 0)


def test_fields_past_the_end_and_names_not_utf8_are_damage():
    assert fields("<HI", b"\x01\x00\x02\x00\x00\x00") == (1, 2)
    with pytest.raises(DamagedError, match="ends too early"):
        fields("<I", b"\x01\x02\x03")
    assert text("Å".encode()) == "Å"
    with pytest.raises(DamagedError, match="UTF-8"):
        text(b"\xff")


@pytest.mark.parametrize("how", ["zstd", "lz4", "bz2", "zlib"])
def test_a_log_unpacks_to_a_multiple_of_its_size_and_no_further(how):
    packed, budget = PACK[how](bytes(1 << 22)), UnpackBudget(1000)
    for _ in range(2):
        assert len(decompress(packed, how, 1 << 22, budget)) == 1 << 22
    with pytest.raises(DamagedError, match="more than 256 times its size"):
        decompress(packed, how, 1 << 22, budget)


@pytest.mark.parametrize("how", ["lz4", "bz2", "zlib"])
def test_a_stream_that_stops_before_its_checksum_is_damaged(how):
    packed = PACK[how](b"x" * 500)
    with pytest.raises(DamagedError):
        decompress(packed[:-4], how, 500)


def test_a_frame_unpacks_with_and_without_its_size():
    budget = UnpackBudget(1000)
    assert unpack_frame(zstandard.ZstdCompressor().compress(b"x" * 99), budget) == b"x" * 99
    assert (
        unpack_frame(zstandard.ZstdCompressor(write_content_size=False).compress(b"x" * 99), budget)
        == b"x" * 99
    )
    with pytest.raises(DamagedError):
        unpack_frame(zstandard.ZstdCompressor().compress(bytes(1 << 28)), budget)
    with pytest.raises(DamagedError):
        unpack_frame(b"rubbish", budget)


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("/cam/Å", "/cam/Å"),
        ("\x1b[31m", "\\x1b[31m"),
        ("a\nb\r", "a\\nb\\r"),
        ("\u202eabc", "\\u202eabc"),
        ("\x9b", "\\x9b"),
        ("a" * 2000, "a" * 397 + "..."),
        ("\x00" * 5000, None),
        ("\ud800", "\\ud800"),
    ],
)
def test_what_a_terminal_would_obey_is_escaped(name, shown):
    assert printable(name).isprintable()
    assert len(printable(name)) <= LONGEST_NAME  # so that dive.toml takes it
    assert shown is None or printable(name) == shown
