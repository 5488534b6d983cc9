# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import gzip
import io
import shutil
import struct

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hullrecon.dive.logs.formats import pd0_ensemble
from hullrecon.dive.logs.formats.pd0_ensemble import Ensemble, ensembles, parse
from hullrecon.dive.logs.readers.open import open_log
from hullrecon.dive.logs.readers.pd0 import Pd0Log, earth_from_instrument, from_beams, to_sample
from hullrecon.dive.logs.readers.unpack import DamagedError, fields
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences

QUICK = settings(
    max_examples=40,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
    derandomize=True,
)
DEG = np.pi / 180


def ensemble_bytes(
    number: int = 1, ranges=(10_00, 10_00, 10_00, 10_00), velocity=(100, 200, -300, 0), **more
) -> bytes:
    """A PD0 ensemble written by hand: leaders and bottom track, with its checksum. more: transform,
    heading, pitch, roll (0.01 degrees), system.
    """
    fixed = bytearray(59)
    struct.pack_into("<H", fixed, 4, more.get("system", 0x0200))  # 30 degrees, faces down
    fixed[8:10] = bytes([4, 2])
    struct.pack_into("<H", fixed, 12, 50)
    fixed[25] = more.get("transform", 0b01000)  # instrument coordinates
    struct.pack_into("<H", fixed, 32, 100)
    variable = bytearray(65)
    struct.pack_into("<HH", variable, 0, 0x80, number)
    variable[4:11] = bytes([26, 5, 4, 9, 30, number % 60, 25])
    struct.pack_into(
        "<HHhh", variable, 16, 25, more.get("heading", 0), more.get("pitch", 0), more.get("roll", 0)
    )
    bottom = bytearray(81)
    struct.pack_into("<H", bottom, 0, 0x0600)
    struct.pack_into("<4H", bottom, 16, *ranges)
    struct.pack_into("<4h", bottom, 24, *velocity)
    parts = [bytes(fixed), bytes(variable), bytes(bottom)]
    offsets = np.cumsum([6 + 2 * len(parts), *map(len, parts)])
    body = (
        b"\x7f\x7f" + struct.pack("<HBB3H", int(offsets[-1]), 0, 3, *offsets[:-1]) + b"".join(parts)
    )
    return body + struct.pack("<H", sum(body) % 65536)


def read(path):
    log = Pd0Log(path)
    return [m.data for m in log.messages() if m.channel.topic == "dvl"], log


def test_an_ensemble_written_by_hand_reads_back():
    ping = parse(ensemble_bytes(7, heading=9000, pitch=-250, roll=100))
    assert ping.number == 7
    assert ping.frame == "instrument"
    assert ping.t_ns == 1_777_887_007_250_000_000  # 2026-05-04T09:30:07.25Z
    assert ping.depth_m == 2.5
    assert (ping.heading_rad, ping.pitch_rad, ping.roll_rad) == pytest.approx(
        (90 * DEG, -2.5 * DEG, 1 * DEG)
    )
    assert ping.range_m == pytest.approx([10.0] * 4)
    assert ping.bottom == pytest.approx([0.1, 0.2, -0.3, 0.0])
    assert ping.cell_m == pytest.approx([1.0, 1.5])
    assert ping.beam_angle_rad == pytest.approx(30 * DEG)


def test_lost_ranges_and_velocities_are_nan():
    ping = parse(ensemble_bytes(ranges=(0, 100, 100, 100), velocity=(-32768,) * 4))
    assert np.isnan(ping.range_m[0])
    assert np.isfinite(ping.range_m[1:]).all()
    assert np.isnan(ping.bottom).all()


def test_velocity_is_opposite_to_bottom_with_z_into_housing():
    """Bottom at (0.1, 0.2, -0.3) in the instrument's axes (to beam 2, to beam 3, up): the
    instrument moves the other way; dvl's axes are to beam 3, to beam 2, down.
    """
    sample = to_sample(parse(ensemble_bytes()))
    assert sample.velocity == pytest.approx([-0.2, -0.1, -0.3])


def test_ranges_along_the_axis_become_ranges_along_the_beams():
    sample = to_sample(parse(ensemble_bytes(ranges=(866, 866, 866, 0))))
    assert sample.ranges[:3] == pytest.approx([10.0] * 3, abs=0.001)
    assert np.isnan(sample.ranges[3])
    assert sample.beams[2] == pytest.approx([0.5, 0, np.sqrt(0.75)])  # beam 3 is forward
    assert sample.beams[0] == pytest.approx([0, -0.5, np.sqrt(0.75)])


