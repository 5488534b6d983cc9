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
