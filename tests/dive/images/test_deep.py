# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from io import BytesIO

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from hullrecon.artifacts.writer import ArtifactWriter
from hullrecon.dive.images import encoded as deep_images
from hullrecon.dive.images.encoded import decode, decode_deep, is_deep
from hullrecon.dive.images.sink import ImageSink
from hullrecon.dive.images.store import ImageStore
from hullrecon.dive.logs.samples import ImageSample
from hullrecon.findings.finding import sentences
from hullrecon.records.serialisation import to_arrays


@pytest.mark.parametrize("suffix", [".png", ".tif", ".pgm"])
def test_the_header_says_whether_samples_have_sixteen_bits(suffix):
    shallow = np.full((24, 36), 200, np.uint8)
    for pixels in (shallow, shallow.astype(np.uint16)):
        assert is_deep(cv2.imencode(suffix, pixels)[1].tobytes()) is (pixels.dtype == np.uint16)


@pytest.mark.parametrize("suffix", [".jpg", ".bmp", ".webp", ".jp2", ".gif"])
def test_other_formats_have_eight(suffix):
    pixels = np.zeros((24, 36, 3), np.uint8)
    file = BytesIO()
    Image.fromarray(pixels).save(file, {".jpg": "JPEG", ".jp2": "JPEG2000"}.get(suffix, suffix[1:]))
    assert not is_deep(file.getvalue())


@given(st.sampled_from([b"P5", b"II*\0", b"MM\0+", b"\x89PNG\r\n\x1a\n"]), st.binary(max_size=60))
def test_a_damaged_header_says_nothing_of_it(start, rest):
    assert is_deep(start + rest) in (False, True)


def deep(largest: int, suffix: str = ".png", color: bool = False) -> bytes:
    """An image of 16 bits whose values grow along its rows up to the largest one; of a colour one
    only blue does.
    """
    pixels = np.tile(np.linspace(0, largest, 64).astype(np.uint16), (48, 1))
    if color:
        pixels = np.stack([pixels, 0 * pixels, 0 * pixels], axis=2)
    return cv2.imencode(suffix, pixels)[1].tobytes()


def stored(folder, *encoded: bytes) -> tuple[ImageStore, list[str]]:
    folder.mkdir(exist_ok=True)
    file, notes = BytesIO(), []
    filled = ImageSink("camera_top", (64, 48), folder, lambda: file)
    for t, data in enumerate(encoded):
        filled.take(ImageSample(t, "camera_top", data), t, 0)
    index = filled.finish(notes)
    ArtifactWriter(folder).arrays("images_camera_top.npz", to_arrays(index))
    (folder / "images_camera_top.bin").write_bytes(file.getvalue())
    return ImageStore(folder, None, "camera_top"), notes


@pytest.mark.parametrize("suffix", [".png", ".tif", ".pgm"])
@pytest.mark.parametrize(
    ("largest", "bits"), [(255, 8), (1023, 10), (4095, 12), (16383, 14), (65535, 16)]
)
def test_16_bit_images_are_scaled_by_the_bits_they_fill(tmp_path, largest, bits, suffix):
    store, notes = stored(tmp_path, deep(largest, suffix))
    read = store.read(0)
    assert (read.min(), read.max(), len(np.unique(read))) == (0, 255, 64)
    what = (
        f"its images have 16 bits with values up to {largest}; the upper 8 of {bits} bits are used"
    )
    assert sentences(notes) == [f"camera_top: {what}"]


def test_all_images_of_a_camera_have_one_scale(tmp_path, kit):
    dark, bright, blue = deep(800), deep(4000), deep(3000, color=True)
    store, _ = stored(tmp_path, dark, bright, kit.jpeg(1), blue)
    assert [store.read(row).max() for row in (0, 1, 3)] == [800 >> 4, 4000 >> 4, 3000 >> 4]
    assert store.read(3)[:, :, :2].max() == 0
    np.testing.assert_array_equal(store.read(2), decode(kit.jpeg(1)))
    only_blue, _ = stored(tmp_path / "blue", blue)
    assert only_blue.read(0).max() == 3000 >> 4


def test_a_value_beyond_the_scale_is_white():
    assert decode(deep(4095), 10).max() == 255
    assert decode(deep(4095), 10)[0, 32, 0] == 255


def test_images_of_eight_bits_have_no_scale(tmp_path, kit):
    store, notes = stored(tmp_path, kit.jpeg(0), kit.jpeg(1))
    assert int(store.index.bits) == 16
    assert sentences(notes) == []


def test_numbers_with_a_sign_are_left_to_the_plain_decoder():
    file = BytesIO()
    Image.fromarray(np.full((4, 5), 0.5, np.float32)).save(file, "TIFF")
    assert not is_deep(file.getvalue())
    assert decode_deep(file.getvalue()) is None


def test_an_image_too_large_for_sixteen_bits_is_read_with_eight(monkeypatch):
    monkeypatch.setattr(deep_images, "MOST_DEEP_PIXELS", 64 * 48 - 1)
    assert not is_deep(deep(4095))
    assert decode(deep(4095), 12).max() == 4095 >> 8