def test_earth_velocity_is_turned_back_by_own_attitude():
    """Heading east and level: the bottom passing to the west means moving east, which is forward
    (beam 3).
    """
    sample = to_sample(
        parse(ensemble_bytes(velocity=(-500, 0, 0, 0), transform=0b11100, heading=9000))
    )
    assert sample.velocity == pytest.approx([0.5, 0, 0], abs=1e-9)


def test_an_upward_instrument_is_turned_over():
    """Facing up, rising at 0.3 m/s: the bottom sinks in earth coordinates; the instrument moves
    along its own z axis out.
    """
    sample = to_sample(
        parse(ensemble_bytes(velocity=(0, 0, -300, 0), transform=0b11100, system=0x0280))
    )
    assert sample.velocity == pytest.approx([0, 0, 0.3], abs=1e-9)


def test_earth_rotation_is_orthonormal_and_pitch_lifts_beam_3():
    turn = earth_from_instrument(0.3, 0.2, -0.1)
    assert turn @ turn.T == pytest.approx(np.eye(3), abs=1e-12)
    assert earth_from_instrument(0.0, 0.2, 0.0)[2, 1] == pytest.approx(np.sin(0.2))


def test_beam_velocities_are_inverted_also_with_one_beam_lost():
    angle = 30 * DEG
    truth = np.array([0.3, -0.2, 0.1])
    s, c = np.sin(angle), np.cos(angle)
    beams = np.array(
        [
            s * truth[0] + c * truth[2],
            -s * truth[0] + c * truth[2],
            -s * truth[1] + c * truth[2],
            s * truth[1] + c * truth[2],
        ]
    )
    assert from_beams(beams, angle) == pytest.approx(truth)
    for lost in range(4):
        partial = beams.copy()
        partial[lost] = np.nan
        assert from_beams(partial, angle) == pytest.approx(truth)
    assert np.isnan(from_beams(np.array([np.nan, np.nan, 0.1, 0.1]), angle)).any()


def test_factor_of_all_beams_is_the_printed_number_not_the_printed_formula():
    """[Ozog2016 1.2.1] prints b = 1 / cos 30 deg = 0.2887."""
    angle = 30 * DEG
    beams = np.full(4, 0.1 * np.cos(angle))  # 0.1 m/s towards the bottom
    assert from_beams(beams, angle)[2] == pytest.approx(0.1)
    assert from_beams(beams, angle)[2] / beams.sum() == pytest.approx(0.2887, abs=5e-5)
    printed = 1 / np.cos(angle)
    assert printed == pytest.approx(1.1547, abs=5e-5)
    assert printed * beams.sum() == pytest.approx(0.4)


def own_sensors(path, *contents):
    path.write_bytes(b"".join(contents))
    found = {}
    for message in Pd0Log(path).messages():
        found.setdefault(message.channel.topic, []).append(message.data)
    return found


def test_own_attitude_and_depth_are_those_of_frame_dvl(tmp_path):
    found = own_sensors(tmp_path / "x.pd0", ensemble_bytes(1, heading=9000, pitch=-1000, roll=0))
    (attitude,), (depth,) = found["imu"], found["pressure"]
    ned_from_dvl = Rotation.from_quat(attitude.quaternion).as_matrix()
    # Beam 3, x of dvl, looks east and 10 degrees down (its pitch is negative); the transducers look
    # down and back.
    np.testing.assert_allclose(
        ned_from_dvl[:, 0], [0, np.cos(10 * DEG), np.sin(10 * DEG)], atol=1e-12
    )
    np.testing.assert_allclose(
        ned_from_dvl[:, 2], [0, -np.sin(10 * DEG), np.cos(10 * DEG)], atol=1e-12
    )
    assert attitude.of_dvl
    assert (depth.height, depth.is_up, depth.of_dvl) == (2.5, False, True)


def test_an_instrument_whose_angles_are_all_zero_has_no_compass(tmp_path):
    assert set(own_sensors(tmp_path / "x.pd0", ensemble_bytes(1))) == {"dvl", "pressure"}


def test_velocity_over_ground_and_attitude_of_a_glider_agree(data):
    """A velocity that was logged along the earth's axes comes back by the attitude that the reader
    gives.
    """
    for message in Pd0Log(data / "dvl-pd0-slocum" / "LA100204.PD0").messages():
        if message.channel.topic == "dvl":
            velocity = message.data.velocity
        elif message.channel.topic == "imu" and np.isfinite(velocity).all():
            north_east_down = Rotation.from_quat(message.data.quaternion).apply(velocity)
            break
    with (data / "dvl-pd0-slocum" / "LA100204.PD0").open("rb") as stream:
        ping = next(
            e
            for *_, e in ensembles(stream)
            if isinstance(e, Ensemble) and np.isfinite(e.bottom[:3]).all()
        )
    east, north, up = -ping.bottom[:3]
    np.testing.assert_allclose(north_east_down, [north, east, -up], atol=1e-9)


