# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import struct

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.fuzz.seed_files import oculus_ping
from benchmarks.fuzz.seed_view_point import START_S, file_header, item, oculus_file
from hullrecon.dive.logs.formats.oculus_ping import parse_ping
from hullrecon.dive.logs.readers.oculus import log_items
from hullrecon.dive.logs.readers.oculus.log import OculusLog
from hullrecon.dive.logs.readers.oculus.log_items import parse_file_header, parse_item_header
from hullrecon.dive.logs.readers.open import find_logs, open_log
from hullrecon.dive.logs.readers.unpack import DamagedError
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences

QUICK = settings(
    max_examples=30,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
)
SETTINGS = len(item(b"settings"))
SIZE = len(item(oculus_ping()))  # bytes of an item with a ping
FIRST = 48 + SETTINGS  # byte at which the first ping's item begins


def read(path, *contents):
    path.write_bytes(b"".join(contents))
    log = OculusLog(path)
    return [message.data for message in log.messages()], log


def numbers(pings):
    return [round((p.t_ns / 1e9 - START_S) / 0.2) for p in pings]


@pytest.mark.parametrize("compression", [0, 1])
def test_a_ping_reads_back_with_its_stamp_ranges_and_beams(tmp_path, compression):
    pings, log = read(tmp_path / "x.oculus", oculus_file(2, compression=compression))
    assert [p.t_ns for p in pings] == [round(1e9 * START_S), round(1e9 * (START_S + 0.2))]
    assert log.losses() == []
    assert sentences(log.notes)[0] == "1 items were passed over: they hold no ping with an image"
    sent = parse_ping(oculus_ping())
    np.testing.assert_array_equal(pings[0].image, sent.image)
    np.testing.assert_array_equal(pings[0].range_m, sent.range_m)
    x, y, z = pings[0].directions.T
    assert not x.any()
    np.testing.assert_allclose(np.arctan2(y, z), sent.azimuth_rad)


def test_a_header_says_itself_where_its_payload_begins(tmp_path):
    pings, log = read(
        tmp_path / "x.oculus",
        file_header(),
        item(oculus_ping(), 0, size=64),
        item(oculus_ping(), 1),
    )
    assert numbers(pings) == [0, 1]
    assert log.losses() == []


@pytest.mark.parametrize(
    "wrong",
    [
        {"size": 5000},
        {"time_s": float("nan")},
        {"time_s": 1e300},
        {"compression": 2},
        {"original": 1 << 30},
        {"claimed": 1 << 31},
    ],
    ids=str,
)
def test_an_item_that_viewpoint_does_not_write_is_damage(wrong):
    with pytest.raises(DamagedError):
        parse_item_header(item(b"", **{"claimed": 0, **wrong}))


def test_the_header_of_another_file_is_none():
    with pytest.raises(DamagedError, match="no log of ViewPoint"):
        parse_file_header(bytes(48))
    with pytest.raises(DamagedError, match="a header of 9 bytes"):
        parse_file_header(file_header()[:4] + struct.pack("<I", 9) + file_header()[8:])


def test_an_encrypted_log_is_refused_with_what_to_do(tmp_path):
    with pytest.raises(InputError, match=r"x\.oculus is encrypted"):
        read(tmp_path / "x.oculus", file_header(encryption=1), item(oculus_ping()))
    assert read(tmp_path / "plain.oculus", file_header(), item(oculus_ping()))


def test_a_log_whose_own_header_is_damaged_gives_its_pings(tmp_path):
    pings, log = read(tmp_path / "x.oculus", b"????", oculus_file(2)[4:])
    assert numbers(pings) == [0, 1]
    assert [loss.why for loss in log.losses()] == [
        "the header of the file: no log of ViewPoint begins there"
    ]


def test_items_without_ping_are_counted_and_empty_log_is_noted(tmp_path):
    other = bytearray(oculus_ping())
    struct.pack_into("<H", other, 6, 0x15)  # the message that asks for a ping
    pings, log = read(
        tmp_path / "x.oculus", file_header(), item(bytes(other)), item(b"\0" * 30, 1, kind=500)
    )
    assert pings == []
    assert sentences(log.notes) == [
        "2 items were passed over: they hold no ping with an image",
        "no ping of it could be read",
    ]


@pytest.mark.parametrize("kept", [0, 3, 30, SIZE - 1, SIZE, SIZE + 20, 2 * SIZE + 45])
def test_cut_log_gives_whole_pings_and_names_the_rest(tmp_path, kept):
    pings, log = read(tmp_path / "x.oculus", oculus_file(3)[: FIRST + kept])
    assert len(pings) == kept // SIZE
    rest = kept % SIZE
    assert [loss.why.split(" on ")[0] for loss in log.losses()] == (
        [f"{rest} bytes from byte {FIRST + kept - rest}"] if rest else []
    )


@pytest.mark.parametrize("compression", [0, 1])
def test_damage_costs_the_item_that_it_hits(tmp_path, compression):
    content = bytearray(oculus_file(5, compression=compression))
    size = len(item(oculus_ping(), compression=compression))
    content[FIRST + 2 * size] ^= 0xFF
    pings, log = read(tmp_path / "x.oculus", bytes(content))
    assert numbers(pings) == [0, 1, 3, 4]
    (loss,) = log.losses()
    assert (
        loss.why
        == f"{size} bytes from byte {FIRST + 2 * size} on hold no whole item: no item begins there"
    )
    assert (loss.start_ns, loss.end_ns) == (pings[1].t_ns, pings[2].t_ns)


