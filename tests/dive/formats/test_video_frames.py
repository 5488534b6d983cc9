# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import cv2
import numpy as np
import pytest

from hullrecon.dive.logs.formats.video_frames import VideoFrames
from hullrecon.dive.logs.readers.plain import PlainLog


def write_video(path, count=6, size=(64, 48)):
    """Frames of one gray each, 30 levels apart."""
    writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, cv2.VideoWriter_fourcc(*"MJPG"), 10.0, size)
    assert writer.isOpened()
    for n in range(count):
        writer.write(np.full((size[1], size[0], 3), 20 + 30 * n, np.uint8))
    writer.release()
    return path


def gray(jpeg):
    return float(cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_GRAYSCALE).mean())


def test_frames_are_found_by_their_number(tmp_path):
    video = VideoFrames(write_video(tmp_path / "x.avi"))
    assert [gray(video.jpeg(n)) for n in (0, 2, 5)] == pytest.approx([20, 80, 170], abs=3)
    with pytest.raises(ValueError, match="frames have to grow"):
        video.jpeg(5)
    with pytest.raises(ValueError, match="no frame 9"):
        video.jpeg(9)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"#EXTM3U\n/etc/passwd\n",
        b"RIFF\0\0\0\0AVI " + b"x" * 100,
        b"\0\0\0\x18ftypisom" + b"\0" * 64,
    ],
)
def test_what_is_no_video_is_refused(tmp_path, content):
    (tmp_path / "x.mp4").write_bytes(content)
    with pytest.raises(ValueError, match=r"it is no MP4|it cannot be decoded|its frames have"):
        VideoFrames(tmp_path / "x.mp4")


def test_a_table_names_frames_of_a_video_with_their_times(tmp_path):
    write_video(tmp_path / "dive.avi")
    rows = (
        "t,file,frame\n1.0,dive.avi,0\n1.2,dive.avi,2\n1.3,dive.avi,2\n"
        "1.4,dive.avi,\n1.5,dive.avi,4\n1.9,dive.avi,40\n"
    )
    (tmp_path / "camera_top.csv").write_text(rows)
    log = PlainLog(tmp_path)
    for _ in range(2):  # reading twice gives the same
        samples = [m.data for m in log.messages()]
        assert [s.t_ns for s in samples] == [1_000_000_000, 1_200_000_000, 1_500_000_000]
        assert [gray(s.encoded) for s in samples] == pytest.approx([20, 80, 140], abs=3)
        assert all(s.file == "" for s in samples)
        assert "lines 4, 5, 7 of camera_top.csv" in log.losses()[0].why
    assert [p.name for p in log.named_files()] == ["dive.avi"]


def test_a_video_is_read_as_its_sensor_stored_it(tmp_path):
    """Though its container asks players to turn it, which OpenCV does by itself."""
    path = tmp_path / "dive.mp4"
    codec = cv2.VideoWriter_fourcc(*"mp4v")
    writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, codec, 10.0, (64, 48))
    ramp = np.repeat(np.tile(np.linspace(0, 250, 64).astype(np.uint8), (48, 1))[:, :, None], 3, 2)
    for _ in range(3):
        writer.write(ramp)
    writer.release()
    data = bytearray(path.read_bytes())
    # ISO 14496-12: the track header's matrix begins 40 bytes behind its name; -1, 0, 0, -1 is half
    # a turn
    at = data.index(b"tkhd") + 4 + 40
    data[at : at + 4], data[at + 16 : at + 20] = b"\xff\xff\0\0", b"\xff\xff\0\0"
    path.write_bytes(data)
    (tmp_path / "camera_top.csv").write_text("t,file,frame\n1.0,dive.mp4,0\n1.2,dive.mp4,2\n")
    log = PlainLog(tmp_path)
    encoded = next(m.data.encoded for m in log.messages())
    picture = cv2.imdecode(np.frombuffer(encoded, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert picture[:, :8].mean() < 50 < 200 < picture[:, -8:].mean()
    assert ["turned by 180 degrees" in note.sentence for note in log.notes] == [True]
