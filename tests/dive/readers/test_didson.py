# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from benchmarks.fuzz.seed_aris import aris_file, didson_file
from hullrecon.dive.init.log_summary import summarise_log
from hullrecon.dive.init.proposals import questions
from hullrecon.dive.logs.formats.sonar_file import read_ping
from hullrecon.dive.logs.readers.open import open_log
from hullrecon.dive.logs.readers.plain import PlainLog
from hullrecon.dive.logs.readers.sound_metrics.didson_frames import read_frame
from hullrecon.dive.logs.readers.unpack import DamagedError
from hullrecon.dive.logs.streams.sonar import sonar_pings
from hullrecon.errors import InputError
from hullrecon.findings.finding import sentences

HEADERS = {3: (512, 256), 4: (1024, 1024)}


def table(folder, rows):
    (folder / "sonar.csv").write_text("t,file,ping,range_from,range_to\n" + "\n".join(rows) + "\n")
    return PlainLog(folder)


@pytest.mark.parametrize("version", [3, 4])
@pytest.mark.parametrize("beams", [48, 96])
def test_frame_of_both_versions_is_read_port_to_starboard(tmp_path, version, beams):
    content = didson_file(version, 3, beams)
    (tmp_path / "p.ddf").write_bytes(content)
    before, header = HEADERS[version]
    at = before + 2 * (header + 512 * beams) + header
    pixels = np.frombuffer(content, np.uint8, 512 * beams, at).reshape(512, beams)
    np.testing.assert_array_equal(read_frame(tmp_path / "p.ddf", 2), pixels[:, ::-1].T)


def test_rows_give_stamp_and_window_and_dive_toml_the_beams(tmp_path):
    (tmp_path / "p.ddf").write_bytes(didson_file(4))
    log = table(tmp_path, ["1.5,p.ddf,0,1,6", "2.5,p.ddf,1,1,6"])
    pings = [message.data for message in log.messages()]
    assert [p.t_ns for p in pings] == [1_500_000_000, 2_500_000_000]
    assert pings[0].directions is None
    assert pings[0].range_m[[0, -1]] == pytest.approx([1 + 5 / 1024, 6 - 5 / 1024])
    azimuth = np.linspace(-14, 14, 48)
    assert sonar_pings(pings, [], azimuth).directions[0] == pytest.approx(
        [0, np.sin(np.radians(-14)), np.cos(np.radians(14))]
    )
    assert (
        "nothing says where the sonar's 48 beams point"
        in sentences(questions(summarise_log(log)))[0]
    )


@pytest.mark.parametrize(
    ("window", "why"),
    [
        (None, "states no ranges in metres"),
        ((6.0, 1.0), "a window from 6 to 1 m"),
        ((0.0, 1e6), "a window"),
        ((np.nan, 3.0), "a window"),
    ],
)
def test_a_window_that_is_not_given_is_asked_for(tmp_path, window, why):
    (tmp_path / "p.ddf").write_bytes(didson_file(3))
    with pytest.raises(ValueError, match=why):
        read_ping(tmp_path / "p.ddf", 0, window)


def test_a_window_for_a_file_that_has_ranges_is_refused(tmp_path):
    np.savez(tmp_path / "p.npz", image=np.zeros((2, 3), np.uint8), azimuth=[0, 1], range=[1, 2, 3])
    with pytest.raises(ValueError, match="this one has ranges of its own"):
        read_ping(tmp_path / "p.npz", 0, (1.0, 2.0))


def test_cut_file_gives_whole_frames_and_loses_other_rows(tmp_path):
    (tmp_path / "p.ddf").write_bytes(didson_file(3)[:-1])
    log = table(tmp_path, ["1,p.ddf,0,1,6", "2,p.ddf,1,1,6", "3,p.ddf,7,1,6"])
    assert len(list(log.messages())) == 1
    assert [loss.why for loss in log.losses()] == [
        "lines 3, 4 of sonar.csv cannot be read: p.ddf: it holds no whole frame of that number"
    ]


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (didson_file(3)[:15], "ends too early"),
        (b"DDF\x02" + didson_file(3)[4:], "version 2 with 48 beams is not read"),
        (didson_file(3)[:16] + b"\x09" + didson_file(3)[17:], "version 3 with 9 beams is not read"),
        (didson_file(3)[:524] + b"?" + didson_file(3)[525:], "no frame begins where"),
        (aris_file(1), "name it in logs.files"),
    ],
    ids=range(5),
)
def test_a_file_that_is_none_is_refused_with_the_reason(tmp_path, content, why):
    (tmp_path / "p.ddf").write_bytes(content)
    with pytest.raises(DamagedError, match=why):
        read_frame(tmp_path / "p.ddf", 0)


def test_a_file_given_as_a_log_is_told_where_it_belongs(tmp_path):
    (tmp_path / "p.ddf").write_bytes(didson_file(4))
    with pytest.raises(InputError, match="a recording of a DIDSON") as caught:
        open_log(tmp_path / "p.ddf")
    assert "t, file, ping, range_from, range_to" in caught.value.remedy