@pytest.mark.parametrize("claimed", [-1, 1])
def test_an_item_whose_length_is_wrong_is_not_taken_for_whole(tmp_path, claimed):
    wrong = item(oculus_ping(), 0, claimed=len(oculus_ping()) + claimed)
    pings, log = read(
        tmp_path / "x.oculus", file_header(), wrong, item(oculus_ping(), 1), item(oculus_ping(), 2)
    )
    assert numbers(pings) == [1, 2]
    assert [loss.why.rpartition(": ")[2] for loss in log.losses()] == [
        "no other item follows where it ends"
    ]


def test_damage_within_a_ping_costs_that_ping(tmp_path):
    content = bytearray(oculus_file(4))
    struct.pack_into("<H", content, FIRST + SIZE + 40 + 106, 60_000)  # ranges of the second
    pings, log = read(tmp_path / "x.oculus", bytes(content))
    assert numbers(pings) == [0, 2, 3]
    (loss,) = log.losses()
    assert loss.why.startswith(f"the item at byte {FIRST + SIZE}: ")
    assert (loss.start_ns, loss.end_ns) == (pings[0].t_ns, pings[1].t_ns)


@pytest.mark.parametrize(("original", "held"), [(0, 1), (100, 101), (1 << 20, len(oculus_ping()))])
def test_an_item_that_does_not_unpack_to_its_length_is_damage(tmp_path, original, held):
    content = (
        file_header()
        + item(oculus_ping(), 0, compression=1, original=original)
        + item(oculus_ping(), 1, compression=1)
    )
    pings, log = read(tmp_path / "x.oculus", content)
    assert numbers(pings) == [1]
    assert [loss.why for loss in log.losses()] == [
        f"the item at byte 48: it holds {held} bytes instead of {original}"
    ]


@pytest.mark.parametrize(
    ("behind", "whole", "why"),
    [(b"", 2, "more than 256 times its size"), (b"?", 1, "no other item follows where it ends")],
)
def test_a_log_unpacks_to_a_multiple_of_its_size_and_no_further(tmp_path, behind, whole, why):
    """Three pings with 6 MiB of zeros behind each; one that no item follows is unpacked twice, to
    see whether it is whole.
    """
    ping = oculus_ping()
    long = ping[:10] + struct.pack("<I", len(ping) - 16 + (6 << 20)) + ping[14:] + bytes(6 << 20)
    content = file_header() + b"".join(item(long, n, compression=1) + behind for n in range(3))
    pings, log = read(tmp_path / "x.oculus", content)
    assert numbers(pings) == list(range(whole))
    assert log.losses()[-1].why.endswith(why)


def test_a_search_behind_damage_goes_on_over_its_windows(tmp_path, monkeypatch):
    monkeypatch.setattr(log_items, "WINDOW", 700)
    pings, log = read(
        tmp_path / "x.oculus",
        oculus_file(2),
        log_items.ITEM_MAGIC * 1500,
        *(item(oculus_ping(), n) for n in (2, 3)),
    )
    assert numbers(pings) == [0, 1, 2, 3]
    assert len(log.losses()) == 1


@QUICK
@given(st.integers(0, len(oculus_file(3)) - 1), st.integers(1, 255))
def test_a_changed_byte_ends_in_pings_and_losses_twice_the_same(tmp_path, at, change):
    content = bytearray(oculus_file(3))
    content[at] ^= change
    if at in (26, 27):  # the header's word of encryption
        with pytest.raises(InputError, match="encrypted"):
            read(tmp_path / "x.oculus", bytes(content))
        return
    first, log = read(tmp_path / "x.oculus", bytes(content))
    second = [message.data for message in log.messages()]
    assert [(p.t_ns, p.image.tobytes()) for p in first] == [
        (p.t_ns, p.image.tobytes()) for p in second
    ]
    assert (
        len(first) == 3
        or log.losses()
        or sentences(log.notes)[0].startswith("2 items were passed over")
    )


def test_a_log_is_known_by_its_first_bytes_or_its_name(tmp_path):
    (tmp_path / "sonar.dat").write_bytes(oculus_file(1))
    assert isinstance(open_log(tmp_path / "sonar.dat"), OculusLog)
    (tmp_path / "x.oculus").write_bytes(b"????" + oculus_file(1)[4:])
    assert len(list(open_log(tmp_path / "x.oculus").messages())) == 1
    assert find_logs(tmp_path) == [tmp_path / "sonar.dat", tmp_path / "x.oculus"]


def test_the_pings_of_a_real_oculus_read_back_from_a_log(data, tmp_path):
    sent = (data / "oculus-pings" / "one_ping_8bit.raw").read_bytes()
    pings, log = read(
        tmp_path / "x.oculus", file_header(), item(sent, 0), item(sent, 1, compression=1)
    )
    assert log.losses() == []
    assert numbers(pings) == [0, 1]
    for ping in pings:
        assert ping.image.shape == (256, 703)
        np.testing.assert_array_equal(ping.image, parse_ping(sent).image)
