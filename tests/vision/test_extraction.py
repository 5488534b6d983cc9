# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from hullrecon.vision.features.extraction import FeatureOptions, extract, no_features, root_sift


@pytest.fixture
def blobs():
    """Gaussian spots of 3 px sigma at known places on grey, as an RGB image."""
    places = np.array([[60.25, 50.5], [130.0, 70.75], [90.5, 120.0], [40.0, 130.25]])
    v, u = np.mgrid[0:180, 0:200]
    image = np.full((180, 200), 90.0)
    for x, y in places:
        image += 120 * np.exp(-((u - x) ** 2 + (v - y) ** 2) / (2 * 3.0**2))
    rgb = np.repeat(image[..., None], 3, axis=2)
    rgb[..., 2] *= 0.5
    return places, rgb.clip(0, 255).astype(np.uint8)


@pytest.mark.parametrize("reduction", [1.0, 2.0])
def test_a_spot_is_found_at_its_place_in_raw_pixels(blobs, reduction):
    places, image = blobs
    found = extract(image, FeatureOptions(reduction=reduction, clahe_clip=0.0))
    for place in places:
        assert np.linalg.norm(found.keypoints[:, :2] - place, axis=1).min() < 0.15


def test_features_carry_the_colour_of_their_pixel(blobs):
    places, image = blobs
    found = extract(image, FeatureOptions(clahe_clip=0.0))
    k = int(np.linalg.norm(found.keypoints[:, :2] - places[1], axis=1).argmin())
    u, v = np.rint(found.keypoints[k, :2]).astype(int)
    np.testing.assert_array_equal(found.color[k], image[v, u])


def test_features_come_in_a_fixed_order_and_repeat_bit_for_bit(blobs):
    first, second = (extract(blobs[1], FeatureOptions()) for _ in range(2))
    assert (np.diff(first.keypoints[:, 1]) >= 0).all()
    np.testing.assert_array_equal(first.keypoints, second.keypoints)
    np.testing.assert_array_equal(first.descriptors, second.descriptors)


def test_levelling_brings_out_faint_texture():
    rng = np.random.default_rng(2)
    faint = (40 + np.kron(rng.uniform(0, 5, (32, 40)), np.ones((8, 8)))).astype(np.uint8)
    plain = extract(faint, FeatureOptions(clahe_clip=0.0, reduction=1.0))
    assert len(extract(faint, FeatureOptions(reduction=1.0))) > 3 * len(plain) + 20


def test_at_most_the_number_of_features_asked_for_is_kept():
    noise = np.random.default_rng(1).integers(0, 255, (256, 256)).astype(np.uint8)
    assert len(extract(noise, FeatureOptions(max_features=100))) <= 102  # OpenCV keeps ties


def test_an_image_without_texture_has_no_features_but_whole_arrays():
    found = extract(np.full((64, 64, 3), 7, np.uint8), FeatureOptions())
    assert len(found) == len(no_features()) == 0
    assert found.descriptors.shape == (0, 128)
    assert found.color.shape == (0, 3)


def test_corners_come_behind_the_sift_features_which_stay(blobs):
    noise = np.random.default_rng(1).integers(0, 255, (160, 200, 3)).astype(np.uint8)
    plain, both = extract(noise, FeatureOptions()), extract(noise, FeatureOptions(), corners=True)
    corners = both.keypoints[both.corner]
    assert plain.corners == 0 < both.corners == len(both) - len(plain)
    assert len(both.color) == len(both.descriptors) == len(both)
    np.testing.assert_array_equal(both.without_corners().keypoints, plain.keypoints)
    np.testing.assert_array_equal(both.without_corners().descriptors, plain.descriptors)
    assert (corners[:, :2] > 20).all()  # in raw pixels, a patch of 20 px from the border
    assert (corners[:, :2] < [180, 140]).all()
    assert (corners[:, 2] == 40).all()


def test_there_are_at_most_half_as_many_corners_as_features_are_asked_for():
    noise = np.random.default_rng(1).integers(0, 255, (256, 256)).astype(np.uint8)
    assert extract(noise, FeatureOptions(max_features=60), corners=True).corners == 30


def test_an_image_without_sift_features_has_no_corners_either():
    assert len(extract(np.full((64, 64), 7, np.uint8), FeatureOptions(), corners=True)) == 0


def test_a_grey_image_gets_grey_colours():
    noise = np.random.default_rng(1).integers(0, 255, (128, 128)).astype(np.uint8)
    color = extract(noise, FeatureOptions()).color
    assert len(color) > 3
    assert (color == color[:, :1]).all()


def test_root_sift_is_the_root_of_the_shares():
    raw = np.zeros((1, 128), np.float32)
    raw[0, :2] = 3.0
    raw[0, 2:18] = 1.0  # sum 22: roots of 3/22 and 1/22, times 512
    found = root_sift(raw)
    assert found[0, 0] == round(512 * np.sqrt(3 / 22))
    assert found[0, 5] == round(512 * np.sqrt(1 / 22))
    assert not found[0, 18:].any()


def test_a_share_beyond_a_byte_is_held_at_255():
    raw = np.zeros((1, 128), np.float32)
    raw[0, 0] = 9.0
    assert root_sift(raw)[0, 0] == 255
