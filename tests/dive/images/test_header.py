# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import io
import struct
import zlib

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from hullrecon.dive.images import encoded as encoded_images
from hullrecon.dive.images.encoded import LARGEST_PIXELS, check_image, decode, fits, header_size

SUFFIXES = [".jpg", ".png", ".bmp", ".ppm", ".tif", ".webp", ".jp2", ".gif"]


def encoded(suffix: str, *flags: int) -> bytes:
    pixels = np.random.default_rng(1).integers(0, 255, (24, 36, 3), np.uint8)
    if suffix == ".jp2":  # OpenCV reads them only
        file = io.BytesIO()
        Image.fromarray(pixels).save(file, "JPEG2000")
        return file.getvalue()
    ok, data = cv2.imencode(suffix, pixels, list(flags))
    assert ok
    return data.tobytes()


def png_of_zeros(width: int, height: int) -> bytes:
    """A PNG of one bit a pixel, all black: 30,000 x 30,000 pixels in 110 kB."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    row, packer = bytes(1 + (width + 7) // 8), zlib.compressobj(9)
    data = b"".join(packer.compress(row) for _ in range(height)) + packer.flush()
    head = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


@pytest.fixture
def no_decoder(monkeypatch):
    def fail(*_):
        raise AssertionError("it was decoded")

    monkeypatch.setattr(encoded_images, "_decode", fail)
    monkeypatch.setattr(cv2, "imdecode", fail)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_the_size_of_every_format_is_read_from_its_header(suffix, no_decoder):
    assert header_size(encoded(suffix)) == (36, 24)


@pytest.mark.parametrize(
    ("flag", "value"), [(cv2.IMWRITE_JPEG_PROGRESSIVE, 1), (cv2.IMWRITE_JPEG_RST_INTERVAL, 2)]
)
def test_so_is_that_of_other_jpegs(flag, value):
    assert header_size(encoded(".jpg", flag, value)) == (36, 24)


@pytest.mark.parametrize("flags", [(cv2.IMWRITE_WEBP_QUALITY, 50), (cv2.IMWRITE_WEBP_QUALITY, 101)])
def test_webp_says_its_size_whether_lossy_or_not(flags):
    assert header_size(encoded(".webp", *flags)) == (36, 24)


def test_the_canvas_of_an_extended_webp_is_its_size():
    assert header_size(
        b"RIFF\0\0\0\0WEBPVP8X" + bytes(8) + (35).to_bytes(3, "little") + (23).to_bytes(3, "little")
    ) == (36, 24)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_every_format_decodes_as_before(suffix):
    image = decode(encoded(suffix))
    assert image is not None
    assert image.shape == (24, 36, 3)
    assert check_image(encoded(suffix)).size == (36, 24)


def test_a_png_of_another_size_than_the_cameras_is_not_decoded(no_decoder):
    assert check_image(encoded(".png"), (640, 480)).size == (36, 24)


def test_a_png_that_claims_a_billion_pixels_is_never_decoded(no_decoder):
    bomb = png_of_zeros(30_000, 30_000)
    assert len(bomb) < 200_000
    assert (
        check_image(bomb).size
        == check_image(bomb, (640, 480)).size
        == check_image(bomb, (30_000, 30_000)).size
        == (30_000, 30_000)
    )
    assert decode(bomb) is None


def test_a_png_with_a_chunk_longer_than_the_file_is_not_decoded(no_decoder):
    """OpenCV made room for four gigabytes, and filled it."""
    data = bytearray(encoded(".png"))
    at = data.find(b"IDAT")
    data[at - 4] = 0xFF
    assert header_size(bytes(data)) is None
    assert check_image(bytes(data)).size is None
    assert decode(bytes(data)) is None


@pytest.mark.parametrize("missing", [1, 12, 13, 100])
def test_a_png_without_its_end_has_no_size(missing):
    assert header_size(encoded(".png")[:-missing]) is None


def test_what_fits_is_bounded_by_the_memory_of_its_decoding():
    assert fits((1, LARGEST_PIXELS))
    assert not fits((2, LARGEST_PIXELS))
    assert not fits((0, 480))


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_cut_header_has_no_size(suffix):
    assert header_size(encoded(suffix)[:7]) is None


@settings(max_examples=100, deadline=None, derandomize=True)
@given(
    st.sampled_from(
        [
            b"",
            b"\xff\xd8",
            b"\x89PNG\r\n\x1a\n",
            b"RIFF0000WEBPVP8L",
            b"II*\0",
            b"BM",
            b"P6 ",
            b"GIF89a",
        ]
    ),
    st.binary(max_size=200),
)
def test_any_bytes_have_a_size_or_none(head, rest):
    size = header_size(head + rest)
    assert size is None or len(size) == 2