def test_a_file_without_bottom_track_says_so(tmp_path):
    (tmp_path / "x.pd0").write_bytes(ensemble_bytes(1, ranges=(0, 0, 0, 0), velocity=(-32768,) * 4))
    _, log = read(tmp_path / "x.pd0")
    assert sentences(log.notes)[0].startswith("no ensemble has a bottom track")


def test_hexadecimal_text_is_refused_until_it_is_binary(tmp_path):
    path = tmp_path / "x.pd0"
    content = ensemble_bytes(1) + ensemble_bytes(2)
    path.write_bytes(content.hex().encode())
    with pytest.raises(InputError, match="no whole ensemble: it is the hexadecimal text") as caught:
        read(path)
    assert "xxd -r -p" in caught.value.remedy
    path.write_bytes(bytes.fromhex(path.read_text()))
    assert len(read(path)[0]) == 2


def test_a_file_of_another_name_is_known_behind_a_greeting(tmp_path):
    path = tmp_path / "x.000"
    path.write_bytes(b"[BREAK Wakeup A]\r\n>CS\r\n" + ensemble_bytes(1))
    assert isinstance(open_log(path), Pd0Log)
    path.write_bytes(b"[BREAK Wakeup A]\r\n>CS\r\n\x7f\x7f" + bytes(300))
    with pytest.raises(InputError, match="no log that is read here"):
        open_log(path)


