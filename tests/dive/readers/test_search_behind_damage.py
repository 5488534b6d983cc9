# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
"""What is read of a file stays in proportion to its size, however many headers in it claim the rest
of it.
"""

import io

import pytest

from benchmarks.fuzz import seed_aris, seed_view_point
from hullrecon.dive.logs.readers.oculus.log_items import items
from hullrecon.dive.logs.readers.sound_metrics.aris_frames import frames
from hullrecon.dive.logs.readers.unpack import UnpackBudget


class CountedBytes(io.BytesIO):
    """A file that knows how much was read of it."""

    count = 0

    def read(self, size=-1):
        data = super().read(size)
        self.count += len(data)
        return data


def oculus_headers(count):
    """A file of headers of 40 bytes, each with a payload up to the end but seven bytes."""
    false = (seed_view_point.item(b"", claimed=40 * (count - n - 1) - 7) for n in range(count - 1))
    return seed_view_point.file_header() + b"".join(false) + b"x" * 40


def aris_headers(count):
    """A file of headers of 1024 bytes, each with an image of 500,000 bytes, behind which no other
    begins.
    """
    false = seed_aris.frame(0, samples=0, claimed=500_000 // 64)
    return seed_aris.file_header() + count * false + bytes(500_000)


@pytest.mark.parametrize(
    ("make", "walk", "few"),
    [
        (
            oculus_headers,
            lambda stream: items(stream, 48, UnpackBudget(stream.getbuffer().nbytes)),
            2000,
        ),
        (aris_headers, frames, 200),
    ],
    ids=["oculus", "aris"],
)
def test_headers_claiming_rest_of_file_cost_linear_time(make, walk, few):
    read, size = [], []
    for count in (few, 4 * few):
        stream = CountedBytes(make(count))
        assert all(isinstance(found, str) for *_, found in walk(stream))
        read.append(stream.count)
        size.append(stream.getbuffer().nbytes)
    assert read[1] < 4.5 * read[0]
    assert read[1] < 30 * size[1]
