# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
from hullrecon.dive.images.sink import MOST, RUN, SampledImages


def sampled(count):
    """So many images of three bytes each, and the numbers of those that were kept."""
    out = SampledImages()
    for k in range(count):
        out.write(k.to_bytes(3, "big"))
    return out, [k for k in range(count) if out.image_at(3 * k) == k.to_bytes(3, "big")]


def test_few_images_are_all_kept():
    assert sampled(MOST)[1] == list(range(MOST))


def test_runs_of_neighbouring_images_are_kept_over_whole_dive():
    out, kept = sampled(20 * MOST)
    assert MOST // 4 <= len(kept) <= MOST
    assert kept[-1] > 18 * MOST
    assert all(
        k - k % RUN + j in kept for k in kept for j in range(RUN) if k - k % RUN + j < 20 * MOST
    )
    assert out.image_at(1) is None


def test_two_cameras_keep_the_same_images():
    assert sampled(1000)[1] == sampled(1000)[1]