def test_wrong_checksum_loses_one_ensemble_with_its_place(tmp_path):
    content = [ensemble_bytes(n) for n in range(5)]
    content[2] = content[2][:100] + b"\x55" + content[2][101:]
    path = tmp_path / "x.pd0"
    path.write_bytes(b"".join(content))
    samples, log = read(path)
    assert [s.t_ns // 10**9 % 60 for s in samples] == [0, 1, 3, 4]
    size = len(content[0])
    assert f"{size} bytes from byte {2 * size}" in log.losses()[0].why
    assert log.losses()[0].start_ns == samples[1].t_ns
    assert log.losses()[0].end_ns == samples[2].t_ns


def test_rubbish_and_cut_end_between_ensembles_are_skipped(tmp_path):
    path = tmp_path / "x.pd0"
    path.write_bytes(
        b"rubbish\x7f\x7f"
        + ensemble_bytes(1)
        + b"\x7f" * 50
        + ensemble_bytes(2)
        + ensemble_bytes(3)[:-20]
    )
    samples, log = read(path)
    assert len(samples) == 2
    assert len(log.losses()) == 3


@QUICK
@given(st.data())
def test_any_flipped_bit_costs_at_most_one_ensemble(tmp_path, data):
    content = bytearray(b"".join(ensemble_bytes(n) for n in range(6)))
    content[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    path = tmp_path / "x.pd0"
    path.write_bytes(content)
    samples, log = read(path)
    assert len(samples) >= 5
    assert len(samples) == 6 or log.losses()


@QUICK
@given(st.binary(max_size=300), st.binary(max_size=300))
def test_any_bytes_around_an_ensemble_do_not_hide_it(tmp_path, before, after):
    path = tmp_path / "x.pd0"
    path.write_bytes(before + ensemble_bytes(7) + after)
    samples, log = read(path)
    assert [s.t_ns for s in samples] == [parse(ensemble_bytes(7)).t_ns]
    assert len(log.losses()) == (len(before) > 0) + (len(after) > 0)


def reference(text: str, key: str) -> list[np.ndarray]:
    """Every value of a key in the independent decode."""
    lines = [line.strip() for line in text.splitlines()]
    return [
        np.array(eval(line.partition(":")[2]), float)
        for line in lines
        if line.startswith(f"{key}:")
    ]


def test_ensembles_equal_an_independent_decoder(data):
    folder = data / "dvl-pd0-slocum"
    text = gzip.decompress((folder / "LA101636_20.yml.gz").read_bytes()).decode()
    found = [e for _, _, e in ensembles(io.BytesIO((folder / "LA101636_20.PD0").read_bytes()))]
    assert len(found) == 20
    assert all(isinstance(e, Ensemble) for e in found)
    names = ("water_velocity_east", "water_velocity_north", "water_velocity_up", "error_velocity")
    for column, name in enumerate(names):
        for ping, row in zip(found, reference(text, name), strict=True):
            np.testing.assert_array_equal(
                ping.water[:, column], np.where(row == -32768, np.nan, row / 1000)
            )
    for name, field in (("heading", "heading_rad"), ("pitch", "pitch_rad"), ("roll", "roll_rad")):
        measured = np.degrees([getattr(e, field) for e in found]) * 100
        np.testing.assert_allclose(measured, reference(text, name), atol=1e-9)
    np.testing.assert_allclose(
        [e.depth_m * 10 for e in found], reference(text, "transducer_depth"), atol=1e-9
    )
    np.testing.assert_array_equal([e.number for e in found], reference(text, "ensemble_number"))
    first = np.array(reference(text, "bin_1_distance")) / 100
    np.testing.assert_allclose([e.cell_m[0] for e in found], first)
    step = np.array(reference(text, "cell_length")) / 100
    np.testing.assert_allclose([e.cell_m[1] - e.cell_m[0] for e in found], step)
    # seconds since 1900 in the reference
    stamps = np.array(reference(text, "internal_timestamp")) - 2_208_988_800
    np.testing.assert_allclose([e.t_ns / 1e9 for e in found], stamps, atol=1e-3)


def test_glider_bottom_track_equals_its_published_values(data):
    found = [
        e
        for _, _, e in ensembles(
            io.BytesIO((data / "dvl-pd0-slocum" / "LA100204.PD0").read_bytes())
        )
    ]
    assert len(found) == 107
    assert sum(np.isfinite(e.bottom[:3]).all() for e in found) == 51
    ping = next(e for e in found if e.number == 58)
    assert ping.range_m == pytest.approx([62.91, 64.32, 54.90, 74.19])
    assert ping.bottom == pytest.approx([0.416, -0.238, -0.002, 0.010])
    assert np.degrees([ping.heading_rad, ping.pitch_rad, ping.roll_rad]) == pytest.approx(
        [284.39, -29.00, -2.39]
    )


def test_a_diving_glider_sinks_and_moves_ahead(data):
    """Signs against physics: over the first bottom track depth grows, and a glider flies nose
    first.
    """
    found = [
        e
        for _, _, e in ensembles(
            io.BytesIO((data / "dvl-pd0-slocum" / "LA100204.PD0").read_bytes())
        )
    ]
    tracked = [e for e in found if np.isfinite(e.bottom[:3]).all()]
    climbing = -np.mean([e.bottom[2] for e in tracked[:20]])  # of the vehicle, upward
    sinking = (
        (tracked[19].depth_m - tracked[0].depth_m) / (tracked[19].t_ns - tracked[0].t_ns) * 1e9
    )
    assert -climbing == pytest.approx(sinking, abs=0.08)
    assert np.median([to_sample(e).velocity[0] for e in tracked]) > 0.2


def test_corrupted_file_gives_whole_ensembles_and_losses(data, tmp_path):
    path = tmp_path / "x.PD0"
    shutil.copy(data / "dvl-pd0-slocum" / "LB180210_3_corrupted.PD0", path)
    samples, log = read(path)
    assert len(samples) == 2
    assert [loss.why for loss in log.losses()] == [
        "446 bytes from byte 446 on hold no whole ensemble: a checksum is wrong"
    ]


def test_profiler_without_bottom_track_gives_lost_pings(data):
    samples, _ = read(data / "dvl-pd0-slocum" / "ADCP_CCE1T_20.000")
    assert len(samples) == 20
    assert all(np.isnan(s.velocity).all() and np.isnan(s.ranges).all() for s in samples)


def test_false_ensemble_heads_cost_one_checksum_over_the_file(monkeypatch):
    """Every byte of it may start an ensemble that claims half of 64 KiB, whose checksum is another
    sum each time.
    """
    tried = []
    monkeypatch.setattr(
        pd0_ensemble,
        "fields",
        lambda layout, data, at=0: tried.append(at) or fields(layout, data, at),
    )
    content = b"\x7f" * (3 << 20) + ensemble_bytes(1)
    found = list(ensembles(io.BytesIO(content)))
    assert [(start, end) for start, end, _ in found] == [(0, 3 << 20), (3 << 20, len(content))]
    assert len(tried) < 100


def test_ensembles_across_read_block_edges_are_found(monkeypatch):
    monkeypatch.setattr(pd0_ensemble, "BLOCK", 300)
    content = b"".join(ensemble_bytes(n) for n in range(20)) + b"rubbish" + ensemble_bytes(20)
    found = list(ensembles(io.BytesIO(content)))
    assert [e.number for _, _, e in found if isinstance(e, Ensemble)] == list(range(21))
    assert [(e - s, why) for s, e, why in found if isinstance(why, str)] == [
        (7, "no ensemble starts there")
    ]


@pytest.mark.parametrize("angle", [0, 90, 255])
def test_beams_that_stand_nowhere_are_damage(angle):
    content = bytearray(ensemble_bytes(system=0x0300))
    content[6 + 6 + 58] = angle
    with pytest.raises(DamagedError, match=f"{angle} degrees off the axis"):
        parse(bytes(content[:-2]))
