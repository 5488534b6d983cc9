# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import io
import struct
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from benchmarks.fuzz.seed_ad2cp import (
    DF20,
    DF21,
    TEXT,
    WATER_TRACK,
    block,
    configuration,
    dvl_file,
    dvl_record,
    signature_file,
    signature_record,
    word_sum,
)
from hullrecon.dive.logs.readers.ad2cp import blocks as ad2cp_blocks
from hullrecon.dive.logs.readers.ad2cp import bottom_track
from hullrecon.dive.logs.readers.ad2cp.blocks import Block, blocks, checksum
from hullrecon.dive.logs.readers.ad2cp.bottom_track import parse
from hullrecon.dive.logs.readers.ad2cp.log import Ad2cpLog, read_beams, velocity_from_beams
from hullrecon.dive.logs.readers.open import find_logs, open_log
from hullrecon.dive.logs.readers.unpack import DamagedError
from hullrecon.dive.logs.streams.dvl import dvl_pings
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences

QUICK = settings(
    max_examples=30,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
)
DEG = np.pi / 180
SIN, COS = np.sin(25 * DEG), np.cos(25 * DEG)
ENU, XYZ, BEAM = 0, 1, 2


def read(path, *contents):
    path.write_bytes(b"".join(contents))
    log = Ad2cpLog(path)
    found = {"dvl": [], "imu": []}
    for message in log.messages():
        found[message.channel.topic].append(message.data)
    return found["dvl"], found["imu"], log


def signature(**more) -> bytes:
    return configuration() + block(DF20, signature_record(**more))


def test_a_dvl_s_record_reads_back_in_the_instruments_own_axes(tmp_path):
    (ping,), attitudes, log = read(
        tmp_path / "x.ad2cp", configuration((45, -45, -135, 135)), block(DF21, dvl_record(7))
    )
    assert ping.t_ns == 1_777_887_007_250_000_000  # 2026-05-04T09:30:07.25Z
    assert ping.velocity == pytest.approx([0.1, -0.2, 0.06])  # z is the mean of the two
    assert ping.ranges == pytest.approx([3.0, 3.1, 3.2, 3.3])
    assert ping.along_axis
    assert ping.sigma == pytest.approx(np.sqrt((0.003**2 + 0.004**2 + 0.005**2) / 3))
    assert ping.beams[0] == pytest.approx([SIN * np.sqrt(0.5), SIN * np.sqrt(0.5), COS])
    assert ping.beams[1] == pytest.approx([SIN * np.sqrt(0.5), -SIN * np.sqrt(0.5), COS])
    assert (attitudes, log.losses()) == ([], [])
    assert any(
        "pressure was ignored" in r and "clock was taken as UTC" in r for r in sentences(log.notes)
    )


def test_distances_along_z_become_ranges_along_the_beams(tmp_path):
    pings, _, _ = read(tmp_path / "x.ad2cp", dvl_file())
    assert dvl_pings(pings, None, 0.003, []).ranges[0] == pytest.approx(
        np.array([3.0, 3.1, 3.2, 3.3]) / COS
    )


def test_undescribed_beams_are_asked_for_and_can_be_configured(tmp_path):
    pings, _, _ = read(tmp_path / "x.ad2cp", block(DF21, dvl_record()))
    assert pings[0].beams is None
    with pytest.raises(InputError, match="nothing says where the DVL's 4 beams point"):
        dvl_pings(pings, None, 0.003, [])
    tilted = np.array([[0.6, 0, 0.8], [0, -0.6, 0.8], [-0.6, 0, 0.8], [0, 1.0, 0.0]])
    ranges = dvl_pings(pings, tilted, 0.003, []).ranges[0]
    # the fourth never comes down
    np.testing.assert_allclose(ranges, [3.0 / 0.8, 3.1 / 0.8, 3.2 / 0.8, np.nan], rtol=1e-6)


