# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.fuzz.seed_aris import aris_file, file_header, frame
from hullrecon.dive.logs.readers.open import find_logs, open_log
from hullrecon.dive.logs.readers.sound_metrics import aris_frames
from hullrecon.dive.logs.readers.sound_metrics.aris import (
    ARIS_1200,
    ARIS_1800,
    ARIS_3000,
    ArisLog,
    beam_azimuths,
)
from hullrecon.dive.logs.readers.sound_metrics.aris_frames import parse_header
from hullrecon.dive.logs.readers.unpack import DamagedError
from hullrecon.findings.finding import sentences

QUICK = settings(
    max_examples=30,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
)
START_NS = 1_777_887_000_000_000_000
SIZE = 1024 + 64 * 8  # bytes of a frame


def read(path, *contents):
    path.write_bytes(b"".join(contents))
    log = ArisLog(path)
    return [message.data for message in log.messages()], log


def test_a_frame_reads_back_with_its_stamp_ranges_and_beams(tmp_path):
    pixels = np.frombuffer(frame(0)[1024:], np.uint8).reshape(8, 64)
    pings, log = read(tmp_path / "x.aris", aris_file(2))
    assert [p.t_ns - START_NS for p in pings] == [0, 200_000_000]
    assert log.losses() == []
    # middles of samples of 10 us
    assert pings[0].range_m[:2] == pytest.approx([750 * 2005e-6, 750 * 2015e-6])
    # beam 0 of the file is the one farthest to starboard
    np.testing.assert_array_equal(pings[0].image[0], pixels[:, -1])
    x, y, z = pings[0].directions.T
    assert not x.any()
    assert np.degrees(np.arctan2(y, z)[[0, -1]]) == pytest.approx([-14.887, 14.887], abs=0.005)


@pytest.mark.parametrize(
    ("model", "beams", "is_telephoto", "table"),
    [  # of the published tables: the first three beams, two in the middle
        (ARIS_3000, 128, False, {0: -15.0068, 1: -14.7768, 63: -0.1193, 64: 0.1193, 127: 15.0156}),
        (ARIS_3000, 64, False, {0: -14.8872, 16: -7.3742, 31: -0.2389, 32: 0.2389}),
        (ARIS_1200, 48, False, {0: -13.5735, 1: -13.1419, 2: -12.7003, 44: 12.2442, 47: 13.5735}),
        (ARIS_1800, 48, True, {0: -7.339, 1: -7.043, 2: -6.744, 6: -5.529}),
    ],
)
def test_beams_point_where_the_maker_measured_them(model, beams, is_telephoto, table):
    azimuth = np.degrees(beam_azimuths(model, beams, is_telephoto=is_telephoto))
    assert len(azimuth) == beams
    assert (np.diff(azimuth) > 0).all()
    for beam, angle in table.items():
        assert azimuth[beam] == pytest.approx(angle, abs=0.012)


def test_unpublished_lens_has_no_beam_directions(tmp_path):
    assert beam_azimuths(ARIS_3000, 128, is_telephoto=True) is None
    assert beam_azimuths(9, 48, is_telephoto=False) is None
    (ping,), log = read(tmp_path / "x.aris", aris_file(1, lens=1))
    assert ping.directions is None
    assert sentences(log.notes)[0] == "ARIS 3000, 64 beams, telephoto lens"
    assert "sonar.elevation_deg" in sentences(log.notes)[1]


@pytest.mark.parametrize(
    "wrong",
    [
        {"mode": 0},
        {"claimed": 1 << 31},
        {"period_us": 0},
        {"speed": float("nan")},
        {"delay_us": 1 << 30},
        {"ordered": 0},
        {"time_us": (1 << 64) - 1},
        {"period_us": 1000, "samples": 400},
    ],
    ids=str,
)
def test_a_header_that_no_aris_writes_is_damage(wrong):
    with pytest.raises(DamagedError):
        parse_header(frame(**wrong))


def test_frames_without_sound_are_left_out_and_counted(tmp_path):
    pings, log = read(tmp_path / "x.aris", file_header(), frame(0), frame(1, on=0), frame(2))
    assert len(pings) == 2
    assert "1 frames were left out: the transmitter was off" in sentences(log.notes)


