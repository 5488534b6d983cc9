# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import tempfile
import tracemalloc

import numpy as np
import pytest

from hullrecon.dive.logs.ping_spool import PingSpool, look_at
from hullrecon.dive.logs.samples import SonarSample
from hullrecon.dive.logs.streams.sonar import leave_black, sonar_pings
from hullrecon.errors import InputError

RANGES = np.linspace(1.0, 5.0, 64)
DIRECTIONS = np.tile([0.0, 0.0, 1.0], (96, 1))


def ping(t_ns, dtype=np.uint8, ranges=RANGES):
    image = np.random.default_rng(t_ns).integers(0, 250, (96, len(ranges))).astype(dtype)
    return SonarSample(t_ns, image, DIRECTIONS.copy(), ranges.copy())


@pytest.mark.parametrize("dtype", ["u1", "<u2", ">u2", "<f4"])
def test_pings_come_back_as_they_went(dtype):
    samples = [ping(0), *(ping(t, dtype) for t in range(1, 5)), ping(5, ranges=RANGES[:33])]
    with tempfile.TemporaryFile() as file:
        spool = PingSpool(file)
        for kept, sample in zip([spool.keep(s) for s in samples], samples, strict=True):
            back = spool.load(kept)
            assert back.t_ns == sample.t_ns
            assert back.image.dtype == sample.image.dtype
            np.testing.assert_array_equal(back.image, sample.image)
            np.testing.assert_array_equal(back.range_m, sample.range_m)
            np.testing.assert_array_equal(back.directions, sample.directions)


def test_a_kept_ping_has_shape_type_and_bright_pixel_and_no_image():
    sample = ping(1, "<u2")
    sample.image[3, 4] = 65535
    kept = PingSpool(None).keep(sample)
    assert (kept.image.shape, kept.image.dtype) == (sample.image.shape, sample.image.dtype)
    assert not kept.image.any()
    assert 0 < (sample.image > kept.look.bright).mean() <= 0.005
    assert kept.look.bright in sample.image
    assert look_at(np.full((2, 3), np.nan, np.float32)).bright == 0


def test_without_spool_file_notes_stay_and_images_are_black():
    samples = [ping(t, "<u2") for t in range(3)]
    spool = PingSpool(None)
    told, heard = [], []
    whole = sonar_pings(samples, told)
    black = sonar_pings([spool.keep(s) for s in samples], heard, keep=leave_black, load=spool.load)
    assert told == heard
    assert len(told) == 1
    assert black.image.shape == whole.image.shape
    assert not black.image.any()


def test_equal_beams_and_ranges_are_kept_once():
    spool = PingSpool(None)
    first, second, third = (spool.keep(s) for s in (ping(0), ping(1), ping(2, ranges=RANGES[:33])))
    assert second.range_m is first.range_m
    assert second.directions is first.directions
    assert len(third.range_m) == 33


def take_one_by_one(shape, images):
    assert sum(image.shape == shape[1:] for image in images) == shape[0]
    return leave_black(shape, images)


def test_the_record_is_that_of_pings_in_memory():
    samples = [ping(0, "<u2"), ping(1, "<u2"), ping(2, "<u2", RANGES * 1.004)]
    with tempfile.TemporaryFile() as file:
        spool = PingSpool(file)
        spooled = sonar_pings([spool.keep(s) for s in samples], [], load=spool.load)
    np.testing.assert_array_equal(spooled.image, sonar_pings(samples, []).image)
    assert spooled.image.max() == 255


def test_memory_does_not_grow_with_the_pings():
    size = 96 * 64
    with tempfile.TemporaryFile() as file:
        spool = PingSpool(file)
        tracemalloc.start()
        kept = [spool.keep(ping(t)) for t in range(500)]
        pings = sonar_pings(kept, [], keep=take_one_by_one, load=spool.load)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert pings.image.shape == (500, 96, 64)
    assert peak < 500 * size / 3


@pytest.mark.parametrize("stored", ["<u2", ">u2"])
def test_pixels_whose_bytes_are_exchanged_are_put_right(stored):
    """The hull is bright beside the water, so that neighbours mostly resemble each other."""
    rng = np.random.default_rng(1)
    pixels = rng.integers(0, 2000, (96, 64)) + np.where(np.arange(64) > 20, 20_000, 0)
    right = pixels.astype("<u2")
    image = right if stored == "<u2" else right.byteswap()
    notes = []
    found = sonar_pings([SonarSample(0, image, DIRECTIONS, RANGES)], notes)
    np.testing.assert_array_equal(
        found.image, sonar_pings([SonarSample(0, right, DIRECTIONS, RANGES)], []).image
    )
    assert ("sonar-bytes-exchanged" in [note.code for note in notes]) == (stored == ">u2")


def test_decibels_are_refused_and_amplitudes_read():
    amplitude = (1.0 + ping(1).image) / 256
    image = 20 * np.log10(amplitude)
    with pytest.raises(InputError, match="below zero: are they decibels"):
        sonar_pings([SonarSample(0, image, DIRECTIONS, RANGES)], [])
    assert sonar_pings([SonarSample(0, amplitude, DIRECTIONS, RANGES)], []).image.max() == 255