@pytest.mark.parametrize(
    ("record", "velocity", "ranges"),
    [
        (dvl_record(velocity=(0.1, 0.2, -32.768, 0.4)), (0.1, 0.2, 0.4), (3.0, 3.1, 3.2, 3.3)),
        (dvl_record(status=0xFFFFF & ~(1 << 12)), (np.nan, -0.2, 0.06), (3.0, 3.1, 3.2, 3.3)),
        (dvl_record(velocity=(-32.768,) * 4), (np.nan,) * 3, (3.0, 3.1, 3.2, 3.3)),
        (
            dvl_record(distance=(0, np.nan, 1, np.inf)),
            (0.1, -0.2, 0.06),
            (np.nan, np.nan, 1, np.nan),
        ),
        (dvl_record(status=0xFFFFF & ~(1 << 5)), (0.1, -0.2, 0.06), (3.0, np.nan, 3.2, 3.3)),
        (dvl_record(status=0), (np.nan,) * 3, (np.nan,) * 4),
    ],
)
def test_what_a_dvl_marks_as_not_valid_is_nan(record, velocity, ranges):
    ping = parse(DF21, record)
    np.testing.assert_allclose(ping.velocity, velocity, rtol=1e-6)
    np.testing.assert_allclose(ping.distance_m, ranges, rtol=1e-6)


@pytest.mark.parametrize(
    "merit", [(10.0, 0.01, 0.01, 0.01), (0.01, 0.01, 10.0, 10.0), (np.nan, 0.01, 0.01, 0.01)]
)
def test_a_velocity_without_a_valid_figure_of_merit_has_no_sigma(merit):
    assert np.isnan(parse(DF21, dvl_record(merit=merit)).sigma)


def test_beam_velocities_become_instrument_velocity(tmp_path):
    """It moves with (0.3, -0.2, 0.1) m/s: beam 1 leans to x, beam 2 to -y, beam 3 to -x, beam 4 to
    y.
    """
    closing = [
        SIN * 0.3 + COS * 0.1,
        SIN * 0.2 + COS * 0.1,
        -SIN * 0.3 + COS * 0.1,
        -SIN * 0.2 + COS * 0.1,
    ]
    fine = [round(1e6 * c) for c in closing]
    (ping,), _, _ = read(tmp_path / "x.ad2cp", signature(code=BEAM, velocity=fine, scale=-6))
    assert ping.velocity == pytest.approx([0.3, -0.2, 0.1], abs=1e-6)
    (ping,), _, _ = read(
        tmp_path / "x.ad2cp", signature(code=BEAM, velocity=fine, scale=-6, merit=(12, -1, 12, 12))
    )
    assert ping.velocity == pytest.approx([0.3, -0.2, 0.1], abs=1e-6)
    (ping,), _, _ = read(
        tmp_path / "x.ad2cp", signature(code=BEAM, velocity=fine, scale=-6, distance=(9, -1, -1, 9))
    )
    assert np.isnan(ping.velocity).all()


def test_values_belong_to_the_beams_that_the_record_names(tmp_path):
    """The same velocities in the order of beams 4, 3, 2, 1."""
    closing = [
        SIN * 0.3 + COS * 0.1,
        SIN * 0.2 + COS * 0.1,
        -SIN * 0.3 + COS * 0.1,
        -SIN * 0.2 + COS * 0.1,
    ]
    fine = [round(1e6 * c) for c in closing[::-1]]
    (ping,), _, _ = read(
        tmp_path / "x.ad2cp", signature(code=BEAM, velocity=fine, scale=-6, physical=0x1234)
    )
    assert ping.velocity == pytest.approx([0.3, -0.2, 0.1], abs=1e-6)


def test_beam_velocities_without_directions_are_lost_and_noted(tmp_path):
    (ping,), _, log = read(tmp_path / "x.ad2cp", block(DF20, signature_record(code=BEAM)))
    assert np.isnan(ping.velocity).all()
    assert any("1 velocities along the beams were lost" in r for r in sentences(log.notes))


def test_beams_in_one_plane_give_no_velocity():
    flat = np.array([[SIN, 0, COS], [0.0, 0, 1.0], [-SIN, 0, COS]])
    assert np.isnan(velocity_from_beams(np.array([0.1, 0.2, 0.3]), flat)).all()


def test_xyz_velocity_is_kept_with_mean_of_its_two_z(tmp_path):
    (ping,), _, log = read(tmp_path / "x.ad2cp", signature(velocity=(100, -200, 300, 310)))
    assert ping.velocity == pytest.approx([0.1, -0.2, 0.305])
    assert len(ping.ranges) == 0
    assert any("(DF20) were ignored" in r for r in sentences(log.notes))
    three = signature(velocity=(100, -200, 300), physical=0x321)
    assert read(tmp_path / "x.ad2cp", three)[0][0].velocity == pytest.approx([0.1, -0.2, 0.3])