def test_a_rotator_that_turns_is_named(tmp_path):
    _, log = read(tmp_path / "x.aris", file_header(), frame(0, pan=10.0), frame(1, pan=-20.0))
    assert any("its rotator turned (pan by 30 degrees)" in note for note in sentences(log.notes))
    _, still = read(tmp_path / "y.aris", aris_file(2, pan=10.0))
    assert not any("rotator" in note for note in sentences(still.notes))


@pytest.mark.parametrize(
    "kept", [0, 3, 1024, 1030, 1024 + 1023, 1024 + SIZE - 1, 1024 + SIZE, 1024 + SIZE + 900]
)
def test_cut_file_gives_whole_frames_and_names_the_rest(tmp_path, kept):
    pings, log = read(tmp_path / "x.aris", aris_file(3)[:kept])
    assert len(pings) == max(0, kept - 1024) // SIZE
    rest = max(0, kept - 1024) % SIZE
    assert len(log.losses()) == (rest > 0)
    assert all(loss.why.startswith(f"{rest} bytes from byte ") for loss in log.losses())


def test_damage_costs_the_frame_that_it_hits(tmp_path):
    content = bytearray(aris_file(5))
    content[1024 + 2 * SIZE + 12] ^= 0xFF
    pings, log = read(tmp_path / "x.aris", bytes(content))
    assert [(p.t_ns - START_NS) // 200_000_000 for p in pings] == [0, 1, 3, 4]
    (loss,) = log.losses()
    assert (
        loss.why
        == f"{SIZE} bytes from byte {1024 + 2 * SIZE} on hold no whole frame: no frame begins there"
    )
    assert (loss.start_ns, loss.end_ns) == (pings[1].t_ns, pings[2].t_ns)


@pytest.mark.parametrize("claimed", [7, 9])
def test_a_frame_whose_size_is_wrong_is_not_taken_for_whole(tmp_path, claimed):
    pings, log = read(
        tmp_path / "x.aris", file_header(), frame(0, claimed=claimed), frame(1), frame(2)
    )
    assert [p.t_ns - START_NS for p in pings] == [200_000_000, 400_000_000]
    assert [loss.why.rpartition(": ")[2] for loss in log.losses()] == [
        "no other frame follows where its frame ends"
    ]


def test_missing_or_extra_bytes_cost_only_the_frames_around_them(tmp_path):
    content = aris_file(5)
    cut = content[: 1024 + SIZE + 1100] + content[1024 + SIZE + 1200 :]
    pings, _ = read(tmp_path / "cut.aris", cut)
    assert {(p.t_ns - START_NS) // 200_000_000 for p in pings} >= {0, 3, 4}
    pings, log = read(
        tmp_path / "more.aris", content[: 1024 + 2 * SIZE], bytes(3000), content[1024 + 2 * SIZE :]
    )
    assert len(pings) == 5
    assert [loss.why.split(" on ")[0] for loss in log.losses()] == [
        f"3000 bytes from byte {1024 + 2 * SIZE}"
    ]


def test_a_search_behind_damage_goes_on_over_its_windows(tmp_path, monkeypatch):
    monkeypatch.setattr(aris_frames, "WINDOW", 700)
    pings, log = read(
        tmp_path / "x.aris", aris_file(1), b"DDF\x05" * 1500, *(frame(n) for n in (1, 2))
    )
    assert len(pings) == 3
    assert len(log.losses()) == 1


@QUICK
@given(st.integers(0, 3 * SIZE + 1023), st.integers(1, 255))
def test_a_changed_byte_ends_in_pings_and_losses_twice_the_same(tmp_path, at, change):
    content = bytearray(aris_file(3))
    content[at] ^= change
    first, log = read(tmp_path / "x.aris", bytes(content))
    second = [message.data for message in log.messages()]
    assert [(p.t_ns, p.image.tobytes()) for p in first] == [
        (p.t_ns, p.image.tobytes()) for p in second
    ]
    assert (
        len(first) == 3
        or log.losses()
        or any("transmitter was off" in r for r in sentences(log.notes))
    )


def test_a_file_is_known_by_its_first_bytes_or_its_name(tmp_path):
    (tmp_path / "sonar.ddf").write_bytes(aris_file(1))
    assert isinstance(open_log(tmp_path / "sonar.ddf"), ArisLog)
    (tmp_path / "x.aris").write_bytes(b"????" + aris_file(1)[4:])
    assert len(list(open_log(tmp_path / "x.aris").messages())) == 1
    assert find_logs(tmp_path) == [tmp_path / "sonar.ddf", tmp_path / "x.aris"]
