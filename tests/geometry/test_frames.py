# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import pytest

from hullrecon.geometry.frames import Camera, Frame


def test_the_top_camera_comes_first() -> None:
    assert [camera.column for camera in Camera] == [0, 1]
    assert next(iter(Camera)) is Camera.TOP


@pytest.mark.parametrize("camera", list(Camera))
def test_a_camera_names_its_files_and_its_table(camera: Camera) -> None:
    assert camera.key == f"camera_{camera}"
    assert camera.section == f"camera.{camera}"
    assert Camera(str(camera)) is camera


def test_no_two_frames_share_a_letter() -> None:
    assert len({frame.value for frame in Frame}) == len(Frame)
    assert Frame("M") is Frame.HULL


def test_an_unknown_frame_is_refused() -> None:
    with pytest.raises(ValueError, match="is not a valid Frame"):
        Frame("x")