def test_one_lost_beam_spoils_a_velocity_that_was_made_of_all(tmp_path):
    for lost in ({"merit": (12, 12, -1012, 12)}, {"distance": (3000, -1022, 3000, 3000)}):
        (ping,), _, log = read(tmp_path / "x.ad2cp", signature(**lost))
        assert np.isnan(ping.velocity).all()
        assert "no bottom track of it is valid: it gives no velocity over ground" in sentences(
            log.notes
        )


@pytest.mark.parametrize("orientation", [4, 5, 7])
def test_earth_velocity_is_turned_back_by_reported_attitude(tmp_path, orientation):
    turned = {"heading": 4500, "pitch": -200, "roll": 300, "orientation": orientation}
    (ping,), (attitude,), _ = read(
        tmp_path / "x.ad2cp", signature(code=ENU, velocity=(300, 400, -100, -100), **turned)
    )
    ned = Rotation.from_quat(attitude.quaternion).apply(ping.velocity)
    assert ned == pytest.approx([0.4, 0.3, 0.1])  # east 0.3, north 0.4, up -0.1
    assert attitude.of_dvl


def test_heading_pitch_roll_follow_nortek_transformation(tmp_path):
    """Looking up and level, x is where the heading says; pitch lifts x; roll of 90 degrees lays z
    to where y was, reversed.
    """
    looks = {}
    for name, angles in (
        ("level", {}),
        ("pitched", {"pitch": 1000}),
        ("rolled", {"roll": 9000}),
        ("down", {"orientation": 5}),
    ):
        _, (attitude,), _ = read(tmp_path / "x.ad2cp", signature(heading=9000, **angles))
        # north, east, down of x, y, z
        looks[name] = Rotation.from_quat(attitude.quaternion).as_matrix()
    np.testing.assert_allclose(looks["level"], [[0, 1, 0], [1, 0, 0], [0, 0, -1]], atol=1e-12)
    np.testing.assert_allclose(
        looks["pitched"][:, 0], [0, np.cos(10 * DEG), -np.sin(10 * DEG)], atol=1e-12
    )
    np.testing.assert_allclose(looks["rolled"][:, 2], [-1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(looks["down"], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-12)


@pytest.mark.parametrize("more", [{"orientation": 0}, {"config": 0x32B}, {"config": 0x327}])
def test_angles_of_other_axis_or_incomplete_are_no_attitude(tmp_path, more):
    (ping,), attitudes, log = read(tmp_path / "x.ad2cp", signature(code=ENU, **more))
    assert attitudes == []
    assert np.isnan(ping.velocity).all()
    assert any("1 velocities east, north, up were lost" in r for r in sentences(log.notes))


@pytest.mark.parametrize(
    ("kind", "record", "why"),
    [
        (DF20, signature_record(version=3), "its version 3 is not known"),
        (DF21, dvl_record(version=2), "its version 2 is not known"),
        (DF20, signature_record(code=3), "its head contradicts itself"),
        (DF20, signature_record(velocity=(1, 2)), "its head contradicts itself"),
        (DF21, dvl_record(count=3), "its head contradicts itself"),
        (DF20, signature_record(scale=1), "units of 1e1 m/s"),
        (DF20, signature_record(config=0x30F), "it lacks velocities"),
        (DF20, signature_record(config=0x02F), "that tell the lost ones"),
        (DF20, signature_record(month=12), "its clock shows no time"),
        (DF21, dvl_record(month=12), "its clock shows no time"),
        (
            DF21,
            dvl_record()[:12] + struct.pack("<H", 10_000) + dvl_record()[14:],
            "its clock shows no time",
        ),
        (DF20, signature_record()[:-1], "it ends too early"),
        (DF21, dvl_record()[:-1], "it ends too early"),
        (DF20, b"\1", "it ends too early"),
    ],
)
def test_a_record_that_is_not_what_its_kind_has_is_a_named_loss(tmp_path, kind, record, why):
    with pytest.raises(DamagedError, match=why):
        parse(kind, record)
    pings, _, log = read(tmp_path / "x.ad2cp", block(kind, record))
    assert pings == []
    assert log.losses()[0].why.startswith("the bottom track at byte 0 cannot be read: ")
    assert "no bottom-track record was read from it" in sentences(log.notes)[0]


@pytest.mark.parametrize("kind", [0x15, WATER_TRACK])
def test_a_kind_that_nobody_entered_is_not_parsed_as_another(tmp_path, kind):
    with pytest.raises(
        DamagedError, match=f"blocks of kind {kind:#04x} are not read as bottom tracks"
    ):
        parse(kind, dvl_record())
    pings, _, log = read(tmp_path / "x.ad2cp", block(kind, dvl_record()), block(DF21, dvl_record()))
    assert len(pings) == 1
    assert any(
        r.startswith("1 blocks of other kinds were passed over") for r in sentences(log.notes)
    )


def test_registered_kind_uses_its_own_parser_and_count(tmp_path, monkeypatch):
    """A third kind, whose parser gives a velocity of its own."""
    other = replace(parse(DF21, dvl_record()), velocity=np.array([7.0, 8, 9]))
    monkeypatch.setitem(
        bottom_track.KINDS, 0x15, bottom_track.Kind("DF99", lambda data, start: other)
    )
    pings, _, log = read(tmp_path / "x.ad2cp", block(0x15, dvl_record()), block(DF21, dvl_record()))
    assert [p.velocity[0] for p in pings] == pytest.approx([7.0, 0.1])
    assert not any(
        "no bottom-track record" in r or "passed over" in r for r in sentences(log.notes)
    )


def test_a_wrong_checksum_loses_that_block_alone_and_says_where(tmp_path):
    content = [block(DF21, dvl_record(n)) for n in range(5)]
    content[2] = content[2][:100] + bytes([content[2][100] ^ 0x55]) + content[2][101:]
    pings, _, log = read(tmp_path / "x.ad2cp", *content)
    assert [p.t_ns // 10**9 % 60 for p in pings] == [0, 1, 3, 4]
    (loss,) = log.losses()
    assert (
        loss.why
        == f"{len(content[0])} bytes from byte {2 * len(content[0])} on hold no whole block: a "
        "checksum is wrong"
    )
    assert (loss.start_ns, loss.end_ns) == (pings[1].t_ns, pings[2].t_ns)


@pytest.mark.parametrize(
    ("odd", "why"),
    [
        (b"GETALL\r\n", "no block starts there"),
        (block(DF21, dvl_record())[:-20], "a checksum is wrong"),
        (block(0x23, bytes(10), is_long=True)[:4] + b"\xff" * 18, "a header's checksum is wrong"),
        (block(0x0F, bytes(10), family=0x20), "its family 0x20 is not that of a DVL or Signature"),
    ],
)
def test_what_is_no_block_is_named_and_stepped_over(tmp_path, odd, why):
    pings, _, log = read(
        tmp_path / "x.ad2cp", block(DF21, dvl_record(1)), odd, block(DF21, dvl_record(2))
    )
    assert len(pings) == 2
    assert [loss.why for loss in log.losses()] == [
        f"{len(odd)} bytes from byte 222 on hold no whole block: {why}"
    ]


@pytest.mark.parametrize("left", [5, 11, 100])
def test_a_cut_end_is_named(tmp_path, left):
    pings, _, log = read(
        tmp_path / "x.ad2cp",
        block(DF21, dvl_record(1)),
        block(DF21, dvl_record(2), is_long=True)[:left],
    )
    assert len(pings) == 1
    assert (
        log.losses()[0].why
        == f"{left} bytes from byte 222 on hold no whole block: the last block is cut off"
    )


def test_a_block_that_claims_gigabytes_costs_itself(tmp_path):
    head = struct.pack("<BBBBIH", 0xA5, 12, 0x23, 0x10, 3 << 30, 0)
    head += struct.pack("<H", word_sum(head))
    pings, _, log = read(tmp_path / "x.ad2cp", head, block(DF21, dvl_record(1)))
    assert len(pings) == 1
    assert f"a block of {3 << 30} bytes is longer than any that is read" in log.losses()[0].why


def test_checksum_takes_last_odd_byte_as_high_half_of_word():
    assert checksum(b"") == 0xB58C
    assert checksum(b"\x01\x02\x03") == 0xB58C + 0x0201 + 0x0300
    for size in range(40):
        data = bytes((7 * k + size) % 251 for k in range(size))
        assert checksum(data) == word_sum(data)


def test_blocks_are_found_across_read_window_edges(
    monkeypatch,
):
    monkeypatch.setattr(ad2cp_blocks, "WINDOW", 300)
    parts = [block(kind, bytes(range(kind)), is_long=kind % 3 == 0) for kind in range(1, 60)]
    found = list(blocks(io.BytesIO(b"".join(parts[:30]) + b"rubbish" + b"".join(parts[30:]))))
    assert [b.kind for *_, b in found if isinstance(b, Block)] == list(range(1, 60))
    assert all(b.data == bytes(range(b.kind)) for *_, b in found if isinstance(b, Block))
    assert [(end - start, b) for start, end, b in found if isinstance(b, str)] == [
        (7, "no block starts there")
    ]


def test_overlapping_headers_cost_one_checksum_over_the_file(monkeypatch):
    """Each stands in the data of the one before and claims 60 kB; their own checksums hold, those
    of their data do not.
    """
    tried = []
    monkeypatch.setattr(
        ad2cp_blocks, "checksum", lambda data: tried.append(len(data)) or checksum(data)
    )
    head = struct.pack("<BBBBHH", 0xA5, 10, DF21, 0x10, 60_000, 1)
    head += struct.pack("<H", word_sum(head))
    content = head * 20_000 + block(DF21, dvl_record(1))
    found = list(blocks(io.BytesIO(content)))
    assert [(start, end) for start, end, _ in found] == [(0, 200_000), (200_000, len(content))]
    assert len(tried) < 10


@QUICK
@given(st.data())
def test_any_flipped_bit_costs_at_most_one_record_and_is_noticed(tmp_path, data):
    content = bytearray(b"".join(block(DF21, dvl_record(n), is_long=n % 2 == 0) for n in range(6)))
    content[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    pings, _, log = read(tmp_path / "x.ad2cp", bytes(content))
    assert len(pings) == 5
    assert log.losses()


@QUICK
@given(st.binary(max_size=300), st.binary(max_size=300))
def test_any_bytes_around_a_block_do_not_hide_it(tmp_path, before, after):
    pings, _, log = read(tmp_path / "x.ad2cp", before, block(DF21, dvl_record(7)), after)
    assert [p.t_ns for p in pings] == [1_777_887_007_250_000_000]
    assert len(log.losses()) == (len(before) > 0) + (len(after) > 0)


def test_second_reading_is_equal_and_other_blocks_are_counted(tmp_path):
    (tmp_path / "x.ad2cp").write_bytes(dvl_file() + block(0x15, bytes(31)))
    log = Ad2cpLog(tmp_path / "x.ad2cp")
    first = [(m.t_ns, m.data.velocity.tolist()) for m in log.messages()]
    assert first == [(m.t_ns, m.data.velocity.tolist()) for m in log.messages()]
    assert len(first) == 4
    assert sentences(log.notes)[0] == "2 blocks of other kinds were passed over (1 water tracks)"


def test_beams_are_read_from_the_configuration_alone():
    (found,) = [b.data for *_, b in blocks(io.BytesIO(configuration((0, -90, 180, 90), 25)))]
    beams = read_beams(found)
    assert sorted(beams) == [1, 2, 3, 4]
    assert beams[2] == pytest.approx([0, -SIN, COS], abs=1e-12)
    assert read_beams(b"BEAMCFGLIST,BEAM=1,THETA=90.00,PHI=0.00,FREQ=1\n") == {}
    assert read_beams(b"BEAMCFGLIST,BEAM=1,THETA=abc,PHI=0.00,FREQ=1\n") == {}
    assert read_beams(b"$GPGGA,1\xff\xfe\n") == {}


def test_it_is_known_by_its_first_bytes_and_by_its_name(tmp_path):
    (tmp_path / "a").write_bytes(dvl_file())
    (tmp_path / "b.AD2CP").write_bytes(b"\0" + dvl_file()[1:])
    assert [open_log(tmp_path / name).kind for name in ("a", "b.AD2CP")] == ["Nortek AD2CP"] * 2
    assert find_logs(tmp_path) == [tmp_path / "a", tmp_path / "b.AD2CP"]
    (tmp_path / "c.bin").write_bytes(block(TEXT, b"x" * 20, family=0x20))  # a Nucleus
    with pytest.raises(InputError, match="a file of another instrument of Nortek"):
        open_log(tmp_path / "c.bin")


@pytest.mark.parametrize("code", [ENU, XYZ, BEAM])
def test_each_frame_gives_a_velocity_and_an_attitude_a_record(tmp_path, code):
    pings, attitudes, log = read(tmp_path / "x.ad2cp", signature_file(code))
    assert len(pings) == len(attitudes) == 4
    assert all(np.isfinite(p.velocity).all() for p in pings)
    assert log.losses() == []
