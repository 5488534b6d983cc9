# SPDX-FileCopyrightText: 2026 the hullrecon authors
# SPDX-License-Identifier: Apache-2.0
import cv2
import numpy as np
import pytest

from hullrecon.studies.matching.corners import (
    APART_PX,
    RADIUS_PX,
    describe_corners,
    extract_with_corners,
    find_corners,
    is_corner,
    sample_patches,
    zernike_magnitudes,
)
from hullrecon.vision.features.descriptors import sparse_distance, to_unit
from hullrecon.vision.features.extraction import extract
from hullrecon.vision.options import FeatureOptions

NO_SIFT = np.zeros((0, 2), np.float32)
CENTRE = np.array([[60.0, 60.0]], np.float32)


def texture(seed, sigma=2.0):
    noise = np.random.default_rng(seed).uniform(0, 255, (121, 121)).astype(np.float32)
    return cv2.normalize(cv2.GaussianBlur(noise, (0, 0), sigma), None, 0, 255, cv2.NORM_MINMAX)


def turned(image, degrees):
    return cv2.warpAffine(
        image, cv2.getRotationMatrix2D((60, 60), degrees, 1.0), (121, 121), flags=cv2.INTER_CUBIC
    )


def square(corner):
    """A bright square of 50 px from that corner on, a pixel's worth of its edges mixed."""
    fine = np.zeros((480, 480), np.float32)
    u, v = np.rint(4 * (np.array(corner) + 0.5)).astype(int)
    fine[v : v + 200, u : u + 200] = 160
    return cv2.GaussianBlur(
        cv2.resize(fine, (120, 120), interpolation=cv2.INTER_AREA), (0, 0), 1.0
    ).astype(np.uint8)


def distance(a, b):
    one, other = (to_unit(describe_corners(image, CENTRE)) for image in (a, b))
    return float(sparse_distance(one, other, np.array([0]), np.array([0]))[0])


def test_corners_of_square_are_found():
    place, response = find_corners(square((30, 35)), NO_SIFT, 10)
    # the response is largest a little within the corner
    inside = np.array([[1, 1], [-1, 1], [1, -1], [-1, -1]])
    wanted = np.array([[30, 35], [80, 35], [30, 85], [80, 85]]) + 1.6 * inside
    np.testing.assert_allclose(place, wanted, atol=0.2)
    assert (response > 0).all()


def test_corner_moves_with_image_by_fractions_of_pixel():
    still, _ = find_corners(square((30, 35)), NO_SIFT, 10)
    moved, _ = find_corners(square((30.25, 35.5)), NO_SIFT, 10)
    np.testing.assert_allclose(moved - still, np.tile([0.25, 0.5], (len(still), 1)), atol=0.2)


def test_corners_are_strongest_in_fixed_order():
    image = texture(1).astype(np.uint8)
    every, response = find_corners(image, NO_SIFT, 1000)
    some, strongest = find_corners(image, NO_SIFT, 20)
    assert (np.diff(np.floor(every[:, 1] + 0.5)) >= 0).all()
    assert len(some) == 20 < len(every)
    assert strongest.min() >= np.sort(response)[-20]


def test_corner_that_sift_has_found_is_not_found_again():
    image = texture(1).astype(np.uint8)
    every, _ = find_corners(image, NO_SIFT, 1000)
    others, _ = find_corners(image, every[:5] + np.float32(0.5 * APART_PX), 1000)
    assert len(others) <= len(every) - 5
    assert not (others[:, None] == every[:5]).all(axis=2).any()


def test_patch_lies_within_image():
    place, _ = find_corners(texture(1).astype(np.uint8), NO_SIFT, 1000)
    assert place.min() > RADIUS_PX
    assert place.max() < 120 - RADIUS_PX


@pytest.mark.parametrize("shape", [(64, 64), (15, 40)])
def test_plain_or_small_image_has_no_corners(shape):
    place, response = find_corners(np.full(shape, 90, np.uint8), NO_SIFT, 10)
    assert place.shape == (0, 2)
    assert len(response) == 0
    assert describe_corners(np.full(shape, 90, np.uint8), place).shape == (0, 128)


@pytest.mark.parametrize("degrees", [30, 90, 137])
def test_patch_that_is_turned_keeps_its_descriptor(degrees):
    among = [distance(texture(1), texture(seed)) for seed in range(2, 8)]
    assert distance(texture(1), turned(texture(1), degrees)) < 0.25 * min(among)


def test_magnitudes_change_by_under_5_percent_when_turned():
    magnitudes = zernike_magnitudes(
        np.concatenate([sample_patches(turned(texture(1), k), CENTRE) for k in range(0, 181, 15)])
    )
    change = np.linalg.norm(magnitudes[1:] - magnitudes[0], axis=1)
    assert change.max() < 0.05 * np.linalg.norm(magnitudes[0])


def test_contrast_and_brightness_do_not_change_descriptor():
    assert distance(texture(1), 0.4 * texture(1) + 30) < 0.02


def test_corners_come_behind_sift_features():
    noise = np.random.default_rng(1).integers(0, 255, (160, 200, 3)).astype(np.uint8)
    plain, both = extract(noise, FeatureOptions()), extract_with_corners(noise, FeatureOptions())
    sift = both.scored
    assert plain.scored.all()
    assert len(both.color) == len(both.descriptors) == len(both)
    assert 0 < (~sift).sum() == len(both) - len(plain)
    assert not sift[len(plain) :].any()
    np.testing.assert_array_equal(is_corner(both.descriptors), ~sift)
    np.testing.assert_array_equal(both.keypoints[sift], plain.keypoints)
    np.testing.assert_array_equal(both.descriptors[sift], plain.descriptors)
    corners = both.keypoints[~sift]
    assert (corners[:, :2] > 20).all()  # in raw pixels, a patch of 20 px from the border
    assert (corners[:, :2] < [180, 140]).all()
    assert (corners[:, 2] == 40).all()


def test_corners_are_at_most_half_features_asked_for():
    noise = np.random.default_rng(1).integers(0, 255, (256, 256)).astype(np.uint8)
    found = extract_with_corners(noise, FeatureOptions(max_features=60))
    assert is_corner(found.descriptors).sum() == 30


def test_image_without_sift_features_has_no_corners():
    flat = np.full((64, 64), 7, np.uint8)
    assert len(extract_with_corners(flat, FeatureOptions())) == 0
